# SPDX-License-Identifier: GPL-2.0-or-later
"""Cohesive interfaces of elastic grains: largest force against a reference, energy, ranks, restart, condensed bonds, a chain."""
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
CASE = json.loads((VERIFICATION / "elastic_bonds.json").read_text())["cases"]["ring"]
R, DT = 5e-3, 4e-9
PROCESSORS = {1: "1 1 1", 2: "1 1 2"}
VALUES = ["f_bond[3]", "f_bond[9]", "f_bond[17]", "f_cem[8]", "f_cem[12]"]
SOFTENS = "interface cohesive tn 2e7 tt 2e7 Gn 10.6 Gt 10.6"


def fixes(cell, words="", of_grains="grains elastic 70e9 0.22"):
    Ep, Ez, nu_p, nu_zp, Gzp = CASE["elastic"]
    return f"""\
timestep {DT}
fix cem calcite mpm cell {cell} elastic vti {Ep} {Ez} {nu_p} {nu_zp} {Gzp} axis bond {words}
fix bond grains mpm/couple cem damping 0.3 {SOFTENS} {of_grains}
"""


def pull(grains, distance, steps):
    """The first and the last grain part by `distance`."""
    T = 0.9 * steps * DT
    text = f'variable d equal "{distance}*((step*dt<{T})*(0.5-0.5*cos(PI*step*dt/{T}))+(step*dt>={T}))"\n'
    text += f'variable v equal "{distance}*(step*dt<{T})*0.5*PI/{T}*sin(PI*step*dt/{T})"\n'
    text += f"group low id 1\ngroup high id {grains}\nfix hold low move linear 0 0 0\nfix pull high move variable NULL NULL v_d NULL NULL v_v\n"
    if grains > 2:
        text += "group middle subtract grains low high\nfix motion middle nve/sphere\n"
    return text + thermo(25, VALUES)


def row_of_grains(cell, grains=2, processors="1 1 1", **options):
    text = host(processors=processors) + f"region box block -7e-3 7e-3 -7e-3 7e-3 -7e-3 {2 * R * grains:.15g} units box\ncreate_box 2 box\n"
    for i in range(grains):
        text += f"create_atoms 1 single 0 0 {2 * R * i:.15g} units box\n"
    text += f"set type 1 diameter {2 * R} density 2500\ngroup grains type 1\n{NEIGHBOURS}"
    for i in range(1, grains):
        text += f"create_cement calcite pair {i} {i + 1} shape flat inner {CASE['inner']} outer {CASE['outer']} film grid spacing {cell / 2}\n"
    return text + fixes(cell, **options)


@pytest.mark.long
def test_largest_force(tmp_path, figures):
    """That of springs of the exact compliance (elastic_cohesive.py), and the displacement there; five cells across the width."""
    from elastic_cohesive import softening

    distances = np.linspace(0, 1.6e-6, 161)[1:]
    expected = softening(distances)
    text = row_of_grains(2e-4) + pull(2, 2.4e-6, 16000)
    table = run(text.replace("thermo 25", "thermo 20") + "run 16000\n", tmp_path, minutes=20).table()
    force = abs(table["f_bond[9]"])
    n, at = int(force.argmax()), int(expected.argmax())
    T = 0.9 * 16000 * DT
    distance = 2.4e-6 * (0.5 - 0.5 * math.cos(math.pi * table["step"][n] * DT / T))
    figures.below("error of the largest force", abs(force[n] / expected[at] - 1), 0.03)
    figures.below("error of its displacement", abs(distance / distances[at] - 1), 0.05)


@pytest.fixture(scope="module")
def torn(tmp_path_factory):
    """A pair whose interfaces soften and debond; it leaves middle.restart."""
    results = {}

    def get(ranks):
        if ranks not in results:
            text = row_of_grains(2.5e-4, processors=PROCESSORS[ranks]) + pull(2, 2.6e-6, 2500)
            results[ranks] = run(text + "run 1300\nwrite_restart middle.restart\nrun 1200\n", tmp_path_factory.mktemp("torn"), ranks)
        return results[ranks]

    return get


def test_energy_and_ranks(torn, figures):
    one = torn(1).table()
    force = abs(one["f_bond[9]"])
    assert force.max() > 150 and force[-1] < 1 and one["f_bond[17]"][-1] > 500
    area = 2 * math.pi * R**2 * (math.sqrt(1 - (CASE["inner"] / R) ** 2) - math.sqrt(1 - (CASE["outer"] / R) ** 2))
    assert 1.0 < one["f_cem[8]"][-1] / (area * 10.6) < 2.0  # one interface debonds, the other one softens
    for ranks in (1, 2):
        t = torn(ranks).table()
        figures.below(f"{ranks} ranks: imbalance of the energy", abs(t["f_cem[12]"][3:]).max(), 2e-6)
        assert (t["f_bond[17]"] == one["f_bond[17]"]).all()
        figures.below(f"{ranks} ranks: force", abs(t["f_bond[9]"] - one["f_bond[9]"]).max() / force.max(), 1e-8)


@pytest.mark.parametrize("ranks", [1, 2])
def test_restart_is_bitwise(ranks, torn, tmp_path):
    shutil.copy(torn(ranks).directory / "middle.restart", tmp_path)
    text = restarted("middle.restart", processors=PROCESSORS[ranks]) + fixes(2.5e-4) + pull(2, 2.6e-6, 2500)
    again, first = run(text + "run 1200\n", tmp_path, ranks).table(), torn(ranks).table()
    for value in ("f_bond[9]", "f_bond[17]"):
        assert (again[value][1:] == first[value][-again[value].size + 1 :]).all(), value


def test_condensed(torn, tmp_path, figures):
    """A bond that was condensed until its interface began to soften."""
    one = torn(1).table()
    other = run(row_of_grains(2.5e-4, words="condense yes") + pull(2, 2.6e-6, 2500) + "run 2500\n", tmp_path).table()
    figures.below("largest force", abs(abs(other["f_bond[9]"]).max() / abs(one["f_bond[9]"]).max() - 1), 0.01)
    figures.below("imbalance of the energy", abs(other["f_cem[12]"][10:]).max(), 1e-3)


def test_chain(tmp_path, figures):
    """Bonds on one grain act on each other while one of them softens; the middle grain is free."""
    t = run(row_of_grains(3e-4, grains=3) + pull(3, 3.2e-6, 3000) + "run 3000\n", tmp_path).table()
    assert t["f_bond[17]"][-1] > 300
    figures.below("imbalance of the energy", abs(t["f_cem[12]"][5:]).max(), 1e-6)
