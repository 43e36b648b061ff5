# SPDX-License-Identifier: GPL-2.0-or-later
"""What helps those who report or change something: `make help`, the forms of issues, the targets and tests that CONTRIBUTING.md names."""
import re
import subprocess
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
MAKEFILE = (ROOT / "Makefile").read_text()
PAGE = (ROOT / "CONTRIBUTING.md").read_text()
TARGETS = re.search(r"^\.PHONY: (.*)$", MAKEFILE, re.M)[1].split()
FORMS = sorted(path for path in (ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml") if path.name != "config.yml")


def test_help_has_a_line_for_each_target():
    # Below another make, as in `make test`, make also names its directory.
    said = subprocess.run(["make", "--no-print-directory", "help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    lines = dict(re.fullmatch(r"  make ([a-z-]+) +(\S.{5,})", line).groups() for line in said)
    assert set(lines) == set(TARGETS)
    assert all(len(line) <= 130 and "$" not in line for line in said), said


def test_every_target_is_phony():
    """A target that is no file must not depend on whether there is one of its name."""
    rules = set(re.findall(r"^([a-z][a-z-]*)(?= ?[a-z-]* ?:(?!=))", MAKEFILE, re.M))
    assert rules <= set(TARGETS), rules - set(TARGETS)


@pytest.mark.parametrize("form", FORMS, ids=lambda path: path.stem)
def test_form_of_an_issue(form):
    """As GitHub asks for: a name, a description, and questions with an identifier and a label."""
    data = yaml.safe_load(form.read_text())
    assert set(data) == {"name", "description", "body"} and data["name"] and data["description"]
    questions = [part for part in data["body"] if part["type"] != "markdown"]
    assert questions and all(part["type"] in ("input", "textarea") and part["attributes"]["label"] for part in questions)
    assert len({part["id"] for part in questions}) == len(questions)
    for name in re.findall(r"doc/[\w.]+", form.read_text()):
        assert (ROOT / name.rstrip(".")).is_file(), name


def test_defects_are_asked_for_what_the_page_asks():
    assert len(FORMS) == 3
    labels = " ".join(part["attributes"].get("label", "") for part in yaml.safe_load((ROOT / ".github/ISSUE_TEMPLATE/defect.yml").read_text())["body"])
    asked = re.search(r"easiest to act on with:\n\n(.*?)\n\n", PAGE, re.S)[1]
    assert asked.count("* ") == 4
    for words in ("files that it reads", "number of ranks", "log.liggghts", "expected, and why"):
        assert words in labels and words in asked.replace("`", "").replace("\n", " "), words


def test_tests_that_the_page_names_are_there():
    """`ctest -R system.NAME` runs tests/system/test_NAME.py."""
    named = [name for words in re.findall(r"ctest -R '?system\.\(?([\w|]+)", PAGE) for name in words.split("|")]
    made_by_patches = {"linear_damage"}
    assert len(named) > 6
    assert not [name for name in named if not (ROOT / f"tests/system/test_{name}.py").is_file() and name not in made_by_patches]
