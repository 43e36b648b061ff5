#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Builds LIGGGHTS 3.8.0 from source with the series of patches/ and this package, then
# runs the system tests on the result.
#
#   tools/liggghts_from_source.sh DIRECTORY
#
# The executable is DIRECTORY/liggghts-mpdem. From the environment:
#   TARBALL   liggghts_3.8.0+repack1.orig.tar.xz; fetched from Debian's archive if not set
#   JOBS      of make, and tests at a time (2)
# A second call compiles what has changed. Another tarball or series starts anew.
set -eu
unset MAKEFLAGS MFLAGS MAKELEVEL  # of a make that called this script

tarball_name=liggghts_3.8.0+repack1.orig.tar.xz
tree_name=LIGGGHTS-PUBLIC-3.8.0

stop() {
  echo "liggghts_from_source.sh: $*" >&2
  exit 1
}

[ $# -eq 1 ] || stop "usage: tools/liggghts_from_source.sh DIRECTORY"
for tool in patch xz g++ mpicxx; do
  command -v $tool > /dev/null || stop "$tool is missing; on Debian: apt-get install patch xz-utils g++ libopenmpi-dev"
done
root=$(cd "$(dirname "$0")/.." && pwd)
[ -z "${TARBALL:-}" ] || TARBALL=$(realpath "$TARBALL")
mkdir -p "$1"
cd "$1"
directory=$PWD

"$root/tools/fetch_liggghts.sh" "$directory"
tarball=$directory/$tarball_name

series=$(cat "$tarball" "$root"/patches/*.patch | sha256sum)
if [ "$series" != "$(cat series 2> /dev/null)" ]; then
  rm -rf series $tree_name
  tar -xf "$tarball"
  for p in "$root"/patches/*.patch; do
    echo "Applying $(basename "$p")"
    patch -d $tree_name -p1 --fuzz=0 --quiet < "$p"
  done
  echo "$series" > series
fi

cd $tree_name/src
ln -sfn "$root/src/USER-MPDEM" USER-MPDEM
# as Debian builds it, but without VTK; the file is a copy of the default without its head
sed -e 1,10d -e 's/^USE_VTK *=.*/USE_VTK = "OFF"/' -e 's/^USE_SUPERQUADRICS *=.*/USE_SUPERQUADRICS = "OFF"/' \
    MAKE/Makefile.user_default > MAKE/Makefile.user
make yes-user-mpdem
nice -n 10 make -j "${JOBS:-2}" auto
cp lmp_auto "$directory/liggghts-mpdem"
echo "Built $directory/liggghts-mpdem"

cd "$root"
MPDEM_EXE=$directory/liggghts-mpdem nice -n 10 tools/test_files.sh "$directory/tests" tests/system/test_*.py
