# SPDX-License-Identifier: GPL-2.0-or-later
"""What README and doc/ show is run: whole scripts as they stand, lines in a small scene."""
import re
from pathlib import Path

import pytest

from scenes import RING, pair, run

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md"] + sorted((ROOT / "doc").glob("*.md"))
SECTIONS = ["Syntax", "Examples", "Description", "Restart", "Restrictions", "Related commands", "Default"]


def blocks(kind):
    for page in PAGES:
        for text in re.findall(rf"^```{kind}\n(.*?)^```", page.read_text(), re.M | re.S):
            yield page, text


SCRIPTS = [pytest.param(text, id=page.stem) for page, text in blocks("liggghts")]
LINES = [pytest.param(line, id=f"{page.stem}:{' '.join(line.split()[:4])[:40]}")
         for page, text in blocks("liggghts-fragment") for line in text.splitlines()]


@pytest.mark.parametrize("script", SCRIPTS)
def test_whole_script(script, tmp_path):
    run(script, tmp_path, ranks=2)


def test_script_that_continues(tmp_path):
    """What README shows for a restart file goes on as the script before it would have."""
    (_, text), = blocks("liggghts-restart")
    first = next(t for page, t in blocks("liggghts") if page.name == "README.md")
    run(first + "write_restart half.restart\n", tmp_path)
    continued = run(text, tmp_path, name="in.continued")
    whole = run(re.sub(r"^run .*$", "run 1000", first, flags=re.M), tmp_path / "whole")
    rows = [re.findall(r"^ +(?:800|900|1000) .*$", r.output, re.M) for r in (continued, whole)]
    assert len(rows[0]) == 3 and rows[0] == rows[1], rows


@pytest.mark.parametrize("line", LINES)
def test_line(line, tmp_path):
    command = line.split()[0]
    scene = pair(1e-4, cement=RING)
    cement = "fix cem calcite mpm cell 2e-4 elastic isotropic 60e9 0.25"
    couple = "fix bond grains mpm/couple cem"
    if command == "atom_style":
        scene = re.sub(r"^atom_style .*$", line, scene, flags=re.M)
    elif command == "create_cement":
        scene = re.sub(r"^create_cement .*$", line, scene, flags=re.M)
    elif " mpm " in line and command == "fix":
        cement = line
    elif " mpm/couple " in line:
        couple = line
    script = f"{scene}timestep 5e-9\n{cement}\n{couple}\n"
    if " check/timestep/mpm " in line:
        script += line + "\n"
    if command == "compute":
        name = line.split()[1]
        script += f"{line}\ndump d calcite custom 1 points.txt id c_{name}\n"
    script += "fix move grains nve/sphere\nrun 2\n"
    run(script, tmp_path)


@pytest.mark.parametrize("page", [p for p in PAGES if p.parent.name == "doc" and "## Syntax" in p.read_text()],
                         ids=lambda p: p.stem)
def test_order_of_a_page(page):
    heads = re.findall(r"^## (.*)$", page.read_text(), re.M)
    order = [next((i for i, s in enumerate(SECTIONS) if h.startswith(s) or (s == "Restart" and h == "Output")), -1)
             for h in heads]
    assert -1 not in order and order == sorted(order) and len(set(order)) == len(SECTIONS), heads


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
        assert (page.parent / target).exists(), f"{page.name}: {target}"
