# SPDX-License-Identifier: GPL-2.0-or-later
"""Statements of the pages that once contradicted the program or each other: limits, defaults, units of names, which bonds are equal."""
import re
from pathlib import Path

import numpy as np
import pytest
from scenes import NEIGHBOURS, RADIUS, host, launch, pair, run
from test_stiffness_command import rows_of

ROOT = Path(__file__).resolve().parents[2]
DOC = ROOT / "doc"


def tables(page, head):
    """Tables below a head of a page, as lists of rows of cells without quotes; a cell that is left out is that of the row above."""
    text = re.split(r"^## ", (DOC / page).read_text().split(f"\n## {head}\n", 1)[1], flags=re.M)[0]
    found = []
    for table in re.findall(r"^\|.*\n\|[-|]+\n((?:\|.*\n)+)", text, re.M):
        rows = []
        for line in table.splitlines():
            cells = [c.replace("`", "").strip() for c in line.strip().strip("|").split("|")]
            rows.append([cells[0] or rows[-1][0], *cells[1:]])
        found.append(rows)
    return found


def created(words, **options):
    """Two beads and a create_cement with these words."""
    text = pair(1e-4, **options)
    return text[: text.index("create_cement")] + f"create_cement calcite pair 1 2 {words}\n"


def error_of(script, directory):
    (error,) = launch(script, directory).errors()
    return error


# ------------------------------------------------------------------------------- create_cement


def test_keywords_of_create_cement(tmp_path):
    """Those that the command lists, shape by shape and for all of it."""
    known = error_of(created("shape flat outer 2e-3 spacing 1e-4 nonsense 1"), tmp_path)
    shapes, command = tables("create_cement.md", "Syntax")
    page = {row[1].rstrip(" *") for row in shapes} | {row[0] for row in command} | {"shape", "file"}
    page |= {row[0].split()[0] for row in tables("calcite_content.md", "Keywords")[0]}
    listed = re.search(r"known here: ([a-z_, ]+[a-z])", known)[1].split(", ")
    assert sorted(page) == sorted(listed)


def test_defaults_of_create_cement(tmp_path):
    """A command with every default of the page said is the command without."""
    ((*rows,),) = tables("create_cement.md", "Default")
    default = dict(rows)
    of_shape = {"meniscus": ("contact",), "coating": ("cap",), "hourglass": ("waist",)}
    words = {k: re.match(r"(?:share )?[-\w.]+", v)[0] for k, v in default.items()}
    words.update(density=re.search(r"(\d+) in si", default["density"])[1], grid="0 0 0", type="2")
    assert words.pop("attach") == "one"
    whole = {k: v for k, v in words.items() if not any(k in of for of in of_shape.values())}
    for shape, of in of_shape.items():
        size = "content 0.02 spacing 2e-4" if shape != "coating" else "thickness 5e-4 spacing 2e-4"
        # a waist of the default needs a gap
        out = [
            run(created(f"shape {shape} {more}{size}{rest}", gap=4e-4), tmp_path / f"{shape}{n}").output.split("Cement between")[1]
            for n, (more, rest) in enumerate([("", ""), (" ".join(f"{k} {words[k]}" for k in of) + " ", " " + " ".join(f"{k} {v}" for k, v in whole.items()))])
        ]
        assert out[0] == out[1], shape


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_least_waist(share, tmp_path):
    """Between touching equal beads, by the formula of create_cement.md and the numbers beside it."""
    page = " ".join((DOC / "create_cement.md").read_text().split())
    assert "sqrt(R/(R + sqrt(R^2 - outer^2))): 0.71 for thin bonds, 0.73 for `outer` R/2, 0.79 for 0.8 R" in page
    R, a = RADIUS, share * RADIUS
    least = np.sqrt(R / (R + np.sqrt(R**2 - a**2)))
    assert f"{least:.2f}" == {0.2: "0.71", 0.5: "0.73", 0.8: "0.79"}[share]
    spacing = 2 * (R - np.sqrt(R**2 - a**2)) / 5

    def words(waist):
        return f"shape hourglass outer {a:.15g} waist {waist:.15g} inner {a / 4:.15g} film grid spacing {spacing:.15g}"

    error = error_of(created(words(least * (1 - 1e-4))), tmp_path / "narrow")
    assert "cuts into the grains" in error
    assert float(re.search(r"at least ([\d.]+)", error)[1]) == pytest.approx(least, rel=1e-5)
    run(created(words(least * (1 + 1e-4))), tmp_path / "wide")


