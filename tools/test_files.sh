#!/bin/sh
# SPDX-License-Identifier: GPL-2.0-or-later
# Runs files of tests with pytest, JOBS (2) of them at a time, the output of each in one piece.
#
#   tools/test_files.sh FOLDER [--long] FILE...
#
# What the tests write is in FOLDER. Exit status 0 if all of them pass. From the environment:
#   MPDEM_EXE      the executable under test
#   MPDEM_FIGURES  where the figures that the tests measure go
set -eu
[ $# -ge 2 ] || { echo "usage: tools/test_files.sh FOLDER [--long] FILE..." >&2; exit 1; }
mkdir -p "$1"
FOLDER=$(realpath "$1")
shift
LONG=
[ "$1" != --long ] || { LONG=--long; shift; }
export FOLDER LONG
printf '%s\n' "$@" | xargs -d '\n' -P "${JOBS:-2}" -n 1 sh -c '
  status=0
  output=$(/usr/bin/python3 -B -m pytest -q -p no:cacheprovider $LONG --basetemp="$FOLDER/$(basename "$0" .py)" "$0" 2>&1) ||
    status=$?
  printf "%s\n%s\n" "$0" "$output"
  exit $status'
