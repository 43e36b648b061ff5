# SPDX-License-Identifier: GPL-2.0-or-later
"""Where points lie in their cells, how many there are, and how small: answers change by no more than
the error of the cell size does."""
import numpy as np
import pytest
from bonds import BRITTLE
from scenes import RING, cement, edit, pair, pull, run, shift, thermo
from test_point_file import from_file, read, write

CELL = 2e-4
EXACT = 9.2743094e8  # N/m, axisymmetric finite elements, see tests/system/test_stiffness.py
HOLD = "unfix pull\nfix pull second move linear 0 0 0\n"


def stiffness(script, directory):
    script += shift(1e-8, "(500*dt)") + "run 500\n" + HOLD + "run 400\n" + thermo(4, ["f_bond"]) + "run 300\n"
    return run(script, directory).table()["f_bond"].mean() / 1e-8


def offset(cells):
    """The ring with the grid shifted by so many cells."""
    shifted = RING + " grid " + " ".join(f"{c * CELL:.15g}" for c in cells)
    return pair(CELL / 2, cement=shifted) + cement(CELL, 5e-9)


def test_offset_of_the_grid(tmp_path, figures, long):
    """The grid shifted against the points, among others so that points lie on the faces of cells."""
    shifts = [(0, 0, 0), (0.25, 0.25, 0.25), (0.5, 0.5, 0.5), (0, 0, 0.25), (0.25, 0, 0)]
    shifts += list(np.random.default_rng(1).uniform(-0.5, 0.5, (30 if long else 4, 3)))
    k = np.array([stiffness(offset(s), tmp_path / str(n)) for n, s in enumerate(shifts)])
    figures.below(f"{len(k)} offsets of the grid: stiffness, largest error against finite elements", abs(k / EXACT - 1).max(), 0.012)
    along = k[4] / k[0] - 1  # across the bond axis only
    figures.below("offset of a quarter cell across the bond: change of the stiffness", abs(along), 0.005)


def test_offset_and_failure(tmp_path, figures, long):
    """Pulled through failure on shifted grids: energy is kept, the bond breaks, the peak moves little."""
    peaks = []
    for n, s in enumerate(np.random.default_rng(2).uniform(-0.5, 0.5, (10 if long else 3, 3))):
        script = edit(offset(s), "axis global 0 0 1", f"axis radial {BRITTLE}") + pull(4.0, 4e-6)
        t = run(script + thermo(10, ["f_bond", "f_cem[12]", "f_bond[22]"]) + "run 1400\n", tmp_path / str(n)).table()
        peaks.append(t["f_bond"].max())
        figures.below(f"offset {n}: imbalance of the energy after the peak", abs(t["f_cem[12]"][t["f_bond"].argmax() :]).max(), 0.005)
        assert abs(t["f_bond"][-20:]).mean() < 0.1 * peaks[-1]
    figures.below(f"{len(peaks)} offsets of the grid: spread of the peak force", np.ptp(peaks) / np.mean(peaks), 0.2)


@pytest.mark.parametrize("percell", [1, 2, 3, 4])
def test_points_a_cell(percell, tmp_path, figures, long):
    """1, 8, 27 and 64 points a cell, with 1 and 27 some of them on faces of the quadratic cells; in the short form a thinner ring breaks."""
    inner = "inner 1e-3 outer 2e-3"
    k = stiffness(pair(CELL / percell, cement=inner) + cement(CELL, 5e-9), tmp_path / "elastic")
    figures.below(f"{percell**3} points a cell: stiffness against finite elements", abs(k / EXACT - 1), 0.06 if percell == 1 else 0.012)
    breaks = inner if long else "inner 1.6e-3 outer 2e-3"
    script = pair(CELL / percell, cement=breaks) + cement(CELL, 4e-9, axis="radial", damage=BRITTLE) + pull(4.0, 4e-6)
    t = run(script + thermo(10, ["f_bond", "f_cem[12]"]) + "run 1600\n", tmp_path / "broken").table()
    figures.below(f"{percell**3} points a cell: imbalance of the energy after the peak", abs(t["f_cem[12]"][t["f_bond"].argmax() :]).max(), 0.01)
    figures.note(f"{percell**3} points a cell: peak force", f"{t['f_bond'].max():.0f} N")


@pytest.mark.parametrize("words", ["", "basis linear", "kinematics updated"])
@pytest.mark.parametrize("fraction", [1e-2, 1e-4, 1e-6])
def test_cut_cells(words, fraction, tmp_path, figures):
    """A tenth of the points at the surface have a volume down to a millionth of a cell."""
    run(pair(CELL / 2) + "write_cement cement.txt\n", tmp_path / "made")
    points = read(tmp_path / "made" / "cement.txt")
    cut = np.flatnonzero(points["volume"] < 0.99 * (CELL / 2) ** 3)
    small = np.random.default_rng(3).choice(cut, len(cut) // 10, replace=False)
    points["volume"][small] = fraction * CELL**3
    write(tmp_path / "cement.txt", points)
    script = from_file("../cement.txt") + cement(CELL, 1e-9, axis="radial", damage=BRITTLE)
    script = edit(script, "mpm cell 0.0002", f"mpm cell 0.0002 {words} timestep auto 0.9") + pull(4.0, 4e-6)
    script += thermo(20, ["f_bond", "f_cem[12]", "f_cem[5]", "dt"]) + "run 0\nvariable n equal ceil(7e-6/dt)\nrun ${n}\n"
    t = run(script, tmp_path / "broken").table()
    assert all(np.isfinite(c).all() for c in t.values())
    name = f"{words or 'default'}, {len(small)} of {len(points['volume'])} points of {fraction:g} of a cell"
    figures.note(f"{name}: time step", f"{t['dt'][-1]:.3g} s")
    figures.below(f"{name}: imbalance of the energy after the peak", abs(t["f_cem[12]"][t["f_bond"].argmax() :]).max(), 0.006)
    assert abs(t["f_bond"][-1]) < 0.2 * t["f_bond"].max()
