# SPDX-License-Identifier: GPL-2.0-or-later
"""create_cement ... points later: condensed bonds have no points until they are activated, and nothing else changes."""
import csv
import re
from pathlib import Path

import numpy as np
import pytest
from scenes import CONTACT, cement, dump, edit, launch, pair, pull, restarted, run, thermo
from test_stiffness_command import rows_of

ROOT = Path(__file__).parents[2]
AWAKE = "f_cem[24]"
SKEW = dict(direction=(0.36, -0.48, 0.8), half_box=(0.02, 0.02, 0.02))
FLAT = "outer 1.5e-3 inner 0.3e-3"


def scene(points, words="condense yes", axis="radial", shape="flat", size=FLAT, **options):
    """Two grains; `points`: now or later."""
    text = edit(
        pair(1e-4, gap=2e-4, shape=shape, cement=f"{size} points {points}", **options),
        "group        grains type 1\n",
        "group        grains type 1\nset atom 2 diameter 0.0097\n",
    )
    return text + cement(2e-4, 4e-9, axis=axis, damage=f"damage tensor B0 9.6e3 cutoff 0.9 check 10 {words}")


COLUMNS = ["f_bond", AWAKE] + [f"f_cem[{k}]" for k in range(1, 24) if k != 12] + [f"f_bond[{k}]" for k in range(1, 35)]


@pytest.mark.parametrize("shape, size", [("flat", FLAT), ("coating", "thickness 3e-4 cap 25")])
def test_through_failure(shape, size, tmp_path, figures):
    """What the tables say of a bond is the same without its points, and when they are made. It is activated a step later."""
    found = {}
    for points in ("now", "later"):
        text = scene(points, shape=shape, size=size, **SKEW) + pull(0.5, 8e-6, SKEW["direction"]) + thermo(5, COLUMNS + ["atoms"])
        found[points] = run(text + "run 2600\n", tmp_path / points).table()
    now, later = found["now"], found["later"]
    wakes = [int(np.argmax(t[AWAKE] > 0)) for t in (now, later)]
    assert 10 < wakes[0] <= wakes[1] <= wakes[0] + 1, wakes
    assert (later["atoms"][: wakes[1]] == 2).all() and (later["atoms"][wakes[1] :] == now["atoms"][-1]).all() and (now["atoms"] == now["atoms"][0]).all()
    assert now["f_cem[2]"][-1] > 20, "points fail"
    for name in COLUMNS:
        size_of = np.abs(now[name]).max()
        before = np.abs(now[name] - later[name])[: wakes[0]].max()
        assert before <= 1e-9 * size_of, (name, before, size_of)
    alike = now[AWAKE] == later[AWAKE]  # else the force of one is still that of the static fields
    figures.below(f"{shape}: force from the waking on, over its peak", np.abs(now["f_bond"] - later["f_bond"])[alike].max() / now["f_bond"].max(), 1e-4)
    assert abs(now["f_cem[2]"][-1] - later["f_cem[2]"][-1]) <= 2


def test_weight(tmp_path):
    """Gravity of the group of the points acts on cement that has none yet."""
    found = {}
    for points in ("now", "later"):
        text = scene(points, axis="bond") + "fix g calcite gravity 1e6 vector 1 0 -2\nfix hold grains move linear 0 0 0\n"
        found[points] = run(text + thermo(1, ["f_bond[1]", "f_bond[3]", "f_bond[7]", "f_bond[9]"]) + "run 20\n", tmp_path / points).table()
    for name, values in found["now"].items():
        assert found["later"][name] == pytest.approx(values, rel=1e-12), name
    assert abs(found["now"]["f_bond[3]"][-1]) > 0


