#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A specimen with condensed bonds against the same with resolved ones, in unconfined compression until ten bonds are broken.

    tests/verification/specimen_condensed.py OUT [--beads 150] [--only condensed,...]

Runs tools/specimen.py with `condense no`, and compares with it: `condense yes`, other `wake`; and what tells the noise of a brittle specimen: `condense no`
with half the step, and with a plate that is faster by a millionth and by a thousandth. For each it prints the largest difference of the stress, over the peak, up to
the first bond, the peak and the tenth bond, and which of the first ten bonds are the same: of those that failed, whose load fell below half of the
largest that they had as points failed; and of those that are separated, to which last bridges of a few points may belong long after. Goes on where it was stopped.
"""
import argparse
import os
import shutil
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools"))
from mpdem import specimen  # noqa: E402

SPEED, RECORD, BROKEN = 0.02, 50, 10
WORDS = ["--pressures", "", "--tests", "compression", "--jobs", "1"]
ALL = {"frames": "1", "beyond": "1.15", "speed": str(SPEED), "record": str(RECORD)}
RUNS = {
    "resolved": {"condense": "no"},
    "resolved, half the step": {"condense": "no", "step": "0.05", "record": str(2 * RECORD)},
    "resolved, faster by 1e-6": {"condense": "no", "speed": repr(SPEED * (1 + 1e-6))},
    "resolved, faster by 1e-3": {"condense": "no", "speed": repr(SPEED * (1 + 1e-3))},
    "condensed": {},
    "condensed, wake 0.5": {"wake": "0.5"},
    "condensed, wake 0.3": {"wake": "0.3"},
}


def time_of(step, curve):
    return float(np.interp(step, curve.table["step"], curve.table["time"]))


def first_bonds(bonds, curve, met):
    """(time, bond) of the first bonds for which met(row), a flag a bond, is true at a step of the table, in its order."""
    found, seen = [], set()
    for step in sorted(bonds):
        row = bonds[step]
        for b in row["bond"][met(row)]:
            if int(b) not in seen:
                seen.add(int(b))
                found.append((time_of(step, curve), int(b)))
        if len(found) >= BROKEN:
            break
    return found[:BROKEN]


def first_separated(bonds, curve):
    return first_bonds(bonds, curve, lambda row: row["separated"] > 0)


def first_to_fail(bonds, curve):
    """The same of bonds whose load, while points have failed, is below half of the largest that they had."""
    largest = {}

    def failed(row):
        load = np.sqrt(sum(row[f"f{d}1"] ** 2 for d in "xyz"))
        for b, f in zip(row["bond"], load):
            largest[b] = max(largest.get(b, 0.0), f)
        return (row["failed"] > 0) & (load < 0.5 * np.array([largest[b] for b in row["bond"]]))

    return first_bonds(bonds, curve, failed)


def swaps(order, reference):
    """Largest difference of the times of two bonds that broke the other way round, as the reference has them; of those in both."""
    at = {b: t for t, b in reference}
    times = [at[b] for _, b in order if b in at]
    return max((max(times[: i + 1]) - t for i, t in enumerate(times)), default=0.0)


def told(name, what, run, reference):
    (a, mine), (b, theirs) = run, reference
    off = np.abs(np.interp(b.table["time"], a.table["time"], a.stress) - b.stress) / b.stress[b.peak]
    end = min(a.table["time"][-1], b.table["time"][-1])
    if not mine or not theirs:
        print(f"{name}: no bond {what}; set a larger `beyond`")
        return
    until = [min(mine[0][0], theirs[0][0]), b.table["time"][b.peak], min(mine[-1][0], theirs[-1][0], end)]
    parts = ", ".join(f"{100 * off[b.table['time'] <= t].max():.2g}" for t in until)
    same = len({n for _, n in mine} & {n for _, n in theirs})
    order = next((i for i, (x, y) in enumerate(zip(mine, theirs)) if x[1] != y[1]), len(theirs))
    print(
        f"{name}: peak {100 * (a.stress[a.peak] / b.stress[b.peak] - 1):+.2g} %; stress up to the first bond that {what}, the peak, the last of the first such bonds: off by "
        f"at most {parts} % of the peak; of the first {len(theirs)} {same} the same, in the same order the first {order}, "
        f"others within {1e6 * swaps(mine, theirs):.2g} us of {1e6 * theirs[-1][0]:.0f}"
    )


def main():
    p = argparse.ArgumentParser()
    p.add_argument("out")
    p.add_argument("--beads", default="150")
    p.add_argument("--content", default="0.003")
    p.add_argument("--set", action="append", default=[], help="NAME=VALUE for all runs")
    p.add_argument("--only", help="names of runs, beside the resolved one")
    p.add_argument("--exe", default=os.path.join(ROOT, "build", "liggghts-mpdem"))
    args = p.parse_args()
    label = f"{float(args.content):g}"
    folders, found = {name: os.path.join(args.out, name.replace(",", "").replace(" ", "_")) for name in RUNS}, {}
    for name, words in RUNS.items():
        if args.only and name != "resolved" and name not in args.only.split(";"):
            continue
        out = folders[name]
        if name != "resolved" and not os.path.isdir(out):
            os.makedirs(out)
            for stage in ("poured", f"cemented_{label}"):
                shutil.copytree(os.path.join(folders["resolved"], stage), os.path.join(out, stage))
        settings = {**ALL, **words, **dict(word.split("=") for word in args.set)}
        subprocess.run(
            [
                os.path.join(ROOT, "tools", "specimen.py"),
                out,
                "--exe",
                args.exe,
                "--beads",
                args.beads,
                "--contents",
                args.content,
                *WORDS,
                *(w for k, v in settings.items() for w in ("--set", f"{k}={v}")),
            ],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        folder = os.path.join(out, f"compression_{label}")
        curve = specimen.Curve(folder, "compression", 0.0)
        bonds = specimen.bonds_at(folder)
        found[name] = {"failed": (curve, first_to_fail(bonds, curve)), "is separated": (curve, first_separated(bonds, curve))}
        for what in found[name] if name != "resolved" else ():
            told(name, what, found[name][what], found["resolved"][what])
    for name, lists in found.items():
        for what, (_, order) in lists.items():
            print(f"{name}, {what}: (us, bond) {[(round(1e6 * t), b) for t, b in order]}")


if __name__ == "__main__":
    main()
