# SPDX-License-Identifier: GPL-2.0-or-later
"""Cylinder bonds in tension, torsion, bending and shear: closed forms, and finite elements with Poisson's effect.

A cylinder of radius a and length L between spheres of radius R >> a. Where Poisson's ratios are zero (torsion: for any)
the field of a cylinder between rigid ends is that of a bar, so E A/L, G J/L and E I/L are exact but for the ends, which
are not plane: the sag a^2/2R of a sphere is taken as its mean over the load's stress. The links are springs of
kn/cell an area at both ends, in series with the bar. Shear has no closed form: Timoshenko's beam comes close to
the finite elements, which are the reference (tests/verification/bond_fe.py, harmonics 0 and 1).

Points sit at the centroids of their parts of the cylinder, so they carry its second moment of area with an error of
order 2 (0.5 % at 8 cells across and two points a cell and direction). At the ends, where the stress is singular at the rim
(Poisson) and the grid need not fit the sphere, at least order 1 is to be expected. This contribution jumps: spheres this large
are nearly planes of the lattice, and what reaches less than a twelfth of a spacing into a layer gets no points there
(six samples a direction in cut cells); with 16 samples the errors in shear are -3.2, -1.6, -1.1 and -0.4 %. The order
is therefore that of the line through four sizes, not of two.
"""
import math

import numpy as np
import pytest
from elastic_pair import measure, measure_case, references
from scenes import pair, run
from test_point_file import read

LOADS = ("tension", "torsion", "shear", "bending")
CYLINDER = references()["cylinder"]
RADIUS, LENGTH, A = (CYLINDER[w] for w in ("radius", "gap", "outer"))
CELLS = (4, 6, 8, 12)  # across
COARSE, FINE = A / 2, A / 4
NO_POISSON = (60e9, 40e9, 0.0, 0.0, 18e9)
AREA, INERTIA = math.pi * A**2, math.pi / 4 * A**4


def bar(load, cell, kn):
    """Bar of the mean length of its fibres and the springs of the links at both ends, in series."""
    modulus, section, sag = {
        "tension": (NO_POISSON[1], AREA, A**2 / (2 * RADIUS)),
        "torsion": (NO_POISSON[4], 2 * INERTIA, 2 * A**2 / (3 * RADIUS)),
        "bending": (NO_POISSON[1], INERTIA, 2 * A**2 / (3 * RADIUS)),
    }[load]
    return 1 / ((LENGTH + sag) / (modulus * section) + 2 * cell / (kn * section))


@pytest.mark.parametrize("load, limit", [("tension", 0.005), ("torsion", 0.01), ("bending", 0.01)])
@pytest.mark.parametrize("stiff", [200, 1])
def test_closed_forms(load, limit, stiff, tmp_path, figures):
    """Links 200 times as stiff as the cement, the default, and just as stiff: they take a tenth of the motion then."""
    kn = stiff * NO_POISSON[1]
    words = f"outer {A:.15g} inner 0"
    errors = []
    for cell in (COARSE, FINE):
        k = measure(tmp_path / f"{cell}", load, "flat", words, cell, gap=LENGTH, radius=RADIUS, elastic=NO_POISSON, kn=f"{kn:.15g}")
        errors.append(k / bar(load, cell, kn) - 1)
    figures.note(f"cylinder, no Poisson's effect, kn {stiff} Ez, {load}: signed errors at 4 and 8 cells across", " ".join(f"{e:+.4f}" for e in errors))
    figures.below(f"cylinder, no Poisson's effect, kn {stiff} Ez, {load}: error at 8 cells across", abs(errors[1]), limit)


def test_links_at_the_points(tmp_path, figures):
    """`at points`: the springs, as stiff as the cement, hold the bar at the points of the outermost layer.

    What lies beyond them, half a spacing, is not free of strain in the cell that it shares with what is loaded: order 1.
    """
    kn, cell = NO_POISSON[1], FINE
    words = f"outer {A:.15g} inner 0"
    made = pair(cell / 2, gap=LENGTH, cement=words, radius=RADIUS, half_box=(0.026, 0.026, 0.0525))
    run(made + "write_cement cement.txt\n", tmp_path / "made")
    points = read(tmp_path / "made" / "cement.txt")
    ends = [np.average(points["z"], weights=points[area]) for area in ("area_i", "area_j")]
    bar = 1 / (abs(ends[1] - ends[0]) / (NO_POISSON[1] * AREA) + 2 * cell / (kn * AREA))
    k = measure(tmp_path, "tension", "flat", words, cell, gap=LENGTH, radius=RADIUS, elastic=NO_POISSON, kn=f"{kn:.15g}", at="points")
    figures.note("cylinder, links at the points: share of its length between the points", f"{abs(ends[1] - ends[0]) / LENGTH:.4f}")
    figures.below("cylinder, links at the points, tension: error at 8 cells across", abs(k / bar - 1), 0.02)


@pytest.mark.parametrize("load, limit", [("tension", 0.005), ("torsion", 0.01), ("shear", 0.025), ("bending", 0.0125)])
def test_against_finite_elements(load, limit, tmp_path, figures):
    reference = CYLINDER["stiffness"][load]
    assert reference["relative_uncertainty"] < 1e-4
    errors = [measure_case(tmp_path / f"{n}", CYLINDER, load, 2 * A / n, duration=16e-6) / reference["value"] - 1 for n in CELLS]
    order = -np.polyfit(np.log(CELLS), np.log(np.abs(errors)), 1)[0]
    figures.note(f"cylinder, {load}: signed errors at {CELLS} cells across", " ".join(f"{e:+.4f}" for e in errors))
    figures.note(f"cylinder, {load}: order", f"{order:.2f}")
    figures.below(f"cylinder, {load}: error at 8 cells across", abs(errors[2]), limit)
    assert order > 1.0


def test_timoshenko():
    """The reference for shear against V17: an independent, approximate closed form."""
    E, nu, G = CYLINDER["elastic"][1], CYLINDER["elastic"][3], CYLINDER["elastic"][4]
    kappa = 6 * (1 + nu) / (7 + 6 * nu)
    beam = 1 / (LENGTH**3 / (12 * E * INERTIA) + LENGTH / (kappa * G * AREA))
    assert abs(beam / CYLINDER["stiffness"]["shear"]["value"] - 1) < 0.05
