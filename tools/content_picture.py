#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Picture of a packing whose bonds are coloured by their content, beside the distribution of the contents.

    tools/content_picture.py GRAINS CEMENT PICTURE.png

GRAINS is a dump with the columns id x y z radius, CEMENT one with x y z radius c_bond: the beads_at.STEP.txt and
cement_at.STEP.txt of a run of examples/specimen. A bond joins the two grains whose surfaces are nearest to the middle of its
points. Needs Debian's python3-numpy and python3-matplotlib.
"""
import argparse
import sys

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.collections import EllipseCollection, LineCollection
except ImportError as missing:
    sys.exit(f"content_picture.py: {missing}; apt-get install python3-numpy python3-matplotlib, run with /usr/bin/python3")

AROUND, ABOVE = np.radians(25.0), np.radians(12.0)  # direction of view


def read(path, columns):
    """Columns of a text dump of LIGGGHTS."""
    try:
        with open(path) as f:
            lines = f.read().splitlines()
    except OSError as why:
        sys.exit(f"content_picture.py: {path}: {why.strerror}")
    heads = [n for n, line in enumerate(lines) if line.startswith("ITEM: ATOMS")]
    if len(heads) != 1:
        sys.exit(f"content_picture.py: {path}: has {len(heads)} steps, must be a dump of one")
    names = lines[heads[0]].split()[2:]
    lacking = [c for c in columns if c not in names]
    if lacking:
        sys.exit(f"content_picture.py: {path}: lacks the column {lacking[0]}; needs {' '.join(columns)}")
    rows = np.array([line.split() for line in lines[heads[0] + 1 :]], float).reshape(-1, len(names))
    return {c: rows[:, names.index(c)] for c in columns}


def bonds(grains, points, of_grain, of_cement):
    """Places of the centres of both grains, content and radii of each bond."""
    centres = np.column_stack([grains[c] for c in "xyz"])
    volume = 4 / 3 * np.pi * points["radius"] ** 3
    mass = of_grain * 4 / 3 * np.pi * grains["radius"] ** 3
    pairs, contents = [], []
    for bond in np.unique(points["c_bond"]):
        of = points["c_bond"] == bond
        middle = np.array([np.average(points[c][of], weights=volume[of]) for c in "xyz"])
        a, b = np.argsort(np.linalg.norm(centres - middle, axis=1) - grains["radius"])[:2]
        pairs.append((a, b))
        contents.append(of_cement * volume[of].sum() / (mass[a] + mass[b]))
    return centres, np.array(pairs), 100 * np.array(contents)


def draw(path, grains, centres, pairs, contents):
    fig, (space, spread) = plt.subplots(1, 2, figsize=(7.48, 3.4), gridspec_kw={"width_ratios": [1.25, 1]})
    right = np.array([np.cos(AROUND), np.sin(AROUND), 0.0])
    away = np.array([-np.sin(AROUND) * np.cos(ABOVE), np.cos(AROUND) * np.cos(ABOVE), -np.sin(ABOVE)])
    seen = 1e3 * centres @ np.array([right, np.cross(right, away), away]).T
    wide = 2e3 * grains["radius"]
    space.add_collection(
        EllipseCollection(
            wide, wide, np.zeros(len(wide)), units="xy", offsets=seen[:, :2], transOffset=space.transData, facecolors="none", edgecolors="0.85", lw=0.4
        )
    )
    depth = seen[pairs].mean(axis=1)[:, 2]
    order = np.argsort(-depth)
    size = plt.Normalize(contents.min(), contents.max() + 1e-12)
    lines = LineCollection(
        seen[pairs[order]][:, :, :2], array=contents[order], cmap="viridis", norm=size, linewidths=0.8 + 2.4 * size(contents[order]), capstyle="round"
    )
    space.add_collection(lines)
    space.set_aspect("equal")
    space.set_xlim((seen[:, 0] - wide).min(), (seen[:, 0] + wide).max())
    space.set_ylim((seen[:, 1] - wide).min(), (seen[:, 1] + wide).max())
    space.axis("off")
    fig.colorbar(lines, ax=space, shrink=0.8, pad=0.02, label="bond content, %")
    spread.hist(contents, bins=20, color="0.6")
    spread.set_xlabel("bond content, %")
    spread.set_ylabel("bonds")
    variation = contents.std() / contents.mean()
    spread.set_title(f"{len(contents)} bonds, mean {contents.mean():.3g} %, coefficient of variation {variation:.2g}", fontsize=7)
    fig.tight_layout()
    fig.savefig(path, dpi=200)


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
    if len(grains["id"]) < 2 or not len(points["x"]):
        sys.exit("content_picture.py: needs two grains and some cement")
    centres, pairs, contents = bonds(grains, points, args.grain_density, args.cement_density)
    draw(args.picture, grains, centres, pairs, contents)
    print(f"{len(contents)} bonds, content {contents.min():.4g} to {contents.max():.4g} %, mean {contents.mean():.4g} %")


if __name__ == "__main__":
    main()