@pytest.mark.parametrize("boundary, ranks", [("s s s", 1), ("s s s", 2), ("f m s", 2)])
def test_sides_that_follow_the_atoms(boundary, ranks, tmp_path, figures):
    """There is no box beyond the middles of the grains, which are all atoms there are. It grows when the points are made."""
    found = []
    for sides in ("f f f", boundary):
        text = scene("later", boundary=sides) + pull(0.5, 8e-6) + thermo(10, ["f_bond", AWAKE, "f_cem[2]", "atoms"])
        found.append(run(text + "run 1200\n", tmp_path / sides.replace(" ", ""), ranks).table())
    fixed, following = found
    assert following["atoms"][0] == 2 and following[AWAKE][-1] == 1 and following["f_cem[2]"][-1] > 20
    for name in ("atoms", AWAKE, "f_cem[2]"):
        assert (fixed[name] == following[name]).all(), name
    figures.below(
        f"{boundary}, {ranks} ranks: force with a box that grows, over its peak",
        np.abs(fixed["f_bond"] - following["f_bond"]).max() / fixed["f_bond"].max(),
        1e-9,
    )


@pytest.mark.parametrize("at", [300, 770, 900])
def test_restart(at, tmp_path):
    """Without points, when they are asked for, and with them: bitwise identical."""
    script = scene("later", half_box=(6e-3, 6e-3, 12.5e-3)) + pull(0.5, 8e-6)
    columns = ["f_bond", AWAKE, "f_cem[2]", "f_cem[5]", "f_cem[6]", "f_cem[7]"]
    whole = run(script + thermo(10, columns) + f"run {at}\nwrite_restart r\nrun 700\n", tmp_path, 2).table()
    again = run(restarted("r") + script[script.index("timestep") :] + thermo(10, columns) + "run 700\n", tmp_path, 2, name="in.again").table()
    rows = len(again["step"])
    assert again[AWAKE][-1] == 1
    for name in columns:
        assert (whole[name][-rows:] == again[name]).all(), name


def test_no_condensed_bonds(tmp_path):
    """Where bonds need their points, `points all` makes them at the start: the run is that of `points now`, bitwise."""
    tables = {}
    for points in ("now", "later"):
        for word in ("condense no", "condense yes cracks split", "condense yes"):
            axis = "global 1 2 3" if word == "condense yes" else "radial"
            t = run(
                scene(points, word, axis) + "fix_modify cem points all\n" + pull(0.5, 2e-7) + thermo(20, ["f_bond", AWAKE, "atoms"]) + "run 200\n",
                tmp_path / points,
            ).table()
            tables[points, word] = t
    for (points, word), t in tables.items():
        for name, values in t.items():
            assert (values == tables["now", word][name]).all(), (word, name)
        assert t["atoms"][0] > 1000


def test_all_points(tmp_path):
    """`fix_modify ... points all` makes them at their present positions: files of points and the stiffness are those of `points now`."""
    for points in ("now", "later"):
        text = (
            scene(points, **SKEW)
            + "velocity first set 0.01 0.02 0\nvelocity second set 0.03 0.01 0.01\nset group second omegaz 40\nfix motion grains nve/sphere\n"
        )
        run(text + f"run 200\nbond_stiffness {points}.csv\nfix_modify cem points all\nrun 0\nwrite_cement {points}.txt\n", tmp_path)
    now, later = (np.loadtxt(tmp_path / f"{points}.txt", skiprows=3) for points in ("now", "later"))
    assert now.shape == later.shape and len(now) > 1000
    assert np.abs(now - later).max(axis=0) == pytest.approx(0, abs=1e-12)
    now, later = (rows_of(tmp_path / f"{points}.csv")[0] for points in ("now", "later"))
    for name, value in now.items():
        if isinstance(value, float):
            assert later[name] == pytest.approx(value, rel=1e-7, abs=1e-9 * abs(now["k33"])), name


