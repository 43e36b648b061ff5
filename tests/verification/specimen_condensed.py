#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A specimen with condensed bonds against the same with resolved ones, in unconfined compression until ten bonds are broken.

    tests/verification/specimen_condensed.py OUT [--beads 150]

Runs tools/specimen.py twice, with `condense yes` and `condense no`, and prints the largest difference of the stress, over the peak, up to
the peak and up to the tenth broken bond, and the first ten bonds that broke. Goes on where it was stopped.
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

WORDS = ["--pressures", "", "--tests", "compression", "--jobs", "1", "--set", "speed=0.02", "--set", "record=50", "--set", "frames=1",
         "--set", "beyond=1.15"]


def first_broken(bonds, number):
    """Bonds by the row of the table in which they are separated first, and the step of the last of `number`."""
    found = []
    for step in sorted(bonds):
        row = bonds[step]
        found += [(step, int(b)) for b, s in zip(row["bond"], row["separated"]) if s > 0 and int(b) not in {f[1] for f in found}]
        if len(found) >= number:
            break
    return found[:number]


def main():
    p = argparse.ArgumentParser()
    p.add_argument("out")
    p.add_argument("--beads", default="150")
    p.add_argument("--content", default="0.003")
    p.add_argument("--exe", default=os.path.join(ROOT, "build", "liggghts-mpdem"))
    args = p.parse_args()
    curves, broken = {}, {}
    for word in ("yes", "no"):
        out = os.path.join(args.out, word)
        if word == "no" and not os.path.isdir(out):
            os.makedirs(out)
            for name in ("poured", f"cemented_{float(args.content):g}"):
                shutil.copytree(os.path.join(args.out, "yes", name), os.path.join(out, name))
        subprocess.run([os.path.join(ROOT, "tools", "specimen.py"), out, "--exe", args.exe, "--beads", args.beads, "--contents", args.content,
                        *WORDS, "--set", f"condense={word}"], check=True)
        folder = os.path.join(out, f"compression_{float(args.content):g}")
        curves[word] = specimen.Curve(folder, "compression", 0.0)
        broken[word] = first_broken(specimen.bonds_at(folder), 10)
    a, b = curves["yes"], curves["no"]
    steps = a.table["step"]
    stress = np.interp(steps, b.table["step"], b.stress)
    off = np.abs(a.stress - stress) / b.stress[b.peak]
    until = {"the peak": b.table["step"][b.peak], "the tenth broken bond": min(x[-1][0] for x in broken.values())}
    for name, step in until.items():
        print(f"stress up to {name}: largest difference {100 * off[steps <= step].max():.2g} % of the peak")
    print(f"peak: {100 * (a.stress[a.peak] / b.stress[b.peak] - 1):.2g} %")
    for word in ("yes", "no"):
        print(f"condense {word}: first broken (step since the start, bond) {[(int(s - curves[word].table['step'][0]), n) for s, n in broken[word]]}")
    one, two = ({n for _, n in broken[word]} for word in ("yes", "no"))
    print(f"of the first ten {len(one & two)} are the same; in the same order the first "
          f"{next((i for i, (x, y) in enumerate(zip(broken['yes'], broken['no'])) if x[1] != y[1]), 10)}")


if __name__ == "__main__":
    main()
