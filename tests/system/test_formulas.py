# SPDX-License-Identifier: GPL-2.0-or-later
"""Formulas of the pages are such that GitHub, MathJax and LaTeX set them alike: $...$ in a line, $$ on lines of their own."""
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")] + sorted((ROOT / "doc").glob("*.md"))
# Commands that all three know, and that are in use. GitHub's Markdown eats the backslash of \, \; \! \{ and \}.
COMMANDS = set(
    r"""Big Delta Gamma Lambda Omega Phi Pi Psi Sigma Theta alpha arcsin bar begin beta cdot chi cos delta dot dots end eta exp frac gamma ge hat int iota
    kappa lambda langle le left leftarrow ln log lvert mathbf mathrm max min mu nabla nu omega otimes partial phi pi psi qquad quad rangle rho right
    rvert sigma sin sqrt sum tan tau theta times varepsilon varphi vartheta xi zeta""".split()
)
CODE = re.compile(r"^( *)```.*?^\1```|`[^`\n]*`", re.M | re.S)
BLOCK = re.compile(r"^\$\$\n(.*?)\n\$\$$", re.M | re.S)
INLINE = re.compile(r"\$([^$]*)\$")


def faults(text):
    """What is wrong with the formulas of a page, and how many there are."""
    text = CODE.sub("", text)
    blocks = BLOCK.findall(text)
    rest = BLOCK.sub("", text)
    found = ["a $$ that is not alone on its line"] if "$$" in rest else []
    lines = []
    for paragraph in re.split(r"\n\s*\n|\n(?=[|*#])", rest):
        if paragraph.count("$") % 2:
            found.append(f"a $ without another: {paragraph[:60]}")
        lines += INLINE.findall(paragraph)
        for m in INLINE.finditer(paragraph):
            if re.match(r"\w", paragraph[m.start() - 1 : m.start()]) or re.match(r"\w", paragraph[m.end() : m.end() + 1]):
                found.append(f"a letter beside a $: {m[0]}")
    for formula in blocks + lines:
        said = " ".join(formula.split())[:60]
        unknown = set(re.findall(r"\\([A-Za-z]+|[^\w\s\\])", formula)) - COMMANDS
        if unknown:
            found.append(f"commands {sorted(unknown)}: {said}")
        for opened, closed in ((r"(?<!\\)\{", r"(?<!\\)\}"), (r"\\left\b", r"\\right\b"), (r"\\begin\b", r"\\end\b")):
            if len(re.findall(opened, formula)) != len(re.findall(closed, formula)):
                found.append(f"'{opened}' is not closed: {said}")
        if re.search(r"^\s*([-+*=>]|\d+\.)\s|^\s*$", formula, re.M) and formula in blocks:
            found.append(f"a line that Markdown takes for a list: {said}")
        if "](" in formula or "|" in formula or re.search(r"<\S|\S<", formula):
            found.append(f"'](', '|', or '<' without spaces, which are Markdown: {said}")
        if formula in lines and (formula != formula.strip() or not formula):
            found.append(f"space beside a $: {said}")
    return found, len(blocks) + len(lines)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_formulas_can_be_set(page):
    found, _ = faults(page.read_text())
    assert not found


def test_there_are_formulas():
    counts = {page.name: faults(page.read_text())[1] for page in PAGES}
    assert counts["theory.md"] > 900 and sum(count > 0 for count in counts.values()) > 12, counts


@pytest.mark.parametrize(
    "text",
    [
        "with $a",
        "a$b$ c",
        "$a$b",
        "of $ a$",
        "$a | b$",
        r"$\foo a$",
        r"$a\, b$",
        r"$\frac{a}{b$",
        "text $$\na\n$$",
        "$$\na\n+ b\n$$",
        r"$[a](b)$",
        "$a <b$",
        "$$\n\\left( a\n$$",
    ],
)
def test_a_fault_is_found(text):
    assert faults(text)[0]


@pytest.mark.parametrize("text", ["`$x` and $v$", "$$\na &= b \\\\\n&\\quad + c\n$$", "($a$, $b$)-plane"])
def test_others_are_not(text):
    assert not faults(text)[0]


PLAIN = re.compile(r"sqrt\(|\b\w+\^\(?-?\d|\b(?:eps|sigma|kappa0?|lambda|theta|phi|zeta)\b *[=/*^]")
# Columns, words of a script and figures of other programs; the formula of create_cement is read by test_page_claims.py.
LEFT = {"create_cement.md", "howto_examples.md", "README.md"}


def test_no_formula_is_plain_text():
    found = []
    for page in PAGES:
        text = INLINE.sub("", BLOCK.sub("", CODE.sub("", page.read_text())))
        if page.name not in LEFT:
            found += [f"{page.name}: {line.strip()[:90]}" for line in text.splitlines() if PLAIN.search(line)]
    assert not found
