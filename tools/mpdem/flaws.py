# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Flaws in the points of a bond: files of `write_cement` in, files for `create_cement ... file` out.

    pores      spheres without cement, until the share `amount` of the volume is gone
    softness   grains of cement, each with a damage of its own from the start: any from 0 to `amount`, each as likely
    contact    the second bead holds in round patches alone, which are the share `amount` of the attached area

`size` is the radius of pores and patches, and that of a sphere of the mean volume of the grains.
"""
import numpy as np

from .run import Trouble

KINDS = ("pores", "softness", "contact")


class Points:
    """The columns of a file, by name."""

    def __init__(self, path):
        with open(path) as f:
            lines = [line for line in f if line.strip() and not line.startswith("#")]
        if len(lines) < 2:
            raise Trouble(f"{path}: no points; write it with write_cement")
        self.names = lines[0].split()
        table = np.array([line.split() for line in lines[1:]], dtype=float)
        self.columns = dict(zip(self.names, table.T))
        lacking = [n for n in ("x", "y", "z", "volume", "dxx", "area_j", "foot_jx", "attached_j") if n not in self.columns]
        if lacking:
            raise Trouble(f"{path}: no column {', '.join(lacking)}; take a file of write_cement")

    def vectors(self, x, y, z):
        return np.column_stack([self.columns[n] for n in (x, y, z)])

    def write(self, path, kept):
        with open(path, "w") as f:
            f.write(" ".join(self.names) + "\n")
            np.savetxt(f, np.column_stack([self.columns[n][kept] for n in self.names]), fmt="%.17g")


def make(kind, amount, size, seed, source, target):
    """Writes the points of `source` with flaws to `target`."""
    points, chance = Points(source), np.random.default_rng(seed)
    kept = np.ones(len(points.columns["x"]), dtype=bool)
    if kind == "pores":
        kept = ~covered(points.vectors("x", "y", "z"), points.columns["volume"], amount, size, chance)
    elif kind == "softness":
        add_damage(points, amount, size, chance)
    elif kind == "contact":
        holds = points.columns["area_j"] > 0.0
        feet = points.vectors("foot_jx", "foot_jy", "foot_jz")[holds]
        points.columns["attached_j"][holds] = covered(feet, points.columns["area_j"][holds], amount, size, chance)
    points.write(target, kept)


def covered(x, weight, share, radius, chance):
    """Those in spheres about random ones of x, as many as cover that share of the weights."""
    inside = np.zeros(len(x), dtype=bool)
    while weight[inside].sum() < share * weight.sum():
        inside |= ((x - x[chance.integers(len(x))]) ** 2).sum(axis=1) < radius**2
    return inside


def add_damage(points, most, size, chance):
    x = points.vectors("x", "y", "z")
    count = max(1, round(points.columns["volume"].sum() / (4 / 3 * np.pi * size**3)))
    middles = x[chance.choice(len(x), size=min(count, len(x)), replace=False)]
    nearest, of = np.full(len(x), np.inf), np.zeros(len(x), dtype=int)
    for i, middle in enumerate(middles):
        square = ((x - middle) ** 2).sum(axis=1)
        closer = square < nearest
        nearest[closer], of[closer] = square[closer], i
    damage = chance.uniform(0.0, most, len(middles))[of]
    for name in ("dxx", "dyy", "dzz"):
        points.columns[name] = damage.copy()
