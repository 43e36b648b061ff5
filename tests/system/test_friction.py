# SPDX-License-Identifier: GPL-2.0-or-later
"""`friction` of fix mpm/couple in a script: what let go touches again. Figures are in tests/unit/test_freed_places.cpp."""
import csv
from pathlib import Path

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, cement, edit, launch, pair, pull, restarted, run, thermo

CELL = 2.5e-4
WORDS = "friction 0.3"


def scene(words=WORDS, damage="check 20", **more):
    fixes = cement(CELL, 4e-9, elastic=CALCITE, axis="radial", damage=damage, couple=f"kn auto kt auto {words} csv 20 bond.csv", **more)
    return pair(CELL / 2, cement="content 0.01") + CONTACT + fixes + pull(4.0, 4e-6) + thermo(20, ["f_bond"])


@pytest.mark.parametrize("words, damage, message", [
    ("friction -0.1", "check 20", "friction"),
    ("friction nan", "check 20", "friction"),
    ("friction", "check 20", "friction"),
    (WORDS, "check 20 kinematics updated", "'friction' needs a reference that stays, and fix mpm 'cem' has 'kinematics updated'"),
    (WORDS, "check 20 cracks split mass_order 2", "with lumped masses"),
    ("", "check 20 unilateral maybe", "unilateral"),
    ("", "check 20 unilateral yes", "'unilateral yes' needs a law of damage"),
    ("", "damage tensor B0 9.6e3 check 20 kinematics updated unilateral yes", "'unilateral yes' measures cracks from a reference that stays"),
    (WORDS, "check 20 reproject auto 0.1", "'friction' needs a reference that stays, and fix mpm 'cem' has 'reproject auto'"),
])
def test_bad_words(tmp_path, words, damage, message):
    done = launch(scene(words, damage) + "run 0\n", tmp_path)
    assert done.status != 0
    assert len(done.errors()) == 1 and message in done.errors()[0], done.output[-1000:]


def test_other_friction_after_a_restart_is_refused(tmp_path):
    run(scene() + "run 10\nwrite_restart early\n", tmp_path)
    for words in ("", "friction 0.2"):
        done = launch(edit(scene(words), pair(CELL / 2, cement="content 0.01"), restarted("early")) + "run 1\n", tmp_path, name="in.other")
        assert done.status != 0 and any("'friction 0.3'" in e for e in done.errors()), done.output[-1000:]


def test_example_breaks_closes_and_slides(tmp_path, figures):
    """examples/pair_closed: tension until it breaks, compression when it is closed, friction below mu N, and the books close."""
    folder = Path(__file__).parents[2] / "examples" / "pair_closed"
    assert launch((folder / "in.closed").read_text(), tmp_path, name="in.closed").status == 0
    with open(tmp_path / "bond.csv") as f:
        rows = list(csv.DictReader(f))
    step, tension, shear, apart, touching, imbalance = (
        np.array([float(r[name]) for r in rows]) for name in ("step", "tension", "fx1", "separated", "touching_grain2", "energy_imbalance"))
    closed, sliding = step >= 2600, step >= 3400
    assert tension.max() > 50 and apart[-1] == 1 and touching[closed].mean() > 0.05 and touching[closed].min() > 0.01
    assert tension[closed].max() < -20
    share = (shear[sliding] / -tension[sliding]).mean()
    figures.note("friction over normal force while the closed bond slides", f"{share:.3f}")
    assert 0.1 < share < 0.3
    figures.below("energy imbalance through breaking, closing and sliding", abs(imbalance).max(), 0.01)
