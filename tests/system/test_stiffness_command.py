# SPDX-License-Identifier: GPL-2.0-or-later
"""bond_stiffness: the 6 by 6 matrix of each bond without a run."""
import csv
import re

import numpy as np
import pytest
from elastic_pair import WORDS, measure_case, references
from scenes import RING, VTI, cement, edit, launch, pair, pull, restarted, run, thermo
from test_bond_stiffness import ACROSS

CASES = references()
COLUMN = {"tension": "tension", "shear": "shear_min", "torsion": "torsion", "bending": "bending_min"}


def rows_of(file):
    with open(file) as f:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(f)]


def matrix(row):
    return np.array([[row[f"k{i}{j}"] for j in range(1, 7)] for i in range(1, 7)])


def scene(case, cell, direction=(0, 0, 1)):
    words = " ".join(f"{w} {case[w]:.15g}" for w in WORDS[case["shape"]])
    axis = "bond" if case["axis"] == "z" else case["axis"]
    half_box = tuple(np.abs(direction) * (case["radius"] + case["gap"] / 2) + case["radius"] + 1e-3)
    return pair(cell / 2, gap=case["gap"], cement=words, shape=case["shape"], radius=case["radius"], half_box=half_box, direction=direction) + cement(
        cell, 1e-9, elastic=tuple(case["elastic"]), axis=axis
    )


def solve(directory, script, ranks=1):
    """The rows, and how many bonds were solved."""
    result = run(script + "bond_stiffness k.csv\n", directory, ranks)
    return rows_of(directory / "k.csv"), int(re.search(r"^bond_stiffness: \d+ bonds, (\d+) solved", result.output, re.M)[1])


@pytest.mark.parametrize("name", ACROSS)
def test_finite_elements(name, tmp_path, figures):
    (row,), _ = solve(tmp_path, scene(CASES[name], ACROSS[name] / 8))
    for load, reference in CASES[name]["stiffness"].items():
        error = row[COLUMN[load]] / reference["value"] - 1
        figures.below(f"{name}, {load}: error of the stiffness, 8 cells across the neck", abs(error), 0.02)
    # the bond is as stiff along x as along y
    assert row["shear_max"] / row["shear_min"] < 1 + 1e-6 and row["bending_max"] / row["bending_min"] < 1 + 1e-6


@pytest.mark.parametrize("load", COLUMN)
def test_a_run_of_the_same_bond(load, tmp_path, figures):
    name = "meniscus across a gap"
    cell = ACROSS[name] / 8
    (row,), _ = solve(tmp_path, scene(CASES[name], cell))
    figures.below(f"{load}: stiffness against the run", abs(row[COLUMN[load]] / measure_case(tmp_path, CASES[name], load, cell) - 1), 2e-4)


def test_axes_of_the_box(tmp_path):
    """The same bond along z, x and y: matrices are permuted. Symmetric, positive, without coupling in the middle of a symmetric bond."""
    case, K, rows = CASES["meniscus across a gap"], [], []
    for n, direction in enumerate(np.eye(3)[[2, 0, 1]]):
        (row,), _ = solve(tmp_path / str(n), scene(case, 2.5e-4, direction))
        order = [(d + n) % 3 for d in range(3)]
        K.append(matrix(row)[np.ix_(order + [3 + d for d in order], order + [3 + d for d in order])])
        rows.append(row)
        assert [row["x"], row["y"], row["z"]] == pytest.approx([0, 0, 0], abs=1e-15)
        assert [row["nx"], row["ny"], row["nz"]] == pytest.approx(direction, abs=1e-12)
    assert K[0] == pytest.approx(K[1], abs=1e-8 * K[0][2, 2]) and K[0] == pytest.approx(K[2], abs=1e-8 * K[0][2, 2])
    assert (K[0] == K[0].T).all() and (np.linalg.eigvalsh(K[0] / np.sqrt(np.outer(np.diag(K[0]), np.diag(K[0])))) > 0).all()
    diagonal = np.diag(K[0])
    scale = np.sqrt(np.outer(diagonal, diagonal))
    assert (np.abs(K[0] - np.diag(diagonal)) < 1e-6 * scale).all()
    assert diagonal[2] == pytest.approx(rows[0]["tension"]) and diagonal[5] == pytest.approx(rows[0]["torsion"])


