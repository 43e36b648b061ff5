#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""A picture that moves: a bond as it breaks, or a specimen as it is loaded, beside its curve.

    tools/mpdem_movie.py RUN_DIR [--out bond_breaks.gif] [--frames 40] [--magnify 40]
    tools/mpdem_movie.py RUN_DIR --out specimen.mp4

A bond: reads bond_NAME.csv of `fix mpm/couple` and the text dumps cut_NAME.*.txt of a slice at y = 0, or points_NAME.*.txt (x y z, id, and compute
mpm/atom with the ID damage and the ID failed), as examples/pair_flat and examples/pair_table write them. The cut has displacements `magnify` times
as large as they are; loads are tension, compression, force and shear. A specimen: reads curve.csv and the files of VTK that examples/specimen
writes with `-var pictures`; --column colours the cement. Frames lie evenly along the curve. A name that ends in .mp4 or .webm needs Debian's ffmpeg.
Needs Debian's python3-numpy, python3-pandas, python3-matplotlib and python3-pil; of a specimen python3-vtk9 and, without a screen, xvfb.
"""
import argparse
import glob
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    import mpdem
    import PIL.Image  # noqa: F401
    from mpdem import interface, movie, run
except ImportError as missing:
    sys.exit(
        f"mpdem_movie.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib python3-pil, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )

DURATION, LAST = 90, 2500  # ms of a frame, of the last one


def arguments():
    p = argparse.ArgumentParser(description="A picture that moves, of a bond that breaks or of a specimen.")
    p.add_argument("run_dir", metavar="RUN_DIR", help="folder of the run's output")
    p.add_argument("--of", choices=("bond", "specimen"), help="what is shown (default: specimen if there are beads_STEP.vtk, else bond)")
    p.add_argument("--bond", metavar="CSV", help="table of fix mpm/couple (default: the only bond.csv or bond_*.csv in RUN_DIR)")
    p.add_argument("--cut", metavar="DUMP", nargs="+", help="dumps of the slice, names or a pattern (default: cut_NAME.*.txt, else points_NAME.*.txt)")
    p.add_argument("--out", metavar="FILE", help=".gif, .mp4 or .webm (default: bond_breaks.gif or specimen.gif in RUN_DIR)")
    p.add_argument("--frames", metavar="N", type=int, default=40, help="how many, at most (40)")
    p.add_argument("--magnify", metavar="M", type=float, default=40.0, help="factor on displacements of a bond (40)")
    p.add_argument("--radius", metavar="R", type=float, default=0.005, help="of the two grains, m (0.005)")
    p.add_argument("--until", metavar="X", type=float, default=1.1, help="end at this multiple of the opening at which the bond is separated (1.1)")
    p.add_argument("--column", metavar="C", default="c_damage", help="array of the cement of a specimen that colours it (c_damage)")
    args = p.parse_args()
    if args.frames < 2 or not args.magnify > 0.0 or not args.radius > 0.0 or not args.until > 0.0:
        p.error("--frames must be at least 2, --magnify, --radius and --until above 0")
    return args


def of_bond(args):
    bond = run.read_bonds(run.find_bond_file(args.run_dir, args.bond))[0]
    cut = f"{run.beside(bond, 'cut')}.*.txt"
    names = args.cut or [cut if run.matches(args.run_dir, cut) else f"{run.beside(bond, 'points')}.*.txt"]
    dumps = run.find_dumps(args.run_dir, names, bond)
    interface.follow_load(args.run_dir, bond)
    if bond.load in ("torsion", "bending", "mixed"):
        raise run.Trouble(f"{args.run_dir}: the load is {bond.load}; the cut shows tension, compression, force and shear")
    steps = movie.choose(bond, sorted(dumps), args.frames, args.until)
    return movie.draw(bond, {s: dumps[s] for s in steps}, args.radius, args.magnify), "bond_breaks.gif"


def of_specimen(args):
    try:
        from mpdem import scene, specimen_movie
    except ImportError as missing:
        raise run.Trouble(f"{missing}; apt-get install python3-vtk9") from None
    output = mpdem.load(args.run_dir)
    scene.steps(output.folder)  # what is missing is said before a screen is made
    scene.on_a_screen()
    return specimen_movie.draw(output, args.frames, args.column), "specimen.gif"


def main():
    args = arguments()
    specimen = args.of == "specimen" or args.of is None and glob.glob(os.path.join(glob.escape(args.run_dir), "beads_[0-9]*.vtk"))
    pictures, name = (of_specimen if specimen else of_bond)(args)
    path = args.out or os.path.join(args.run_dir, name)
    movie.write(pictures, path, DURATION, LAST)
    print(f"  written: {path}, {len(pictures)} frames, {os.path.getsize(path) / 1e3:.0f} kB")


if __name__ == "__main__":
    run.end_with_message("mpdem_movie.py", main)
