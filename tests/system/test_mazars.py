# SPDX-License-Identifier: GPL-2.0-or-later
"""`damage mazars` in a script: a flat bond pulled through failure, its columns, files and messages."""
import re

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, cement, edit, launch, pair, pull, restarted, run, thermo
from test_point_file import read

CELL, RAMP = 2.5e-4, 4e-6
KAPPA0, AT, BT = 1e-3, 0.9, 1e3
WORDS = f"damage mazars kappa0 {KAPPA0} At {AT} Bt {BT} cutoff 0.9"
COLUMNS = ["f_bond", "f_bond[17]", "f_cem[8]", "f_cem[9]", "f_cem[12]"]


def damage_at(kappa):
    kappa = np.maximum(kappa, KAPPA0)
    return np.where(kappa > KAPPA0, 1 - (1 - AT) * KAPPA0 / kappa - AT * np.exp(-BT * (kappa - KAPPA0)), 0.0)


def scene(words=WORDS, every=20, cement_words="content 0.01"):
    return (
        pair(CELL / 2, cement=cement_words)
        + CONTACT
        + cement(CELL, 4e-9, elastic=CALCITE, axis="radial", damage=words)
        + pull(4.0, RAMP)
        + thermo(every, COLUMNS)
    )


def test_pulled_through_failure(tmp_path, figures):
    """Energy balances through failure; the events are the same on two ranks, and those after a restart."""
    words = WORDS + " check 20 events events.csv"
    table = run(scene(words) + "run 700\nwrite_restart half\nrun 1900\n", tmp_path).table()
    force, peak = table["f_bond"], table["f_bond"].argmax()
    assert table["f_bond[17]"][-1] > 100 and abs(force[-30:].mean()) < 0.1 * force[peak], "not broken"
    assert table["f_cem[8]"][-1] > 0 and table["f_cem[9]"][-1] > 0
    figures.below("imbalance of the energy from the peak on", abs(table["f_cem[12]"][peak:]).max(), 0.002)
    events = [line.split(",") for line in (tmp_path / "events.csv").read_text().splitlines()[1:]]
    assert len(events) > 100
    assert all(r[8] == r[9] == r[10] for r in events)
    assert np.median([abs(float(r[13])) for r in events]) > 0.9, "normals are not along the pull"

    def same(name, of):
        found = [line.split(",")[:4:2] for line in (tmp_path / name).read_text().splitlines()[1:]]
        assert found == [r[:4:2] for r in of], name

    ranks = edit(words, "events.csv", "ranks.csv")
    run(scene(ranks) + "run 2600\n", tmp_path, ranks=2, name="in.ranks")
    same("ranks.csv", events)
    after = edit(scene(edit(words, "events.csv", "after.csv")), pair(CELL / 2, cement="content 0.01"), restarted("half"))
    run(after + "run 1900\n", tmp_path, name="in.after")
    same("after.csv", [r for r in events if int(r[0]) > 700])


def test_columns(tmp_path):
    """kappa, the damage that depends on it, the tensor, the driving force and the stress of each point."""
    names = ["kappa", "damage", "damage_xx", "damage_xy", "drive", "failed", "stress_max", "strain_zz"]
    script = scene() + "".join(f"compute q_{n} calcite mpm/atom cem {n}\n" for n in names)
    script += "dump d calcite custom 500 points.*.txt id " + " ".join(f"c_q_{n}" for n in names) + "\nrun 500\n"
    run(script, tmp_path)
    lines = (tmp_path / "points.500.txt").read_text().splitlines()
    rows = np.array([[float(w) for w in line.split()] for line in lines[9:]])
    p = dict(zip(["id"] + names, rows.T))
    some = p["kappa"] > 0
    assert some.sum() > 50 and (p["kappa"][some] > KAPPA0).all()
    np.testing.assert_allclose(p["damage"], damage_at(p["kappa"]), atol=2e-5)
    np.testing.assert_allclose(p["damage_xx"], p["damage"], atol=1e-9)
    assert abs(p["damage_xy"]).max() < 1e-14
    alive = p["failed"] == 0
    assert p["drive"][alive].max() < 1 + 1e-5 and p["drive"][alive & some].max() > 0.99


