# SPDX-License-Identifier: GPL-2.0-or-later
"""regularization nonlocal: fracture energy and width of the band are the same with every cell."""
import csv
import math
import re
from pathlib import Path

import pytest
import softening_bar
from localisation import band
from scenes import CONTACT, cement, edit, launch, pair
from softening_bar import B0, bar

LENGTH = 2e-4


def pulled(directory, cells_a_length, words, monkeypatch, *, stretch=2.25, **options):
    """A bar ten lengths long, pulled apart."""
    monkeypatch.setattr(softening_bar, "LENGTH", 10 * LENGTH)
    monkeypatch.setattr(softening_bar, "RADIUS", 5000 * LENGTH)
    cells = round(10 * cells_a_length)
    return bar(directory, cells, 0.0, stretch=stretch * cells_a_length, regularization=f"nonlocal {LENGTH} {words}", **options)


def implied(directory):
    """Energy per area and width of the band from the report."""
    text = (directory / "log.liggghts").read_text()
    return [float(v) for v in re.search(r"a crack takes (\S+) per area in a band of (\S+),", text).groups()]


@pytest.mark.parametrize("cells_a_length", [1, 1.5, 2])
def test_same_energy_at_any_cell(tmp_path, figures, monkeypatch, cells_a_length):
    """The bar is no longer than its band by far, and is pulled through a snap: 2 to 3 % less than in an infinite one."""
    r = pulled(tmp_path, cells_a_length, "", monkeypatch)
    energy, width = implied(tmp_path)
    expected = band(0.0)
    assert energy == pytest.approx(math.sqrt(2) * B0 * LENGTH * sum(expected[1:]), rel=2e-3)
    assert width == pytest.approx(LENGTH * expected[0], rel=0.1)
    assert r["end"] < 0.02 and r["failed"] <= 3
    damaged = sum(d > 0.2 for d in r["profile"]) / (2 * cells_a_length)
    figures.note(f"bar with {cells_a_length:g} cells a length: damage of its layers", r["profile"])
    spent = math.sqrt(2) * B0 * LENGTH * expected[1]  # the rest leaves in waves when the middle fails
    figures.below(f"bar with {cells_a_length:g} cells a length: error of the energy that damage takes", abs(r["energy"] / spent - 1), 0.04)
    figures.below(f"bar with {cells_a_length:g} cells a length: error of the width, lengths", abs(damaged - width / LENGTH), 0.3)


SLOWLY = {"speed": 0.01, "stretch": 6, "share": 0.7}


@pytest.mark.parametrize("cells_a_length, energy, limit", [(1, 18.0, 0.06), (2, 18.0, 0.06), (1, 25.0, 0.1), (2, 25.0, 0.03)])
def test_energy_asked_for(tmp_path, figures, monkeypatch, cells_a_length, energy, limit):
    """The area under force and opening. The bar holds 13.6 J/m2 at the peak: with a smaller fracture energy it snaps, and loses its elastic energy as well."""
    r = pulled(tmp_path, cells_a_length, f"energy {energy}", monkeypatch, **SLOWLY)
    assert implied(tmp_path)[0] == pytest.approx(energy, rel=1e-4)
    assert r["end"] < 0.02
    figures.below(f"energy {energy:g} asked for, {cells_a_length:g} cells a length: error", abs(r["under_curve"] / energy - 1), limit)


@pytest.mark.parametrize("couple", ["kn auto kt auto", "kn 4e14 kt 2e14"], ids=["stiff", "soft"])
@pytest.mark.parametrize("cells_a_length, energy, limit", [(1, 18.0, 0.1), (2, 18.0, 0.1), (1, 25.0, 0.1), (2, 25.0, 0.1)])
def test_energy_beside_a_grain(tmp_path, figures, monkeypatch, cells_a_length, energy, limit, couple):
    """The band at a grain is half a band, and takes the energy of a whole one, on stiff and on soft links. With one softening for all points it takes half."""
    r = pulled(tmp_path, cells_a_length, f"energy {energy}", monkeypatch, breaks=1.5 * LENGTH, couple=couple, **SLOWLY)
    assert r["end"] < 0.02
    ends = sorted((r["profile"][0], r["profile"][-1]))
    assert ends[0] < 0.5 and ends[1] > 0.85, "it broke inside, or came off both grains"
    figures.below(
        f"energy {energy:g} at a grain, {cells_a_length:g} cells a length, {'stiff' if 'auto' in couple else 'soft'} links: error",
        abs(r["under_curve"] / energy - 1),
        limit,
    )


