# SPDX-License-Identifier: GPL-2.0-or-later
"""References of elastic grains: the closed form of the sphere, and bonds between two of them (tests/verification/elastic_bond.py)."""
import json
import subprocess
import sys
from pathlib import Path

import pytest

VERIFICATION = Path(__file__).parent.parent / "verification"
sys.path.insert(0, str(VERIFICATION))
CASES = json.loads((VERIFICATION / "elastic_bonds.json").read_text())["cases"]


@pytest.mark.parametrize("tool", ["elastic_sphere.py", "elastic_bond.py"])
def test_references_themselves(tool):
    """Systems of 2 by 2 equations, finite elements of the sphere, rigid grains, the whole bond and its half, values of another program."""
    done = subprocess.run([sys.executable, "-B", VERIFICATION / tool, "--self-check"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.count("ok  ") >= 8 and "FAIL" not in done.stdout, done.stdout + done.stderr


def test_cases_are_of_all_kinds():
    """Rings, menisci, cylinders without a hole, gaps, unequal grains, two materials of grains, cement of both symmetries."""
    assert len(CASES) >= 16 and all(set(c["stiffness"]) == {"tension", "torsion", "shear", "bending"} for c in CASES.values())
    assert all(s["relative_change"] < 1e-3 for c in CASES.values() for s in c["stiffness"].values())
    assert any(c["shape"] == "meniscus" for c in CASES.values()) and any(c["gap"] > 0 for c in CASES.values())
    assert any(c["inner"] == 0 for c in CASES.values()) and any(c["radius"][0] != c["radius"][1] for c in CASES.values())
    assert len({tuple(g) for c in CASES.values() for g in c["grain"]}) > 1 and len({c["elastic"][0] / c["elastic"][1] for c in CASES.values()}) > 1


@pytest.mark.parametrize("name", ["ring", "small ring", "meniscus across a gap", "unequal grains across a gap"])
def test_stored_values_are_of_this_solver(name):
    """A mesh of half the resolution gives the stored stiffness."""
    from elastic_bond import solve_case

    for load, stored in CASES[name]["stiffness"].items():
        found = solve_case(CASES[name], load, 8, 3).stiffness
        assert abs(found / stored["value"] - 1) < 1e-3, f"{name}, {load}: {found}, stored {stored['value']}"


def test_wrong_compliance_is_found(monkeypatch):
    """With a response of the sphere that is 2 % off at degree 2 alone the stiffness of the ring changes by more than its limit."""
    import elastic_sphere
    from elastic_bond import solve_case

    right = elastic_sphere.spheroidal
    monkeypatch.setattr(elastic_sphere, "spheroidal", lambda l, nu: right(l, nu) * (1.02 if l == 2 else 1.0))
    found = solve_case(CASES["ring"], "tension", 8, 3).stiffness
    assert abs(found / CASES["ring"]["stiffness"]["tension"]["value"] - 1) > 1e-3
