# SPDX-License-Identifier: GPL-2.0-or-later
"""regularization nonlocal: the energy of a crack that runs, along the grid and at an angle to it (tests/verification/running_crack.py)."""
import math

import pytest
from running_crack import crack

FINE = 2  # cells a length


@pytest.mark.parametrize(
    "cells, angle, off, energy",
    [
        (1, 0, 0, None),
        (1, 0, 1, None),
        (1, 26.565, 0, None),
        (1, 45, 0, None),
        (1, 0, 0, 14.0),
        (FINE, 0, 0, None),
        (FINE, 0, 1, None),
        (FINE, 26.565, 0, None),
        (FINE, 45, 0, None),
        (FINE, 0, 0, 14.0),
    ],
)
def test_slope(tmp_path, figures, long, cells, angle, off, energy):
    if cells == FINE and not long:
        pytest.skip("a minute each: with --long")
    r = crack(tmp_path, cells, math.radians(angle), off, energy)
    what = f"crack that runs, {cells:g} cells a length, at {angle:g} degrees{', notch elsewhere' if off else ''}{f', energy {energy:g}' if energy else ''}"
    assert max(abs(h) for h in r["halves"]) < 0.06, "it does not run steadily"
    assert r["imbalance"] < 1e-3
    figures.below(f"{what}: error of the energy", abs(r["ratio"] - 1), 0.06 if cells == 1 else 0.035 if off else 0.03)
