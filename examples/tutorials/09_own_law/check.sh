#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Tutorial 9: compiles pull.cpp with the law of linear_damage.h and runs it. Another file of a law: ./check.sh, after you name it in pull.cpp.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
material=$here/../../../src/USER-MPDEM/material
g++ -std=c++17 -O1 -Wall -Wno-psabi -I "$material" -I /usr/include/eigen3 "$here/pull.cpp" \
  "$material/vti_elasticity.cpp" "$material/law.cpp" "$material/scatter.cpp" "$material/localisation.cpp" -o pull
./pull > pull.csv
sed -n '1p;6p;8p;12p;$p' pull.csv
