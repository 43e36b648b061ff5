# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds between elastic grains: stiffness against finite elements, and runs: energy, ranks, restart, the rigid limit."""
import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from scenes import NEIGHBOURS, cement, dump, host, launch, pair, restarted, run, thermo

CASES = json.loads((Path(__file__).parent.parent / "verification" / "elastic_bonds.json").read_text())["cases"]
COLUMN = {"tension": "tension", "shear": "shear_min", "torsion": "torsion", "bending": "bending_min"}
QUICK = ["cylinder across a gap", "cylinder of VTI", "meniscus across a gap", "ring of VTI"]


def scene(case, cell, grains="elastic", points=""):
    R, gap, inner = case["radius"], case["gap"], case["inner"]
    wide, z = max(R) + 1e-3, (-R[0] - gap / 2, R[1] + gap / 2)
    text = host() + f"region box block {-wide} {wide} {-wide} {wide} {2 * z[0] - 1e-3} {2 * z[1] + 1e-3} units box\ncreate_box 3 box\n"
    for i in range(2):
        text += f"create_atoms {i + 1} single 0 0 {z[i]:.15g} units box\nset type {i + 1} diameter {2 * R[i]} density 2500\n"
    words = f"outer {case['outer']:.15g}" if case["shape"] == "flat" else f"neck {case['neck']:.15g} contact {case['contact']}"
    text += "group grains type 1 2\n" + NEIGHBOURS
    text += f"create_cement calcite pair 1 2 shape {case['shape']} inner {inner:.15g} {words} film grid spacing {cell / 2:.15g} {points}\n"
    (E1, nu1), (E2, nu2) = case["grain"]
    of_grains = f"grains elastic {E1} {nu1} type 2 {E2} {nu2}" if grains == "elastic" else grains
    return text + cement(cell, 1e-9, elastic=tuple(case["elastic"]), axis="bond" if case["axis"] == "z" else "radial", couple=f"kn auto kt auto {of_grains}")


def stiffness(directory, script, ranks=1):
    run(script + "bond_stiffness k.csv\n", directory, ranks)
    with open(directory / "k.csv") as f:
        row = next(csv.DictReader(f))
    return {load: float(row[name]) for load, name in COLUMN.items()}


def cell_of(case, across=10):
    return min((case.get("outer", case.get("neck")) - case["inner"]) / across, 2e-4)


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in QUICK else [pytest.mark.long]) for n in CASES if "attached_from" not in CASES[n]])
def test_finite_elements(name, tmp_path, figures):
    """Ten cells across the width, at most 0.2 mm."""
    found = stiffness(tmp_path, scene(CASES[name], cell_of(CASES[name])))
    for load, reference in CASES[name]["stiffness"].items():
        error = found[load] / reference["value"] - 1
        figures.note(f"{name}, {load}: signed error", f"{error:+.4f}")
        figures.below(f"{name}, {load}: error of the stiffness", abs(error), 0.01)


@pytest.mark.long
@pytest.mark.parametrize("name", [n for n in CASES if "attached_from" in CASES[n]])
def test_debonded_at_the_second_grain(name, tmp_path, figures):
    """A point file whose links to the second grain are gone inside of a radius. The crack front is smeared over a cell of a tenth of the width."""
    limit = 0.015 if "20 %" in name else 0.04
    case = CASES[name]
    made = scene(case, cell_of(case))
    run(made + "write_cement cement.txt\n", tmp_path)
    lines = (tmp_path / "cement.txt").read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if "attached_j" in line)
    columns = lines[head].lstrip("# ").split()
    at = {c: columns.index(c) for c in ("x", "y", "z", "area_j", "attached_j")}
    for i in range(head + 1, len(lines)):
        values = lines[i].split()
        if len(values) != len(columns) or float(values[at["area_j"]]) == 0:
            continue
        x, y, z = (float(values[at[c]]) for c in "xyz")
        r, R = np.hypot(x, y), case["radius"][1]
        if R * r / np.hypot(r, z - case["gap"] / 2 - R) < case["attached_from"]:
            values[at["attached_j"]] = "0"
            lines[i] = " ".join(values)
    (tmp_path / "debonded.txt").write_text("\n".join(lines) + "\n")
    first = made.index("create_cement")
    again = made[:first] + f"create_cement calcite pair 1 2 file debonded.txt spacing {cell_of(case) / 2:.15g}\n" + made[made.index("\n", first) + 1 :]
    found = stiffness(tmp_path, again)
    for load, reference in case["stiffness"].items():
        figures.below(f"{name}, {load}: error of the stiffness", abs(found[load] / reference["value"] - 1), limit)


