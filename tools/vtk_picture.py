#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Picture of beads and cement from the files of `dump custom/vtk`, with VTK, as ParaView would draw them.

    tools/vtk_picture.py RUN_DIR PICTURE.png --steps 352000,355000 --titles 'before the peak,past the peak'

For each step it reads beads_STEP.vtk (radius), cement_STEP.vtk (radius, c_failed, and c_damage or --column) and, if it is there,
plate_STEP.vtk, see doc/howto_pictures.md. Needs Debian's python3-vtk9, python3-matplotlib and, without a screen, xvfb.
"""
import argparse
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    from mpdem import figures, run, scene
except ImportError as missing:
    sys.exit(
        f"vtk_picture.py: {missing}; apt-get install python3-vtk9 python3-numpy python3-pandas python3-matplotlib, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )


def main():
    p = argparse.ArgumentParser(description="Picture of beads and cement from the files of dump custom/vtk.")
    p.add_argument("folder", metavar="RUN_DIR")
    p.add_argument("picture", metavar="PICTURE.png")
    p.add_argument("--steps", metavar="N,M", help="steps, a panel each (default: the first and the last)")
    p.add_argument("--titles", metavar="A,B", help="of the panels (default: the steps)")
    p.add_argument("--column", metavar="C", default=scene.DAMAGE, help="array of the cement that colours it (c_damage)")
    p.add_argument("--words", metavar="TEXT", default="", help="what the column is, with its unit")
    p.add_argument("--dpi", metavar="N", type=int, default=200, help="dots an inch (200)")
    args = p.parse_args()
    there = scene.steps(args.folder)
    try:
        steps = [int(s) for s in args.steps.split(",")] if args.steps else sorted({there[0], there[-1]})
    except ValueError:
        p.error(f"--steps {args.steps}: must be whole numbers with commas between them")
    titles = args.titles.split(",") if args.titles else [f"step {s}" for s in steps]
    if len(titles) != len(steps):
        raise run.Trouble(f"{len(titles)} titles for {len(steps)} steps; give as many")
    for step in steps:
        if step not in there:
            raise run.Trouble(f"{args.folder}: no files of step {step}; there are {there[0]} to {there[-1]}, {len(there)} of them")
    scene.on_a_screen()
    figures.save(scene.panels(args.folder, steps, titles, args.column, args.words), args.picture, args.dpi)
    print(f"written: {args.picture}, {os.path.getsize(args.picture) / 1e3:.0f} kB")


if __name__ == "__main__":
    run.end_with_message("vtk_picture.py", main)
