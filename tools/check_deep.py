#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""What is too long for every change: `make stress`, every pair of options in other scenes, the changes of tests/changes, 20 minutes of fuzzing, clang, clang-tidy, and all tests of the preset `sanitize`.

    tools/check_deep.py [--build build] [--jobs 2] [PIECE...]

Runs in pieces of at most 40 minutes on two idle cores. It can be stopped at any time: a piece that passed is not run
again as long as the files of the repository are the same, for which each piece leaves a stamp in build/check-deep,
beside its output. Pages (*.md) count for the piece `test` alone. Exit status 0 once all pieces have passed.
"""
import argparse
import hashlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SANITIZE = 4  # pieces of its tests
TIDY = 3  # pieces of clang-tidy
PAIRS = 4  # other scenes with every pair of options
MINUTES = 40


def pieces(root, build, jobs):
    """Name and command of each. Each builds what it runs first, so none passes with the program of another state."""
    make = f"make BUILD={build} JOBS={jobs}"
    found = {"test": f"{make} test"}
    for script in sorted((root / "tests" / "stability").glob("test_*.py")):
        found[f"long.{script.stem[5:]}"] = f"{make} long LONG={script.relative_to(root)}"
    found["tables"] = f"{make} tables"
    for seed in range(2, 2 + PAIRS):
        found[f"pairs.{seed}"] = f"{make} all && MPDEM_PAIRS_SEED={seed} ctest --test-dir {build} -R '^system.option_pairs$' --output-on-failure"
    found["changes"] = f"tools/check_changes.py --build {build} --jobs {jobs}"
    found["fuzz"] = f"{make} fuzz MINUTES=20 INPUTS=1000000"
    clang = f"tools/setup.sh deep && cmake -S . -B {build}-clang -DCMAKE_CXX_COMPILER=clang++ -DMPDEM_UNITY=ON -DCMAKE_COMPILE_WARNING_AS_ERROR=ON"
    found["clang"] = f"{clang} && cmake --build {build}-clang --parallel {jobs} && ctest --test-dir {build}-clang -L unit --parallel {jobs}"
    for k in range(1, TIDY + 1):
        found[f"tidy.{k}"] = f"tools/setup.sh deep && {make} all && tools/tidy.py {build} --jobs {jobs} --part {k} {TIDY}"
    sanitize = f"cmake --preset sanitize && cmake --build --preset sanitize --parallel {jobs}"
    found["sanitize.build"] = sanitize
    for k in range(1, SANITIZE + 1):
        found[f"sanitize.{k}"] = f"{sanitize} && ctest --preset sanitize --parallel {jobs} -I {k},,{SANITIZE}"
    return found


def state(root, pages):
    """A number of what the files hold that git knows or would add. The page that a piece itself writes is left out."""
    names = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=root, capture_output=True, check=True).stdout.split(
        b"\0"
    )
    sums = hashlib.sha256()
    for name in sorted(set(filter(None, names))):
        path = root / os.fsdecode(name)
        if path.is_file() and name != b"doc/reliability.md" and not name.startswith(b"doc/data/reliability_") and (pages or path.suffix != ".md"):
            sums.update(name + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return sums.hexdigest()


def passes(command, root, output):
    """Whether it ends with status 0. It does not outlive this program, which cannot be stopped until it knows what to end."""
    ends = {signal.SIGINT, signal.SIGTERM}
    with open(output, "wb") as out:
        signal.pthread_sigmask(signal.SIG_BLOCK, ends)
        process = subprocess.Popen(
            command,
            shell=True,
            cwd=root,
            stdout=out,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            preexec_fn=lambda: signal.pthread_sigmask(signal.SIG_UNBLOCK, ends),
        )
        try:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, ends)
            return process.wait() == 0
        except BaseException:
            os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            raise


def check(root, folder, wanted):
    """Runs those that have not passed in this state; the names of those that fail."""
    folder.mkdir(parents=True, exist_ok=True)
    failed = []
    for name, command in wanted.items():
        stamp, output = folder / f"{name}.passed", folder / f"{name}.txt"
        now = state(root, pages=name == "test")
        if stamp.exists() and stamp.read_text() == now:
            print(f"{name}: passed before", flush=True)
            continue
        stamp.unlink(missing_ok=True)
        print(f"{name}: {command}", flush=True)
        start = time.monotonic()
        passed = passes(command, root, output)
        minutes = (time.monotonic() - start) / 60
        if passed and state(root, pages=name == "test") != now:
            passed = False
            print(f"{name}: files changed while it ran; run it again", flush=True)
        elif not passed:
            print("\n".join(output.read_text(errors="replace").splitlines()[-30:]), flush=True)
        print(
            f"{name}: {'passed' if passed else 'FAILED'} after {minutes:.1f} minutes{', longer than a piece is to take' if minutes > MINUTES else ''}; "
            f"output in {output}",
            flush=True,
        )
        if passed:
            stamp.write_text(now)
        else:
            failed.append(name)
    return failed


def main():
    p = argparse.ArgumentParser(description="Long checks, in pieces that can be resumed.")
    p.add_argument("--build", default="build", help="folder of the build (build)")
    p.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time (number of cores)")
    p.add_argument("pieces", metavar="PIECE", nargs="*", help="these alone")
    args = p.parse_args()
    known = pieces(ROOT, args.build, args.jobs)
    for name in args.pieces:
        if name not in known:
            p.error(f"piece '{name}': must be one of {', '.join(known)}")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("check_deep.py: stopped; called again it goes on from this piece"))
    failed = check(ROOT, ROOT / args.build / "check-deep", {n: c for n, c in known.items() if not args.pieces or n in args.pieces})
    if failed:
        sys.exit(f"check_deep.py: {len(failed)} of {len(args.pieces or known)} pieces failed: {', '.join(failed)}")
    print(f"check_deep.py: all of {', '.join(args.pieces) or f'{len(known)} pieces'} passed")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("check_deep.py: stopped; called again it goes on from this piece")
    except subprocess.CalledProcessError:
        sys.exit("check_deep.py: git does not list the files of this folder; run it in a clone of the repository")