def test_frequency_of_a_free_pair(tmp_path, figures):
    """Two free grains swing along their line with the stiffness of bond_stiffness; each takes half of the mass of the cement."""
    case, cell, dt, steps = CASES["ring"], 2.5e-4, 6e-9, 4500
    text = scene(case, cell).replace("timestep     1e-09", f"timestep {dt}")
    k = stiffness(tmp_path / "k", text)["tension"]
    text += "fix motion grains nve/sphere\nvelocity first set 0 0 1e-3\nvelocity second set 0 0 -1e-3\n"
    text += "variable points equal mass(calcite)\nvariable grains equal mass(grains)\n" + thermo(5, ["f_bond[9]", "v_points", "v_grains"])
    t = run(text + f"run {steps}\n", tmp_path).table()
    force, step = t["f_bond[9]"], t["step"]
    up = [i for i in range(1, len(force)) if force[i - 1] < 0 <= force[i]]
    at = [step[i] - 5 * force[i] / (force[i] - force[i - 1]) for i in up]
    period = (at[-1] - at[0]) / (len(at) - 1) * dt
    mass = 0.5 * (t["v_grains"][0] + t["v_points"][0])
    expected = 2 * np.pi * np.sqrt(0.5 * mass / k)
    assert len(at) >= 2
    figures.below("error of the frequency", abs(expected / period - 1), 0.005)


def test_stiff_grains_are_rigid(tmp_path, figures):
    case = {**CASES["cylinder across a gap"], "grain": [[1e20, 0.22]] * 2}
    stiff, rigid = (stiffness(tmp_path / g, scene(case, cell_of(case, 5), g)) for g in ("elastic", "grains rigid"))
    for load in COLUMN:
        figures.below(f"{load}: E = 1e20 Pa against rigid grains", abs(stiff[load] / rigid[load] - 1), 1e-6)


def test_ranks_and_condensed_bonds(tmp_path, figures):
    """Two ranks share the bond; a condensed bond has the same matrix."""
    case = CASES["ring of VTI"]
    text = scene(case, cell_of(case, 5))
    one = stiffness(tmp_path / "one", text)
    for name, script, ranks in (
        ("two ranks", text.replace("processors   * * *", "processors   2 1 1"), 2),
        ("condensed", text.replace("axis bond", "axis bond condense yes"), 1),
    ):
        other = stiffness(tmp_path / name.replace(" ", "_"), script, ranks)
        figures.below(f"stiffness, {name}", max(abs(other[load] / one[load] - 1) for load in COLUMN), 1e-6)


def rims(directory, condense):
    """Normal traction by a unit load, mean over the outermost fifth of the width at each rim with weights that fall linearly from it."""
    case, cell, T, pull = CASES["ring"], 2e-4, 8e-6, 2e-9
    R = case["radius"][0]
    text = scene(case, cell).replace("kn auto kt auto", "kn auto kt auto damping 0.3").replace("timestep     1e-09", "timestep 4e-9")
    text = text.replace("axis radial", f"axis radial condense {condense}").replace("axis bond", f"axis bond condense {condense}")
    text += f'variable d equal "{pull}*((step*dt<{T})*(0.5-0.5*cos(PI*step*dt/{T}))+(step*dt>={T}))"\n'
    text += f'variable v equal "{pull}*(step*dt<{T})*0.5*PI/{T}*sin(PI*step*dt/{T})"\n'
    text += "fix hold first move linear 0 0 0\nfix pull second move variable NULL NULL v_d NULL NULL v_v\n"
    names = ["grain", "attached_area", "traction_n", "traction_t"]
    text += "".join(f"compute {n} calcite mpm/atom cem {n}\n" for n in names)
    text += thermo(3000, ["f_bond[9]"]) + dump(3000, ["id", "x", "y", "z"] + [f"c_{n}" for n in names], "links.*.txt") + "run 3000\n"
    done = run(text, directory)
    force, links = abs(done.table()["f_bond[9]"][-1]), done.points(3000, "links")
    found = []
    for grain, side in ((1, -1), (2, 1)):
        at = links["c_grain"] == grain
        z = links["z"][at] - side * (R + (pull if grain == 2 else 0.0))
        r = np.hypot(links["x"][at], links["y"][at])
        foot, area, t = R * r / np.hypot(r, z), links["c_attached_area"][at], links["c_traction_n"][at]
        weights = [area * np.clip(1 - abs(foot - rim) / (0.2 * (case["outer"] - case["inner"])), 0, 1) for rim in (case["inner"], case["outer"])]
        found.append([w @ t / w.sum() / force for w in weights])
        along = (area * (-t * z / R)).sum() * side
        assert abs(along) < force
    return np.array(found)