@pytest.mark.parametrize(
    "words, message",
    [
        ("nonlocal 1.9e-4", "the length must be at least the cell, which is 0.0002; take 'cell 0.00019' or less"),
        ("nonlocal 0.2", "the length must be at most 100 cells, which are 0.02, in the units of the box"),
        ("nonlocal 0", "regularization nonlocal"),
        ("nonlocal -1e-4", "regularization nonlocal"),
        ("nonlocal 2e-4 energy -1", "regularization nonlocal ... energy"),
        ("nonlocal 2e-4 energy 1", "must lie between"),
        ("nonlocal 2e-4 energy 1e4", "or for this energy the length between"),
        ("nonlocal 2e-4 imperfection -1e-3", "regularization nonlocal ... imperfection"),
        ("nonlocal 2e-4 imperfection 0.2", "by how much more strain one side of a bond carries"),
        ("nonlocal 2e-4 imperfecton 1e-3", "and after 'regularization nonlocal' energy, imperfection"),
        ("nonlocal 2e-4 imperfection nan", "a finite number is needed"),
        ("nonlocal 2e-4 imperfection 1e-3 energy 14 imperfection 1e-3", "'imperfection' is given twice in regularization nonlocal"),
    ],
)
def test_bad_options(tmp_path, words, message):
    text = scene(words)
    result = launch(text, tmp_path)
    assert result.status != 0 and len(result.errors()) == 1 and message in result.errors()[0]


@pytest.mark.parametrize(
    "damage, words, message",
    [
        ("none", "", "'regularization nonlocal 2e-4' does not go with 'damage none'"),
        ("mazars kappa0 4e-4 At 1 Bt 3000", "energy 10", "energy 10' does not go with 'damage mazars kappa0"),
    ],
)
def test_law_that_cannot(tmp_path, damage, words, message):
    text = edit(scene(f"nonlocal 2e-4 {words}"), f"damage tensor B0 {B0}", f"damage {damage}")
    result = launch(text, tmp_path)
    assert result.status != 0 and len(result.errors()) == 1 and message in result.errors()[0]


def scene(words):
    return pair(1e-4) + CONTACT + cement(2e-4, 1e-9, damage=f"damage tensor B0 {B0} regularization {words}") + "run 0\n"


@pytest.mark.parametrize(
    "words, cracks",
    [
        ("", "bonds"),
        ("regularization nonlocal 2e-4", "split"),
        ("regularization nonlocal 2e-4 cracks bonds", "bonds"),
        ("regularization nonlocal 2e-4 condense yes", "bonds"),
        ("regularization nonlocal 2e-4 kinematics updated", "bonds"),
        ("regularization nonlocal 2e-4 reproject 10", "bonds"),
    ],
)
def test_cracks_by_default(tmp_path, words, cracks):
    """The average ends at a crack only where its sides have nodes of their own."""
    done = launch(pair(1e-4) + cement(2e-4, 1e-9, damage=f"damage tensor B0 9.6e3 {words}") + CONTACT + "run 0\n", tmp_path)
    assert done.status == 0, done.output
    assert re.search(r"^  cracks +(\w+)$", done.output, re.M)[1] == cracks


@pytest.mark.parametrize("beads, ranks, weaker", [("equal", 1, 1), ("IDs swapped", 1, 2), ("IDs swapped", 2, 2), ("upper one larger", 1, 2)])
def test_imperfection_decides_which_grain_debonds(tmp_path, figures, beads, ranks, weaker):
    """Without it an eighth of the fracture surface is at the second grain. The weaker side is that of the lower of equal beads, and else that of the larger."""
    script = (Path(__file__).parents[2] / "examples" / "pair_table" / "in.pair_table").read_text()
    words = dict(content=0.01, spacing=1.5e-4, inner=1e-3, film="grid", frames=10**8, regularization="nonlocal 3e-4 imperfection 0.1")
    if beads == "upper one larger":
        words["diameter"] = 0.01 * (1 + 1e-5)
    if beads == "IDs swapped":
        lower, top = "create_atoms 1 single 0 0 ${lower} units box\n", "create_atoms 1 single 0 0 ${top} units box\n"
        script = edit(script, lower + top, top + lower)
        script = edit(edit(script, "group        lower id 1", "group        lower id 2"), "group        upper id 2", "group        upper id 1")
        script = edit(script, "set          atom 2 diameter", "set          atom 1 diameter")
    result = launch(script, tmp_path, ranks, name="in.pair_table", arguments=[w for k, v in words.items() for w in ("-var", k, str(v))])
    assert result.status == 0, result.output
    assert "one side of each bond carries 0.1 more strain than the other" in result.output
    bond = list(csv.DictReader((tmp_path / "bond_run.csv").open()))[-1]
    figures.below(f"{beads}, {ranks} ranks, imperfection of 0.1: share that is not at the weaker grain", 1 - float(bond[f"share_grain{weaker}"]), 0.01)