def test_written_and_read(tmp_path):
    """write_cement has the damage as a tensor, which create_cement ... file gives back to the law."""
    run(scene() + "run 700\nwrite_cement cement.txt\n", tmp_path)
    written = read(tmp_path / "cement.txt")
    assert written["dxx"].max() > 0.1
    for c in ("dyy", "dzz"):
        np.testing.assert_allclose(written[c], written["dxx"], atol=1e-12)
    t = 700 * 4e-9  # the grain has moved
    moved = 2.0 * (t - RAMP / np.pi * np.sin(np.pi * t / RAMP))
    made = re.search(r"^create_cement.*\n", scene(), re.M)[0]
    again = edit(scene(), made, f"create_cement calcite pair 1 2 file cement.txt spacing {CELL / 2:.15g}\n")
    again = edit(again, "single 0 0 0.005 units", f"single 0 0 {0.005 + moved:.17g} units")
    run(again + "run 0\nwrite_cement again.txt\n", tmp_path, name="in.again")
    back = read(tmp_path / "again.txt")
    np.testing.assert_allclose(np.sort(back["dxx"]), np.sort(written["dxx"]), atol=1e-9)
    for words, found in ((edit(WORDS, "cutoff 0.9", "cutoff 0.05"), "above the cut-off 0.05"), ("", "damage tensor")):
        done = launch(edit(again, WORDS, words) + "run 0\n", tmp_path, name="in.refused")
        assert done.status != 0 and found in done.output, done.output[-2000:]


@pytest.mark.parametrize(
    "words, found",
    [
        ("damage mazars At 0.9 Bt 1e3", ["'damage mazars' needs 'kappa0'"]),
        ("damage mazars kappa0 1e-3 At 1.5 Bt 1e3", ["damage mazars At 1.5", "(0, 1]"]),
        ("damage mazars kappa0 1e-3 At 0.9 Bt 0", ["damage mazars Bt 0", "greater than 0"]),
        ("damage mazars kappa0 1e-3 At 0.9 Bt 1e3 zeta 0.1", ["'zeta' belongs to the words of 'damage tensor'"]),
        (
            "damage mazars kappa0 1e-3 At 0.9 Bt 1e3 check 10 cutoff 0.8",
            ["'cutoff' belongs to the words of 'damage mazars'", "kappa0 ... At ... Bt ... cutoff"],
        ),
        ("damage mazar", ["none, tensor, mazars"]),
        (WORDS + " regularization crackband 10", ["'regularization crackband 10' does not go with 'damage mazars kappa0", "'damage tensor'"]),
    ],
)
def test_bad_options(tmp_path, words, found):
    done = launch(scene(words) + "run 0\n", tmp_path)
    assert done.status != 0
    for text in found:
        assert text in done.output, done.output[-1500:]


def test_another_law_goes_on(tmp_path):
    """Points that one law damaged are refused to another by name."""
    other = scene("damage tensor B0 9.6e6")
    fixes = re.search(r"^fix +cem .*\n", other, re.M)[0]
    coupled = fixes + "fix bond grains mpm/couple cem kn auto kt auto\nrun 0\n"
    refused = "a state of 'damage mazars', from which 'damage tensor' cannot go on"
    done = launch(scene() + "run 700\nwrite_restart half\nunfix bond\nunfix cem\n" + coupled, tmp_path)
    assert done.status != 0 and refused in done.output, done.output[-1500:]
    after = edit(other, pair(CELL / 2, cement="content 0.01"), restarted("half"))
    done = launch(after + "run 0\n", tmp_path, name="in.after")
    assert done.status != 0 and refused in done.output, done.output[-1500:]
    done = launch(restarted("half") + "write_cement cement.txt\n", tmp_path, name="in.write")
    assert done.status != 0 and "their state is that of 'damage mazars'; define fix mpm with that law" in done.output, done.output[-1500:]
