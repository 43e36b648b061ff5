# SPDX-License-Identifier: GPL-2.0-or-later
"""What README and doc/ show is run: whole scripts as they stand, lines in a small scene, commands in a copy of the folders.

What is fenced has a word that says what becomes of it:
  liggghts            a whole script                      run
  liggghts-restart    a script that continues README's    run
  liggghts-fragment   lines of a script                   run one by one in a scene
  sh, python          commands                            run
  sh-template         commands that take long or need a place of their own; files, targets, presets and variables
                      that they name must be there
  sh-tutorial         commands of a tutorial, which test_tutorial_pages.py runs
  liggghts-compression  a script that includes cement.in, which test_parameters.py runs
  liggghts-specimen   lines of examples/specimen, which test_specimen.py runs
  liggghts-template   lines with words to be replaced; the command or style must be there
  text                neither: output, folders
Indented blocks are templates under the head Syntax. There are no others. Formulas are $...$ and $$...$$, see test_formulas.py.
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from scenes import PATIENCE, RING, executable, launch, pair, run

ROOT = Path(__file__).parents[2]
DOC = sorted((ROOT / "doc").rglob("*.md"))
TOP = [ROOT / name for name in ("CONTRIBUTING.md", "CHANGELOG.md", "patches/README.md")]
PAGES = [ROOT / "README.md"] + DOC + TOP
KINDS = {
    "liggghts",
    "liggghts-restart",
    "liggghts-fragment",
    "liggghts-specimen",
    "liggghts-compression",
    "liggghts-template",
    "sh",
    "sh-template",
    "sh-tutorial",
    "python",
    "text",
}
FENCED = re.compile(r"^( *)```([^\n]*)\n(.*?)^\1```", re.M | re.S)
SECTIONS = ["Syntax", "Examples", "Description", "Restart", "Restrictions", "Related commands", "Default"]


def name_of(page):
    return str(page.relative_to(ROOT))


def blocks(*kinds):
    for page in PAGES:
        for _, kind, text in FENCED.findall(page.read_text()):
            if kind in kinds:
                yield page, text


def prose(page):
    """Without what is fenced."""
    return FENCED.sub("", page.read_text())


def indented(page):
    """Indented blocks outside of lists, with the head that they stand under."""
    head, before = "", ""
    for line in prose(page).splitlines():
        if line.startswith("#"):
            head = line.lstrip("# ")
        if line.startswith("    ") and not re.match(r"[*0-9]", before):
            yield head, line.strip()
        if line.strip() and not line.startswith(" "):
            before = line


SCRIPTS = [pytest.param(text, id=page.stem) for page, text in blocks("liggghts")]
LINES = [pytest.param(line, id=f"{page.stem}:{' '.join(line.split()[:4])[:40]}") for page, text in blocks("liggghts-fragment") for line in text.splitlines()]


@pytest.mark.parametrize("script", SCRIPTS)
def test_whole_script(script, tmp_path):
    """Files that it writes are there; it takes all of its steps, and what it prints of them is numbers and moves."""
    result = run(script, tmp_path, ranks=2)
    files = set(re.findall(r"\S+\.(?:csv|txt|restart)", script))
    steps = sum(int(n) for n in re.findall(r"^run +(\d+)", script, re.M))
    assert files or steps
    for name in files:
        assert (tmp_path / name).stat().st_size > 100, name
    if steps == 0:
        return
    head = re.findall(r"^ +Step .*$", result.output, re.M)[-1].split()
    rows = re.findall(rf"^ +\d+(?: +\S+){{{len(head) - 1}}} *$", result.output, re.M)
    table = np.array([r.split() for r in rows], dtype=float)
    assert len(table) > 2 and table[-1, 0] == steps and np.isfinite(table).all() and (np.ptp(table, axis=0)[2:] > 0).any()


def rows_of(text):
    """Rows of thermo output of the first script, by step."""
    return {int(r.split()[0]): r for r in re.findall(r"^ +\d+(?: +\S+){6} *$", text, re.M)}


def test_first_script(tmp_path):
    """README's first script pulls the pair apart, under heads that are words, without a warning, and prints what README shows. What
    howto_examples.md shows for a restart file goes on from the middle to the same end."""
    readme = (ROOT / "README.md").read_text()
    first = next(t for page, t in blocks("liggghts") if page.name == "README.md")
    ((_, text),) = blocks("liggghts-restart")
    whole = run(first, tmp_path)
    continued = run(text, tmp_path, name="in.continued")
    rows = []
    for result in (whole, continued):
        (heads,) = set(re.findall(r"^ +Step .*$", result.output, re.M))
        assert heads.split() == ["Step", "Time", "gap_um", "tension", "peak", "failed", "apart"]
        (mode,) = re.findall(r"^fix mpm \(id cem\): bond 1 of grains 1 and 2: (\w+), ", result.output.split("Setting up run")[-1], re.M)
        assert mode == "debonding" and f"bond 1 of grains 1 and 2: {mode}, " in readme
        assert "WARNING" not in result.output
        rows.append(rows_of(result.output))
    assert list(rows[0]) == list(range(0, 1100, 100)) and list(rows[1]) == list(range(400, 1100, 100))
    assert all(rows[0][step] == row for step, row in rows[1].items()), rows
    table, shown = (np.array([[float(w) for w in r.split()] for r in found.values()]) for found in (rows[0], rows_of(readme)))
    tension, peak, apart = table[:, 3], table[:, 4], table[:, 6]
    assert tension[4] > 0.99 * peak[-1] > 150 and abs(tension[-1]) < 0.02 * peak[-1]
    assert apart[4] == 0 and apart[-1] == 1, "the restart file is to be written before the bond is separated"
    assert shown[:5, 1:4] == pytest.approx(table[:5, 1:4], rel=1e-3) and shown[:, 4] == pytest.approx(peak, rel=1e-3)
    assert (shown[:, [0, 6]] == table[:, [0, 6]]).all()


def test_first_script_is_converged(tmp_path):
    """Two thirds of cell and spacing change the peak of README's first script by less than 3 %, by what README says."""
    first = next(t for page, t in blocks("liggghts") if page.name == "README.md")
    first = first[: first.index("run          400")] + "run 500\n"  # past the peak
    finer = first
    for old, new in (("spacing 1e-4", "spacing 6.66666667e-5"), ("cell 2e-4", "cell 1.33333333e-4"), ("run 500", "run 750")):
        assert finer.count(old) == 1
        finer = finer.replace(old, new)
    coarse, fine = (
        float(list(rows_of(run(script, tmp_path / name).output).values())[-1].split()[4]) for name, script in (("as it is", first), ("finer", finer))
    )
    said = re.findall(r"^\| above.*\| ([\d.]+) \| (?:([+-][\d.]+) %)? ?\|$", (ROOT / "README.md").read_text(), re.M)
    assert abs(fine / coarse - 1) < 0.03
    assert [float(n) for n, _ in said] == pytest.approx([coarse, fine], rel=1e-3) and float(said[1][1]) == pytest.approx(100 * (fine / coarse - 1), abs=0.1)


