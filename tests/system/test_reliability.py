# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of doc/reliability.md hold what was measured, and what was not measured stays."""
import json
import subprocess
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "reliability.py"
PAGE = "Head\n<!-- table: begin -->\nold\n<!-- table: end -->\nbetween\n<!-- fuzz: begin -->\nold\n<!-- fuzz: end -->\nend\n<!-- mutants: begin -->\nold\n<!-- mutants: end -->\n"
COUNTS = {"ok": 3, "message": 4, "silent": 0, "nameless": 0, "crash": 1, "hang": 0, "memory": 0, "host": 2}


def figure(name, value, limit):
    return {"test": "test_a", "what": "What.", "line": 7, "case": name, "figure": name, "value": value, "limit": limit, "met": limit is None or value <= limit}


@pytest.fixture
def write(tmp_path):
    def run(page=PAGE, **files):
        (tmp_path / "figures").mkdir(exist_ok=True)
        for name, records in files.items():
            (tmp_path / "figures" / f"{name}.json").write_text(json.dumps(records))
        (tmp_path / "page.md").write_text(page)
        done = subprocess.run([TOOL, tmp_path / "figures", tmp_path / "page.md"], capture_output=True, text=True)
        return done.returncode, done.stderr, (tmp_path / "page.md").read_text()

    return run


def test_row_is_that_of_the_figure_nearest_to_its_limit(write):
    status, _, page = write(test_file=[figure("far", 1.0, 10.0), figure("near", 0.2, 0.5), figure("noted", "1e-3", None)])
    assert status == 0
    assert (
        "| `test_file`: a | What. | 3, 2 | near | 0.2 | 0.5 |\n\n0 figures measure rounding: they are below 1e-09. No limit of them is above 30 times the largest "
        "figure that it holds.\n<!-- table: end -->\nbetween\n"
    ) in page
    assert "<!-- fuzz: begin -->\nold\n<!-- fuzz: end -->" in page


@pytest.mark.parametrize("value, limit", [(2.0, 1.0), (1.0, 0.0)])
def test_a_limit_that_is_missed_is_said(write, value, limit):
    _, _, page = write(test_file=[figure("missed", value, limit), figure("near", 0.9, 1.0)])
    assert f"missed | {value:.2g} **not met** | {limit:g} |" in page


def test_wide_limits_of_rounding_are_said(write):
    """Of the figures of one limit the largest counts; one that is exact, or none, is left out."""
    one = [figure("one rank", 1e-15, 4e-13), figure("two ranks", 2e-14, 4e-13), figure("exact", 0.0, 1e-10), figure("physics", 1e-6, 1e-3)]
    other = [figure("loose", 1e-14, 1e-9)]
    _, _, page = write(test_file=one, test_other=other)
    assert (
        "3 figures measure rounding: they are below 1e-09. Of these limits are above 30 times the largest figure that they hold: `test_other`: a (1e-09 for 1.0e-14)."
        in page
    )
    _, _, page = write(test_file=one, test_other=[])
    assert "2 figures measure rounding" in page and "No limit of them is above 30 times" in page


def test_fuzzer_alone(write):
    status, _, page = write(fuzz=[{"test": "test_fuzz", "case": "nothing", "counts": COUNTS, "seed": 7}])
    assert status == 0 and "<!-- table: begin -->\nold\n" in page
    assert "10 inputs of seed 7:" in page and "| nothing | 3 | 4 | 0 | 0 | 1 | 0 | 0 | 2 |\n<!-- fuzz: end -->\nend\n" in page


def mutant(outcome, by):
    return {"seed": 3, "outcome": outcome, "by": by, "file": "mpm/a.cpp", "line": 7, "change": "`a || b` becomes `a && b`", "content": "if (a || b) return;"}


def test_mutants(write):
    """Each with what killed it; survivors and what was not run cannot be overlooked, and code with bars stays in its cell."""
    status, _, page = write(
        mutants=[mutant("killed", "test_mpm: Grid.A"), mutant("changes nothing", "Nobody reads it."), mutant("survives", ""), mutant("not run", "")]
    )
    assert status == 0 and "<!-- table: begin -->\nold\n" in page and "<!-- fuzz: begin -->\nold\n" in page
    table = page.split("<!-- mutants: begin -->\n")[1].split("\n<!-- mutants: end -->")[0].splitlines()
    assert table[0] == "4 mutants of seed 3: 1 fail a test, 1 change nothing, 1 **survive**, 1 **were not run**."
    assert table[4:] == [
        "| mpm/a.cpp:7 | `a \\|\\| b` becomes `a && b` in `if (a \\|\\| b) return;` | " + by + " |"
        for by in ("`test_mpm: Grid.A`", "Nobody reads it.", "**survives**", "**not run**")
    ]


@pytest.mark.parametrize(
    "name, text",
    [
        ("test_file", "{"),
        ("test_file", "[1, 2]"),
        ("test_file", '{"a": 1}'),
        ("test_file", '[{"test": "test_a"}]'),
        ("fuzz", "[]"),
        ("fuzz", "nonsense"),
        ("mutants", "[]"),
        ("mutants", '[{"seed": 1}]'),
    ],
)
def test_a_file_that_holds_no_figures(write, tmp_path, name, text):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / f"{name}.json").write_text(text)
    status, error, page = write()
    assert status == 1 and page == PAGE and len(error.splitlines()) == 1, error
    assert f"{name}.json: holds no figures of tests" in error


def test_nothing_measured_or_nowhere_to_write(write, tmp_path):
    status, error, page = write()
    assert status == 1 and page == PAGE
    assert error == f"reliability.py: no figures in {tmp_path / 'figures'}; run `make test`, `make stress`, `make fuzz` or `make mutants`\n"
    status, error, page = write("no marks\n", test_file=[figure("a", 1.0, 2.0)])
    assert status == 1 and "'<!-- table: begin -->'" in error and page == "no marks\n"