@pytest.mark.parametrize("spacings, allowed", [(16.4, True), (16.6, False)])
def test_largest_cell(spacings, allowed, tmp_path):
    """The cell may be 16.5 spacings wide, as fix_mpm.md says."""
    (cell,) = (row for row in tables("fix_mpm.md", "Syntax")[0] if row[0] == "cell")
    assert "16.5" in " ".join(cell)
    spacing = 1.2e-4
    script = created(f"shape flat inner 1e-3 outer 1.3e-3 spacing {spacing}", gap=2e-3) + (
        f"timestep 1e-9\nfix cem calcite mpm cell {spacings * spacing:.15g} elastic isotropic 60e9 0.25\nfix bond grains mpm/couple cem\n"
        "fix hold grains move linear 0 0 0\nrun 0\n"
    )
    done = launch(script, tmp_path)
    assert (done.status == 0) == allowed and (allowed or "spacings of the cement" in done.errors()[0])


# --------------------------------------------------------------------------------- equal bonds

X, Y, Z, SKEW, OTHER = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, 0.8), (0, 0.6, 0.8)


def row_of_pairs(directions, words="", axis="radial", points="now", elastic="isotropic 60e9 0.25"):
    """Touching pairs beside each other, each with a flat bond along its direction; the lower ID lies behind."""
    width = 0.03
    text = host() + f"region box block -0.015 {width * len(directions) - 0.015:g} -0.015 0.015 -0.015 0.015 units box\ncreate_box 2 box\n"
    for n, direction in enumerate(directions):
        for side in (-1, 1):
            place = side * RADIUS * np.array(direction, float) + [n * width, 0, 0] + 0.0
            text += f"create_atoms 1 single {' '.join(f'{c:.15g}' for c in place)} units box\n"
    text += f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n" + NEIGHBOURS
    text += f"create_cement calcite contacts grains gap 1e-6 shape flat outer 2e-3 inner 1e-3 film grid spacing 2e-4 points {points}\n"
    return text + (
        f"timestep 1e-8\nfix cem calcite mpm cell 4e-4 elastic {elastic} axis {axis} damage tensor B0 9.6e3 {words}\n"
        "fix bond grains mpm/couple cem\nbond_stiffness k.csv\nfix move grains nve/sphere\nrun 0\n"
    )


@pytest.mark.parametrize(
    "directions, solutions, more",
    [
        ((Z, SKEW, OTHER), 1, {}),
        ((Z, Y, SKEW), 2, {}),
        ((X, Y, Z), 3, {}),
        ((Z, (0, 0, -1)), 2, {}),
        ((Z, SKEW), 2, {"axis": "global 0 0 1"}),
        ((Z, Z, Y), 2, {"points": "later"}),
    ],
)
def test_which_bonds_are_equal(directions, solutions, more, tmp_path):
    """As bond_stiffness.md says: nearest axis of the box, order of the IDs, and with `axis global` the direction."""
    output = run(row_of_pairs(directions, "condense yes", **more), tmp_path).output
    (condensed,) = re.findall(r"condensed (\d+) of \d+ bonds, with (\d+) solutions", output)
    assert condensed == (str(len(directions)), str(solutions))
    if "points" not in more:
        assert re.findall(r"^bond_stiffness: (\d+) bonds, (\d+) solved", output, re.M) == [(str(len(directions)), str(solutions))]
    assert " bonds, cell " in output and "bodies" not in output


# --------------------------------------------------------------------------------- point files

SPACING = 1e-4


def known_columns(tmp_path):
    (tmp_path / "cement.txt").write_text("nonsense\n1\n")
    return re.search(r"known are ([\w ]+)", error_of(created(f"file cement.txt spacing {SPACING}"), tmp_path))[1].split()


def test_columns_of_point_files(tmp_path):
    """The page has the columns of the program, and which others they need."""
    (columns,) = tables("point_files.md", "Columns")
    known = known_columns(tmp_path)
    assert sorted(" ".join(row[0] for row in columns).split()) == sorted(known)

    run(created(f"shape flat inner 1e-3 outer 2e-3 film grid spacing {SPACING}") + "write_cement whole.txt\n", tmp_path)
    lines = [line.split() for line in (tmp_path / "whole.txt").read_text().splitlines() if line and not line.startswith("#")]
    whole = dict(zip(lines[0], zip(*lines[1:])))
    count = len(lines) - 1
    for name in known:
        whole.setdefault(name, ["1" if name in ("az", "v1x", "v2y") else "0"] * count)

    def read(groups, folder):
        names = " ".join(groups).split()
        (tmp_path / folder).mkdir(exist_ok=True)
        rows = [" ".join(names)] + [" ".join(row) for row in zip(*(whole[n] for n in names))]
        (tmp_path / folder / "cement.txt").write_text("\n".join(rows) + "\n")
        return launch(created(f"file cement.txt spacing {SPACING}"), tmp_path / folder)

    first, needed = columns[0][0], 0
    for n, row in enumerate(columns):
        needs = []  # groups that it needs, and what these need
        while (needs[-1:] or [row])[-1][3].startswith(("area", "attached")):
            last = (needs[-1:] or [row])[-1]
            needs.append(next(r for r in columns if r[0] == last[3]))
        groups = [first] + [r[0] for r in needs] + [row[0]] * (n > 0)
        assert not read(groups, f"{n}").errors(), groups
        if needs:
            needed += 1
            (error,) = read([first] + [r[0] for r in needs[1:]] + [row[0]], f"{n}without").errors()
            assert "need" in error and needs[0][0].split()[0] in error
    assert needed == 3