def test_lines_of_the_specimen():
    """What doc/howto_pictures.md shows stands so in the script that tests/system/test_specimen.py runs."""
    scripts = " ".join(" ".join((ROOT / "examples" / "specimen" / name).read_text().split()) for name in ("pictures.in", "in.load", "compression.in"))
    shown = [" ".join(line.split()) for _, text in blocks("liggghts-specimen") for line in text.splitlines()]
    assert len(shown) == 9 and all(line in scripts for line in shown), [line for line in shown if line not in scripts]


@pytest.mark.parametrize("line", LINES)
def test_line(line, tmp_path):
    command = line.split()[0]
    scene = pair(1e-4, cement=RING)
    if command in ("atom_modify", "communicate", "neigh_modify"):
        scene = re.sub(rf"^{' +'.join(map(re.escape, line.split()))}.*$", line, scene, count=1, flags=re.M)
        assert line in scene
    cement = "fix cem calcite mpm cell 2e-4 elastic isotropic 60e9 0.25"
    couple = "fix bond grains mpm/couple cem"
    if command == "atom_style":
        scene = re.sub(r"^atom_style .*$", line, scene, flags=re.M)
    elif command == "create_cement":
        scene = re.sub(r"^create_cement .*$", line, scene, flags=re.M)
        if "points later" in line:
            cement += " condense yes"
    elif " mpm " in line and command == "fix":
        cement = line
    elif " mpm/couple " in line:
        couple = line
    script = f"{scene}timestep 5e-9\n{cement}\n{couple}\n"
    if " check/timestep/mpm " in line:
        script += line + "\n"
    if command == "compute":
        name = line.split()[1]
        used = "".join(f"variable {v} equal 1e-6\n" for v in re.findall(r"\bv_(\w+)", line))
        column = "[1]" if " mpm/stress" in line else ""
        script += f"{used}{line}\ndump d calcite custom 1 points.txt id c_{name}{column}\n"
    script += "fix move grains nve/sphere\nrun 2\n"
    run(script, tmp_path)


