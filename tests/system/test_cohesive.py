# SPDX-License-Identifier: GPL-2.0-or-later
"""`interface cohesive` of fix mpm/couple in a script: a flat bond without damage pulled off its grains."""
import re

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, cement, edit, launch, pair, pull, restarted, run, thermo

CELL, STEP, RAMP = 2.5e-4, 4e-9, 4e-6
TN, TT, GN, GT = 10e6, 10e6, 40.0, 40.0  # the surfaces of the grains are tilted: one energy for all modes
WORDS = f"interface cohesive tn {TN} tt {TT} Gn {GN} Gt {GT}"
COLUMNS = ["f_bond", "f_bond[16]", "f_bond[17]", "f_bond[18]", "f_cem[8]", "f_cem[9]", "f_cem[12]"]
STEPS, HALF = 2000, 1000


def scene(words=WORDS, damage="events events.csv check 20", every=20, ring="content 0.01"):
    fixes = cement(CELL, STEP, elastic=CALCITE, axis="radial", damage=damage, couple=f"kn auto kt auto {words} csv 20 bond.csv")
    return pair(CELL / 2, cement=ring) + CONTACT + fixes + pull(4.0, RAMP) + thermo(every, COLUMNS)


def events(directory, name="events.csv"):
    return [line.split(",") for line in (directory / name).read_text().splitlines()[1:]]


def areas(output):
    """Attached areas at either grain, as create_cement tells them."""
    return [float(a) for a in re.search(r"attached area (\S+) \+ (\S+?),", output).groups()]


def test_pulled_off_its_grains(tmp_path, figures):
    """Links let go although no point fails, take Gn times their area, are listed, and the bond is debonded; the same on two ranks and
    after a restart."""
    first = run(scene() + f"run {HALF}\nwrite_restart half\nrun {STEPS - HALF}\n", tmp_path)
    table = first.table()
    assert table["f_bond[18]"][-1] == 0, "points failed"
    listed = events(tmp_path)
    assert len(listed) == table["f_bond[17]"][-1] > 50
    assert {r[-1] for r in listed} == {"debonding"} and {r[4] for r in listed} <= {"1", "2"}
    row = (tmp_path / "bond.csv").read_text().splitlines()[-1].split(",")
    assert row[-1] == "debonding"
    peak = table["f_bond"].argmax()
    figures.below("imbalance of the energy from the peak on", abs(table["f_cem[12]"][peak:]).max(), 0.01)
    grain = {int(r[4]) for r in listed}
    assert len(grain) == 1
    # what is more than Gn times the area is the damage at the other grain, which stays on
    figures.below("energy over Gn times the area, less 1", abs(table["f_cem[8]"][-1] / (GN * areas(first.output)[grain.pop() - 1]) - 1), 0.05)
    assert any(int(r[0]) > HALF for r in listed) and any(int(r[0]) <= HALF for r in listed)

    run(edit(scene(), "events.csv", "ranks.csv") + f"run {STEPS}\n", tmp_path, ranks=2, name="in.ranks")
    assert [r[:5] for r in events(tmp_path, "ranks.csv")] == [r[:5] for r in listed]
    after = edit(edit(scene(), "events.csv", "after.csv"), pair(CELL / 2, cement="content 0.01"), restarted("half"))
    run(after + f"run {STEPS - HALF}\n", tmp_path, name="in.after")
    assert [r[:5] for r in events(tmp_path, "after.csv")] == [r[:5] for r in listed if int(r[0]) > HALF]


@pytest.mark.parametrize("words, message", [
    ("interface cohesive tn 1e6 tt 1e6 Gn 1", "'interface cohesive' needs 'Gt', the energy per area that shear takes"),
    ("interface cohesive tn -1 tt 1e6 Gn 1 Gt 1", "'interface cohesive tn -1': must be greater than 0"),
    ("interface cohesive tn 1e9 tt 1e6 Gn 1e-3 Gt 1", "'Gn 0.001' must be above"),
    ("interface glue", "interface"),
])
def test_bad_words(tmp_path, words, message):
    done = launch(scene(words) + "run 0\n", tmp_path)
    assert done.status != 0
    assert len(done.errors()) == 1 and message in done.errors()[0], done.output[-1000:]


def test_another_law_after_a_restart_is_refused(tmp_path):
    run(scene() + "run 10\nwrite_restart early\n", tmp_path)
    for words, told in (("", "interface penalty"), (edit(WORDS, f"Gn {GN}", "Gn 21"), "interface cohesive")):
        done = launch(edit(scene(words), pair(CELL / 2, cement="content 0.01"), restarted("early")) + "run 1\n", tmp_path, name="in.other")
        assert done.status != 0 and any(told in e and f"Gn {GN:g}" in e for e in done.errors()), done.output[-1000:]
