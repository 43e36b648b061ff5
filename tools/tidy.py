#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs clang-tidy with the checks of .clang-tidy over all source files, or over one part of them in several.

Each finding is printed once, though several files may include its header. Exit status 1 if there is any. BUILD is a folder in
which CMake configured the project; it has the options of the compiler.
"""
import argparse
import concurrent.futures
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FINDING = re.compile(r"^(/.*?):(\d+):\d+: (?:warning|error): (.*)$", re.M)


def findings(file, build):
    """Lines of what clang-tidy says of a file, with its headers."""
    command = ["clang-tidy", "-p", str(build), "--quiet", str(file)]
    text = subprocess.run(command, capture_output=True, text=True).stdout
    return {f"{os.path.relpath(os.path.normpath(name), ROOT)}:{line}: {what}" for name, line, what in FINDING.findall(text)}


def main():
    p = argparse.ArgumentParser(description="clang-tidy over the source.")
    p.add_argument("build", type=Path)
    p.add_argument("--jobs", type=int, default=os.cpu_count())
    p.add_argument("--part", type=int, nargs=2, metavar=("K", "N"), default=(1, 1), help="part K of N")
    args = p.parse_args()
    if not (args.build / "compile_commands.json").exists():
        sys.exit(f"tidy.py: {args.build} has no compile_commands.json; configure it by 'cmake -S . -B {args.build}'")
    k, n = args.part
    if not 1 <= k <= n:
        p.error(f"--part {k} {n}: the first number must lie between 1 and the second")
    files = sorted((ROOT / "src" / "USER-MPDEM").rglob("*.cpp"))[k - 1 :: n]
    found = set()
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for number, said in enumerate(pool.map(lambda f: findings(f, args.build), files), 1):
            for line in sorted(said - found):
                print(line, flush=True)
            found |= said
            if number % 10 == 0:
                print(f"tidy.py: {number} of {len(files)} files", file=sys.stderr, flush=True)
    sys.exit(f"tidy.py: {len(found)} findings in {len(files)} files" if found else 0)


if __name__ == "__main__":
    main()
