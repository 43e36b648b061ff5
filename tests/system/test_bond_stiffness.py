# SPDX-License-Identifier: GPL-2.0-or-later
"""Stiffness of menisci and coatings against finite elements (tests/verification/bond_fe.py).

The attached area is all of the wetted part of the spheres. 8 cells across the neck: across its diameter, or from the
inner to the outer rim where `inner` makes it a ring.
"""
import math
import subprocess
import sys

import pytest
from elastic_pair import VERIFICATION, measure_case, references

CASES = references()
ACROSS = {
    "meniscus across a gap": 2e-3,
    "meniscus at 30 degrees": 2e-3,
    "meniscus of touching beads": 0.8e-3,
    "coating that ends at its ring": 1.24e-3,
    "coating": 1.24e-3,
}


@pytest.mark.parametrize("tool", ["axisymmetric_fe.py", "bond_fe.py"])
def test_finite_elements_themselves(tool):
    """Closed forms of cylinders and rings, volumes, independence of the axis where it is isotropic."""
    done = subprocess.run([sys.executable, "-B", VERIFICATION / tool, "--self-check"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.count("ok  ") > 5 and "FAIL" not in done.stdout, done.stdout + done.stderr


def test_references_are_of_this_solver():
    """The stored figures are what the tool gives for the cases stored with them; three meshes tell."""
    from bond_fe import solve_case

    for name, case in CASES.items():
        for load, (_, value, uncertainty) in solve_case(case, case["stiffness"], levels=3).items():
            stored = case["stiffness"][load]
            assert stored["relative_uncertainty"] < 1e-4, name
            assert abs(value - stored["value"]) < 3 * uncertainty + 1e-8 * value, f"{name}, {load}: {value} +- {uncertainty}"


@pytest.mark.parametrize(
    "name, load",
    [
        pytest.param(name, load, marks=[pytest.mark.long] if load in ("shear", "torsion") and "meniscus" not in name else [])
        for name in ACROSS
        for load in CASES[name]["stiffness"]
    ],
)
def test_eight_cells_across(name, load, tmp_path, figures):
    error = measure_case(tmp_path, CASES[name], load, ACROSS[name] / 8) / CASES[name]["stiffness"][load]["value"] - 1
    figures.note(f"{name}, {load}: signed error of the stiffness", f"{error:+.4f}")
    figures.below(f"{name}, {load}: error of the stiffness, 8 cells across the neck", abs(error), 0.02)


@pytest.mark.parametrize(
    "name, coarse, fine", [("meniscus across a gap", 2.5e-4, 1e-4), ("meniscus of touching beads", 2e-4, 1e-4), ("coating that ends at its ring", 2e-4, 1e-4)]
)
def test_finer_cells(name, coarse, fine, tmp_path, figures):
    """Signs differ, so there is no order to be read off two of them; at order 2 the error would fall to 0.16 to 0.25."""
    exact = CASES[name]["stiffness"]["shear"]["value"]
    errors = [measure_case(tmp_path / str(cell), CASES[name], "shear", cell) / exact - 1 for cell in (coarse, fine)]
    figures.note(f"{name}, shear: signed errors with cells of {coarse:g} and {fine:g}", " ".join(f"{e:+.4f}" for e in errors))
    figures.below(f"{name}, shear: larger cells", abs(errors[0]), 0.02)
    figures.below(f"{name}, shear: smaller cells", abs(errors[1]), 0.003)


@pytest.mark.parametrize("name, limit", [("coating", 0.01), ("coating across a gap", 0.02)])
def test_unbonded_gap(name, limit, tmp_path, figures):
    """Beyond the ring in which they meet, two shells have nodes of their own (src/USER-MPDEM/fracture/unbonded_gap.h).

    The end of the gap is known to a fraction of a cell, which is what the errors are: no order, but a bound. With
    nodes that the shells share the errors are 8 and 6 %, 25 and 19 % across a gap.
    """
    exact = CASES[name]["stiffness"]["tension"]["value"]
    cells = (2e-4, 4e-4 / 3)
    errors = [measure_case(tmp_path / str(cell), CASES[name], "tension", cell) / exact - 1 for cell in cells]
    figures.note(f"{name}, tension: signed errors with cells of {cells[0]:.3g} and {cells[1]:.3g}", " ".join(f"{e:+.4f}" for e in errors))
    figures.below(f"{name}, tension: error with 2 and 3 cells across the shell", max(map(abs, errors)), limit)


def test_unbonded_gap_of_split_nodes(tmp_path, figures):
    """The same by phantom nodes; with any connection joining them the error is 6 %."""
    exact = CASES["coating"]["stiffness"]["tension"]["value"]
    error = measure_case(tmp_path, CASES["coating"], "tension", 2e-4, cracks="split") / exact - 1
    figures.note("coating, tension, split nodes: signed error with cells of 0.0002", f"{error:+.4f}")
    figures.below("coating, tension, split nodes: error with 2 cells across the shell", abs(error), 0.01)


def test_one_cell_across_the_shell(tmp_path, figures):
    """8 cells across the ring of the bond are too coarse where the shell is thin beside it."""
    name = "coating across a gap"
    ring = 2 * math.sqrt(5.4e-3**2 - 5.2e-3**2)
    error = measure_case(tmp_path, CASES[name], "tension", ring / 8) / CASES[name]["stiffness"]["tension"]["value"] - 1
    figures.note(f"{name}, tension: signed error with 8 cells across the ring, 1.1 across the shell", f"{error:+.4f}")
    figures.below(f"{name}, tension: error with 8 cells across the ring, 1.1 across the shell", abs(error), 0.08)


@pytest.mark.parametrize("basis, limit", [("linear", 0.01), ("quadratic", 0.01), ("cubic", 0.035)])
def test_basis(basis, limit, tmp_path, figures):
    """Edge nodes of wider splines hold less; as constrained nodes they no longer make the bonded surface soft."""
    name = "meniscus across a gap"
    exact = CASES[name]["stiffness"]["tension"]["value"]
    error = measure_case(tmp_path, CASES[name], "tension", 2e-4, basis=basis) / exact - 1
    figures.note(f"{name}, tension, {basis}: signed error of the stiffness", f"{error:+.4f}")
    figures.below(f"{name}, tension, {basis}: error of the stiffness, 10 cells across the neck", abs(error), limit)
