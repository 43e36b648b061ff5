# SPDX-License-Identifier: GPL-2.0-or-later
"""The tutorials of doc/tutorial_*.md: their commands run one after the other, and print what the pages show.

A page has blocks `sh-tutorial` with commands. Each block `text` after one has lines of what it prints, in their order: words as they stand, numbers
within 3 %, or within 1 % of the largest number in the same place of the block, whole numbers first in a line exactly. `...` ends a line that goes on.
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from scenes import PATIENCE, executable

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "doc").glob("tutorial_*.md"))
BLOCKS = re.compile(r"^```(sh-tutorial|text)\n(.*?)^```", re.M | re.S)
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.]*\w)")
MOST = 120_000  # bytes of a picture


def name_of(page):
    return page.stem


def split(line):
    """Words of a line without its numbers, and the numbers."""
    return " ".join(NUMBER.sub("#", line).split()), [float(n) for n in NUMBER.findall(line)]


def matches(shown, said, scale):
    """Whether a line of the output is that of the page. scale: the largest numbers of such lines of the page, by place."""
    words, numbers = split(shown.removesuffix("..."))
    theirs, values = split(said)
    if shown.endswith("..."):
        theirs, values = theirs[: len(words)], values[: len(numbers)]
    if words != theirs or len(numbers) != len(values):
        return False
    for i, (a, b) in enumerate(zip(numbers, values)):
        exact = i == 0 and shown.lstrip()[:1].isdigit() and a == int(a)
        if exact and a != b or not exact and abs(a - b) > max(0.03 * max(abs(a), abs(b)), 0.01 * scale[words][i]):
            return False
    return True


def not_said(shown, said):
    """Lines of a page that the output does not have, in their order."""
    scale = {}
    for line in shown:
        words, numbers = split(line.removesuffix("..."))
        largest = scale.setdefault(words, [0.0] * len(numbers))
        scale[words] = [max(a, abs(b)) for a, b in zip(largest, numbers)]
    at, lacking = 0, []
    for line in shown:
        found = next((i for i in range(at, len(said)) if matches(line, said[i], scale)), None)
        if found is None:
            lacking.append(line)
        else:
            at = found + 1
    return lacking


def environment(root):
    """What doc/tutorials.md has a reader set."""
    found = {**os.environ, "PYTHONPATH": str(root / "tools"), "PYTHONDONTWRITEBYTECODE": "1"}
    found["PATH"] = os.pathsep.join([str(root / "build"), str(root / "tools"), os.environ["PATH"]])
    return found


def blocks(page):
    """Commands, and all lines of their output that are shown."""
    found = []
    for kind, text in BLOCKS.findall(page.read_text()):
        if kind == "sh-tutorial":
            found.append((text, []))
        elif found:
            found[-1][1].extend(line for line in text.splitlines() if line.strip())
    return found


def follow(page, root):
    """Runs the commands of a page. Returns for each block what is shown and what was printed."""
    here, results = root, []
    for commands, shown in blocks(page):
        done = subprocess.run(["sh", "-euc", commands], cwd=here, env=environment(root), capture_output=True, text=True, timeout=400 * PATIENCE)
        assert done.returncode == 0, f"{commands}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        for folder in re.findall(r"^cd (\S+)$", commands, re.M):
            here = here / folder
        results.append((shown, done.stdout.splitlines()))
    return results


@pytest.fixture
def repository(tmp_path):
    for name in ("examples", "tools", "src"):
        shutil.copytree(ROOT / name, tmp_path / name)
    (tmp_path / "build").mkdir()
    (tmp_path / "build/liggghts-mpdem").symlink_to(executable())
    return tmp_path


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_tutorial(page, repository):
    """All commands of the page run, and each line that it shows is printed, numbers within 3 %. Its picture is made, and is small."""
    results = follow(page, repository)
    lacking = [line for shown, said in results for line in not_said(shown, said)]
    assert not lacking and sum(len(shown) for shown, _ in results) >= 3, lacking
    (picture,) = re.findall(r"^!\[[^]]+\]\(data/(\w+\.png)\)$", page.read_text(), re.M)
    (made,) = repository.glob(f"examples/tutorials/*/{picture}")
    assert 5000 < made.stat().st_size < MOST and 5000 < (ROOT / "doc/data" / picture).stat().st_size < MOST


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_form_of_a_page(page):
    """A tutorial has 300 to 700 words, a folder with its number, and a row in the list."""
    text = page.read_text()
    words = len(re.sub(r"^```.*?^```", "", text, flags=re.M | re.S).split())
    assert 300 <= words <= 700, words
    number = page.stem.split("_")[1]
    (folder,) = (ROOT / "examples/tutorials").glob(f"{number}_*")
    assert f"cd examples/tutorials/{folder.name}\n" in text
    assert re.search(rf"^\| {int(number)} \| \[[^]]+\]\({page.name}\) \|", (ROOT / "doc/tutorials.md").read_text(), re.M)


def test_all_folders_have_a_page():
    assert [p.name.split("_")[0] for p in sorted((ROOT / "examples/tutorials").iterdir())] == [p.stem.split("_")[1] for p in PAGES]


@pytest.mark.parametrize(
    "shown, said, lacking",
    [
        (["peak 100 N"], ["begin", "peak 102 N"], 0),
        (["peak 100 N"], ["peak 110 N"], 1),
        (["100 1.5 0.001", "200 3.0 0.1"], ["100 1.51 0.0015", "200 3.0 0.1"], 0),
        (["100 1.5"], ["101 1.5"], 1),
        (["bond 1: debonding, ..."], ["bond 1: debonding, 30 points"], 0),
        (["bond 1: internal, ..."], ["bond 1: debonding, 30 points"], 1),
        (["a 1", "b 2"], ["b 2", "a 1"], 1),
    ],
)
def test_a_difference_is_found(shown, said, lacking):
    assert len(not_said(shown, said)) == lacking


# ------------------------------------------------------------------------------------- the law of tutorial 9


def test_law_is_the_one_that_is_built():
    """tools/check_changes.py builds LIGGGHTS with the file of the tutorial, and tests it; the lines that the page shows are of this file."""
    law = (ROOT / "examples/tutorials/09_own_law/linear_damage.h").read_text()
    patch = (ROOT / "tests/changes/damage_linear.patch").read_text()
    (part,) = re.findall(r"^\+\+\+ b/src/USER-MPDEM/material/linear_damage.h\n@@.*\n((?:\+.*\n)+)", patch, re.M)
    assert "".join(line[1:] + "\n" for line in part.splitlines()) == law
    page = (ROOT / "doc/tutorial_09_own_law.md").read_text()
    lines = [line for block in re.findall(r"^```text\n(.*?)^```", page, re.M | re.S) for line in block.splitlines() if line.startswith("  ")]
    assert len(lines) > 5 and not [line for line in lines if line not in law.splitlines()]


def test_registration_fits(repository):
    """register.patch fits the present list of laws, and is what the patch of tests/changes does to it."""
    patch = ROOT / "examples/tutorials/09_own_law/register.patch"
    done = subprocess.run(["git", "apply", "--check", patch], cwd=repository, env={**os.environ, "GIT_CEILING_DIRECTORIES": str(repository.parent)})
    changed = re.findall(r"^[+-][^+-].*$", patch.read_text(), re.M)
    assert done.returncode == 0 and len(changed) == 3 and all(f"\n{line}\n" in (ROOT / "tests/changes/damage_linear.patch").read_text() for line in changed)


if __name__ == "__main__":  # shows what the commands of a page print
    for block in follow(Path(sys.argv[1]), Path(sys.argv[2])):
        print("\n".join(block[1]))
