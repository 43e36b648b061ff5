# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy balance, and action against reaction, of a flat bond pulled through failure."""
import numpy as np
import pytest
from scenes import CALCITE, CONTACT, cement, pair, pull, run, thermo

FORCES = [f"f_bond[{i}]" for i in (1, 2, 3, 7, 8, 9)]


@pytest.mark.parametrize("B0, speed", [(9.6e6, 4.0), (9.6e3, 0.1265)])
def test_pulled_through_failure(tmp_path, figures, B0, speed):
    cell = 2.5e-4
    script = (pair(cell / 2, cement="content 0.01") + CONTACT
              + cement(cell, 4e-9, elastic=CALCITE, axis="radial", damage=f"damage tensor B0 {B0} cutoff 0.9")
              + pull(speed, 4e-6)
              + thermo(20, ["f_bond", "f_bond[17]", "f_cem[12]"] + FORCES) + "run 2600\n")
    table = run(script, tmp_path).table()
    force, failed = table["f_bond"], table["f_bond[17]"]
    peak = force.argmax()
    assert failed[-1] > 100 and abs(force[-30:].mean()) < 0.1 * force[peak], "not broken"
    figures.below(f"B0 {B0:g}: imbalance of the energy from the peak on", abs(table["f_cem[12]"][peak:]).max(), 0.01)
    on_grains = np.array([table[c] for c in FORCES])
    sum_of_both = np.linalg.norm(on_grains[:3] + on_grains[3:], axis=0)
    # what is left is the momentum that the cement takes up, until it breaks on one side
    loading = np.argmax(force > 0.95 * force[peak])
    figures.below(f"B0 {B0:g}: |F1 + F2| over the peak, up to 95 % of it", sum_of_both[:loading].max() / force[peak], 0.01)
