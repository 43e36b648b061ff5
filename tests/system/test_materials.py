# SPDX-License-Identifier: GPL-2.0-or-later
"""Several cements in one scene, and scatter of their properties: doc/cement_material.md."""
import math
import re

import numpy as np
import pytest
from pulled_bonds import first_failures, modulus_of_weibull
from scenes import CALCITE, VTI, cement, deform, edit, launch, pair, point_quantities, restarted, run, shift, thermo

RADIUS, INNER, OUTER, THICK = 5e-3, 1e-3, 2e-3, 2e-4
CAP = math.degrees(math.asin(OUTER / (RADIUS + THICK)))  # the shell ends where the flat bond does


def softer(contrast):
    """VTI with moduli of one over the contrast."""
    return (VTI[0] / contrast, VTI[1] / contrast, *VTI[2:4], VTI[4] / contrast)


SOFT = softer(5)
FLAT = f"inner {INNER} outer {OUTER}"
SHELL = f"shape coating thickness {THICK} cap {CAP:.12g} material soft shape flat outer {OUTER} inner {INNER}"


def words_of(elastic):
    return "vti " + " ".join(f"{e:.15g}" for e in elastic)


def stiffness(directory, load, materials, shapes, cell=1.25e-4, elastic=VTI, condense=""):
    """Force per displacement of grain 2, or moment per rotation, after a smooth motion."""
    timestep = 0.35 * cell / (elastic[1] / 2710) ** 0.5
    amount = 1e-8 if load in ("tension", "shear") else 1e-5
    script = pair(cell / 2, cement=FLAT)
    script = edit(script, f"create_cement calcite pair 1 2 shape flat {FLAT} film grid", f"{materials}create_cement calcite pair 1 2 {shapes} film grid")
    script += edit(cement(cell, timestep, elastic=elastic, couple="kn auto kt auto damping 0.5"), " axis", f" {condense} axis")
    script += deform(load, amount, 10e-6, timestep, 2 * RADIUS)
    script += "unfix pull\nfix pull second move linear 0 0 0\n" + thermo(4, ["v_load"]) + f"run {round(2.5e-6 / timestep)}\n"
    return run(script, directory).table()["v_load"].mean() / amount


# ------------------------------------------------------------------------ several cements


def test_another_material_is_as_that_of_fix_mpm(tmp_path):
    """A bond of material 1 with the words of fix mpm is bitwise identical to one of material 0."""
    own = stiffness(tmp_path / "own", "shear", "", f"shape flat {FLAT}", cell=2.5e-4)
    named = stiffness(tmp_path / "named", "shear", "cement_material same\n", f"shape flat {FLAT} material same", cell=2.5e-4)
    assert own == named


@pytest.mark.parametrize("condense", ["", "condense yes"])
def test_moduli_of_a_bond(tmp_path, figures, condense):
    """All of a bond of a fifth of the moduli has a fifth of the stiffness, links included."""
    own = stiffness(tmp_path / "own", "tension", "", f"shape flat {FLAT}", cell=2.5e-4, condense=condense)
    soft = stiffness(
        tmp_path / "soft", "tension", f"cement_material soft elastic {words_of(SOFT)}\n", f"shape flat {FLAT} material soft", cell=2.5e-4, condense=condense
    )
    figures.below(f"bond of a second cement, {condense or 'resolved'}: error of the ratio of stiffnesses", abs(5 * soft / own - 1), 2e-3)


