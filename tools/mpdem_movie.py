#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""A picture that moves: the cut through a bond as it breaks, beside tension against opening of the gap.

    tools/mpdem_movie.py RUN_DIR [--out bond_breaks.gif] [--frames 40] [--magnify 40]

Reads bond_NAME.csv of `fix mpm/couple` and the text dumps cut_NAME.*.txt of a slice at y = 0 (x y z, id, and compute mpm/atom
with the ID damage and the ID failed), as examples/pair_flat writes them. Displacements are drawn `magnify` times as large as they are.
Frames lie evenly along the curve of tension against opening. Needs Debian's python3-numpy, python3-pandas, python3-matplotlib and python3-pil.
"""
import argparse
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    from PIL import Image
    from mpdem import movie, run
except ImportError as missing:
    sys.exit(
        f"mpdem_movie.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib python3-pil, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )

COLOURS = 48  # of the palette, that of the last frame: it has all of them
LAST = 2500  # ms that the last frame stays


def arguments():
    p = argparse.ArgumentParser(description="A picture that moves, of a bond that breaks.")
    p.add_argument("run_dir", metavar="RUN_DIR", help="folder of the run's output")
    p.add_argument("--bond", metavar="CSV", help="table of fix mpm/couple (default: the only bond.csv or bond_*.csv in RUN_DIR)")
    p.add_argument("--cut", metavar="DUMP", nargs="+", help="dumps of the slice, names or a pattern (default: cut_NAME.*.txt)")
    p.add_argument("--out", metavar="GIF", help="where to write (default: bond_breaks.gif in RUN_DIR)")
    p.add_argument("--frames", metavar="N", type=int, default=40, help="how many, at most (40)")
    p.add_argument("--magnify", metavar="M", type=float, default=40.0, help="factor on displacements (40)")
    p.add_argument("--radius", metavar="R", type=float, default=0.005, help="of the two grains, m (0.005)")
    p.add_argument("--until", metavar="X", type=float, default=1.1, help="end at this multiple of the opening at which the bond is separated (1.1)")
    args = p.parse_args()
    if args.frames < 2 or not args.magnify > 0.0 or not args.radius > 0.0 or not args.until > 0.0:
        p.error("--frames must be at least 2, --magnify, --radius and --until above 0")
    return args


def main():
    args = arguments()
    bond = run.read_bonds(run.find_bond_file(args.run_dir, args.bond))[0]
    dumps = run.find_dumps(args.run_dir, args.cut or [f"{run.beside(bond, 'cut')}.*.txt"], bond)
    steps = movie.choose(bond, sorted(dumps), args.frames, args.until)
    pictures = movie.draw(bond, {s: dumps[s] for s in steps}, args.radius, args.magnify)
    frames = [Image.fromarray(p) for p in pictures]
    palette = frames[-1].quantize(COLOURS, dither=Image.Dither.NONE)
    frames = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames]
    path = args.out or os.path.join(args.run_dir, "bond_breaks.gif")
    try:
        frames[0].save(path, save_all=True, append_images=frames[1:], duration=[90] * (len(frames) - 1) + [LAST], loop=0, optimize=True)
    except OSError as e:
        raise run.Trouble(f"{path}: {e.strerror}; name a file in a folder that can be written") from None
    print(f"  written: {path}, {len(frames)} frames, {os.path.getsize(path) / 1e3:.0f} kB")


if __name__ == "__main__":
    run.end_with_message("mpdem_movie.py", main)