def test_traction_at_the_rims(tmp_path, figures):
    """That of the finite elements, for both grains, resolved and condensed."""
    resolved, condensed = (rims(tmp_path / c, c) for c in ("no", "yes"))
    for n, rim in enumerate(("inner", "outer")):
        figures.below(f"{rim} rim: error of the traction", abs(resolved[:, n] / CASES["ring"]["rims"][n] - 1).max(), 0.05)
    figures.below("traction of the condensed bond", abs(condensed / resolved - 1).max(), 1e-3)


GRAINS = " grains elastic 70e9 0.22 type 2 95e9 0.08"
BEFORE, AFTER = 1200, 100  # steps; hundreds of points have failed at the restart
FIXES = cement(2e-4, 2e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9", couple="kn 2e12 kt 3e11" + GRAINS)
COLUMNS = ["id", "x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz", "fx", "fy", "fz"]
VALUES = ["f_bond[9]", "f_bond[17]", "f_cem[8]", "f_cem[9]", "f_cem[12]"]
PROCESSORS = {1: "1 1 1", 2: "2 1 1", 4: "2 2 1"}


@pytest.fixture(scope="module")
def torn(tmp_path_factory):
    """A free pair that flies apart and rotates, on a number of ranks, which cut the bond; it leaves middle.restart."""
    results = {}

    def get(ranks):
        if ranks not in results:
            text = pair(1e-4, gap=2e-4, processors=PROCESSORS[ranks]) + FIXES + "velocity second set 0.05 0.1 0.3\nset group second omegaz 300\n"
            text += "fix motion grains nve/sphere\n" + thermo(10, VALUES) + dump(50, COLUMNS, "first.*.txt", "all")
            results[ranks] = run(text + f"run {BEFORE}\nwrite_restart middle.restart\nrun {AFTER}\n", tmp_path_factory.mktemp("torn"), ranks)
        return results[ranks]

    return get


def test_energy_and_ranks(torn, figures):
    one = torn(1).table()
    assert one["f_bond[17]"][-1] > 500
    for ranks in (1, 2, 4):
        t = torn(ranks).table()
        figures.below(f"{ranks} ranks: imbalance of the energy", abs(t["f_cem[12]"][3:]).max(), 1e-5)
        assert (t["f_bond[17]"] == one["f_bond[17]"]).all()
        figures.below(f"{ranks} ranks: force of the bond", abs(t["f_bond[9]"] - one["f_bond[9]"]).max() / abs(one["f_bond[9]"]).max(), 1e-8)


@pytest.mark.parametrize("ranks", [1, 2])
def test_restart_is_bitwise(ranks, torn, tmp_path):
    first = torn(ranks)
    shutil.copy(first.directory / "middle.restart", tmp_path)
    text = restarted("middle.restart", processors=PROCESSORS[ranks]) + FIXES + "fix motion grains nve/sphere\n" + thermo(10, VALUES)
    again = run(text + dump(50, COLUMNS, "again.*.txt", "all") + f"run {AFTER}\n", tmp_path, ranks)
    for step in (BEFORE + 50, BEFORE + AFTER):
        a, b = first.points(step, "first"), again.points(step, "again")
        for c in ("vx", "vy", "vz", "fx", "fy", "fz"):
            assert (a[c] == b[c]).all(), f"step {step}: {c}"


@pytest.mark.parametrize(
    "words, message",
    [
        ("grains elastic -7e10 0.22", "must be greater than 0"),
        ("grains elastic 7e10 0.5", "0.499"),
        ("grains elastic inf 0.2", "inf"),
        ("grains elastic 7e10 0.2 rigid 9", "atom type 9"),
        ("grains elastic 7e10 0.2 friction 0.3", "does not go with"),
        ("grains elastic 7e10 0.2 at points", "does not go with"),
    ],
)
def test_bad_input(words, message, tmp_path):
    case = CASES["cylinder across a gap"]
    done = launch(scene(case, cell_of(case, 4), words) + "run 0\n", tmp_path)
    assert done.status != 0 and len(done.errors()) == 1 and message in done.errors()[0], done.errors()


def test_other_grains_in_the_next_run(tmp_path):
    """The load of the bond would jump."""
    case = CASES["cylinder across a gap"]
    text = scene(case, cell_of(case, 4)) + "fix motion grains nve/sphere\nrun 2\n"
    change = "unfix bond\nfix bond grains mpm/couple cem kn auto kt auto grains rigid\nrun 2\n"
    done = launch(text + change, tmp_path)
    assert done.status != 0 and "in the steps before" in done.errors()[0], done.errors()
    assert np.isfinite(CASES["ring"]["stiffness"]["tension"]["value"])