def by_elements(contrast):
    """Stiffness of the shell under the flat bond by finite elements (tests/verification/bond_fe.py), by load."""
    from axisymmetric_fe import TransverselyIsotropic, axis_uniform
    from bond_fe import flat_body
    from bond_fe import stiffness as solved

    def in_coat(r, z):
        up = RADIUS - z
        return (np.hypot(r, up) < RADIUS + THICK) & (np.arctan2(r, up) < math.radians(CAP))

    found = {}
    for load in ("tension", "shear", "torsion"):
        coarse, fine = (
            solved(
                load,
                flat_body(RADIUS, 0.0, INNER, OUTER, n, n // 2, 1.5),
                TransverselyIsotropic(*VTI),
                axis_uniform(0.0, 1.0),
                (TransverselyIsotropic(*softer(contrast)), in_coat),
            )
            for n in (48, 96)
        )
        assert abs(fine / coarse - 1) < 4e-3
        found[load] = fine
    return found


@pytest.mark.parametrize(
    "contrast, cell, limit", [(1, 1.25e-4, 0.01), (2, 1.25e-4, 0.02), (5, 1.25e-4, 0.1), pytest.param(5, 7e-5, 0.04, marks=pytest.mark.long)]
)
def test_coating_and_flat_bond_of_unlike_moduli(tmp_path, figures, contrast, cell, limit):
    """A soft shell on both grains and stiff cement between them, against finite elements. Where the moduli jump, strain does, and splines
    smear that over a cell: the error goes with contrast and cell."""
    script = pair(cell / 2, cement=FLAT)
    materials = f"cement_material soft elastic {words_of(softer(contrast))}\n"
    script = edit(script, f"create_cement calcite pair 1 2 shape flat {FLAT} film grid", f"{materials}create_cement calcite pair 1 2 {SHELL} film grid")
    run(script + cement(cell, 1e-8) + "bond_stiffness stiffness.csv\n", tmp_path)
    found = np.genfromtxt(tmp_path / "stiffness.csv", delimiter=",", names=True)
    for load, exact in by_elements(contrast).items():
        error = float(found["shear_min" if load == "shear" else load]) / exact - 1
        figures.note(f"shell of 1/{contrast} of the moduli, cells of {cell:g}, {load}: signed error of the stiffness", f"{error:+.4f}")
        figures.below(f"shell of 1/{contrast} of the moduli, cells of {cell:g}, {load}: error of the stiffness", abs(error), limit)


BREAKS = "damage tensor B0 9.6e3 cutoff 0.6 regularization crackband 20"


def broken(directory, materials, shapes, ranks=1, columns=(), extra="", words=BREAKS, cell=2.5e-4, steps=900):
    timestep = 0.3 * cell / 4000
    script = pair(cell / 2, cement=FLAT)
    script = edit(script, f"create_cement calcite pair 1 2 shape flat {FLAT} film grid", f"{materials}create_cement calcite pair 1 2 {shapes} film grid")
    script += cement(cell, timestep, elastic=CALCITE, axis="radial", damage=words) + extra
    script += point_quantities(["material", "strength_factor", "moduli_factor", "damage"]) + shift(1.2e-6, steps * timestep)
    script += thermo(50, ["f_bond[14]", "f_bond[18]", "f_cem[3]", "f_cem[9]", "f_cem[12]", *columns])
    script += "dump points calcite custom 300 points.*.txt id c_material c_strength_factor c_moduli_factor c_damage\n"
    script += 'dump_modify points sort id format "%d %.17g %.17g %.17g %.17g"\n' + f"run {steps}\n"
    return run(script, directory, ranks)


TWO = f"cement_material soft elastic {words_of(SOFT)} damage tensor B0 2e3 cutoff 0.6 energy 3\n"


def test_two_cements_break(tmp_path, figures):
    """Damage is mostly in the soft shell, whose strength is lower; the energy balance closes."""
    r = broken(tmp_path, TWO, SHELL)
    p = r.points(900)
    assert set(p["c_material"]) == {0.0, 1.0}
    early = r.points(300)
    damage = [early["c_damage"][early["c_material"] == n].mean() for n in (0, 1)]
    figures.note("two cements in a bond that breaks: mean damage of the strong and the weak one", f"{damage[0]:.4f} {damage[1]:.4f}")
    assert damage[1] > 2 * damage[0]
    figures.below("two cements in a bond that breaks: imbalance of the energy", np.abs(r.table()["f_cem[12]"]).max(), 0.01)


@pytest.mark.parametrize("words", ["", "cracks split"])
def test_ranks(tmp_path, words):
    """Two cements and fields in one bond, on 1, 2 and 4 ranks: drawn values bitwise, results within rounding."""
    scattered = TWO.strip() + " scatter strength weibull 6 length 5e-4 seed 3 scatter moduli lognormal 0.2 length 1e-3 seed 4\n"
    runs = [
        broken(tmp_path / str(n), scattered, SHELL, ranks=n, words=BREAKS + " " + words + " scatter strength lognormal 0.3 seed 5", steps=600)
        for n in (1, 2, 4)
    ]
    tables = [r.points(0) for r in runs]
    for t in tables[1:]:
        for c in ("c_material", "c_strength_factor", "c_moduli_factor"):
            assert np.array_equal(t[c], tables[0][c]), c
    assert np.ptp(tables[0]["c_strength_factor"]) > 0.3
    loads = [r.table()["f_bond[14]"] for r in runs]
    for load in loads[1:]:
        assert np.abs(load - loads[0]).max() < 2e-3 * np.abs(loads[0]).max()


def test_restart(tmp_path):
    """A run that is continued from a restart file is bitwise that without one."""
    materials = TWO.strip() + " scatter strength weibull 6 length 5e-4 seed 3\n"
    words = BREAKS + " scatter interface lognormal 0.2 seed 5"
    cell = 2.5e-4
    timestep = 0.3 * cell / 4000
    first = pair(cell / 2, cement=FLAT)
    first = edit(first, f"create_cement calcite pair 1 2 shape flat {FLAT} film grid", f"{materials}create_cement calcite pair 1 2 {SHELL} film grid")
    fixes = cement(cell, timestep, elastic=CALCITE, axis="radial", damage=words) + point_quantities(["strength_factor", "damage"])
    motion = shift(1.2e-6, 600 * timestep)
    dump = 'dump points calcite custom 200 points.*.txt id x y z c_strength_factor c_damage\ndump_modify points sort id format "%d %.17g %.17g %.17g %.17g %.17g"\n'
    run(first + fixes + motion + dump + "run 200\nwrite_restart half.rst\nrun 200\n", tmp_path)
    whole = {p: (tmp_path / f"points.{p}.txt").read_text() for p in (400,)}
    again = restarted("half.rst")
    run(again + fixes + motion + dump + "run 200\n", tmp_path, name="in.again")
    assert (tmp_path / "points.400.txt").read_text() == whole[400]
    wrong = launch(again + "cement_material soft elastic isotropic 1e10 0.2\n" + fixes, tmp_path, name="in.other")
    assert any("this material exists with the words" in e for e in wrong.errors()), wrong.output[-2000:]


def test_a_column_of_a_point_file(tmp_path):
    """write_cement writes the numbers of the materials, and create_cement reads them."""
    text = pair(1.25e-4, cement=FLAT)
    made = f"cement_material soft elastic {words_of(SOFT)}\ncreate_cement calcite pair 1 2 {SHELL} film grid"
    text = edit(text, f"create_cement calcite pair 1 2 shape flat {FLAT} film grid", made)
    run(text + "write_cement points.txt\n", tmp_path)
    again = edit(text, f"{SHELL} film grid", "file points.txt")
    run(again + "write_cement again.txt\n", tmp_path, name="in.again")
    columns = [np.loadtxt(tmp_path / f, skiprows=3, usecols=-1) for f in ("points.txt", "again.txt")]
    assert set(columns[0]) == {0.0, 1.0} and np.array_equal(*columns)
    few = launch(edit(again, f"cement_material soft elastic {words_of(SOFT)}\n", ""), tmp_path, name="in.few")
    assert any("column 'material' is 1; the scene has 1 materials" in e for e in few.errors()), few.output[-2000:]


# ------------------------------------------------------------------------ scatter


@pytest.mark.parametrize("modulus", [3, 6, 12])
def test_modulus_of_weibull(tmp_path, figures, modulus):
    """200 bonds of one drawn value each: the loads at their first failed points have the modulus of the strength, B0 has half of it.
    tests/verification/pulled_bonds.py pulls 500."""
    loads = first_failures(tmp_path, f"scatter strength weibull {modulus} seed {modulus}", 200)
    found = modulus_of_weibull(loads)
    figures.note(f"modulus of Weibull of the loads of 200 bonds, {modulus} asked for", f"{found:.2f}")
    figures.below(f"modulus of Weibull of 200 bonds, {modulus} asked for: error", abs(found / modulus - 1), 0.15)


def test_condensed_bonds_draw_the_same(tmp_path):
    """Condensed bonds have the values of resolved ones, and fail at nearly the same loads."""
    words = "scatter strength weibull 6 seed 2 scatter moduli lognormal 0.1 length 3e-4 seed 3"
    loads = [first_failures(tmp_path / c, f"{words} condense {c}", 12) for c in ("no", "yes")]
    assert np.ptp(loads[0]) > 0.2 * loads[0].mean()
    assert np.abs(loads[1] / loads[0] - 1).max() < 0.02


def test_drawn_values_in_the_table(tmp_path):
    """Bonds of one value have it in the table, with a mean of 1 over many bonds."""
    first_failures(tmp_path, "scatter strength lognormal 0.2 seed 2 scatter moduli lognormal 0.1 seed 3", 60, steps=5)
    rows = np.genfromtxt(tmp_path / "bonds.csv", delimiter=",", names=True, dtype=None, encoding=None)
    rows = rows[rows["step"] == 0]
    strength, moduli = rows["strength_factor"], rows["moduli_factor"]
    assert abs(strength.mean() - 1) < 4 * 0.2 / 60**0.5 and abs(moduli.mean() - 1) < 4 * 0.1 / 60**0.5
    assert 0.12 < strength.std() < 0.3 and 0.06 < moduli.std() < 0.15
    assert abs(np.corrcoef(strength, moduli)[0, 1]) < 0.5
    assert set(rows["material"]) == {0.0}


@pytest.mark.parametrize(
    "words, couple, spread",
    [
        ("B0 1e3 cutoff 0.5 regularization crackband 0.3 scatter energy lognormal 0.3 seed 2", "", (0.0, 0.02)),
        ("B0 1e5 cutoff 0.5 scatter interface lognormal 0.3 seed 4", "interface cohesive tn 3e6 tt 3e6 Gn 0.5 Gt 0.5", (0.15, 0.5)),
    ],
)
def test_energy_and_interface(tmp_path, words, couple, spread):
    """A drawn energy leaves the peaks alike, a drawn strength of the links does not; the energy balance closes."""
    from pulled_bonds import script

    text = edit(script("scatter", 8, steps=1200), "B0 1000 cutoff 0.5 scatter", words)
    run(edit(text, "mpm/couple cem", f"mpm/couple cem {couple}"), tmp_path)
    rows = np.genfromtxt(tmp_path / "bonds.csv", delimiter=",", names=True, dtype=None, encoding=None)
    last = rows[rows["step"] == 1200]
    peaks = last["peak_tension"]
    assert np.all(last["attached"] < last["debonded"] + last["attached"])
    assert spread[0] < np.ptp(peaks) / peaks.mean() and peaks.std() / peaks.mean() < spread[1]
    assert np.abs(rows["energy_imbalance"]).max() < 1e-3


def test_films_have_no_scatter_of_energy_and_interface(tmp_path, monkeypatch):
    """A run warns of the scatter that its films do not have, and not without films."""
    import pulled_bonds

    words = "B0 1e3 cutoff 0.5 regularization crackband 0.3 scatter energy lognormal 0.3 scatter interface lognormal 0.3"

    def output(film, directory, ranks):
        text = edit(pulled_bonds.script("scatter", 4, steps=2), "B0 1000 cutoff 0.5 scatter", words)
        text = edit(text, "mpm/couple cem", "mpm/couple cem interface cohesive tn 3e6 tt 3e6 Gn 0.5 Gt 0.5")
        return run(edit(text, "film grid", f"film {film}"), directory, ranks).output

    warning = "'scatter energy' and 'scatter interface' of cement_material leave 4 of 4 bonds as they are"
    assert "leave" not in output("grid", tmp_path / "cells", 1)
    monkeypatch.setattr(pulled_bonds, "GAP", 5e-5)
    assert warning in output("joined", tmp_path / "film", 2)


# ------------------------------------------------------------------------ what is refused


@pytest.mark.parametrize(
    "material, create, words, message",
    [
        ("cement_material default elastic isotropic 1e10 0.2\n", "", "", "'default' is the material of fix mpm"),
        ("cement_material soft elastic isotropic 1e10 0.6\n", "", "", "nu = 0.6 must lie between"),
        ("cement_material soft elastic isotropic 1e10 energy 3\n", "", "", "nu is missing, 'energy' is not a finite number"),
        ("cement_material soft elastic vti 1e10 1e10 0.2 0.2 energy 3\n", "", "", "Gzp is missing, 'energy' is not a finite number"),
        ("cement_material soft dmage tensor B0 1\n", "", "", "'dmage'"),
        ("", "material soft", "", "there is no 'material soft'; known are default"),
        ("cement_material soft\ncement_material soft energy 3\n", "", "", "this material exists with the words"),
        (
            "cement_material soft damage mazars kappa0 1e-4 At 1 Bt 1e4\n",
            "material soft",
            "damage tensor B0 1e4",
            "all cements of a scene have one law of damage",
        ),
        ("cement_material soft energy 3\n", "material soft", "damage tensor B0 1e4", "'energy 3' needs a fix mpm with an energy"),
        ("", "", "damage tensor B0 1e4 scatter strength weibull 0.5", "modulus of Weibull"),
        ("", "", "damage tensor B0 1e4 scatter strength lognormal 3", "must be at most 2"),
        ("", "", "damage tensor B0 1e4 scatter strength weibull 6 seed 0", "seed"),
        ("", "", "damage tensor B0 1e4 scatter strength weibull 6 length 1e-5", "correlation length must be at least the cell"),
        ("", "", "damage tensor B0 1e4 scatter strength weibull 6 scatter strength weibull 3", "is given twice without 'length'"),
        ("", "", "scatter strength weibull 6", "does not go with 'damage none'"),
        ("", "", "damage tensor B0 1e4 scatter energy weibull 6", "does not go with 'regularization none'"),
        ("", "", "scatter moduli lognormal 0.1 kinematics updated", "does not go with 'kinematics updated'"),
        ("cement_material soft damage tensor B0 2e3\n", SHELL, "damage tensor B0 1e4 regularization nonlocal 3e-4", "'several materials in a bond'"),
        ("cement_material soft scatter moduli lognormal 0.1\n", "material soft points later", "condense yes", "bonds of one template have the same values"),
    ],
)
def test_refused(tmp_path, material, create, words, message):
    """One error that names the word, why, and what to do."""
    script = pair(1.25e-4, cement=FLAT)
    made = create if create.startswith("shape") else f"shape flat {FLAT} {create}"
    script = edit(script, f"create_cement calcite pair 1 2 shape flat {FLAT} film grid", f"{material}create_cement calcite pair 1 2 {made} film grid")
    axis = "radial" if "later" in create else "global 0 0 1"
    script += cement(2.5e-4, 1e-8, elastic=CALCITE, axis=axis, damage=words) + "run 0\n"
    r = launch(script, tmp_path, ranks=2 if "soft" in material else 1)
    assert r.status != 0
    assert any(message in e for e in r.errors()), r.output[-1500:]
    assert len(set(r.errors())) == 1, re.findall("ERROR.*", r.output)
