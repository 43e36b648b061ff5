# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds on one elastic grain act on each other: chains and bonds at an angle against closed forms, energy, ranks, restart."""
import json
import math
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import NEIGHBOURS, host, restarted, run, thermo

VERIFICATION = Path(__file__).parent.parent / "verification"
sys.path.insert(0, str(VERIFICATION))
REFERENCES = json.loads((VERIFICATION / "elastic_bonds.json").read_text())
R, DT, PULL = 5e-3, 4e-9, 1e-9
PROCESSORS = {1: "1 1 1", 2: "1 1 2", 4: "2 1 2"}
VALUES = ["f_cem[8]", "f_cem[12]", "f_bond[3]", "f_bond[17]"]


def fixes(case, cell, words="", of_grains="grains elastic 70e9 0.22"):
    Ep, Ez, nu_p, nu_zp, Gzp = case["elastic"]
    return f"""\
timestep {DT}
fix cem calcite mpm cell {cell:.15g} elastic vti {Ep} {Ez} {nu_p} {nu_zp} {Gzp} axis bond {words}
fix bond grains mpm/couple cem damping 0.3 {of_grains} csv 50 bonds.csv
"""


def two_bonds(case, cell, angle, pull=PULL, steps=2500, turn=0.0, processors="1 1 1", **options):
    """A grain at rest with two others at an angle, which are pulled away by `pull` along their bonds. turn: about the y axis."""
    ways = [np.array([math.sin(a), 0.0, math.cos(a)]) for a in (turn, turn + angle)]
    text = host(processors=processors) + "region box block -17e-3 17e-3 -7e-3 7e-3 -17e-3 17e-3 units box\ncreate_box 2 box\n"
    for at in [np.zeros(3)] + [2 * R * w for w in ways]:
        text += f"create_atoms 1 single {at[0]:.15g} {at[1]:.15g} {at[2]:.15g} units box\n"
    text += f"set type 1 diameter {2 * R} density 2500\ngroup grains type 1\n{NEIGHBOURS}"
    for i in (2, 3):
        text += f"create_cement calcite pair 1 {i} shape flat inner {case['inner']} outer {case['outer']} film grid spacing {cell / 2:.15g}\n"
    return text + fixes(case, cell, **options) + motions(ways, pull, steps)


def motions(ways, pull, steps):
    T = 0.7 * steps * DT
    text = "group middle id 1\nfix hold middle move linear 0 0 0\n"
    for i, way in zip((2, 3), ways):
        for c, x in zip("xyz", way):
            d = pull * x if abs(x) > 1e-12 else 0.0
            text += f'variable d{i}{c} equal "{d}*((step*dt<{T})*(0.5-0.5*cos(PI*step*dt/{T}))+(step*dt>={T}))"\n'
            text += f'variable v{i}{c} equal "{d}*(step*dt<{T})*0.5*PI/{T}*sin(PI*step*dt/{T})"\n'
        text += f"group g{i} id {i}\nfix pull{i} g{i} move variable v_d{i}x v_d{i}y v_d{i}z v_v{i}x v_v{i}y v_v{i}z\n"
    return text


def tension(directory):
    rows = np.genfromtxt(directory / "bonds.csv", delimiter=",", names=True, dtype=None, encoding=None)
    return rows["tension"][-2:]


@pytest.mark.parametrize("name", [n if n.startswith("ring") else pytest.param(n, marks=pytest.mark.long) for n in REFERENCES["chains"]])
def test_chain_of_three(name, tmp_path, figures):
    """Each bond is as stiff as a bond whose second sphere has the same tractions at its other pole."""
    case = REFERENCES["chains"][name]
    run(two_bonds(case, (case["outer"] - case["inner"]) / 5, math.pi) + "run 2500\n", tmp_path)
    expected = case["stiffness"]["tension"]["value"]
    figures.below(f"{name}: error of the stiffness", abs(tension(tmp_path) / PULL / expected - 1).max(), 0.01)