def test_skew_bond(tmp_path, figures):
    """As in test_stiffness.py the grid lies otherwise."""
    case = CASES["meniscus across a gap"]
    (straight,), _ = solve(tmp_path / "straight", scene(case, 2e-4))
    (skew,), _ = solve(tmp_path / "skew", scene(case, 2e-4, (0.36, -0.48, 0.8)))
    for load, column in COLUMN.items():
        figures.below(f"skew bond against aligned, {load}: change", abs(skew[column] / straight[column] - 1), 0.02)
    assert [skew["nx"], skew["ny"], skew["nz"]] == pytest.approx([0.36, -0.48, 0.8], abs=1e-9)


PACKING = """\
units        si
atom_style   mpdem
atom_modify  map array first grains
boundary     f f f
newton       off
communicate  single vel yes
region       box block -0.01 0.03 -0.01 0.03 -0.01 0.03 units box
create_box   2 box
lattice      sc 0.01
region       beads block -0.005 0.015 -0.005 0.015 -0.005 0.015 units box
create_atoms 1 region beads
set          type 1 diameter 0.01 density 2500
group        grains type 1
communicate  single vel yes group grains
neighbor     0.001 bin
neigh_modify include grains delay 0
create_cement calcite contacts grains gap 1e-6 shape flat outer 2.5e-3 inner auto spacing 4e-4
timestep     4e-8
fix          cem calcite mpm cell 8e-4 elastic isotropic 50e9 0.25 axis radial
fix          bond grains mpm/couple cem
"""


def test_equal_bonds_and_ranks(tmp_path):
    """12 bonds along three axes: three are solved. On more ranks some are cut, and the matrices stay."""

    def by_place(rows):  # LIGGGHTS numbers the beads by ranks
        return {tuple(round(1e4 * row[c]) for c in "xyz"): row for row in rows}

    one, solved = solve(tmp_path / "1", PACKING)
    one = by_place(one)
    assert solved == 3
    assert set(one) == {tuple(np.roll((50, i, j), n)) for n in range(3) for i in (0, 100) for j in (0, 100)}
    for ranks in (2, 4):
        many = by_place(solve(tmp_path / str(ranks), PACKING, ranks)[0])
        assert set(many) == set(one)
        for place, a in one.items():
            b = many[place]
            assert matrix(a) == pytest.approx(matrix(b), abs=1e-7 * a["tension"]), place
            for name in ("nx", "ny", "nz", "tension", "shear_min", "torsion", "bending_max"):
                assert a[name] == pytest.approx(b[name], rel=1e-7, abs=1e-9), (place, name)


def test_other_units(tmp_path):
    (si,) = solve(tmp_path / "si", pair(1e-4) + cement(2e-4, 1e-9))[0]
    text = pair(1e-2, radius=0.5, half_box=(0.6, 0.6, 1.25), cement="inner 0.1 outer 0.2") + cement(2e-2, 1e-9, elastic=(60e10, 40e10, 0.25, 0.2, 18e10))
    text = edit(edit(edit(text, "units        si", "units cgs"), "density 2500", "density 2.5"), "neighbor     0.0005", "neighbor 0.05")
    (cgs,) = solve(tmp_path / "cgs", text)[0]
    assert cgs["tension"] == pytest.approx(1e3 * si["tension"], rel=1e-8)  # dyn/cm
    assert cgs["bending_min"] == pytest.approx(1e7 * si["bending_min"], rel=1e-8)  # dyn cm


