# SPDX-License-Identifier: GPL-2.0-or-later
"""Stiffness of an undamaged bond between two grains, measured through a LIGGGHTS script, and its references."""
import json
from pathlib import Path

import numpy as np
from scenes import RADIUS, VTI, cement, deform, edit, pair, run, thermo

VERIFICATION = Path(__file__).parent.parent / "verification"
# Options of create_cement by shape, as the cases of the references have them.
WORDS = {"flat": ("outer", "inner"), "meniscus": ("neck", "contact", "inner"), "coating": ("thickness", "cap", "inner")}


def references():
    """Cases of tests/verification/bond_stiffness.json by name."""
    return json.loads((VERIFICATION / "bond_stiffness.json").read_text())["cases"]


def measure(
    directory,
    load,
    shape,
    words,
    cell,
    gap=0.0,
    radius=RADIUS,
    elastic=VTI,
    axis="global 0 0 1",
    basis="quadratic",
    kn="auto",
    at="surface",
    duration=16e-6,
    ranks=1,
    cracks="bonds",
):
    """Force per displacement of grain 2 (tension, shear: N/m) or moment per rotation (torsion, bending: N m/rad).

    The grain is moved smoothly and then held for a quarter of the time, over which what is left of the vibration
    averages out. Damping of the links removes the vibration that the rotation in 400 intervals excites.
    """
    timestep = 0.35 * cell / (elastic[1] / 2710) ** 0.5 * (0.5 if basis == "linear" else 1.0)
    amount = 1e-8 if load in ("tension", "shear") else 1e-5
    half_box = (radius + 1e-3, radius + 1e-3, 2 * radius + gap / 2 + 1e-3)
    script = pair(cell / 2, gap=gap, cement=words, shape=shape, radius=radius, half_box=half_box)
    fixes = cement(cell, timestep, elastic=elastic, axis=axis, couple=f"kn {kn} kt {kn} at {at} damping 0.5")
    script += edit(fixes, f"cell {cell:.15g} ", f"cell {cell:.15g} basis {basis} cracks {cracks} ")
    script += deform(load, amount, duration, timestep, 2 * radius + gap)
    script += "unfix pull\nfix pull second move linear 0 0 0\n"
    script += thermo(4, ["v_load"]) + f"run {round(duration / 4 / timestep)}\n"
    force = run(script, directory, ranks).table()["v_load"]
    swing = np.abs(force / force.mean() - 1).max()
    assert swing < 0.1, f"{load}: the load still swings by {swing:.2g}"
    return force.mean() / amount


def measure_case(directory, case, load, cell, duration=10e-6, **options):
    """The same of a case of the references, bonds stiff enough for 10 us."""
    words = " ".join(f"{w} {case[w]:.15g}" for w in WORDS[case["shape"]])
    axis = "global 0 0 1" if case["axis"] == "z" else case["axis"]
    return measure(
        directory,
        load,
        case["shape"],
        words,
        cell,
        gap=case["gap"],
        radius=case["radius"],
        elastic=tuple(case["elastic"]),
        axis=axis,
        duration=duration,
        **options,
    )