def test_history_of_contacts(tmp_path):
    """Two more beads slide on each other, on two ranks. Points that are made take the indices of ghosts; the contact still knows its history."""
    found = {}
    for points in ("now", "later"):
        text = edit(
            pair(1e-4, gap=2e-4, cement=f"{FLAT} points {points}", half_box=(0.012, 0.02, 0.0125), processors="2 1 1"),
            "set          type 1 diameter",
            "create_atoms 1 single -0.004995 0.0125 0 units box\ncreate_atoms 1 single 0.004995 0.0125 0 units box\nset          type 1 diameter",
        )
        text += CONTACT + cement(2e-4, 4e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9 check 10 condense yes") + pull(0.5, 8e-6)
        text += (
            "group slides id 4\ngroup stays id 3\nfix slides slides move linear 0 0.05 0\nfix stays stays move linear 0 0 0\n" "compute t stays reduce sum fy\n"
        )
        found[points] = run(text + thermo(10, ["c_t", AWAKE, "atoms"]) + "run 800\n", tmp_path / points, 2).table()
    now, later = found["now"], found["later"]
    assert later[AWAKE][-1] == 1 and later["atoms"][0] == 4 and later["atoms"][-1] > 1000
    assert abs(now["c_t"][-1]) > 1.2 * abs(now["c_t"][np.argmax(now[AWAKE] > 0)]) > 0
    assert later["c_t"] == pytest.approx(now["c_t"], rel=1e-9)


def packing(points, directory, ranks, steps=450):
    script = edit((ROOT / "examples" / "packing" / "in.packing").read_text(), "spacing 4e-4\n", f"spacing 4e-4 points {points}\n")
    result = launch(script, directory, ranks, arguments=["-var", "condense", "yes", "-var", "side", "3", "-var", "steps", str(steps), "-var", "record", "50"])
    assert result.status == 0 and not result.errors(), result.output[-2000:]
    with open(directory / "bond.csv") as f:
        rows = list(csv.DictReader(f))
    lines = [line.split() for line in result.output.splitlines() if re.fullmatch(r"( +\S+){7} *", line)]
    return rows, np.array([float(w[2]) for w in lines if w[0].isdigit()]), result.output


def test_packing(tmp_path):
    """Free beads with many bonds, contacts with a history, ranks: the same bonds are activated and separate by the same steps."""
    rows, force = {}, {}
    for points, ranks in (("now", 2), ("later", 1), ("later", 2), ("later", 4)):
        (tmp_path / f"{points}{ranks}").mkdir()
        rows[points, ranks], force[points, ranks], output = packing(points, tmp_path / f"{points}{ranks}", ranks)
    for a, b in zip(rows["now", 2], rows["later", 2]):
        assert (a["step"], a["bond"], a["separated"], a["mode"]) == (b["step"], b["bond"], b["separated"], b["mode"])
    peak = int(np.argmax(force["now", 2]))
    assert np.abs(force["later", 2] - force["now", 2])[: peak + 1].max() < 2e-3 * force["now", 2][peak]
    for ranks in (1, 4):  # beads have other IDs then
        assert [(r["step"], r["separated"]) for r in rows["later", ranks]].count(("400", "1")) == [(r["step"], r["separated"]) for r in rows["later", 2]].count(
            ("400", "1")
        )
        assert np.abs(force["later", ranks] - force["later", 2]).max() < 1e-6 * force["now", 2][peak], ranks
    assert any(float(r["separated"]) > 0 for r in rows["now", 2])


BAD = {
    "neither": (f"{FLAT} points later", f"{FLAT} points soon", ["create_cement", "points", "soon", "later"]),
    "a file without points": ("run 1\n", "run 1\nwrite_cement a.txt\n", ["write_cement", "grains 1 and 2", "no points yet", "'points all'", "'run 0'"]),
    "another group": (
        "fix          cem calcite mpm",
        "group other type 2\nfix          cem other mpm",
        ["fix mpm (id cem)", "grains 1 and 2", "made later", "'other'"],
    ),
    "a fix that would move them": ("run 1\n", "fix move all nve/sphere\nrun 1\n", ["fix mpm (id cem)", "'move' (nve/sphere)", "grains 1 and 2", "made later"]),
    "bonds that are not condensed": (
        "condense yes",
        "condense no",
        ["fix mpm (id cem)", "grains 1 and 2", "'points later'", "'condense no'", "'fix_modify ... points all'"],
    ),
    "nodes that split": ("condense yes", "condense yes cracks split", ["fix mpm (id cem)", "'points later'", "'cracks split'", "'cracks bonds'"]),
    "axes of the box": ("axis radial", "axis global 0 0 1", ["fix mpm (id cem)", "'points later'", "'axis global 0 0 1'", "'axis bond'"]),
    "overlap with those before": (
        "timestep     4e-09\n",
        "create_cement calcite pair 1 3 shape flat outer 1.5e-3 inner auto spacing 1e-4\ntimestep     4e-09\n",
        ["overlaps that of grains 1 and 2"],
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_message(name, tmp_path):
    old, new, needed = BAD[name]
    text = scene("later", **SKEW)
    if "overlap" in name:  # a coating all around the first grain, and a third grain behind that
        place = " ".join(f"{-c * 0.0153}" for c in SKEW["direction"])
        text = edit(
            scene("later", shape="coating", size="thickness 2.4e-4 cap 180", **SKEW),
            "set          type 1 diameter",
            f"create_atoms 1 single {place} units box\nset          type 1 diameter",
        )
    text += "" if "move" in name else "fix hold grains move linear 0 0 0\n"
    result = launch(edit(text + "run 1\n", old, new), tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    missing = [word for word in needed if word not in result.errors()[0]]
    assert not missing, result.errors()[0]


def test_a_bond_that_cannot_be_condensed(tmp_path):
    """Its free edge is connected by almost nothing. The message names it, and its cure works."""

    def script(points):
        return (
            pair(1.5e-4, cement=f"inner 1e-3 outer 1.7e-3 points {points}")
            + cement(3e-4, 4e-9, axis="radial", damage="damage tensor B0 9.6e4 cutoff 0.9 edge free condense yes")
            + "fix hold grains move linear 0 0 0\nrun 1\n"
        )

    result = launch(script("later"), tmp_path / "later", 2)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    missing = [
        word
        for word in ("fix mpm (id cem)", "bond of grains 1 and 2", "are connected by almost nothing", "'points now' or 'overlap skip' of create_cement")
        if word not in result.errors()[0]
    ]
    assert not missing, result.errors()[0]
    assert "1 stay resolved, since pieces of them are connected by almost nothing: of grains 1 and 2\n" in run(script("now"), tmp_path / "now", 2).output


@pytest.mark.parametrize("direction", [(0, 0, 1), (0.36, -0.48, 0.8)])
def test_points_of_a_run_move_between_their_grains(direction, tmp_path, figures):
    """Points that are made when a run starts have the motion that create_cement would have given them."""
    motion = "group moved id 2\nvelocity moved set 1.0 0.3 -0.5\nset atom 2 omegax 300 omegay 100\nset atom 1 omegaz -200\n"
    points = {}
    for word in ("now", "later"):
        text = edit(scene(word, "condense no", direction=direction, half_box=(0.02, 0.02, 0.02)), "create_cement", motion + "create_cement")
        text += "fix_modify cem points all\nfix motion grains nve/sphere\n" + dump(1, ["x", "y", "z", "vx", "vy", "vz"]) + "run 0\n"
        p = run(text, tmp_path / word).points(0)
        points[word] = np.array([p[c] for c in ("x", "y", "z", "vx", "vy", "vz")])
    a, b = (p[:, np.lexsort(np.round(p[:3] / 1e-6))] for p in (points["now"], points["later"]))
    figures.below(f"{direction}: places of points made later against those made now, m", abs(a[:3] - b[:3]).max(), 1e-15)
    figures.below(f"{direction}: velocities of points made later against those made now, over the largest", abs(a[3:] - b[3:]).max() / abs(a[3:]).max(), 1e-12)
