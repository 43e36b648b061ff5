# SPDX-License-Identifier: GPL-2.0-or-later
"""The tables of doc/reliability.md hold what was measured, what was not measured stays, and both tell of the tests that there are."""
import ast
import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TOOL = ROOT / "tools" / "reliability.py"
sys.path.insert(0, str(TOOL.parent))
import reliability  # noqa: E402

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


def rows(tmp_path, name):
    with open(tmp_path / "data" / f"reliability_{name}.csv", newline="") as f:
        return list(csv.DictReader(f))


def test_row_is_that_of_the_figure_nearest_to_its_limit(write, tmp_path):
    status, _, page = write(test_file=[figure("far", 1.0, 10.0), figure("near", 0.2, 0.5), figure("noted", "1e-3", None)])
    assert status == 0
    (row,) = rows(tmp_path, "tests")
    assert list(row.values()) == ["test_file", "test_a", "What.", "3", "2", "near", "0.2", "0.5", "yes", "0", ""]
    assert (
        "<!-- table: begin -->\n2 figures of 1 tests have a limit. All meet it.\n0 of them measure rounding: they are below 1e-09. No tests hold "
        "such a figure by a limit that is more than 30 times as large.\n<!-- table: end -->\nbetween\n"
    ) in page
    assert "<!-- fuzz: begin -->\nold\n<!-- fuzz: end -->" in page and not (tmp_path / "data" / "reliability_mutants.csv").exists()


def test_what_is_promised_has_its_figure_in_the_page(write):
    words, file, test = reliability.PROMISES[0]
    _, _, page = write(**{file: [{**figure("a | b", 0.2, 0.5), "test": test}]})
    assert f"| {words} | a \\| b | 0.2 | 0.5 | `{file}`: {reliability.plain(test)} |\n<!-- table: end -->" in page


@pytest.mark.parametrize("value, limit", [(2.0, 1.0), (1.0, 0.0)])
def test_a_limit_that_is_missed_is_said(write, tmp_path, value, limit):
    _, _, page = write(test_file=[figure("missed", value, limit), figure("near", 0.9, 1.0)])
    assert "have a limit. **Not met** by `test_file`: a.\n" in page
    (row,) = rows(tmp_path, "tests")
    assert (row["nearest to its limit"], row["measured"], row["met"]) == ("missed", f"{value:.2g}", "no")


def test_wide_limits_of_rounding_are_said(write, tmp_path):
    """Of the figures of one limit the largest counts; one that is exact, or none, is left out."""
    one = [figure("one rank", 1e-15, 4e-13), figure("two ranks", 2e-14, 4e-13), figure("exact", 0.0, 1e-10), figure("physics", 1e-6, 1e-3)]
    other = [figure("loose", 1e-14, 1e-9)]
    _, _, page = write(test_file=one, test_other=other)
    assert (
        "3 of them measure rounding: they are below 1e-09. 1 tests hold such a figure by a limit that is more than 30 times as large (column `wide`)." in page
    )
    assert [r["wide"] for r in rows(tmp_path, "tests")] == ["", "1e-09 for 1.0e-14"]
    _, _, page = write(test_file=one, test_other=[])
    assert "2 of them measure rounding" in page and "No tests hold" in page


def test_rows_of_files_that_were_not_measured_stay(write, tmp_path):
    """As long as the file of the tests is there."""
    write(test_gone=[figure("old", 1.0, 2.0)], test_reliability=[figure("old", 1.0, 2.0)], test_words=[figure("old", 1.0, 2.0)])
    for name in ("test_gone", "test_reliability"):
        (tmp_path / "figures" / f"{name}.json").unlink()
    _, _, page = write(test_words=[figure("new", 1.0, 2.0), figure("newer", 1.5, 2.0)])
    assert [(r["file"], r["nearest to its limit"]) for r in rows(tmp_path, "tests")] == [("test_reliability", "old"), ("test_words", "newer")]
    assert "3 figures of 2 tests have a limit." in page


def test_fuzzer_alone(write, tmp_path):
    status, _, page = write(fuzz=[{"test": "test_fuzz", "case": "nothing", "counts": COUNTS, "seed": 7}])
    assert status == 0 and "<!-- table: begin -->\nold\n" in page and not (tmp_path / "data").exists()
    assert "10 inputs of seed 7:" in page and "| nothing | 3 | 4 | 0 | 0 | 1 | 0 | 0 | 2 |\n<!-- fuzz: end -->\nend\n" in page


