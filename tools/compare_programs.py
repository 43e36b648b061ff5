#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Compares the results, or the speed, of two builds of liggghts-mpdem on the same scenes.

    tools/compare_programs.py OLD NEW                    every scene on 1 and 2 ranks
    tools/compare_programs.py OLD NEW --scenes packing,flat/shear --ranks 1
    tools/compare_programs.py OLD NEW --time 5           CPU time, five runs of each in turns

Runs the examples of this source tree with either program and compares every table and event log that they leave.
A file is `same` if every byte is the same.  Otherwise the largest difference of a column over the largest value in
it is told, before the first point fails and over the whole run, and whether the same points fail in the same order.
The exit status is 0 if all files are the same or agree within --tolerance before the first failure, with the same events.
Needs Debian's python3-numpy.
"""
import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True

try:
    import numpy as np
except ImportError as missing:
    sys.exit(f"compare_programs.py: {missing}; apt-get install python3-numpy and run with /usr/bin/python3")

ROOT = Path(__file__).resolve().parents[1]


def example(name, variables, words=()):
    """A script of examples/, its variables, and what to replace in its text."""
    return {"script": ROOT / "examples" / name, "variables": variables, "words": words}


WARNS = b" kinetic_share no"  # results do not depend on it, and earlier programs do not know it
COARSE = {"spacing": "2e-4", "record": "10", "frames": "1000000", "limit": "6000"}
UPDATED = [("mpm cell ${cell}", "mpm cell ${cell} kinematics updated")]
SCENES = {
    "pair_flat": example("pair_flat/in.flat_scaled", {"cell": "4e-4", "spacing": "2e-4", "regularization": "none"}),
    "flat/tension": example("pair_table/in.pair_table", {**COARSE, "shape": "flat", "load": "tension"}),
    "flat/shear": example("pair_table/in.pair_table", {**COARSE, "shape": "flat", "load": "shear"}),
    "flat/free": example("pair_table/in.pair_table", {**COARSE, "shape": "flat", "load": "force"}),
    "meniscus/mixed": example("pair_table/in.pair_table", {**COARSE, "shape": "meniscus", "load": "mixed"}),
    "coating/tension": example("pair_table/in.pair_table", {**COARSE, "shape": "coating", "content": "0.25", "spacing": "1.5e-4"}),
    "updated/tension": example("pair_table/in.pair_table", {**COARSE, "shape": "flat", "edge": "free", "limit": "1500"}, UPDATED),
    "packing": example("packing/in.packing", {"side": "3", "steps": "1200", "record": "20"}),
    "rain": example("rain/in.rain", {"steps": "8000", "record": "100"}),
}


def arguments():
    p = argparse.ArgumentParser(description="Compares two builds of liggghts-mpdem on the examples of this source tree.")
    p.add_argument("old", type=Path, help="executable to compare with")
    p.add_argument("new", type=Path, help="executable to compare")
    p.add_argument("--scenes", default=",".join(SCENES), metavar="A,B", help="of " + ", ".join(SCENES))
    p.add_argument("--ranks", default="1,2", metavar="N,M", help="numbers of ranks (1,2)")
    p.add_argument("--tolerance", type=float, default=1e-12, help="difference before the first failure that is let pass (1e-12)")
    p.add_argument("--time", type=int, default=0, metavar="RUNS", help="compare CPU time instead, so many runs of each in turns")
    args = p.parse_args()
    args.scenes = args.scenes.split(",")
    for name in args.scenes:
        if name not in SCENES:
            p.error(f"--scenes {name}: must be of {', '.join(SCENES)}")
    try:
        args.ranks = [int(n) for n in args.ranks.split(",")]
    except ValueError:
        args.ranks = []
    if not args.ranks or min(args.ranks) < 1:
        p.error("--ranks: must be whole numbers of at least 1, with commas between them")
    if args.time < 0:
        p.error(f"--time {args.time}: must be 0 or more")
    for exe in (args.old, args.new):
        if not os.access(exe, os.X_OK):
            p.error(f"{exe}: no such executable; build it with make")
    return args


def run(exe, scene, ranks, folder):
    """Runs a scene in a folder and returns the CPU seconds it took."""
    folder.mkdir(parents=True)
    script = scene["script"]
    for source in script.parent.iterdir():
        if source.is_file():
            (folder / source.name).write_bytes(source.read_bytes().replace(WARNS, b""))
    text = (folder / script.name).read_text()
    for old, new in scene["words"]:
        if text.count(old) != 1:
            sys.exit(f"compare_programs.py: {script} holds '{old}' {text.count(old)} times, not once; adapt the scene")
        text = text.replace(old, new)
    (folder / script.name).write_text(text)
    command = ["mpirun", "-np", str(ranks), "--oversubscribe", str(exe.resolve()), "-in", script.name]
    for name, value in scene["variables"].items():
        command += ["-var", name, value]
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(folder / "screen.txt", "w") as screen:
        status = subprocess.run(command, cwd=folder, env=environment, stdout=screen, stderr=subprocess.STDOUT).returncode
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if status != 0:
        said = (folder / "screen.txt").read_text().splitlines()
        errors = [line for line in said if line.startswith("ERROR")] or said[-10:]
        sys.exit("\n".join([f"compare_programs.py: {exe} ended with status {status} on {script}:", *errors]))
    if not any(len(read(table)[1]) > 0 for table in folder.glob("*.csv")):
        sys.exit(f"compare_programs.py: {exe} ended well on {script}, but left no table with rows; give a build of liggghts-mpdem")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def read(path):
    """Header and rows of a table, as texts."""
    lines = path.read_text().splitlines() or [""]
    return lines[0].split(","), [line.split(",") for line in lines[1:]]


def column(rows, n):
    """Numbers of a column; NaN where there is a text."""

    def value(word):
        try:
            return float(word)
        except ValueError:
            return float("nan")

    return np.array([value(row[n]) for row in rows])


def events_differ(old, new):
    """Where two event logs begin to differ, or an empty string."""
    (old_head, old_rows), (new_head, new_rows) = read(old), read(new)
    wanted = ("step", "point", "bond", "grain", "mode")
    old_events = [[row[old_head.index(c)] for c in wanted] for row in old_rows]
    new_events = [[row[new_head.index(c)] for c in wanted] for row in new_rows]
    for n, (a, b) in enumerate(zip(old_events, new_events)):
        if a != b:
            return f"event {n + 1} of {len(old_events)} differs: {','.join(a)} and {','.join(b)}"
    if len(old_events) != len(new_events):
        return f"{len(old_events)} and {len(new_events)} events"
    return ""


def table_differs(old, new, first_failure):
    """Largest difference of any column of two tables, before the first failure and in all, with the column; None if the
    rows are others."""
    (old_head, old_rows), (new_head, new_rows) = read(old), read(new)
    if len(old_rows) != len(new_rows) or "step" not in old_head:
        return None
    step = column(old_rows, old_head.index("step"))
    found = [(0.0, "no row"), (0.0, "no row")]
    for name in (c for c in old_head if c in new_head):
        a, b = column(old_rows, old_head.index(name)), column(new_rows, new_head.index(name))
        if (np.isnan(a) != np.isnan(b)).any():
            found = [(np.inf, name)] * 2  # a number in one table alone
            break
        if np.isnan(a).any():
            continue  # texts, which the events are compared by
        difference = np.abs(a - b) / max(np.abs(a).max(initial=0.0), 1e-300)
        for n, chosen in enumerate((step < first_failure, step >= 0)):
            found[n] = max(found[n], (difference[chosen].max(initial=0.0), name), key=lambda pair: pair[0])
    return found


def compare(old, new, tolerance):
    """Lines that tell about the files of two folders, and whether they agree."""
    lines, agree = [], True
    names = sorted({p.name for f in (old, new) for p in f.glob("*.csv")})
    first_failure = float("inf")
    for name in names:
        if name.startswith("events") and (old / name).exists():
            head, rows = read(old / name)
            first_failure = min([first_failure] + [float(row[head.index("step")]) for row in rows])
    for name in names:
        a, b = old / name, new / name
        if not (a.exists() and b.exists()):
            lines.append(f"{name}: written by one program only")
            agree = False
        elif a.read_bytes() == b.read_bytes():
            lines.append(f"{name}: same")
        elif name.startswith("events"):
            where = events_differ(a, b)
            lines.append(f"{name}: " + (where or "same events, other digits"))
            agree = agree and not where
        else:
            found = table_differs(a, b, first_failure)
            if found is None:
                lines.append(f"{name}: other rows")
                agree = False
                continue
            (before, where), (overall, other) = found
            lines.append(f"{name}: {before:.1e} ({where}) before the first failure, {overall:.1e} ({other}) in all")
            agree = agree and before <= tolerance
    return lines, agree


def main():
    args = arguments()
    all_agree = True
    with tempfile.TemporaryDirectory() as base:
        for name in args.scenes:
            for ranks in args.ranks:
                place = Path(base) / name.replace("/", "_") / str(ranks)
                who = f"{name} on {ranks} rank{'s' if ranks > 1 else ''}"
                if args.time:
                    seconds = {"old": [], "new": []}
                    for turn in range(args.time):
                        for which, exe in (("old", args.old), ("new", args.new)):
                            seconds[which].append(run(exe, SCENES[name], ranks, place / f"{which}{turn}"))
                    before, after = (statistics.median(seconds[k]) for k in ("old", "new"))
                    print(f"{who}: CPU time {before:.2f} and {after:.2f} s, ratio {after / before:.3f}", flush=True)
                    continue
                for which, exe in (("old", args.old), ("new", args.new)):
                    run(exe, SCENES[name], ranks, place / which)
                lines, agree = compare(place / "old", place / "new", args.tolerance)
                all_agree = all_agree and agree
                print(f"{who}: {'agree' if agree else 'DIFFER'}", *lines, sep="\n  ", flush=True)
    sys.exit(0 if all_agree else 1)


if __name__ == "__main__":
    main()