BREAKING = pair(1e-4) + cement(2e-4, 2e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9") + pull(2.0, 5e-7)


def test_damage_and_what_is_broken(tmp_path):
    """Damage reduces stiffness; a separated bond has none."""
    run(BREAKING + "bond_stiffness a.csv\nrun 160\nbond_stiffness b.csv\nrun 3000\nbond_stiffness c.csv\n", tmp_path, 2)
    whole, damaged, broken = (rows_of(tmp_path / f"{name}.csv")[0] for name in "abc")
    assert 0.01 < damaged["tension"] / whole["tension"] < 0.99, (damaged["tension"], whole["tension"])
    assert np.abs(matrix(broken)[:3, :3]).max() < 1e-5 * whole["tension"]


def test_nothing_else_changes(tmp_path):
    """Before a run and between runs: what comes after is bitwise identical."""

    def script(asks):
        return BREAKING + thermo(100, ["f_bond", "f_cem"]) + f"{asks}run 300\n{asks}run 300\n"

    tables = [run(script(asks), tmp_path / name, 2).table() for name, asks in (("with", "bond_stiffness k.csv\n"), ("without", ""))]
    for name in tables[0]:
        assert (tables[0][name] == tables[1][name]).all(), name


def test_after_a_restart(tmp_path):
    """Damaged and rotated, from the file as in the run that wrote it."""
    run(BREAKING + "run 160\nwrite_restart r\nbond_stiffness a.csv\n", tmp_path, 2)
    fixes = "".join(line + "\n" for line in BREAKING.splitlines() if line.startswith(("timestep", "fix          cem", "fix          bond")))
    run(restarted("r") + fixes + "bond_stiffness b.csv\n", tmp_path)
    a, b = (matrix(rows_of(tmp_path / f"{name}.csv")[0]) for name in "ab")
    assert a == pytest.approx(b, abs=1e-8 * a[2, 2])


# name: (old and new text of the script, words of the message)
BAD = {
    "no file": ("bond_stiffness k.csv", "bond_stiffness", ["bond_stiffness:", "file name"]),
    "a word too many": ("bond_stiffness k.csv", "bond_stiffness k.csv pair", ["bond_stiffness:", "'pair'", "bond_stiffness FILE"]),
    "no such folder": ("bond_stiffness k.csv", "bond_stiffness no/k.csv", ["bond_stiffness:", "'no/k.csv'", "cannot be written", "check name and folder"]),
    "the file of csv": (
        "bond_stiffness k.csv",
        "bond_stiffness ./t.csv",
        ["bond_stiffness:", "'./t.csv'", "'csv' of fix mpm/couple (id bond)", "name another"],
    ),
    "no coupling": ("bond_stiffness k.csv", "unfix bond\nbond_stiffness k.csv", ["bond_stiffness:", "no fix mpm/couple", "define one before"]),
    "no fix mpm": ("bond_stiffness k.csv", "unfix bond\nunfix cem\nbond_stiffness k.csv", ["bond_stiffness:", "no fix mpm,", "define one before"]),
    "too early": ("create_cement", "bond_stiffness k.csv\ncreate_cement", ["bond_stiffness:", "no cement", "create_cement"]),
    "before the box": ("region       box", "bond_stiffness k.csv\nregion       box", ["bond_stiffness:", "box does not exist", "create_box"]),
    "a full disk": ("bond_stiffness k.csv", "bond_stiffness /dev/full", ["bond_stiffness:", "/dev/full", "No space left"]),
    "a grain that moved": ("bond_stiffness k.csv", "set atom 2 z 0.006\nbond_stiffness k.csv", ["fix mpm (id cem)", "grain 2"]),
}


@pytest.mark.parametrize("name", BAD)
def test_message(name, tmp_path):
    old, new, needed = BAD[name]
    script = pair(2e-4, cement=RING) + cement(4e-4, 1e-9, elastic=VTI, couple="kn auto kt auto csv 5 t.csv") + "bond_stiffness k.csv\n"
    result = launch(edit(script, old, new), tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    missing = [word for word in needed if word not in result.errors()[0]]
    assert not missing, result.errors()[0]