def mutant(outcome, by):
    return {"seed": 3, "outcome": outcome, "by": by, "file": "mpm/a.cpp", "line": 7, "change": "`a || b` becomes `a && b`", "content": "if (a || b) return;"}


def test_mutants(write, tmp_path):
    """Each with what killed it; survivors and what was not run cannot be overlooked."""
    status, _, page = write(
        mutants=[mutant("killed", "test_mpm: Grid.A"), mutant("changes nothing", "Nobody reads it."), mutant("survives", ""), mutant("not run", "")]
    )
    assert status == 0 and "<!-- table: begin -->\nold\n" in page and "<!-- fuzz: begin -->\nold\n" in page
    shown = page.split("<!-- mutants: begin -->\n")[1].split("\n<!-- mutants: end -->")[0]
    assert shown == "4 mutants of seed 3: 1 fail a test, 1 change nothing, 1 **survive**, 1 **were not run**."
    planted = rows(tmp_path, "mutants")
    assert [(r["outcome"], r["by"]) for r in planted] == [
        ("killed", "test_mpm: Grid.A"),
        ("changes nothing", "Nobody reads it."),
        ("survives", ""),
        ("not run", ""),
    ]
    assert {(r["seed"], r["file"], r["line"], r["change"]) for r in planted} == {("3", "mpm/a.cpp", "7", "`a || b` becomes `a && b` in `if (a || b) return;`")}


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
    assert f"{name}.json: holds no figures of tests" in error and not (tmp_path / "data").exists()


def test_a_table_that_was_changed_by_hand(write, tmp_path):
    """It is told, and nothing is written."""
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "reliability_tests.csv").write_text("a,b\n1,2\n")
    status, error, page = write(test_file=[figure("a", 1.0, 2.0)])
    assert status == 1 and page == PAGE and "reliability_tests.csv: holds no figures of tests" in error


def test_nothing_measured_or_nowhere_to_write(write, tmp_path):
    status, error, page = write()
    assert status == 1 and page == PAGE
    assert error == f"reliability.py: no figures in {tmp_path / 'figures'}; run `make test`, `make stress`, `make fuzz` or `make mutants`\n"
    status, error, page = write("no marks\n", test_file=[figure("a", 1.0, 2.0)])
    assert status == 1 and "'<!-- table: begin -->'" in error and page == "no marks\n" and not (tmp_path / "data").exists()


# ------------------------------------------------------------------------------------------ the tables of this repository


def measuring_tests():
    """File and name of each test that takes `figures`, with its description as conftest.py has it. Files that only note figures have no limits."""
    for path in sorted((ROOT / "tests").glob("*/test_*.py")):
        text = path.read_text()
        for node in ast.parse(text).body if "figures.below(" in text else ():
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_") and "figures" in [a.arg for a in node.args.args]:
                doc = (ast.get_docstring(node) or "").split("\n\n")[0]
                yield (path.stem, node.name), " ".join(doc.split()) or reliability.plain(node.name)


def test_rows_tell_of_the_tests_that_there_are():
    """Each row has the words of its test, and each file with tests that measure has a row."""
    there = dict(measuring_tests())
    table = reliability.read_table(ROOT / "doc" / "data" / "reliability_tests.csv")
    stale = [(r["file"], r["test"]) for r in table if there.get((r["file"], r["test"])) != r["what"]]
    assert not stale, f"other tests now: run them by ctest, then `make tables`: {stale}"
    missing = {file for file, _ in there} - {r["file"] for r in table}
    assert not missing, f"not measured yet: run them by ctest, then `make tables`: {missing}"
    assert len(table) > 180


def test_the_page_has_the_sums_of_its_tables():
    page = (ROOT / "doc" / "reliability.md").read_text()
    table, planted = (reliability.read_table(ROOT / "doc" / "data" / f"reliability_{name}.csv") for name in ("tests", "mutants"))
    for mark, text in (("table", reliability.sum_of_tests(table)), ("mutants", reliability.sum_of_mutants(planted))):
        assert page == reliability.replace(page, mark, text, "doc/reliability.md"), f"{mark}: run `make tables`"
    missing = [words for words, file, test in reliability.PROMISES if (file, test) not in {(r["file"], r["test"]) for r in table}]
    assert not missing, f"promises without a test: {missing}"