def test_example_of_point_files(tmp_path):
    text = re.search(r"```text\n(.*?)```", (DOC / "point_files.md").read_text(), re.S)[1]
    (tmp_path / "cement.txt").write_text(text)
    assert ", 2 points" in run(created("file cement.txt spacing 1e-4"), tmp_path).output


# -------------------------------------------------------------------------------- bond_stiffness


def test_damaged_links_in_bond_stiffness(tmp_path, figures):
    """Links of damage D count with 1 - D of kn where they are open, and with 1 - D/2 where they are closed. They are so soft that
    the stiffness of the bond is theirs."""
    D, kn = 0.6, 1e8
    run(created(f"shape flat inner 1e-3 outer 2e-3 film grid spacing {SPACING}") + "write_cement whole.txt\n", tmp_path)
    lines = [line for line in (tmp_path / "whole.txt").read_text().splitlines() if line and not line.startswith("#")]

    def tension(damage, speed):
        folder = tmp_path / f"{damage}{speed}"
        folder.mkdir()
        (folder / "cement.txt").write_text("\n".join([f"{lines[0]} damage_i damage_j"] + [f"{line} {damage} {damage}" for line in lines[1:]]) + "\n")
        script = created(f"file cement.txt spacing {SPACING}") + (
            "timestep 1e-8\nfix cem calcite mpm cell 2e-4 elastic isotropic 60e9 0.25 axis bond\n"
            f"fix bond grains mpm/couple cem kn {kn} kt {kn / 1e4} length 2e-4 interface cohesive tn 1e6 tt 1e6 Gn 1e3 Gt 1e6\n"
            f"group second id 2\nfix pull second move linear 0 0 {speed}\ngroup first id 1\nfix hold first move linear 0 0 0\n"
            "run 20\nbond_stiffness k.csv\n"
        )
        run(script, folder)
        return rows_of(folder / "k.csv")[0]["tension"]

    whole = tension(0, 1e-3)
    figures.below("open damaged links: stiffness over that without damage, against 1 - D", abs(tension(D, 1e-3) / whole / (1 - D) - 1), 0.01)
    figures.below("closed damaged links: the same against 1 - D/2", abs(tension(D, -1e-3) / whole / (1 - D / 2) - 1), 0.01)
    page = " ".join((DOC / "bond_stiffness.md").read_text().split())
    assert "$(1 - D)$ of `kn` and `kt` where they are open" in page and "$(1 - D/2)$ of `kn` and $(1 - D)$ of `kt`" in page


# ------------------------------------------------------------------------------------- fix mpm


def test_defaults_of_words_within_keywords():
    """Values that a keyword takes besides its own stand in the table of defaults, too."""
    default = {row[0]: row[1] for row in tables("fix_mpm.md", "Default")[0]}
    source = (ROOT / "src/USER-MPDEM/cement/bond/options.h").read_text()
    assert f"wake {re.search(r'activation_share = ([0-9.]+);', source)[1]}" in default["condense"]


def test_examples_have_the_strength_of_cement():
    """B0 is an energy per volume: what the examples of all pages imply for the tensile strength is below 100 MPa."""
    found = []
    for page in [ROOT / "README.md", *sorted(DOC.rglob("*.md"))]:
        for block in re.findall(r"^```liggghts[^\n]*\n(.*?)^```", page.read_text(), re.M | re.S):
            for line in re.sub(r"&\s*\n", " ", block).splitlines():
                moduli = re.search(r"elastic (?:isotropic ([\d.e]+)|vti [\d.e]+ ([\d.e]+))", line)
                threshold = re.search(r"\bB0 ([\d.e]+)", line)
                if moduli and threshold:
                    found.append((page.name, line, np.sqrt(np.sqrt(2) * float(threshold[1]) * float(moduli[1] or moduli[2])) / 1e6))
    assert found and not [f for f in found if f[2] > 100]
