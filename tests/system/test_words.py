# SPDX-License-Identifier: GPL-2.0-or-later
"""Code, messages and pages speak the terms of doc/glossary.md. What stands here is wrong wherever it is read; ordinary words that have one
meaning in the glossary are not looked for."""
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
READ = (".h", ".cpp", ".py", ".md", ".txt", ".sh", ".patch")
# History and the list of what not to say.
LEFT_OUT = {"CHANGELOG.md", "doc/glossary.md", "tests/system/test_words.py"}

# Phrase, and the term of the glossary.
WRONG = {
    r"\blet(?:s|ting)?[ _]go\b": "debonds, debonded",
    r"\bheirs?\b": "mass receiver",
    r"\btents?\b": "hat functions",
    r"\bcrumbs?\b": "fragment",
    r"\bslivers?\b": "fragment",
    r"\brub(?:s|bing)?\b": "friction, frictional",
    r"(?<!`)\brubbed\b(?!`)": "frictional dissipation",
    r"\bbooked\b|\benergy[ _]?books\b|\bthe books\b": "energy balance, counted",
    r"\bg(?:ive|ives|iving|ave)[ _]way\b": "fails",
    r"\bt(?:ake|akes|aking|aken|ook)[ _]up\b": "what is done: reads, registers, starts from",
    r"\bfreed[ _]places?\b": "contact point",
    r"\bskins?\b": "residue",
    r"\bcrevices?\b": "unbonded gap",
    r"\bnext to nothing\b": "almost nothing",
    r"\bat a blow\b": "at once",
    r"\bgrain[ _]?sides?\b|\bGrainSides?\b": "end of a bond",
    r"\bto the bit\b": "bitwise identical",
    r"\blooked[ _]at\b": "checked, examined",
    r"\bslaves?\b": "constrained node",
    r"\bwoken\b": "activated",
    r"\bbricks?\b": "subdomain",
    r"\bdebris\b": "fragment",
    r"\bsheets?\b": "sides of an unbonded gap",
    r"\bborrow(?:s|ed)?\b": "alias",
}

# Columns, keys and variables that scripts use keep their names.
KEPT = {
    "doc/specimen.md": {"rub"},
    "src/USER-MPDEM/styles/atoms/cement_contacts.cpp": {"skin"},  # a member of LIGGGHTS
    "tests/system/test_specimen_driver.py": {"rub", "rubbed"},
    "tools/mpdem/specimen.py": {"rubbed"},
    "tools/mpdem/specimen_figures.py": {"rubbed"},
    "tools/mpdem/table.py": {"let_go"},
    "tools/mpdem/units.py": {"let_go", "rubbed"},
}


def files():
    names = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    return [name for name in names if name.endswith(READ) and name not in LEFT_OUT and (ROOT / name).is_file()]


def wrong_words(text):
    """Number of the line, what is wrong, and what to say."""
    return [
        (number, found[0], instead)
        for number, line in enumerate(text.splitlines(), 1)
        for wrong, instead in WRONG.items()
        for found in re.finditer(wrong, line, re.I)
    ]


def test_the_words_are_those_of_the_glossary():
    names = files()
    assert len(names) > 300
    found = [
        f"{name}:{number}: '{what}'; {instead}"
        for name in names
        for number, what, instead in wrong_words((ROOT / name).read_text())
        if what not in KEPT.get(name, ())
    ]
    assert not found, f"{len(found)} in all\n" + "\n".join(found[:60])


@pytest.mark.parametrize(
    "text", ["// A link lets go.", "int let_go(int n);", "  give_to(heirs);", "the energy is booked", "std::vector<GrainSide> ends;", "to the bit"]
)
def test_a_wrong_word_is_found(text):
    assert len(wrong_words(text)) == 1


@pytest.mark.parametrize(
    "text", ["// The link debonds.", "the outlet goes", "their", "content", "handbook", "| `rubbed` | energy of friction |", "to the bitwise"]
)
def test_others_are_not(text):
    assert not wrong_words(text)


def test_the_glossary_names_each_term_once():
    rows = re.findall(r"^\| ([^|]+?) \|", (ROOT / "doc" / "glossary.md").read_text(), re.M)
    terms = [row for row in rows if row not in ("term", "---")]
    assert len(terms) > 60
    assert not {term for term in terms if terms.count(term) > 1}
