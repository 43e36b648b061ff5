# SPDX-License-Identifier: GPL-2.0-or-later
"""regularization crackband: the energy that a bar takes when it is pulled apart (tests/verification/softening_bar.py)."""
import pytest
from softening_bar import at_energy, bar


# A bar that does not snap back: long tails of the law for its length.
@pytest.mark.parametrize("m, cells, damping", [(2.6, 10, 0.3), (2.95, 20, 0.3), (2.2, 20, 0.05)])
def test_bar_that_fails_steadily(tmp_path, figures, m, cells, damping):
    r = bar(tmp_path, cells, m, damping=damping)
    assert r["failed"] == 2 and r["end"] < 0.02, r["profile"]
    figures.note(f"bar of {cells} cells, m {m}: width of the band in cells, damage of its layers", f"{r['width']:.3f} {r['profile']}")
    figures.below(f"bar of {cells} cells, m {m}: error of the energy", abs(r["ratio"] - 1), 0.02)


@pytest.mark.parametrize("cells", [10, 20, 40, 80])
def test_same_energy_at_any_cell(tmp_path, figures, cells):
    """Here the elastic energy of the bar exceeds that of the crack: it snaps, and only damping keeps waves from damaging
    what is beside (with a tenth of it: 1.6, 0.8, 0.6 and 5.2 % too much)."""
    r = at_energy(tmp_path, cells, damping=0.3)
    figures.note(f"bar of {cells} cells, one energy: signed error, layers", f"{r['ratio'] - 1:+.3f} {r['profile']}")
    figures.below(f"bar of {cells} cells, one energy: error", abs(r["ratio"] - 1), 0.02)
