#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Bar of material points pulled apart: how wide is the band in which the damage law localises?

A bar of length L along z, two cells wide, hangs between two large grains, its points from a file
(create_cement ... file), two a cell and direction.  One layer in the middle has a little damage, as if its B0
were 0.99 of that of the others.  The energy dissipated and released over that of a unit volume, sqrt2 B0 W(m), and the
cross-section is the effective width of the band.
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "system"))
from scenes import edit, pull, run, thermo  # noqa: E402
import scenes  # noqa: E402

E, B0, DCUT, RHO, LENGTH = 40e9, 9.6e3, 0.9, 2710.0, 4e-3
RADIUS = 500 * LENGTH  # the ends are flat within 1e-4 of a cell


def work(m):
    """W(m): work of a unit volume to failure over sqrt2 B0 (Bazant and Oh's band, see theory.md)."""
    keep = 1 - DCUT
    spent = -math.log(keep) if m == 1 else (1 - keep ** (1 - m)) / (1 - m)
    return spent + keep ** (1 - m) / 2


def spent(m, D):
    """Energy a unit volume has spent on damage D, over sqrt2 B0."""
    return -math.log(1 - D) if m == 1 else (1 - (1 - D) ** (1 - m)) / (1 - m)


def band(m):
    """Cells: a hat of strain on a knot, 3/4 at the two nearest layers, which fail, 1/4 at the next two."""
    beside = 1 - (1 - DCUT) * 3 ** (2 / (1 + m))
    return 1 + (spent(m, beside) if beside > 0 else 0) / work(m)


def lattice(cells, per_cell, width=2):
    """Points of the bar and their spacing."""
    s = LENGTH / cells / per_cell
    n, k = cells * per_cell, width * per_cell
    z = (np.arange(n) - n / 2 + 0.5) * s
    x = (np.arange(k) - k / 2 + 0.5) * s
    return np.array([(a, b, c) for a in x for b in x for c in z]), s


def bar(
    directory,
    cells,
    m,
    per_cell=2,
    speed=0.02,
    stretch=1.2,
    damping=0.3,
    cell_factor=1.0,
    regularization=None,
    breaks="in the middle",
    couple="kn auto kt auto",
    share=0.9,
):
    """regularization: the words of fix mpm in place of a crack band with exponent m.  breaks: where the layer with a little damage is, or how far it goes
    from the first grain.
    couple: stiffness of the links.  share: of the stable step."""
    X, s = lattice(cells, per_cell)
    h = LENGTH / cells * cell_factor
    if breaks == "in the middle":
        weak, strength = np.abs(X[:, 2] - X[X[:, 2] > 0, 2].min()) < 0.1 * s, 0.99
    else:
        weak, strength = X[:, 2] - X[:, 2].min() < breaks, 0.97
    # Strength goes as (1 - D)^((3 - m)/2): that of 0.99 or 0.97 B0
    D0 = np.where(weak, 1 - strength ** (1 / (3 - m)), 0.0)
    first = X[:, 2] == X[:, 2].min()
    last = X[:, 2] == X[:, 2].max()
    directory.mkdir(parents=True, exist_ok=True)
    rows = np.column_stack([X, np.full(len(X), s**3), 0 * D0, 0 * D0, D0, 0 * D0, 0 * D0, 0 * D0, first * s**2, last * s**2])
    np.savetxt(directory / "bar.txt", rows, fmt="%.17g", header="x y z volume dxx dyy dzz dyz dxz dxy area_i area_j", comments="")
    area = (X[:, 0].max() - X[:, 0].min() + s) ** 2
    Gf = math.sqrt(2) * B0 * work(m) * band(m) * h  # makes fix mpm use m
    c, e0 = math.sqrt(E / RHO), 2**0.25 * math.sqrt(B0 / E)
    v = speed * c * e0
    box = " ".join(f"{-b:g} {b:g}" for b in (1.1 * RADIUS, 1.1 * RADIUS, 2.2 * RADIUS + LENGTH))
    text = scenes.host() + f"region box block {box} units box\ncreate_box 2 box\n"
    for side in (-1, 1):
        text += f"create_atoms 1 single 0 0 {side * (RADIUS + LENGTH / 2):.15g} units box\n"
    text += f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n" + scenes.NEIGHBOURS
    text += f"create_cement calcite pair 1 2 file bar.txt spacing {s:.15g}\n"
    text += scenes.cement(
        h,
        1e-9,
        damage=f"damage tensor B0 {B0} cutoff {DCUT} regularization {regularization or f'crackband {Gf:.15g}'} "
        f"timestep auto {share} quasistatic 1 {damping}",
        couple=couple,
    )
    text = edit(text, "vti 60000000000 40000000000 0.25 0.2 18000000000", f"isotropic {E} 0.0")
    # Until the band, if it were two cells, has come to the strain at failure
    stretch = 0.3 + stretch * 2 * h / LENGTH * (1 - DCUT) ** (-(1 + m) / 2)
    duration = stretch * e0 * LENGTH / v
    text += pull(v, 0.1 * duration) + thermo(20, ["f_bond[13]", "f_bond", "f_cem[8]", "f_cem[9]", "f_cem[2]", "f_cem[12]"])
    dt = share * 2 / math.sqrt(6) * h / c
    text += f"dump d calcite custom {int(duration / dt)} end.*.txt id z c_D\n".replace("c_D", "c_damage")
    text = text.replace("dump d", "compute damage calcite mpm/atom cem damage\ndump d")
    text += f"run {int(duration / dt)}\n"
    done = run(text, directory)
    t = done.table()
    end = done.points(int(duration / dt), "end")
    layers = end["c_damage"][np.argsort(end["z"], kind="stable")].reshape(cells * per_cell, -1)
    profile = [round(float(d), 3) for d in layers.mean(axis=1) if d.max() > 0.02]
    spent = t["f_cem[8]"][-1] + t["f_cem[9]"][-1]
    gap, force = t["f_bond[13]"], t["f_bond"]
    under_curve = float(((gap[1:] - gap[:-1]) * (force[1:] + force[:-1])).sum() / 2)
    return {
        "energy": spent / area,
        "under_curve": under_curve / area,
        "width": spent / (math.sqrt(2) * B0 * work(m) * area) / h,
        "ratio": spent / (Gf * area),
        "failed": t["f_cem[2]"][-1] / (len(X) / (cells * per_cell)),
        "peak": t["f_bond"].max() / area / (2**0.25 * math.sqrt(B0 * E)),
        "end": t["f_bond"][-1] / t["f_bond"].max(),
        "profile": profile,
        "table": t,
        "steps": t["step"][-1],
    }


def at_energy(directory, cells, finest=80, most=45.0, **options):
    """The bar with one energy per crack area at any number of cells: `most` sqrt2 B0 times the finest cell."""
    lo, hi = -0.99, 2.999
    for _ in range(60):
        m = (lo + hi) / 2
        lo, hi = (m, hi) if work(m) * band(m) < most * cells / finest else (lo, m)
    return {"m": m, **bar(directory, cells, m, **options)}


if __name__ == "__main__":
    where = Path(sys.argv[1])
    for cells in (10, 20, 40, 80):
        r = at_energy(where / str(cells), cells)
        print(cells, {k: v if k == "profile" else round(float(v), 4) for k, v in r.items() if k != "table"}, flush=True)
