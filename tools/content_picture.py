#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Picture of a packing whose bonds are coloured by their content, beside the distribution of the contents.

    tools/content_picture.py GRAINS CEMENT PICTURE.png

GRAINS is a dump with the columns id x y z radius, CEMENT one with x y z radius c_bond: the beads_at.STEP.txt and
cement_at.STEP.txt of a run of examples/specimen. A bond joins the two grains whose surfaces are nearest to the middle of its
points. Needs Debian's python3-numpy, python3-pandas and python3-matplotlib.
"""
import argparse
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    import numpy as np
    import pandas as pd
    from mpdem import figures, plots, run, tables
except ImportError as missing:
    sys.exit(
        f"content_picture.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )


def read(path, columns):
    """Columns of a text dump of LIGGGHTS."""
    table = tables.read_dump(path)[1]
    lacking = [c for c in columns if c not in table]
    if lacking:
        raise run.Trouble(f"{path}: lacks the column {lacking[0]}; needs {' '.join(columns)}")
    return table


def bonds(grains, points, of_grain, of_cement):
    """IDs of both grains, and content, of each bond."""
    centres, radius, ids = grains[["x", "y", "z"]].to_numpy(), grains["radius"].to_numpy(), grains["id"].to_numpy(dtype=int)
    mass = of_grain * 4 / 3 * np.pi * radius**3
    pairs, contents = [], []
    for _, of in points.assign(volume=4 / 3 * np.pi * points["radius"] ** 3).groupby("c_bond"):
        middle = np.average(of[["x", "y", "z"]], axis=0, weights=of["volume"])
        a, b = np.argsort(np.linalg.norm(centres - middle, axis=1) - radius)[:2]
        pairs.append((ids[a], ids[b]))
        contents.append(of_cement * of["volume"].sum() / (mass[a] + mass[b]))
    return pd.DataFrame(pairs, columns=["grain1", "grain2"]), 100 * np.array(contents)


def main():
    p = argparse.ArgumentParser(description="Picture of a packing whose bonds are coloured by their content.")
    p.add_argument("grains", metavar="GRAINS", help="dump with id x y z radius")
    p.add_argument("cement", metavar="CEMENT", help="dump with x y z radius c_bond")
    p.add_argument("picture", metavar="PICTURE.png")
    p.add_argument("--grain-density", metavar="D", type=float, default=2500.0, help="kg/m3 (2500)")
    p.add_argument("--cement-density", metavar="D", type=float, default=2710.0, help="kg/m3 (2710)")
    args = p.parse_args()
    grains = read(args.grains, ["id", "x", "y", "z", "radius"])
    points = read(args.cement, ["x", "y", "z", "radius", "c_bond"])
    if len(grains) < 2 or points.empty:
        raise run.Trouble("needs two grains and some cement")
    pairs, contents = bonds(grains, points, args.grain_density, args.cement_density)
    figures.save(plots.coloured_bonds(grains.set_index(grains["id"].astype(int)), pairs, contents, "bond content (%)"), args.picture, 200)
    print(f"{len(contents)} bonds, content {contents.min():.4g} to {contents.max():.4g} %, mean {contents.mean():.4g} %")


if __name__ == "__main__":
    run.end_with_message("content_picture.py", main)
