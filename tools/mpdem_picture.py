#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""One figure of what a run left, by its name.

    tools/mpdem_picture.py RUN_DIR FIGURE PICTURE.png [--bond N] [--grain ID] [--column C] [--step S] [--name NAME]

Figures of a bond: force_displacement, damage_cut, interface. Of any run: curve. Of a packing: packing (bonds coloured by --column: content,
material, strength_factor, tension, ...), force_chains, fragments; --step peak is that of the largest load. doc/python.md lists what each needs.
Needs Debian's python3-numpy, python3-pandas and python3-matplotlib.
"""
import argparse
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    import mpdem
    from mpdem import figures, plots, run
except ImportError as missing:
    sys.exit(
        f"mpdem_picture.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )

OF_BOND, OF_PACKING = ("force_displacement", "damage_cut", "interface"), ("packing", "force_chains", "fragments")


def step(text):
    if text not in ("peak", "first", "last") and not text.isdigit():
        raise argparse.ArgumentTypeError(f"{text} is no step; give a whole number, first, peak or last")
    return text


def arguments():
    p = argparse.ArgumentParser(description="One figure of what a run left.")
    p.add_argument("run_dir", metavar="RUN_DIR", help="folder of the run's output")
    p.add_argument("figure", metavar="FIGURE", choices=(*OF_BOND, "curve", *OF_PACKING), help="%(choices)s")
    p.add_argument("picture", metavar="PICTURE", help="file to write: .png, .pdf, .svg")
    p.add_argument("--bond", metavar="N", type=int, help="number of the bond (default: the first)")
    p.add_argument("--grain", metavar="ID", type=int, help="of interface (default: where most links debonded)")
    p.add_argument("--radius", metavar="R", type=float, default=0.005, help="of the grains of damage_cut and interface, m (0.005)")
    p.add_argument("--column", metavar="C", default="content", help="of packing: content (default) or a column of the table of bonds")
    p.add_argument("--x", metavar="C", default="", help="column of curve (default: the displacement)")
    p.add_argument("--y", metavar="C", default="", help="column of curve (default: the load)")
    p.add_argument("--step", metavar="S", type=step, help="of a packing: a step, first, peak (of the load of the specimen) or last")
    p.add_argument("--name", metavar="NAME", help="which run, if the folder has several: NAME of bond_NAME.csv")
    p.add_argument("--dpi", metavar="N", type=int, default=200, help="dots an inch (200)")
    return p.parse_args()


def step_of(output, word):
    steps = output.grain_steps
    if word is None:
        return None
    if word.isdigit():
        if steps and int(word) not in steps:
            near = min(steps, key=lambda s: abs(s - int(word)))
            raise run.Trouble(f"{output.folder}: no dump of the grains at step {word}; the nearest is {near}, of {steps[0]} to {steps[-1]}")
        return int(word)
    if word in ("first", "last"):
        return steps[0 if word == "first" else -1] if steps else None
    if "curve" not in output.curves:
        raise run.Trouble(f"{output.folder}: no curve.csv, so no peak; give the step as a number")
    curve = output.curves["curve"]
    return int(curve.loc[curve["force"].idxmax(), "step"])


def main():
    args = arguments()
    output = mpdem.load(args.run_dir, args.name)
    draw = getattr(plots, args.figure)
    if args.figure == "force_displacement":
        fig = draw(output, args.bond)
    elif args.figure == "damage_cut":
        fig = draw(output, args.bond, args.radius)
    elif args.figure == "interface":
        fig = draw(output, args.bond, args.grain, args.radius)
    elif args.figure == "curve":
        fig = draw(output, args.x, args.y)
    else:
        words = {"step": step_of(output, args.step), **({"column": args.column} if args.figure == "packing" else {})}
        fig = draw(output, **words)
    figures.save(fig, args.picture, args.dpi)
    print(f"written: {args.picture}, {os.path.getsize(args.picture) / 1e3:.0f} kB")


if __name__ == "__main__":
    run.end_with_message("mpdem_picture.py", main)
