# SPDX-License-Identifier: GPL-2.0-or-later
"""The result does not depend on how many ranks share the scene, or where it is cut."""
import re

import numpy as np
import pytest
from scenes import CONTACT, SPINNING, cement, dump, pair, point_quantities, pull, run, thermo

CELL, STEPS = 2e-4, 1600


def pulled(processors, steps):
    return (
        pair(CELL / 2, processors=processors)
        + CONTACT
        + cement(CELL, 3e-9, axis="radial", damage="damage tensor B0 9.6e6 cutoff 0.9")
        + pull(4.0, 4e-6)
        + point_quantities(["failed", "damage"])
        + dump(400, ["c_failed", "c_damage"])
        + thermo(1, ["f_bond", "f_bond[17]"])
        + f"run {steps}\n"
    )


@pytest.fixture(scope="module")
def one_rank(tmp_path_factory):
    return run(pulled("* * *", STEPS), tmp_path_factory.mktemp("one_rank"))


# The box is longest in z, so that a cut by z puts each grain on a rank of its own.
@pytest.mark.parametrize("ranks, processors, steps", [(2, "2 1 1", STEPS), (2, "1 1 2", STEPS), (4, "2 2 1", 1200), (4, "1 1 4", 1200)])
def test_pulled_through_failure(tmp_path, figures, one_rank, ranks, processors, steps):
    other = run(pulled(processors, steps), tmp_path, ranks)
    a, b = one_rank.table(), other.table()
    difference = abs(b["f_bond"] - a["f_bond"][: steps + 1]) / a["f_bond"].max()
    first_failure = np.argmax(a["f_bond[17]"] > 0)
    name = f"{ranks} ranks cut {processors}: bond force against 1 rank, over the peak,"
    figures.note(f"{name} in all {steps} steps", f"{difference.max():.1e}")
    figures.below(f"{name} up to the first failure (step {first_failure})", difference[:first_failure].max(), 1e-12)
    p, q = one_rank.points(steps), other.points(steps)
    assert (p["id"] == q["id"]).all()
    figures.note(f"{ranks} ranks cut {processors}: damage after {steps} steps against 1 rank", f"{abs(p['c_damage'] - q['c_damage']).max():.1e}")
    assert p["c_failed"].sum() > 100
    figures.below(
        f"{ranks} ranks cut {processors}: points failed on one and not the other, of " f"{p['c_failed'].sum():.0f}", (p["c_failed"] != q["c_failed"]).sum(), 0
    )


def test_points_that_change_rank(tmp_path, figures):
    """A spinning pair crosses the cut."""

    def spinning(processors):
        return (
            pair(CELL / 2, gap=2e-4, direction=(0, 0.02, 1), cement="outer 2e-3", half_box=3 * (16e-3,), processors=processors)
            + cement(CELL, 1e-8, axis="radial", couple="kn 2e12 kt 3e11")
            + SPINNING
            + dump(4000, ["x", "y", "z", "vx", "vy", "vz"])
            + "run 4000\n"
        )

    one, two = run(spinning("1 1 1"), tmp_path / "one"), run(spinning("1 1 2"), tmp_path / "two", 2)
    assert not re.search("Neighbor list builds = 0", two.output), "nothing was exchanged"
    before, after, alone = two.points(0), two.points(4000), one.points(4000)
    crossed = (before["z"] * after["z"] < 0).sum()
    assert crossed > 100, crossed
    # A position rounded by 1e-18 m, times the penalty, is felt by the velocity of a light node.
    for names, scale, limit in (("xyz", CELL, 4e-12), (("vx", "vy", "vz"), 30.0, 1e-9)):
        error = max(abs(after[n] - alone[n]).max() for n in names) / scale
        figures.below(f"spinning pair, {crossed} points crossed the cut: {' '.join(names)} against 1 rank", error, limit)
