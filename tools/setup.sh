#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Installs what building and plotting need from Debian's archive, if anything is
# missing; with the word `tests` what the tests need besides, with `deep` what `make check-deep` needs. Without root it prints the one line to run and stops.
set -eu
packages="g++ make cmake liggghts libliggghts-dev libeigen3-dev libopenmpi-dev openmpi-bin openssh-client
          libgtest-dev libbenchmark-dev python3-numpy python3-scipy python3-matplotlib python3-pil python3-pytest
          python3-vtk9 patch xz-utils"
[ "${1:-}" = tests ] && packages="$packages git clang-format black flake8 mypy"
[ "${1:-}" = deep ] && packages="$packages clang clang-tidy"
missing=""
for p in $packages; do
  status=$(dpkg-query -W -f='${Status}' "$p" 2>/dev/null || true)
  [ "$status" = "install ok installed" ] || missing="$missing $p"
done
[ -z "$missing" ] && exit 0
if [ "$(id -u)" -ne 0 ]; then
  echo "These packages are missing; run this line as root, then call make again:" >&2
  echo "  apt-get update && apt-get install --yes --no-install-recommends$missing" >&2
  exit 1
fi
apt-get update
DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends $missing
