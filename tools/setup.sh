#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Installs what building and plotting need from Debian's archive, if anything is missing, and what the words ask for:
# `docs` for the manual, `pdf` for its PDF, `pictures` for animations, `tests` for the tests, `deep` for `make check-deep`. Without root it prints the
# one line to run and stops.
set -eu
packages="g++ make cmake liggghts libliggghts-dev libeigen3-dev libopenmpi-dev openmpi-bin openssh-client
          libgtest-dev libbenchmark-dev python3-numpy python3-pandas python3-scipy python3-matplotlib python3-pil python3-pytest
          python3-vtk9 patch xz-utils"
docs="python3-sphinx python3-myst-parser furo libjs-mathjax"
for word in "$@"; do
  case "$word" in
    docs) packages="$packages $docs" ;;
    pdf) packages="$packages latexmk texlive-xetex texlive-latex-extra fonts-freefont-otf librsvg2-bin" ;;
    pictures) packages="$packages xvfb xauth ffmpeg" ;;
    tests) packages="$packages $docs git clang-format black flake8 mypy python3-pip xvfb xauth ffmpeg" ;;
    deep) packages="$packages clang clang-tidy" ;;
    *) echo "$0: '$word' is none of: docs, pdf, pictures, tests, deep" >&2; exit 1 ;;
  esac
done
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
