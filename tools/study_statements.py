#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Where and in what order the points of pulled pairs fail, from the event logs of tools/pair_table.py.

    tools/study_statements.py OUT statements.csv      # OUT: folder of the runs

One row a run in tension, of what failed before the bond was separated: share of points that debonded from a grain;
radii of the first fiftieth of the failures and of all; height of the failures inside the cement over half the
gap between the beads there, median and quartiles; median time of debonding in the inner, middle and outer
third of the radii (us); number of bursts in which the points debonded, with pauses of at least a fiftieth
of the whole between them.
"""
import csv
import sys
from pathlib import Path

import numpy as np

COLUMNS = (
    "run",
    "points",
    "debonding_share",
    "first_r_min",
    "first_r_max",
    "r_min",
    "r_max",
    "height_q25",
    "height_median",
    "height_q75",
    "t_inner",
    "t_middle",
    "t_outer",
    "bursts",
)


def read(path):
    with open(path) as f:
        return list(csv.DictReader(f))


def row(run, radius):
    events, bond = read(run / "events_run.csv"), read(run / "bond_run.csv")
    separated = [float(b["time"]) for b in bond if float(b["separated"]) > 0]
    t, r, z = (np.array([float(e[c]) for e in events]) for c in ("time", "r", "z"))
    debonding = np.array([e["mode"] == "debonding" for e in events])
    until = t <= (separated[0] if separated else np.inf)
    t, r, z, debonding = t[until], r[until], z[until], debonding[until]
    if len(t) < 20:
        return None
    half = radius - np.sqrt(radius**2 - r**2)
    inside = np.abs(z[~debonding] / half[~debonding])
    first = r[: max(10, len(r) // 50)]
    thirds, bursts = [""] * 3, 0
    if debonding.sum() >= 20:
        ends = np.linspace(r[debonding].min(), r[debonding].max(), 4)
        for i in range(3):
            here = debonding & (r >= ends[i]) & (r <= ends[i + 1])
            thirds[i] = f"{1e6 * np.median(t[here]):.3g}" if here.any() else ""
        times = np.sort(t[debonding])
        bursts = 1 + int((np.diff(times) > (times[-1] - times[0]) / 50).sum())
    heights = [f"{q:.3g}" for q in np.percentile(inside, [25, 50, 75])] if len(inside) else [""] * 3
    return [run.name, len(t), f"{debonding.mean():.3g}", *(f"{1e3 * x:.4g}" for x in (first.min(), first.max(), r.min(), r.max())), *heights, *thirds, bursts]


def main():
    if len(sys.argv) != 3:
        sys.exit("study_statements.py: use: tools/study_statements.py OUT statements.csv")
    runs = sorted(p.parent for p in Path(sys.argv[1]).glob("*/events_run.csv") if ",tension," in p.parent.name)
    if not runs:
        sys.exit(f"study_statements.py: no runs in tension in {sys.argv[1]}; run tools/pair_table.py first")
    rows = [r for r in (row(run, 5e-3) for run in runs) if r]
    with open(sys.argv[2], "w", newline="") as f:
        csv.writer(f).writerows([COLUMNS, *rows])
    print(f"study_statements.py: {len(rows)} runs in {sys.argv[2]}")


if __name__ == "__main__":
    main()
