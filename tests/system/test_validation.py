# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages that compare with others: their numbers are those of the stored tables, and the program still gives what Yade was given."""
import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from beside_yade import FILM, FLAT, PAIR, STIFFNESS
from published_strengths import ALL, active_share, ours, published
from scenes import launch

ROOT = Path(__file__).parents[2]
DATA = ROOT / "doc" / "data"


@pytest.fixture(scope="module")
def yade():
    return json.loads((DATA / "study_yade.json").read_text())


def page_rows(page, head):
    """Cells of the rows of the table of a page whose first cell of the head is `head`."""
    lines = (ROOT / "doc" / page).read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith(f"| {head} |"))
    rows = []
    for line in lines[at + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def pulled(directory, words, limit):
    """Largest load of the pair of examples/pair_table."""
    result = launch(Path(PAIR).read_text(), directory, name="in.pair_table", arguments=[*words, "-var", "limit", str(limit)])
    assert not result.errors(), result.output[-2000:]
    with open(directory / "load_run.csv") as f:
        return max(float(row["load"]) for row in csv.DictReader(f))


def test_stiffness_that_yade_was_given(tmp_path, yade):
    """Stiffness of the bond between 10 mm beads against the values of the comparison."""
    result = launch(STIFFNESS, tmp_path)
    assert result.status == 0, result.output[-2000:]
    table = np.genfromtxt(tmp_path / "stiffness.csv", delimiter=",", names=True)
    for name, value in yade["pair"]["stiffness"].items():
        assert table[name] == pytest.approx(value, rel=1e-3), name


def test_strength_of_the_films_that_yade_was_given(tmp_path, yade, figures):
    """Tension and shear that break a film of the specimen against the values of the comparison."""
    given = yade["specimen"]["strength_over_radius_squared"]["1.0"]
    for load, value in zip(("tension", "shear"), given):
        (tmp_path / load).mkdir()
        found = pulled(tmp_path / load, [*FILM, "-var", "load", load], 6000) / 0.005**2
        figures.below(load, abs(found / value - 1.0), 0.02)  # the table has every tenth step


def test_the_pulled_pair(tmp_path, yade):
    """Tension that breaks the bond between 10 mm beads against the value of the comparison."""
    found = pulled(tmp_path, [*FLAT, "-var", "load", "tension"], 1200)
    assert found == pytest.approx(yade["pair"]["loads"]["tension"]["here"]["peak"], rel=5e-3)


def test_page_of_yade(yade):
    """doc/study_yade.md has the numbers of doc/data/study_yade.json."""
    for load, *cells in page_rows("study_yade.md", "load"):
        both = yade["pair"]["loads"][load]
        here, there = both["here"], both["yade"]
        assert cells[0] == f"{here['peak']:.3g}" and cells[1] == here["mode"], load
        assert cells[2] == (f"{there['peak']:.3g}" if there["mode"] == "broken" else "none") and cells[3] == there["mode"], load
        assert cells[4] == f"{1e3 * here['cpu'] / here['steps']:.2g}" and cells[5] == f"{1e3 * there['cpu'] / there['steps']:.2g}", load
    keys = {"here": "here", "Yade": "yade", "Yade without moments": "yade, no moments", "Yade, damping 0.05": "yade, damping 0.05"}
    rows = page_rows("study_yade.md", "specimen")
    assert {row[0] for row in rows} == set(keys)
    for name, *cells in rows:
        run = yade["specimen"][keys[name]]
        stress, broken = np.array(run["curve"][1]), np.array(run["curve"][2])
        first = int(np.flatnonzero(broken)[0])
        wanted = [f"{1e-6 * run['strength']:.3g}", f"{1e3 * run['strain']:.3g}", f"{1e-6 * stress[: first + 1].max():.2g}", str(run["broken_at_peak"])]
        wanted += [str(run["broken"]), str(run["steps"]), f"{run['cpu']:.2g}", f"{1e3 * run['cpu'] / run['steps']:.2g}"]
        assert cells == wanted, name


def test_published_strengths():
    """The classes of all specimens are those of the studies together."""
    studies = published()
    whole = studies.pop(ALL)
    assert sum(row["specimens"] for row in whole) == 351
    for row in whole:
        parts = [r for rows in studies.values() for r in rows if r["calcite_from_percent"] == row["calcite_from_percent"]]
        assert sum(r["specimens"] for r in parts) == row["specimens"]
        assert min(r["ucs_lowest_MPa"] for r in parts) == row["ucs_lowest_MPa"] and max(r["ucs_highest_MPa"] for r in parts) == row["ucs_highest_MPa"]
        assert min(r["ucs_median_MPa"] for r in parts) <= row["ucs_median_MPa"] <= max(r["ucs_median_MPa"] for r in parts)


def test_page_of_validation():
    """doc/validation.md has the numbers of the stored tables."""
    whole, mine = published()[ALL], ours()
    slope, log_one = np.polyfit(np.log(mine[:, 0]), np.log(mine[:, 1]), 1)
    rows = page_rows("validation.md", "calcite, %")
    assert len(rows) == len(whole)
    for cells, row in zip(rows, whole):
        content, median = row["calcite_median_percent"], row["ucs_median_MPa"]
        here = np.exp(log_one + slope * np.log(content))
        share = 100 * float(active_share(content, median, mine))
        assert cells[0] == f"{row['calcite_from_percent']:g} to {row['calcite_to_percent']:g}" and cells[1] == f"{row['specimens']:.0f}"
        assert cells[2] == f"{row['ucs_lowest_MPa']:g} to {row['ucs_highest_MPa']:g}" and cells[3] == f"{median:g}"
        measured = content < 1.1 * mine[-1, 0]
        assert cells[4:] == [f"{here:.2g}" if measured else "", f"{here / median:.2g}" if measured else "", f"{share:.0f} %"]
    stored = json.loads((DATA / "validation.json").read_text())
    rows = page_rows("validation.md", "80 beads: calcite, %")
    assert len(rows) == len(stored["active_share_runs"])
    for cells, run in zip(rows, stored["active_share_runs"]):
        assert cells[0] == f"{100 * run['calcite']:.3g}" and cells[1] == f"{100 * run['at_contacts']:.0f} %" and cells[2] == f"{1e-6 * run['strength']:.2g}"
        nearest = min(whole, key=lambda row: abs(row["calcite_median_percent"] - 100 * run["calcite"]))
        assert cells[3] == f"{nearest['ucs_median_MPa']:.2g}"
    waves = page_rows("validation.md", "calcite of all")
    assert len(waves) == len(stored["waves"])
    for cells, wave in zip(waves, stored["waves"]):
        assert cells[0] == f"{100 * wave['calcite']:.2g} %" and cells[2:] == [f"{round(wave[k], -1):.0f}" for k in ("shear", "compression")]


def test_strengths_are_those_of_the_specimen_page():
    """Strengths of doc/validation.md and of doc/specimen.md are of the same table."""
    rows = {(r[0], r[2]): float(r[3]) for r in page_rows("specimen.md", "load")}
    for content, compression, tension in ours():
        assert rows["compression", f"{content:.3g} %"] == pytest.approx(compression, rel=0.01)
        assert rows["tension", f"{content:.3g} %"] == pytest.approx(tension, rel=0.01)
    assert re.search(r"\bvalidation\.md\b", (ROOT / "doc" / "index.md").read_text())
