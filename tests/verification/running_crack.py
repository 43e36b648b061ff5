#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy of a crack of `regularization nonlocal` that runs steadily: the slope of the energy spent over the area of the crack.

A strip of cement hangs between two flat grains along its whole length, and has a notch half-way between them at one end. It is drawn apart
and then held so: the pure shear test piece of Rivlin and Thomas 1953. In front of the crack the strip has E e^2/2 times its height of
energy per area, behind it none, so the crack finds the same wherever it is. Points lie on a lattice along the axes of the box; the strip
is turned against it by an angle, or its notch lies elsewhere in the cells. Run with a folder, and cells a length and angles in degrees,
this file measures them, and draws the energy over the way of the crack.
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "system"))
from localisation import band, exponent  # noqa: E402
from scenes import NEIGHBOURS, edit, host, run, thermo  # noqa: E402
import scenes  # noqa: E402

E, B0, DCUT, RHO, LENGTH = 40e9, 9.6e3, 0.9, 2710.0, 2e-4
# Lengths: of the strip across; along it the notch, what the crack runs through before and while it is measured, and what is in front.
HEIGHT, NOTCH, BEFORE, STEADY, AHEAD = 32, 18, 18, 16, 14
LONG = NOTCH + BEFORE + STEADY + AHEAD
SOFTENED = 7  # lengths in front of the notch: it is blunt, and its average no larger than the strength until the strip nearly breaks
OVER = 1.35  # energy of the strip over that of the crack
DAMPING = 0.4  # so that the wake opens soon and does not ring
RAMP, HOLD = 6, 7  # in times that a wave takes across
UNIT = math.sqrt(2) * B0 * LENGTH
IMPLIED = UNIT * sum(band(0.0)[1:])


def spent_share(energy):
    spent, stored = band(exponent(energy / UNIT) if energy else 0.0)[1:]
    return spent / (spent + stored)


def strip(spacing, angle):
    """Points, one cell deep: their places, and along and across the strip, in lengths, both from the middle."""
    n = math.ceil(math.hypot(LONG, HEIGHT) * LENGTH / spacing)
    x, z = np.meshgrid(*2 * [(np.arange(-n, n) + 0.5) * spacing], indexing="ij")
    along, across = (math.cos(angle) * x - math.sin(angle) * z) / LENGTH, (math.sin(angle) * x + math.cos(angle) * z) / LENGTH
    inside = (abs(along) < 0.5 * LONG - 1e-9) & (abs(across) < 0.5 * HEIGHT - 1e-9)
    return tuple(np.concatenate([v, v]) for v in (x[inside], z[inside], along[inside], across[inside])) + (np.repeat([-0.5, 0.5], inside.sum()) * spacing,)


def write_strip(file, spacing, cell, angle, off):
    """off: of the notch from the middle, in spacings."""
    x, z, along, across, y = strip(spacing, angle)
    ahead, beside = along + 0.5 * LONG - NOTCH, abs(across * LENGTH - off * spacing)
    failed = (ahead < 0) & (beside < 0.51 * cell)
    D = np.where(~failed & (beside < 0.51 * LENGTH) & (ahead > -1), np.clip(1.6 * (1 - ahead / SOFTENED), 0.0, 0.85), 0.0)
    np.savetxt(
        file,
        np.column_stack([x, y, z, np.full(len(x), spacing**3), failed, D, D, D, 0 * D, 0 * D, 0 * D]),
        fmt="%.17g",
        header="x y z volume failed dxx dyy dzz dyz dxz dxy",
        comments="",
    )


