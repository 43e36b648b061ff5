# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages say of each keyword, value, default and pair of options what the program declares with `-options`."""
import re
import subprocess
from pathlib import Path

import pytest
from scenes import executable, hosted

DOC = Path(__file__).resolve().parents[2] / "doc"
PAGES = {"fix mpm": "fix_mpm.md", "fix mpm/couple": "fix_mpm_couple.md"}


def declared():
    """[(command, keyword, values, default)] and [(options, options that do not go with them, why)]."""
    if not hosted():
        pytest.skip("LIGGGHTS' own driver does not have -options")
    lines = [line.split("\t") for line in subprocess.run([executable(), "-options"], capture_output=True, text=True, check=True).stdout.splitlines()]
    return [tuple(line) for line in lines if line[0] != "excludes"], [tuple(line[1:]) for line in lines if line[0] == "excludes"]


def plain(text):
    return text.replace("`", "").strip()


def rows(page, head):
    """Rows of the first table below a head, without its own head; a cell that is left out is that of the row above."""
    text = (DOC / page).read_text().split(f"\n## {head}\n", 1)[1]
    table = re.search(r"^\|.*\n\|[-|]+\n((?:\|.*\n)+)", text, re.M)[1]
    found = []
    for line in table.splitlines():
        cells = [c.strip() for c in line.strip("|").split("|")]
        found.append([cells[0] or found[-1][0], *cells[1:]])
    return found


def first_words(values):
    """First word of each value of a list `a X, b Y or c`."""
    return [value.split()[0] for value in re.split(r", then |, | or ", values)]


@pytest.mark.parametrize("command", PAGES)
def test_keywords_of_a_page(command):
    keywords = [k for k in declared()[0] if k[0] == command]
    assert len(keywords) > 7
    page = {}
    for keyword, value, *_ in rows(PAGES[command], "Syntax"):
        page.setdefault(plain(keyword), []).append(plain(value))
    assert sorted(page) == sorted(name for _, name, _, _ in keywords)
    for _, name, values, _ in keywords:
        words = " or ".join(re.sub(r"\[.*?\]", "", v) for v in page[name]) if name in ("damage", "interface") else " or ".join(page[name])
        assert first_words(words) == first_words(values), name
        assert name in ("damage", "interface") or set(re.findall(r"\w+", words)) == set(re.findall(r"\w+", values)), name


@pytest.mark.parametrize("command", PAGES)
def test_defaults_of_a_page(command):
    page = {plain(keyword): plain(default) for keyword, default in rows(PAGES[command], "Default")}
    for _, name, _, initial in (k for k in declared()[0] if k[0] == command):
        assert (name in page) == bool(initial), name
        assert not initial or re.match(rf"{re.escape(initial)}(?![\w.])", page[name]), (name, initial, page[name])


def test_pairs_of_the_page():
    """The table of options that do not go together is that of the program, row by row."""
    page = [tuple(plain(cell) for cell in row) for row in rows("fix_mpm.md", "Restrictions")]
    assert page == [(a.replace(" | ", ", "), b.replace(" | ", ", "), why) for a, b, why in declared()[1]]
