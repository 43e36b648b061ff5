# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds between elastic grains beside contact-cement theory: the integral equation of tests/verification/thin_layer.py, and the table of
tests/verification/contact_cement.py."""
import subprocess
import sys
from pathlib import Path

import pytest
from contact_cement import CELLS, INNER, MODULI, OUTER, R, case_of, integral, read
from test_elastic_grains import cell_of, scene, stiffness

ROOT = Path(__file__).resolve().parents[2]
TABLE = read(ROOT / "doc/data/contact_cement.csv")


def row_of(outer, modulus, cells, load):
    found = [r for r in TABLE if abs(r["outer_m"] / (outer * R) - 1) < 1e-6 and (r["cement_Pa"], r["cells"], r["load"]) == (modulus, cells, load)]
    assert len(found) == 1
    return found[0]


def test_reference_itself():
    """Rigid spheres, a rigid punch, finite elements of the small ring, the published fit; degrees and harmonics have converged."""
    tool = ROOT / "tests/verification/thin_layer.py"
    done = subprocess.run([sys.executable, "-B", tool, "--self-check"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.count("ok  ") >= 15 and "FAIL" not in done.stdout, done.stdout + done.stderr


@pytest.mark.parametrize("outer, modulus", [(OUTER[0], 6e9), (OUTER[1], 60e9)])
def test_thin_cement(outer, modulus, tmp_path, figures):
    """Five cells across the width."""
    case = case_of(outer, modulus)
    found = stiffness(tmp_path, scene(case, cell_of(case, 5)))
    figures.below("tension: from the integral equation", abs(found["tension"] / integral(case, modulus, "tension") - 1), 0.03)


@pytest.mark.long
@pytest.mark.parametrize("modulus", MODULI)
@pytest.mark.parametrize("outer", OUTER)
def test_all_points_of_the_table(outer, modulus, tmp_path, figures):
    """With the most cells of the table; the program gives its rows."""
    case, cells = case_of(outer, modulus), max(CELLS[modulus])
    found = stiffness(tmp_path, scene(case, cell_of(case, cells)))
    for load, limit in {"tension": 0.045, "shear": 0.07}.items():
        row = row_of(outer, modulus, cells, load)
        theory = integral(case, modulus, load)
        assert abs(theory / row["integral_N_per_m"] - 1) < 1e-4 and abs(found[load] / row["program_N_per_m"] - 1) < 1e-3
        figures.below(f"{load}: from the integral equation", abs(found[load] / theory - 1), limit)


def test_table():
    """Every point is there; rings are those of the page; stiff cement has the stiffness of the published fit between half-spaces."""
    assert len(TABLE) == 2 * len(OUTER) * sum(len(c) for c in CELLS.values())
    for row in TABLE:
        assert row["inner_m"] == pytest.approx(INNER * row["outer_m"])
        if row["load"] == "tension" and row["cement_Pa"] == max(MODULI):
            assert row["fit_disc_N_per_m"] == pytest.approx(row["halfspace_disc_N_per_m"], rel=0.012)
