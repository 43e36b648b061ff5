# SPDX-License-Identifier: GPL-2.0-or-later
"""Stiffness of an undamaged ring between two grains against finite elements."""
import functools
import re

import numpy as np
import pytest
from axisymmetric_fe import TransverselyIsotropic, axis_radial, axis_uniform, converged_axial_stiffness
from elastic_pair import measure
from scenes import C33, RADIUS, VTI, cement, pair, run, shift, thermo

DISTANCE, DURATION = 1e-8, 8e-6
EXACT_C33 = 47.619047619e9
SKEW = (0.36, -0.48, 0.8)


@functools.lru_cache
def reference(axis):
    axis = axis_uniform(0.0, 1.0) if axis == "z" else axis_radial(RADIUS, 0.0)
    found = converged_axial_stiffness(RADIUS, 1e-3, 2e-3, 0.0, TransverselyIsotropic(*VTI), axis)
    assert found.uncertainty < 1e-4 * found.value
    return found.value


@pytest.fixture(scope="module")
def stiffness(tmp_path_factory):
    """Stiffness by cell, penalty over C33 (or auto), axis and direction; each is run once."""

    @functools.lru_cache
    def measure(cell, penalty="auto", axis="global 0 0 1", direction=(0, 0, 1)):
        timestep = 1e-8 * cell / 1e-4
        kn = "auto" if penalty == "auto" else f"{penalty * C33(*VTI):.17g}"
        half_box = tuple(np.abs(direction) * RADIUS + RADIUS + 1e-3)
        script = (
            pair(cell / 2, direction=direction, half_box=half_box)
            + cement(cell, timestep, axis=axis, couple=f"kn {kn} kt {kn}")
            + shift(DISTANCE, DURATION, direction)
            + f"run {round(DURATION / timestep)}\n"
            # what is left of the vibration averages out while the grains are held
            + "unfix pull\nfix pull second move linear 0 0 0\n"
            + thermo(4, ["f_bond"])
            + f"run {round(4e-6 / timestep)}\n"
        )
        force = run(script, tmp_path_factory.mktemp("stiffness")).table()["f_bond"]
        return force.mean() / DISTANCE

    return measure


def test_c33(tmp_path):
    assert C33(*VTI) == pytest.approx(EXACT_C33, rel=1e-10)
    output = run(pair(1e-4) + cement(2e-4, 1e-8) + "run 0\n", tmp_path).output
    assert float(re.search(r", C33 (\S+)", output)[1]) == pytest.approx(EXACT_C33, rel=1e-5)


@pytest.mark.parametrize("cell, limit", [(2e-4, 0.025), (1e-4, 0.01)])
def test_axis_along_the_bond(stiffness, figures, cell, limit):
    error = stiffness(cell) / reference("z") - 1
    figures.note(f"axis z, cell {cell:g}: signed error of the stiffness", f"{error:+.4f}")
    figures.below(f"axis z, cell {cell:g}: error of the stiffness", abs(error), limit)


def test_axis_radial(stiffness, figures):
    error = stiffness(1e-4, axis="radial") / reference("radial") - 1
    figures.note("axis radial, cell 1e-4: signed error of the stiffness", f"{error:+.4f}")
    figures.below("axis radial, cell 1e-4: error of the stiffness", abs(error), 0.01)


def test_penalty_hardly_matters(stiffness, figures):
    change = {cell: abs(stiffness(cell, 200) / stiffness(cell, 50) - 1) for cell in (2e-4, 1e-4)}
    figures.note("penalty 200 against 50 C33/h, cell 2e-4: change", f"{change[2e-4]:.4f}")
    figures.below("penalty 200 against 50 C33/h, cell 1e-4: change", change[1e-4], 0.015)


def test_automatic_penalty(stiffness):
    assert stiffness(2e-4) == pytest.approx(stiffness(2e-4, 200), rel=1e-9)


def test_skew_bond(stiffness, figures):
    change = stiffness(1e-4, axis="bond", direction=SKEW) / stiffness(1e-4) - 1
    figures.below("skew bond against aligned, cell 1e-4: change", abs(change), 1e-9)


def test_grid_across_a_thin_bond(tmp_path, figures):
    """A ring as thin as two cells, with a node in its middle and with the grid half a cell off along the bond."""
    words, cell = "outer 2.5e-3 inner 1.96e-3", 8e-4
    exact = converged_axial_stiffness(RADIUS, 1.96e-3, 2.5e-3, 0.0, TransverselyIsotropic(*VTI), axis_uniform(0.0, 1.0)).value
    error = {
        name: measure(tmp_path / name, "tension", "flat", f"{words} {grid}", cell) / exact - 1
        for name, grid in (("middle", ""), ("off", f"grid 0 0 {cell / 2}"))
    }
    figures.below("error of the stiffness with a node in the middle", abs(error["middle"]), 0.03)
    figures.note("signed error of the stiffness, grid half a cell off", f"{error['off']:+.4f}")
    assert error["off"] > 0.1  # what create_cement.md warns of
