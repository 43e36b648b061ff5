# SPDX-License-Identifier: GPL-2.0-or-later
"""What is symmetric stays symmetric: mirrored at the plane between equal grains, and rotated by 90 degrees about their line.

Grid, lattice and shapes have both symmetries, the motion of the grains too: one goes down as the other goes up. Sums
run in different orders, so rounding is all that may differ. It stays rounding as long as nothing amplifies it: in the
elastic bond, and with viscosity through failure. Softening without viscosity is unstable: there a difference of 1e-11
grows tenfold in a hundred steps or less, and where the crack goes to one side, rounding decides which.
"""
import numpy as np
import pytest
from scipy.spatial import cKDTree
from scenes import RADIUS, cement, dump, pair, point_quantities, run, thermo

CELL = 2e-4
SHAPES = {
    "flat": ("flat", "inner 1e-3 outer 2e-3", 0.0),
    "meniscus": ("meniscus", "neck 1.6e-3 inner 8e-4", 0.0),
    "meniscus across a gap": ("meniscus", "neck 1e-3", 5e-4),
    "coating": ("coating", "thickness 4e-4 cap 24 inner 8e-4", 0.0),
}
DAMAGE = "damage tensor B0 9.6e6 cutoff 0.9 viscosity 1e-6"
TENSORS = ["damage", "stress"]
PARTS = ["xx", "yy", "zz", "yz", "xz", "xy"]


def apart(speed, ramp):
    """Both grains, in opposite directions, each at half the speed."""
    x, half = f"v_t/{ramp}", 0.5 * speed
    return (
        f"variable t equal step*dt\n"
        f'variable v equal "(v_t<{ramp})*0.5*{half}*(1-cos(PI*{x}))+(v_t>={ramp})*{half}"\n'
        f'variable d equal "(v_t<{ramp})*0.5*{half}*(v_t-{ramp}/PI*sin(PI*{x}))+(v_t>={ramp})*{half}*(v_t-0.5*{ramp})"\n'
        "variable w equal -v_v\nvariable c equal -v_d\n"
        "fix down first move variable NULL NULL v_c NULL NULL v_w\nfix up second move variable NULL NULL v_d NULL NULL v_v\n"
    )


def fields(points, start):
    """Displacement and tensors, each with the size that counts as 1."""
    u = np.column_stack([points[c] - start[c] for c in "xyz"])
    tensors = []
    for name in TENSORS:
        xx, yy, zz, yz, xz, xy = (points[f"c_{name}_{p}"] for p in PARTS)
        tensors.append(np.stack([np.stack([xx, xy, xz], -1), np.stack([xy, yy, yz], -1), np.stack([xz, yz, zz], -1)], -1))
    return u, tensors


def asymmetry(points, start, R):
    """Largest difference between the fields and themselves after the orthogonal map R, over their largest component."""
    X = np.column_stack([start[c] for c in "xyz"])
    distance, other = cKDTree(X @ R.T).query(X)  # the point that comes to lie on each
    assert distance.max() < 1e-12 * abs(X).max() and len(set(other)) == len(X), "the points themselves are not symmetric"
    u, tensors = fields(points, start)
    worst = abs(u - (u @ R.T)[other]).max() / abs(u).max()
    for T in tensors:
        if abs(T).max() > 0:
            worst = max(worst, abs(T - (R @ T @ R.T)[other]).max() / abs(T).max())
    return worst


MAPS = {"mirror": np.diag([1.0, 1, -1]), "quarter turn": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])}


def scene(name, damage, steps, every, speed=4.0):
    shape, words, gap = SHAPES[name]
    text = pair(CELL / 2, gap=gap, shape=shape, cement=words)
    # Dampers, since rounding feeds the fastest vibration of the links, which nothing else would take.
    text += cement(CELL, 1.2e-8, axis="radial", damage=damage, couple="kn auto kt auto damping 0.1")
    text += point_quantities([f"{t}_{p}" for t in TENSORS for p in PARTS])
    text += dump(every, ["x", "y", "z"] + [f"c_{t}_{p}" for t in TENSORS for p in PARTS])
    columns = ["f_cem[2]"] + [f"f_bond[{i}]" for i in range(1, 13)]
    return text + apart(speed, 4e-6) + thermo(every, columns) + f"run {steps}\n"


def check_forces(t, name, figures):
    force = np.column_stack([t[f"f_bond[{i}]"] for i in range(1, 13)])
    size = abs(force[:, 8]).max()
    figures.below(f"{name}: sum of the forces on both grains", abs(force[:, 0:3] + force[:, 6:9]).max() / size, 7e-11)
    figures.below(f"{name}: force across the line of centres", abs(force[:, [0, 1, 6, 7]]).max() / size, 2e-13)
    figures.below(f"{name}: moment over force times radius", abs(force[:, [3, 4, 5, 9, 10, 11]]).max() / (size * RADIUS), 1e-12)


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", SHAPES)
def test_elastic(name, ranks, tmp_path, figures):
    done = run(scene(name, "damage none", 600, 300), tmp_path, ranks)
    for what, R in MAPS.items():
        worst = max(asymmetry(done.points(step), done.points(0), R) for step in (300, 600))
        figures.below(f"{name}, elastic, {ranks} ranks: asymmetry under the {what}", worst, 1e-11)
    check_forces(done.table(), f"{name}, elastic, {ranks} ranks", figures)


@pytest.mark.parametrize("cracks", ["bonds", "split"])
@pytest.mark.parametrize("name", SHAPES)
def test_through_failure(name, cracks, tmp_path, figures, long):
    if not long and (name, cracks) in (("coating", "bonds"), ("flat", "split")):
        pytest.skip("runs with --long only")
    done = run(scene(name, f"{DAMAGE} cracks {cracks}", 1000, 100, speed=12.0), tmp_path)
    t = done.table()
    load = abs(t["f_bond[9]"])
    assert load[-1] < 0.02 * load.max(), "the bond is not broken"
    for what, R in MAPS.items():
        worst = max(asymmetry(done.points(int(step)), done.points(0), R) for step in t["step"][1:])
        figures.below(f"{name}, cracks {cracks}, through failure ({t['f_cem[2]'][-1]:.0f} points): asymmetry under the {what}", worst, 1e-10)
    check_forces(t, f"{name}, cracks {cracks}, through failure", figures)
