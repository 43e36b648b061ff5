# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy balance, and action against reaction, of a flat bond that is struck or pulled through failure."""
import csv
from pathlib import Path

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, cement, edit, launch, pair, pull, run, thermo

FORCES = [f"f_bond[{i}]" for i in (1, 2, 3, 7, 8, 9)]


@pytest.mark.parametrize("B0, speed", [(9.6e6, 4.0), (9.6e3, 0.1265)])
def test_pulled_through_failure(tmp_path, figures, B0, speed):
    cell = 2.5e-4
    script = (
        pair(cell / 2, cement="content 0.01")
        + CONTACT
        + cement(cell, 4e-9, elastic=CALCITE, axis="radial", damage=f"damage tensor B0 {B0} cutoff 0.9")
        + pull(speed, 4e-6)
        + thermo(20, ["f_bond", "f_bond[17]", "f_cem[12]"] + FORCES)
        + "run 2600\n"
    )
    table = run(script, tmp_path).table()
    force, failed = table["f_bond"], table["f_bond[17]"]
    peak = force.argmax()
    assert failed[-1] > 100 and abs(force[-30:].mean()) < 0.1 * force[peak], "not broken"
    figures.below(f"B0 {B0:g}: imbalance of the energy from the peak on", abs(table["f_cem[12]"][peak:]).max(), 1e-5)
    on_grains = np.array([table[c] for c in FORCES])
    sum_of_both = np.linalg.norm(on_grains[:3] + on_grains[3:], axis=0)
    # what is left is the momentum that the cement gains, until it breaks on one side
    loading = np.argmax(force > 0.95 * force[peak])
    figures.below(f"B0 {B0:g}: |F1 + F2| over the peak, up to 95 % of it", sum_of_both[:loading].max() / force[peak], 0.01)


@pytest.mark.parametrize("cracks", ["bonds", "split"])
@pytest.mark.parametrize("load", ["tension", "shear", "compression"])
def test_balance_through_failure(load, cracks, tmp_path, figures):
    """What points, links and added mass give up in a step of central differences is counted as that step has it, so the balance closes but for rounding and
    for damage within a step."""
    script = Path(__file__).parents[2] / "examples" / "pair_table" / "in.pair_table"
    words = dict(shape="flat", load=load, content=0.01, inner=1e-3, spacing=2e-4, cracks=cracks, limit=2500, frames=10**8)
    result = launch(script.read_text(), tmp_path, name="in.pair_table", arguments=[w for k, v in words.items() for w in ("-var", k, str(v))])
    assert result.status == 0, result.output[-2000:]
    with open(tmp_path / "bond_run.csv") as f:
        rows = list(csv.DictReader(f))
    assert int(rows[-1]["failed"]) > 100
    figures.below(
        f"{load}, cracks {cracks}: energy imbalance through failure",
        max(abs(float(r["energy_imbalance"])) for r in rows),
        {"bonds": 1e-4, "split": 2e-5}[cracks],
    )


@pytest.mark.parametrize("words", ["", "basis linear", "basis cubic"])
def test_struck(tmp_path, figures, words):
    """A free grain is thrown away from the other: waves in the cement, some as short as a cell, and the balance holds
    nevertheless, since it is that of central differences, with added mass that moves with its grain and without."""
    cell = 2.5e-4
    for timestep, limit in ((2e-9, 1e-6), (1.2e-8, 1e-5)):
        steps = round(4e-6 / timestep)
        script = (
            pair(cell / 2, cement="content 0.01")
            + CONTACT
            + edit(cement(cell, timestep, elastic=CALCITE, axis="radial"), f"cell {cell}", f"cell {cell} {words}")
            + "fix motion grains nve/sphere\nvelocity second set 0.03 0.02 0.1\n"
            + thermo(steps // 100, ["f_cem[5]", "f_cem[6]", "f_cem[12]"])
            + f"run {steps}\n"
        )
        table = run(script, tmp_path).table()
        assert table["f_cem[5]"].max() > 0.003 * table["f_cem[6]"].max() > 0.0, "no waves"
        figures.below(f"{words or 'default'}, {'no' if timestep < 1e-8 else 'with'} added mass: imbalance of the energy", abs(table["f_cem[12]"]).max(), limit)


def test_asked_for_early_in_a_step(tmp_path):
    """A variable of fix move reads energies and forces before they are those of the step: what is printed stays the same."""
    columns = [f"f_bond[{i}]" for i in (13, 14)] + [f"f_cem[{i}]" for i in (5, 6, 7, 11, 12)]

    def table(early):
        script = pair(1e-4) + cement(2e-4, 1e-8, elastic=CALCITE)
        script += (
            f'variable z equal 5e3*step*dt*step*dt\nvariable w equal "1e4*step*dt{early}"\nfix hold first move linear 0 0 0\n'
            "fix pull second move variable NULL NULL v_z NULL NULL v_w\n"
        )
        return run(script + thermo(50, columns) + "run 200\n", tmp_path / str(len(early))).table()

    plain, asked = table(""), table("+0*f_bond[14]+0*f_cem[6]")
    assert plain["f_bond[14]"][-1] > 1
    for c in plain:
        assert (plain[c] == asked[c]).all(), c


def test_at_rest(tmp_path):
    """Where rounding of positions is all that there is, the imbalance is 0, not the ratio of two roundings."""
    script = edit(
        edit(pair(1e-4, gap=2e-4, boundary="p p p"), "single 0 0 -0.0051 units", "single 0.00593 0.0051 0.0077 units"),
        "single 0 0 0.0051 units",
        "single -0.00597 0.0052 -0.0071 units",
    )
    script += cement(2e-4, 1e-9) + "fix motion grains nve/sphere\n" + thermo(10, ["f_cem[7]", "f_cem[12]"]) + "run 50\n"
    table = run(script, tmp_path).table()
    assert table["f_cem[7]"].max() > 0.0, "no rounding to tell of"
    assert (table["f_cem[12]"] == 0.0).all()


def test_dampers_of_soft_links(tmp_path, figures):
    """Links that need no added mass: their dampers act between cement and a free grain that is thrown away."""
    cell = 2.5e-4
    script = pair(cell / 2, cement="content 0.01") + cement(cell, 4e-9, elastic=CALCITE, axis="radial", couple="kn 1e12 kt 3e11 damping 0.3")
    script += "fix hold first move linear 0 0 0\nfix motion second nve/sphere\nvelocity second set 0.01 0 0.02\n"
    table = run(script + thermo(20, ["f_cem[10]", "f_cem[12]"]) + "run 400\n", tmp_path).table()
    assert table["f_cem[10]"][-1] > 0
    figures.below("imbalance of the energy", abs(table["f_cem[12]"][1:]).max(), 1e-7)
