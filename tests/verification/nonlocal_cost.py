#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What does a step cost with `regularization nonlocal`, over one with the local law?

    tests/verification/nonlocal_cost.py OUT [--rounds 3] [--limit 8000]

A flat bond of 1 % between beads of 10 and 10.2 mm, pulled and sheared by examples/pair_table/in.pair_table, L = 0.2 mm, `cracks split`, with cells of L
and L/2. Both laws run in turns. Printed is the CPU time of fix mpm a step, over that with the local law in cells alike: medians of the rounds

* while intact: chunks of steps after the first two in which nothing is damaged;
* while it fails: chunks from the first with failed points to the last with a tenth of the largest force.

CPU times, since other programs may run beside. The log's rates go into them, see the page of fix mpm. A run ends after `--limit` steps, twice as
many with L/2. 900 are enough for what an intact bond costs, and take seconds. What it costs to fail is not told then (nan).
"""
import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
EXE = os.environ.get("MPDEM_EXE", str(ROOT / "build" / "liggghts-mpdem"))
LENGTH, CHUNK, POINTS = 2e-4, 50, re.compile(r"(\S+) by CPU time")
LAWS = {"local": "none", "nonlocal": f"nonlocal {LENGTH:g}"}


def chunks(folder, load, ratio, law, limit):
    """Of each chunk: CPU time a step and point, force, failed points, damage energy."""
    folder.mkdir(parents=True, exist_ok=True)
    words = dict(
        shape="flat",
        load=load,
        content=0.01,
        diameter=0.0102,
        inner=1e-3,
        spacing=LENGTH / ratio / 2,
        cracks="split",
        chunk=CHUNK,
        limit=limit * ratio,
        frames=1000000,
        regularization=LAWS[law],
    )
    command = [EXE, "-in", str(ROOT / "examples" / "pair_table" / "in.pair_table")]
    for name, value in words.items():
        command += ["-var", name, str(value)]
    with open(folder / "out.txt", "w") as out:
        subprocess.run(command, cwd=folder, stdout=out, stderr=subprocess.STDOUT, check=True)
    found, row = [], None
    for line in (folder / "log.liggghts").read_text().splitlines():
        values = line.split()
        if len(values) == 10 and values[0].isdigit():
            row = [float(values[3]), float(values[6]), float(values[7])]
        elif (rate := POINTS.search(line)) and row:
            found.append([1.0 / float(rate[1])] + row)
    return np.array(found)


def costs(c):
    cost, force, failed, damage = c.T
    intact = np.flatnonzero(damage == 0.0)[2:]
    if not failed.any():
        return np.median(cost[intact]), np.nan
    last = np.flatnonzero(force > 0.1 * force.max())[-1]
    failing = np.arange(np.flatnonzero(failed > 0)[0], last + 1)
    return np.median(cost[intact]), cost[failing].mean()


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("out", metavar="OUT", help="folder of the runs")
    p.add_argument("--rounds", type=int, default=3, help="runs of each, in turns (3)")
    p.add_argument("--limit", type=int, default=8000, help="steps of a run at most, with cells of L (8000)")
    args = p.parse_args()
    print("load, cell, ratio while intact, ratio while it fails, and the least and largest of the rounds")
    for load in ("tension", "shear"):
        for ratio in (1, 2):
            pairs = []
            for n in range(args.rounds):
                local, average = (costs(chunks(Path(args.out) / f"{load}_{ratio}_{law}_{n}", load, ratio, law, args.limit)) for law in LAWS)
                pairs.append(np.array(average) / np.array(local))
            low, middle, high = np.min(pairs, axis=0), np.median(pairs, axis=0), np.max(pairs, axis=0)
            print(f"{load:8} L/{ratio}  {middle[0]:.3f} ({low[0]:.3f} to {high[0]:.3f})  {middle[1]:.2f} ({low[1]:.2f} to {high[1]:.2f})", flush=True)


if __name__ == "__main__":
    main()