@pytest.mark.parametrize("page", [p for p in DOC if "## Syntax" in p.read_text()], ids=lambda p: p.stem)
def test_order_of_a_page(page):
    heads = re.findall(r"^## (.*)$", page.read_text(), re.M)
    order = [next((i for i, s in enumerate(SECTIONS) if h.startswith(s) or (s == "Restart" and h == "Output")), -1) for h in heads]
    assert -1 not in order and order == sorted(order) and len(set(order)) == len(SECTIONS), heads


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_blocks_say_what_they_are(page):
    kinds = {kind for _, kind, _ in FENCED.findall(page.read_text())}
    assert kinds <= KINDS and page.read_text().count("```") == 2 * len(FENCED.findall(page.read_text())), kinds
    assert not [(head, line) for head, line in indented(page) if head != "Syntax"]


def uneven_rows(text):
    """Rows of tables with other numbers of cells than the head; a | in a cell has a backslash, also in code."""
    wrong, cells = [], 0
    for line in text.splitlines():
        count = len(re.findall(r"(?<!\\)\|", line)) if line.startswith("|") else 0
        if count and cells and count != cells:
            wrong.append(line)
        cells = cells or count if count else 0
    return wrong


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_rows_have_the_cells_of_their_table(page):
    assert not uneven_rows(prose(page))


def test_an_uneven_row_is_found():
    assert uneven_rows("| a | b |\n|---|---|\n| `x|y` | 1 |\n") and not uneven_rows("| a | b |\n|---|---|\n| `x\\|y` | 1 |\n\n| a |\n|---|\n")


# --------------------------------------------------------------------------------------------------- commands


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """What commands of the documentation find: the folders of the repository, and build/liggghts-mpdem."""
    root = tmp_path_factory.mktemp("repository")
    for name in ("examples", "tools", "doc"):
        shutil.copytree(ROOT / name, root / name)
    (root / "build").mkdir()
    (root / "build/liggghts-mpdem").symlink_to(executable())
    return root


@pytest.mark.parametrize("command", [pytest.param(text, id=f"{page.stem}:{text.split()[0]}") for page, text in blocks("sh")])
def test_command(command, folders):
    done = subprocess.run(["sh", "-euc", command], cwd=folders, capture_output=True, text=True, timeout=120 * PATIENCE)
    assert done.returncode == 0 and "ERROR" not in done.stdout, done.stdout[-2000:] + done.stderr[-2000:]


@pytest.mark.parametrize("page,script", [pytest.param(page, text, id=page.stem) for page, text in blocks("python")])
def test_python(page, script, folders):
    """Scripts find the package mpdem, and what the commands of their page left."""
    environment = {**os.environ, "PYTHONPATH": "tools", "MPLBACKEND": "Agg", "PYTHONDONTWRITEBYTECODE": "1"}
    before = "".join(text for of, text in blocks("sh") if of == page)
    for command in (["sh", "-euc", before], [sys.executable, "-c", script]):
        done = subprocess.run(command, cwd=folders, capture_output=True, text=True, timeout=120 * PATIENCE, env=environment)
        assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.parametrize("page,text", [pytest.param(page, text, id=f"{page.stem}:{' '.join(text.split()[:5])[:40]}") for page, text in blocks("sh-template")])
def test_template_names_what_there_is(page, text):
    """Of commands that are not run here: their files, targets, presets, options of the tools and variables of the scripts."""
    makefile = (ROOT / "Makefile").read_text()
    here = ROOT
    for line in text.splitlines():
        words = re.sub(r"\s#.*", "", line).replace("PACKAGE/", "").split()
        if words[0] == "cd":
            here = here / words[1]
        if not here.is_dir():
            break  # inside of LIGGGHTS' source
        if words[0] == "make":
            for target in (w for w in words[1:] if "=" not in w):
                assert re.search(rf"^{re.escape(target)}:", makefile, re.M), target
        for before, word in zip([""] + words, words):
            word = word.strip(";'\"")
            if before == "--preset":
                assert f'"name": "{word}"' in (ROOT / "CMakePresets.json").read_text(), word
            if re.match(r"(examples|tools|tests|doc|src|patches|bench)/", word):
                assert list(ROOT.glob(word)), word
            if before == "-in":
                script = here / word
                assert script.exists(), word
                for variable in re.findall(r"-var (\w+)", line):
                    assert re.search(rf"^variable +{variable} +index", script.read_text(), re.M), variable
            if re.match(r"--[a-z]", word) and words[0].endswith(".py"):
                options = (ROOT / words[0] if "/" in words[0] else ROOT / "tools" / words[0]).read_text()
                if "runner.add_arguments" in options:
                    options += (ROOT / "tools" / "mpdem" / "runner.py").read_text()
                assert f'"{word.split("=")[0]}"' in options, word


