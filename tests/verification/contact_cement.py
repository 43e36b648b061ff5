#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Stiffness of `bond_stiffness` with `grains elastic` beside contact-cement theory: a decade of thickness, two of the cement's modulus.

Rings between touching beads of glass, with ten cells across the width, beside the integral equation of thin_layer.py, the finite elements of
elastic_bond.py, half-spaces in place of spheres, and the published fit.  Rows that the table has are not computed again.

    MPDEM_EXE=build/liggghts-mpdem contact_cement.py doc/data/contact_cement.csv doc/data/contact_cement.png
"""
import csv
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "system"))
from elastic_bond import solve_case  # noqa: E402
from elastic_sphere import isotropic  # noqa: E402
from test_elastic_grains import cell_of, scene  # noqa: E402
from test_elastic_grains import stiffness as of_program  # noqa: E402
from thin_layer import between_spheres, formula, halfspace, stiffness  # noqa: E402

R, GLASS, NU, INNER = 5e-3, (70e9, 0.22), 0.25, 0.2  # inner radius over the outer one
OUTER = (0.1, 0.178, 0.316)  # over R
MODULI = (0.6e9, 6e9, 60e9)
CELLS = {0.6e9: (10,), 6e9: (10,), 60e9: (10,)}  # across the width
COLUMNS = [
    "outer_m",
    "inner_m",
    "largest_thickness_m",
    "cement_Pa",
    "cells",
    "load",
    "program_N_per_m",
    "integral_N_per_m",
    "finite_elements_N_per_m",
    "integral_disc_N_per_m",
    "halfspace_disc_N_per_m",
    "fit_disc_N_per_m",
]


def case_of(outer, modulus):
    return {
        "shape": "flat",
        "radius": [R, R],
        "gap": 0.0,
        "inner": INNER * outer * R,
        "outer": outer * R,
        "axis": "z",
        "elastic": list(isotropic(modulus, NU)),
        "grain": [list(GLASS)] * 2,
    }


def integral(case, modulus, load):
    return stiffness(load, R, case["inner"], case["outer"], (modulus, NU), GLASS)


def rows_of(outer, modulus, cells):
    case, cement = case_of(outer, modulus), (modulus, NU)
    a = case["outer"]
    with tempfile.TemporaryDirectory() as folder:
        found = of_program(Path(folder), scene(case, cell_of(case, cells)))
    for load in ("tension", "shear"):
        values = [found[load], integral(case, modulus, load), solve_case(case, load, 16, 6).stiffness, stiffness(load, R, 0.0, a, cement, GLASS)]
        values += [halfspace(lambda r: r * r / R, 0.0, a, cement, GLASS), formula(R, a, cement, GLASS)] if load == "tension" else [float("nan")] * 2
        yield [f"{x:.5g}" for x in (a, case["inner"], between_spheres(R)(a), modulus)] + [str(cells), load] + [f"{x:.6g}" for x in values]


def read(file):
    with open(file, encoding="utf-8", newline="") as f:
        return [{k: v if k == "load" else float(v) for k, v in row.items()} for row in csv.DictReader(f)]


def measure(file):
    if not Path(file).exists():
        Path(file).write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    for modulus, outer, cells in sorted(((m, a, n) for m in MODULI for a in OUTER for n in CELLS[m]), key=lambda point: point[2]):
        if any(abs(r["outer_m"] / (outer * R) - 1) < 1e-6 and r["cement_Pa"] == modulus and r["cells"] == cells for r in read(file)):
            continue
        rows = list(rows_of(outer, modulus, cells))
        with open(file, "a", encoding="utf-8", newline="") as f:
            csv.writer(f, lineterminator="\n").writerows(rows)
        print(*rows, sep="\n", flush=True)


def draw(file, picture):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"font.size": 8, "legend.fontsize": 6.5, "axes.linewidth": 0.6, "savefig.dpi": 200, "xtick.direction": "in", "ytick.direction": "in"})
    styles = {
        "fit_disc": ("published fit, half-spaces, cement to the line of centres", {"ls": ":"}),
        "halfspace_disc": ("integral equation, half-spaces, cement to the line of centres", {"ls": "--"}),
        "integral": ("integral equation, spheres, ring", {"ls": "-"}),
        "program": ("bond_stiffness, ring", {"ls": "", "marker": "o", "ms": 4}),
    }
    colors = dict(zip(MODULI, ("#6aa69a", "#d98b4a", "#1b2a49")))
    fig, axes = plt.subplots(1, 2, figsize=(7.5, 4.0))
    fig.subplots_adjust(left=0.08, right=0.99, bottom=0.11, top=0.79, wspace=0.2)
    for ax, load in zip(axes, ("tension", "shear")):
        for modulus, color in colors.items():
            rows = [r for r in read(file) if r["load"] == load and r["cement_Pa"] == modulus and r["cells"] == max(CELLS[modulus])]
            rows.sort(key=lambda r: r["outer_m"])
            for column, (_, style) in styles.items():
                ax.plot([1e3 * r["largest_thickness_m"] for r in rows], [1e-6 * r[f"{column}_N_per_m"] for r in rows], color=color, lw=1.0, **style)
        ax.set(xscale="log", yscale="log", xlabel="largest thickness of the cement, mm", ylabel=f"stiffness in {load}, MN/m")
        ax.set_title(load, fontsize=8)
        ax.xaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_major_formatter("{x:g}")
    lines = [plt.Line2D([], [], color="0.3", lw=1.0, label=label, **style) for label, style in styles.values()]
    lines += [plt.Line2D([], [], color=c, lw=4, label=f"cement of {m / 1e9:g} GPa between glass beads of 10 mm") for m, c in colors.items()]
    fig.legend(handles=lines, frameon=False, ncol=2, loc="upper center", handlelength=2.5)
    fig.savefig(picture)


def main():
    measure(sys.argv[1])
    if len(sys.argv) > 2:
        draw(*sys.argv[1:3])


if __name__ == "__main__":
    main()