@pytest.mark.parametrize("degrees, turn", [(90, 0.0), pytest.param(90, 0.3, marks=pytest.mark.long), pytest.param(120, 0.0, marks=pytest.mark.long)])
def test_bonds_at_an_angle(degrees, turn, tmp_path, figures):
    """The work of the tractions of single bonds on the displacement by each other (elastic_bond.py)."""
    from elastic_bond import between_bonds

    case = REFERENCES["cases"]["ring"]
    alone, expected = case["stiffness"]["tension"]["value"], between_bonds(case, math.radians(degrees), ns=8, nt=3)
    assert abs(expected / alone - 1) > 0.011
    run(two_bonds(case, 2e-4, math.radians(degrees), turn=turn) + "run 2500\n", tmp_path)
    figures.below(f"{degrees} degrees, turned by {turn}: error of the stiffness", abs(tension(tmp_path) / PULL / expected - 1).max(), 0.01)


BREAKS = {"words": "damage tensor B0 300 cutoff 0.9"}


@pytest.fixture(scope="module")
def torn(tmp_path_factory):
    """Both bonds at a right angle tear from their grains; it leaves middle.restart."""
    results = {}

    def get(ranks):
        if ranks not in results:
            text = two_bonds(REFERENCES["cases"]["ring"], 2.5e-4, math.pi / 2, 1.2e-6, processors=PROCESSORS[ranks], **BREAKS) + thermo(25, VALUES)
            results[ranks] = run(text + "run 700\nwrite_restart middle.restart\nrun 300\n", tmp_path_factory.mktemp("torn"), ranks)
        return results[ranks]

    return get


def test_energy_and_ranks(torn, figures):
    one = torn(1).table()
    assert 100 < one["f_bond[17]"][-1]
    for ranks in (1, 2, 4):
        t = torn(ranks).table()
        figures.below(f"{ranks} ranks: imbalance of the energy", abs(t["f_cem[12]"][3:]).max(), 2e-6)
        assert (t["f_bond[17]"] == one["f_bond[17]"]).all()
        figures.below(f"{ranks} ranks: force", abs(t["f_bond[3]"] - one["f_bond[3]"]).max() / abs(one["f_bond[3]"]).max(), 1e-8)


@pytest.mark.parametrize("ranks", [1, 2])
def test_restart_is_bitwise(ranks, torn, tmp_path):
    shutil.copy(torn(ranks).directory / "middle.restart", tmp_path)
    text = restarted("middle.restart", processors=PROCESSORS[ranks]) + fixes(REFERENCES["cases"]["ring"], 2.5e-4, **BREAKS)
    text += motions([np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])], 1.2e-6, 2500) + thermo(25, VALUES)
    again, first = run(text + "run 300\n", tmp_path, ranks).table(), torn(ranks).table()
    for value in ("f_bond[3]", "f_bond[17]"):
        assert (again[value][1:] == first[value][-again[value].size + 1 :]).all(), value


def test_condensed_bonds_are_alone(tmp_path):
    """Condensed bonds do not know each other, the log says so, and bonds that are resolved then do as they do."""
    case = REFERENCES["cases"]["ring"]
    done = run(two_bonds(case, 2.5e-4, math.pi, words="condense yes") + "run 2500\n", tmp_path)
    assert "do not act on each other with 'condense yes'" in done.output
    assert abs(tension(tmp_path) / PULL / case["stiffness"]["tension"]["value"] - 1).max() < 0.01


@pytest.mark.parametrize("ranks", [1, 2])
def test_deleted_neighbour(ranks, tmp_path, figures):
    """A bond that goes no longer moves the patch of the other one, whose energy changes."""
    case = REFERENCES["chains"]["ring in a chain of three"]
    text = two_bonds(case, (case["outer"] - case["inner"]) / 4, math.pi, processors=PROCESSORS[ranks]) + thermo(50, ["f_cem[9]", *VALUES])
    t = run(text + "run 2500\ndelete_bond pair 1 3\nrun 200\n", tmp_path, ranks).table()
    end = list(t["step"]).index(2500)
    released = t["f_cem[9]"][end + 1] - t["f_cem[9]"][end]
    figures.note("energy that the other bond releases", released)
    assert abs(released) > 1e-14
    figures.below(f"{ranks} ranks: imbalance of the energy", abs(t["f_cem[12]"][end:]).max(), 1e-4)
