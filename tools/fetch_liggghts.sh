#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Fetches the source of LIGGGHTS 3.8.0 from Debian's archive, if it is not there yet: for
# tools/liggghts_from_source.sh, and for the tutorials that tests/system/test_tutorials.py runs.
#
#   tools/fetch_liggghts.sh DIRECTORY
#
# leaves liggghts_3.8.0+repack1.orig.tar.xz in DIRECTORY. TARBALL=file of the environment is linked
# instead of fetched.
set -eu
name=liggghts_3.8.0+repack1.orig.tar.xz

stop() {
  echo "fetch_liggghts.sh: $*" >&2
  exit 1
}

[ $# -eq 1 ] || stop "usage: tools/fetch_liggghts.sh DIRECTORY"
if [ -n "${TARBALL:-}" ]; then
  [ -e "$TARBALL" ] || stop "no such file: $TARBALL"
  TARBALL=$(realpath "$TARBALL")
fi
mkdir -p "$1"
cd "$1"
[ -z "${TARBALL:-}" ] || [ "$TARBALL" -ef $name ] || ln -sf "$TARBALL" $name
[ ! -e $name ] || exit 0
rm -f $name  # a link to a file that is gone

# Source packages need a deb-src entry. It is put, like the lists of packages, into a
# folder of its own: neither root nor a change of the system's settings is needed.
echo "Fetching $name"
rm -rf apt
here=$PWD
trap 'rm -rf "$here/apt"' EXIT
mkdir -p apt/lists/partial apt/archives/partial apt/source
apt-get indextargets --format '$(ORIGIN)|$(COMPONENT)|$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' \
  | sed -n 's/^Debian|main|/deb-src [signed-by=\/usr\/share\/keyrings\/debian-archive-keyring.gpg] /p' \
  | sort -u > apt/sources.list
[ -s apt/sources.list ] || stop "apt knows no Debian archive; call apt-get update first, or give the tarball by TARBALL=..."
set -- -o Dir::Etc::SourceList="$PWD/apt/sources.list" -o Dir::Etc::SourceParts=/dev/null \
       -o Dir::State::Lists="$PWD/apt/lists" -o Dir::Cache="$PWD/apt" -o APT::Sandbox::User=root
apt-get "$@" --quiet update
cd apt/source
apt-get "$@" --quiet source --tar-only liggghts
[ -e $name ] || stop "Debian's archive has another version than $name"
mv $name ../..  # in one piece: an interrupted call leaves no part of it