@pytest.mark.parametrize("page", [p for p in DOC if "## Syntax" in p.read_text()], ids=name_of)
def test_syntax_names_a_style(page, tmp_path):
    """A line under Syntax begins as a command or style that the program knows, and as the head of the page says."""
    lines = [line for head, line in indented(page) if head == "Syntax"]
    title = page.read_text().split("\n", 1)[0].lstrip("# ").split()
    styles = launch("", tmp_path, arguments=["-h"]).output.replace(",", " ").split()
    for line in lines:
        words = line.split()
        assert words[0] == title[0] and (len(title) == 1 or title[1] in words + ["command"]), line
        style = title[1] if len(title) > 1 and title[1] != "command" else title[0]
        assert style in styles, style


# ------------------------------------------------------------------------------------------------------ links


def anchors(page):
    """What GitHub makes of the heads of a page, and its own."""
    text = prose(page)
    found = set(re.findall(r'<a id="([^"]+)">', text))
    for head in re.findall(r"^#+ (.*)$", text, re.M):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)|`", lambda m: m[1] or "", head)
        found.add(re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-"))
    return found


def links(page):
    return re.findall(r"\]\(([^)\s]+)\)", prose(page))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    for link in links(page):
        if re.match(r"[a-z]+:", link):
            continue
        file, _, anchor = link.partition("#")
        target = page if not file else page.parent / file
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


def test_index_has_every_page():
    index = ROOT / "doc/index.md"
    linked = {(index.parent / link.partition("#")[0]).resolve() for link in links(index)}
    missing = [name_of(p) for p in PAGES if p.resolve() not in linked | {index.resolve()}]
    assert not missing, missing
    assert index.resolve() in {(ROOT / link).resolve() for link in links(ROOT / "README.md")}


@pytest.mark.parametrize("page", DOC + [ROOT / "README.md"], ids=name_of)
def test_page_leads_to_the_bibliography(page):
    assert page.name == "bibliography.md" or any("bibliography.md" in link for link in links(page))


def sources():
    for folder in ("src", "bench", "tests"):
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix in (".h", ".cpp") or file.parent.name == "verification":
                yield file


def test_bibliography_has_every_source():
    """Authors that the pages and the comments of the source name have an entry."""
    heads = " ".join(re.findall(r'^<a id="[^"]*"></a>\*\*(.*?)\*\*', (ROOT / "doc/bibliography.md").read_text(), re.M))
    known = set(re.findall(r"\w+", heads.replace("ö", "oe").replace("ž", "z")))
    missing = []
    for file in list(sources()) + PAGES:
        if file.suffix not in (".md", ".h", ".cpp", ".py") or file.name == "bibliography.md":
            continue
        text = re.sub(r"\n *(//|#)? ?", " ", file.read_text()).replace("ö", "oe").replace("ž", "z")
        named = re.findall(r"\b([A-Z][a-z]+)(?:, [A-Z][a-z]+)* (?:&|and) ([A-Z][a-z]+),? \(?(?:[A-Z][^();]{0,60}\()?[12][09]\d\d\b", text)
        named += [(a,) for a in re.findall(r"\b([A-Z][a-z]+) (?:et al\.|and others),? \(?[12][09]\d\d\b", text)]
        missing += [(name_of(file), *names) for names in named if not set(names) <= known]
    assert not missing, missing


def test_files_that_pages_name_are_there():
    missing = []
    for page in PAGES:
        if page.name == "CHANGELOG.md":
            continue  # of versions that have been
        for name in re.findall(r"`((?:src|tests|tools|examples|bench|patches|doc)/[\w./*-]+)`", prose(page)):
            if not list(ROOT.glob(name)):
                missing.append((name_of(page), name))
    package = ROOT / "src/USER-MPDEM"
    for name in re.findall(
        r"`((?:numerics|parallel|geometry|material|mpm|fracture|coupling|contact|cement|styles|host)/[\w./*]+)`", (ROOT / "doc/theory.md").read_text()
    ):
        if not list(package.glob(name)):
            missing.append(("doc/theory.md", name))
    assert not missing, missing


def test_page_of_refused_settings():
    """doc/refused_settings.md has the rows of the table in styles/guards/host_guards.cpp."""
    table = (ROOT / "src/USER-MPDEM/styles/guards/host_guards.cpp").read_text().split("const Guard kGuards[] = {\n")[1].split("\n};")[0]
    text = r'((?:"(?:[^"\\]|\\.)*"\s*)+)'
    found = re.findall(rf"^    {{[\w |]+,\s*{text},\s*{text},\s*{text},", table, re.M)
    rows = [[" ".join("".join(re.findall(r'"(.*?)"', words)).replace("\\n", " ").split()) for words in row] for row in found]
    assert len(rows) == len(re.findall(r"^    {k", table, re.M)) > 40
    page = re.findall(r"^\| (.*?) \| (.*?) \| (.*?) \|$", (ROOT / "doc/refused_settings.md").read_text(), re.M)
    assert page[1:] == [tuple(row) for row in rows]
