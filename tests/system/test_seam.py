# SPDX-License-Identifier: GPL-2.0-or-later
"""Cement thinner than a cell between elastic grains: a seam. Stiffness against finite elements, an interface that debonds, ranks and restart."""
import shutil

import numpy as np
import pytest
from scenes import launch, restarted, run, thermo
from test_elastic_grains import CASES, COLUMN, scene, stiffness

CASE = CASES["small ring"]
WIDTH = CASE["outer"] - CASE["inner"]
VALUES = ["f_bond[9]", "f_bond[17]", "f_bond[22]", "f_cem[8]", "f_cem[12]"]
STEPS, END, PULL = 3200, 4400, 6.4e-7
FIXES = "fix hold first move linear 0 0 0\nfix pull second move variable NULL NULL v_d NULL NULL v_v\n"
PROCESSORS = {1: "1 1 1", 2: "2 1 1", 4: "2 2 1"}


@pytest.mark.parametrize("across", [1, 2, 4])
def test_finite_elements(across, tmp_path, figures):
    """Cells across the width. The cement is 0.05 mm thick, cells are 0.3 to 0.075 mm wide."""
    found = stiffness(tmp_path, scene(CASE, WIDTH / across))
    for load in COLUMN:
        error = found[load] / CASE["stiffness"][load]["value"] - 1
        figures.note(f"{across} cells, {load}: signed error", f"{error:+.4f}")
        figures.below(f"{across} cells, {load}: error of the stiffness", abs(error), 0.03)


def torn(cohesive="interface cohesive tn 2e7 tt 2e7 Gn 10 Gt 10", across=2, ranks=1, condense="no"):
    """A pull that debonds all of the interface."""
    text = scene(CASE, WIDTH / across).replace("axis bond", f"axis bond quasistatic 1 0.1 condense {condense}")
    text = text.replace("kn auto kt auto", "kn auto kt auto " + cohesive).replace("timestep     1e-09", "timestep 1e-8")
    text = text.replace("processors   * * *", "processors " + PROCESSORS[ranks])
    text += f'variable s equal step/{STEPS}\nvariable d equal "{PULL}*v_s*v_s"\nvariable v equal "2*{PULL}*v_s/({STEPS}*dt)"\n'
    return text + FIXES + thermo(20, VALUES)


def test_cohesive_interface(tmp_path, figures):
    """The interface takes its energy; the largest force hardly depends on the cells; a condensed bond that is activated breaks alike."""
    peaks = {}
    for name, options in {"two cells": {}, "three cells": {"across": 3}, "condensed": {"condense": "yes"}}.items():
        r = run(torn(**options) + f"run {END}\n", tmp_path / name.replace(" ", "_"))
        t = r.table()
        peaks[name] = abs(t["f_bond[9]"]).max()
        figures.note(f"{name}: largest force", peaks[name])
        assert ("condensed" in r.output) == (name == "condensed")
        assert t["f_bond[22]"][-1] == 1 and t["f_bond[22]"][0] == 0
        figures.below(f"{name}: imbalance of the energy", abs(t["f_cem[12]"]).max(), 1e-5)
        outer, inner, R = CASE["outer"], CASE["inner"], CASE["radius"][0]
        area = 2 * np.pi * R * (np.sqrt(R * R - inner * inner) - np.sqrt(R * R - outer * outer))
        figures.below(f"{name}: energy of the interface", abs(t["f_cem[8]"][-1] / (10 * area) - 1), 0.1)
    for name in ("three cells", "condensed"):
        figures.below(f"{name}: largest force against two cells", abs(peaks[name] / peaks["two cells"] - 1), 0.03)


def test_ranks_and_restart(tmp_path, figures):
    """Ranks share the bond while it softens; a run goes on from a file bitwise identically."""
    tables = {}
    for ranks in (1, 2, 4):
        r = run(torn(ranks=ranks) + f"run 2400\nwrite_restart middle.restart\nrun {END - 2400}\n", tmp_path / str(ranks), ranks)
        tables[ranks] = r.table()
        figures.below(
            f"{ranks} ranks: force of the bond", abs(tables[ranks]["f_bond[9]"] - tables[1]["f_bond[9]"]).max() / abs(tables[1]["f_bond[9]"]).max(), 1e-6
        )
    again = tmp_path / "again"
    again.mkdir()
    shutil.copy(tmp_path / "2" / "middle.restart", again)
    whole = torn(ranks=2)
    fixes = whole[whole.index("timestep") :]
    t = run(restarted("middle.restart", processors=PROCESSORS[2]) + fixes + f"run {END - 2400}\n", again, 2).table()
    late = tables[2]["step"] >= 2420
    assert (t["f_bond[9]"][t["step"] >= 2420] == tables[2]["f_bond[9]"][late]).all()


def test_rigid_grains_are_refused(tmp_path):
    done = launch(scene(CASE, WIDTH, "grains rigid") + "run 0\n", tmp_path)
    assert done.status != 0 and len(done.errors()) == 1 and "film joined" in done.errors()[0] and "grains elastic" in done.errors()[0]
    assert "a seam in cells" in done.output


def test_seams_are_not_written(tmp_path):
    done = launch(scene(CASE, WIDTH) + "run 0\nwrite_cement cement.txt\n", tmp_path)
    assert done.status != 0 and "is a seam" in done.errors()[0], done.errors()
