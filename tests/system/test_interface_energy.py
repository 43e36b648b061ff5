# SPDX-License-Identifier: GPL-2.0-or-later
"""`interface cohesive`: a block pulled off one flat grain takes the energy asked for, of either mode and between them
(tests/verification/flat_grain.py)."""
import math

import pytest
from flat_grain import envelope, pulled_off


def check(r, expected, limit, figures, what):
    assert r["of_first"] == 1 and r["of_second"] == 0, r
    assert r["imbalance"] < 0.01
    figures.below(f"{what}: error of the energy", abs(r["energy"] / expected - 1), limit)


@pytest.mark.parametrize("cells, layers", [(2, 0), (3, 1), (4, 0)])
@pytest.mark.parametrize("load, angle", [("opening", 0.0), ("shear", math.pi / 2)])
def test_a_crack_that_runs(tmp_path, figures, load, angle, cells, layers):
    """Held by one end of its face. The cells lie otherwise against the grain with an odd number of layers of points."""
    Gn, Gt = (4.0, 8.0) if load == "opening" else (8.0, 4.0)
    r = pulled_off(tmp_path, cells, angle, Gn, Gt, layers=layers)
    check(r, 4.0, 0.05, figures, f"block off a flat grain, {load}, {cells} cells high, {layers} layers more")


@pytest.mark.parametrize("angle", [0, 30, 45, 60, 90])
@pytest.mark.parametrize("cells", [2, 4])
def test_between_the_modes(tmp_path, figures, cells, angle):
    """All links along one direction: the energy that the law states for it."""
    a = math.radians(angle)
    check(
        pulled_off(tmp_path, cells, a, 4.0, 8.0, held="all"),
        envelope(a, 4.0, 8.0),
        0.05,
        figures,
        f"block off a flat grain, pulled at {angle} degrees, {cells} cells high",
    )