def crack(directory, cells_a_length, angle=0.0, off=0, energy=None, cracks="split"):
    """energy: asked for; else that which B0 and the length imply.  Of this, damage spends a part. The rest is what the band stores when its middle
    debonds, and runs off in waves."""
    cell, G = LENGTH / cells_a_length, energy or IMPLIED
    spacing, every = cell / 2, round(5 * cells_a_length)
    directory.mkdir(parents=True, exist_ok=True)
    write_strip(directory / "strip.txt", spacing, cell, angle, off)
    radius = 500 * HEIGHT * LENGTH
    n = np.array([math.sin(angle), 0.0, math.cos(angle)])
    text = host() + "region box block " + " ".join(f"{-b:g} {b:g}" for b in (2.2 * radius, 1.1 * radius, 2.2 * radius)) + " units box\ncreate_box 2 box\n"
    for side in (-1, 1):
        text += "create_atoms 1 single " + " ".join(f"{c:.15g}" for c in side * (radius + 0.5 * HEIGHT * LENGTH) * n + 0.0) + " units box\n"
    text += f"set type 1 diameter {2 * radius} density 2500\ngroup grains type 1\n" + NEIGHBOURS
    layer = 1.001 * spacing * (abs(math.cos(angle)) + (abs(math.sin(angle)) if angle else 0.0))
    text += f"create_cement calcite pair 1 2 file strip.txt spacing {spacing:.15g} attach {layer:.15g}\n"
    words = f"nonlocal {LENGTH} imperfection 0" + (f" energy {energy}" if energy else "")
    text += scenes.cement(
        cell, 1e-9, damage=f"damage tensor B0 {B0} cutoff {DCUT} regularization {words} cracks {cracks} timestep auto 0.8 quasistatic 1 {DAMPING}"
    )
    text = edit(text, "vti 60000000000 40000000000 0.25 0.2 18000000000", f"isotropic {E} 0.0")
    c = math.sqrt(E / RHO)
    unit, u = HEIGHT * LENGTH / c, math.sqrt(2 * OVER * G * HEIGHT * LENGTH / E)
    T = RAMP * unit
    text += scenes._motion(n, f'"(v_t<{T})*{u}*(v_t/{T}-sin(2*PI*v_t/{T})/2/PI)+(v_t>={T})*{u}"', f'"(v_t<{T})*{u}/{T}*(1-cos(2*PI*v_t/{T}))"')
    text += thermo(every, ["v_t", "f_cem[8]", "f_cem[9]", "f_cem[12]"]) + scenes.point_quantities(["damage"])
    text += f"dump damaged calcite custom {every} damaged.*.txt id x z c_damage\ndump_modify damaged thresh c_damage >= 0.1\n"
    steps = int((RAMP + HOLD) * unit / (0.8 * 2 / math.sqrt(6) * cell / c))
    t = run(text + f"run {steps // every * every}\n", directory, minutes=9).table()
    return {"G": G, **measure(t, fronts(directory, t["step"], angle, spacing), 2 * spacing, G * spent_share(energy))}


def fronts(directory, steps, angle, spacing):
    """Where the largest damage of the columns of points falls below one half, in lengths from the end of the strip with the notch."""
    found = []
    for step in steps:
        rows = np.array([[float(w) for w in line.split()] for line in (directory / f"damaged.{int(step)}.txt").read_text().splitlines()[9:]])
        most = np.zeros(round(LONG * LENGTH / spacing) + 2)
        if len(rows):
            along = math.cos(angle) * rows[:, 1] - math.sin(angle) * rows[:, 2] + 0.5 * LONG * LENGTH
            np.maximum.at(most, np.floor(along / spacing + 1e-6).astype(int), rows[:, 3])
        last = np.flatnonzero(most >= 0.5).max(initial=0)
        found.append((last + 0.5 + (most[last] - 0.5) / (most[last] - most[last + 1])) * spacing / LENGTH if most[last] >= 0.5 else 0.0)
    return np.array(found)


def measure(t, at, depth, G):
    spent = (t["f_cem[8]"] + t["f_cem[9]"]) / (G * LENGTH * depth)
    steady = (at >= NOTCH + BEFORE) & (at <= NOTCH + BEFORE + STEADY)
    slope, start = np.polyfit(at[steady], spent[steady], 1)
    middle = NOTCH + BEFORE + STEADY / 2
    halves = [np.polyfit(at[steady & h], spent[steady & h], 1)[0] / slope - 1 for h in (at <= middle, at >= middle)]
    return {
        "ratio": slope,
        "halves": halves,
        "speed": np.polyfit(t["v_t"][steady], at[steady], 1)[0] * LENGTH / math.sqrt(E / RHO),
        "imbalance": abs(t["f_cem[12]"][-1]),
        "at": at,
        "spent": spent,
        "line": (slope, start),
    }


def draw(file, results):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig, ax = plt.subplots(figsize=(6.4, 4.2))
    for n, (name, r) in enumerate(results.items()):
        runs = r["at"] > NOTCH + SOFTENED
        ax.plot(r["at"][runs] - NOTCH, r["spent"][runs], ".", ms=3, color=f"C{n}", label=f"{name}: {r['ratio']:.3f}")
        x = np.array([BEFORE, BEFORE + STEADY])
        ax.plot(x, r["line"][0] * (x + NOTCH) + r["line"][1], color=f"C{n}", lw=1)
    ax.set_xlabel("way of the front from the notch, lengths")
    ax.set_ylabel("energy spent, over G times length times depth")
    ax.legend(title="cells a length, angle to the grid: slope over G", fontsize=8, title_fontsize=8)
    fig.tight_layout()
    fig.savefig(file, dpi=130)


if __name__ == "__main__":
    where, results = Path(sys.argv[1]), {}
    for case in sys.argv[2:]:
        cells, degrees, *more = (float(w) for w in case.split(","))
        r = crack(where / case, cells, math.radians(degrees), *(int(m) for m in more[:1]), *more[1:2])
        results[f"{cells:g}, {degrees:g} degrees" + "".join(f", {m:g}" for m in more)] = r
        print(case, {k: np.round(r[k], 4) for k in ("ratio", "halves", "speed", "imbalance")}, flush=True)
    draw(where / "running_crack.png", results)
