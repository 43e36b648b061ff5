# SPDX-License-Identifier: GPL-2.0-or-later
"""What may leave the scene: fragments that are attached to no grain, and grains whose bonds are separated, with their cement.
Their number, mass, momentum and energy are counted, and the run goes on. What is joined stops the run."""
import csv

import numpy as np
import pytest
from scenes import NEIGHBOURS, edit, host, launch, restarted, run, thermo

POINTS, FAILED, IMBALANCE, MOMENTUM, GAP, APART = "f_cem[1]", "f_cem[2]", "f_cem[12]", "f_cem[15]", "f_bond[13]", "f_bond[22]"
LEFT_POINTS, LEFT_MASS, LEFT_MOMENTUM, LEFT_ENERGY = "f_cem[27]", "f_cem[28]", "f_cem[31]", "f_cem[32]"
COLUMNS = ["atoms", GAP, APART, POINTS, FAILED, IMBALANCE, MOMENTUM, LEFT_POINTS, LEFT_MASS, LEFT_MOMENTUM, LEFT_ENERGY, "c_mass"]
DAMPED = "quasistatic 1 0.1"
WEIGHT = "fix weight calcite gravity 20000 vector 1 0 0\n"
DELETE = "delete_atoms group {} compress no\n"


def fixes(more, B0, extra="", couple=""):
    return (
        f"timestep 4e-7\n{extra}"
        f"fix cem calcite mpm cell 4e-4 elastic isotropic 1e8 0.25 damage tensor B0 {B0} check 10 {more}\n"
        f"fix bond grains mpm/couple cem {couple} csv 100 bond.csv\nfix motion grains nve/sphere\n"
        "variable mass atom mass\ncompute mass calcite reduce sum v_mass\n" + thermo(50, COLUMNS)
    )


def scene(more="cracks split", B0=1e5, pull=2.0, side=0.012, high=0.0046, extra="", couple=""):
    """The upper bead of a pair flies up at `pull` and takes cement along, since the bond comes off the lower one first."""
    return (
        host()
        + f"""\
region       box block -0.012 {side} -0.012 0.012 -0.012 {high} units box
create_box   2 box
create_atoms 1 single 0 0 -0.0036 units box
create_atoms 1 single 0 0 0.0036 units box
set          type 1 diameter 0.0072 density 2500
group        grains type 1
"""
        + NEIGHBOURS
        + "create_cement calcite pair 1 2 shape flat outer 1.5e-3 inner auto spacing 2e-4\n"
        + f"group lower id 1\ngroup upper id 2\nvelocity upper set 0 0 {pull}\n"
        + fixes(more, B0, extra, couple)
    )


def check_books(table, figures, name, energy):
    """Returns the rows before and after the first departure. energy: limit of the change of the imbalance over it."""
    after = int(np.flatnonzero(table[LEFT_POINTS])[0])
    lost = table[POINTS][after - 1] - table[POINTS][-1]
    assert lost > 0 and lost == table[LEFT_POINTS][-1]
    missing = table["c_mass"][after - 1] - table["c_mass"][-1]
    figures.below(f"{name}: mass that left against mass that is missing", abs(table[LEFT_MASS][-1] / missing - 1), 2e-14)
    figures.below(f"{name}: imbalance of the energy over the departure", abs(table[IMBALANCE][after] - table[IMBALANCE][after - 1]), energy)
    return after - 1, after


@pytest.mark.parametrize("ranks", [1, 2])
def test_grain_leaves(tmp_path, figures, ranks):
    """A bead flies out of the box with all cement of a bond that is separated, which ranks cut."""
    t = run(scene(DAMPED) + "run 2000\n", tmp_path, ranks).table()
    before, _ = check_books(t, figures, f"{ranks} ranks", 6e-10)
    assert t["atoms"][-1] == 1 and t[POINTS][-1] == 0 and t[APART][-1] == 1 and t[GAP][-1] == 0
    figures.below(f"{ranks} ranks: momentum that left against that before", abs(t[LEFT_MOMENTUM][-1] / t[MOMENTUM][before] - 1), 1e-4)
    with open(tmp_path / "bond.csv") as f:
        rows = list(csv.DictReader(f))
    assert len(rows) == 21 and not any(v in ("nan", "inf", "-nan", "-inf") for v in rows[-1].values()) and float(rows[-1]["points"]) == 0


@pytest.mark.parametrize(
    "more, couple, energy",
    [
        ("cracks split", "", 1.3e-5),
        ("cracks split subcycle 2", "", 2e-5),
        ("cracks split", "friction 0.3", 1.3e-4),
        ("condense yes", "", 4e-15),
        ("condense yes cracks split", "", 4e-15),
    ],
)
def test_what_is_connected_to_the_other_grain_stays(tmp_path, figures, more, couple, energy):
    t = run(scene(more, couple=couple) + "run 2000\n", tmp_path).table()
    check_books(t, figures, f"{more} {couple}", energy)
    assert t["atoms"][-1] == 1 + t[POINTS][-1] > 1


@pytest.mark.parametrize("ranks", [1, 2])
def test_fragments_leave(tmp_path, figures, ranks):
    """What failed falls out of the box sideways. What is connected to the beads stays."""
    t = run(scene(side=0.0025, high=0.012, extra=WEIGHT) + "run 2000\n", tmp_path, ranks).table()
    check_books(t, figures, f"{ranks} ranks", 3e-5)
    figures.below(f"{ranks} ranks: imbalance of the energy, with nodes that split later", max(abs(t[IMBALANCE])), 1e-3)
    assert t["atoms"][-1] == 2 + t[POINTS][-1] and 0 < t[POINTS][-1] and t[GAP][-1] > 0


@pytest.mark.parametrize("couple, ranks", [("", 1), ("friction 0.3", 2)])
def test_goes_on_from_a_file(tmp_path, couple, ranks):
    """A run goes on bitwise identically after a departure, and before one that is still to come."""
    for first in (600, 1500):
        a = run(scene(side=0.0025, extra=WEIGHT, couple=couple) + f"run {first}\nwrite_restart middle.restart\nprint MIDDLE\nrun 800\n", tmp_path, ranks)
        b = run(restarted("middle.restart") + fixes("cracks split", 1e5, WEIGHT, couple) + "run 800\n", tmp_path, ranks, name="in.continued")
        rows = [
            [line for line in text.splitlines() if line.split()[:1] and line.split()[0].isdigit() and len(line.split()) == 1 + len(COLUMNS)]
            for text in (a.output.split("MIDDLE")[-1], b.output)
        ]
        assert len(rows[0]) == 17 and rows[0] == rows[1]
        assert float(rows[0][-1].split()[1 + COLUMNS.index(LEFT_POINTS)]) > 0


def test_leaves_a_periodic_box(tmp_path, figures):
    """A pair whose cement goes through a periodic side, so that two ranks have it, leaves as one in the middle of a fixed box does."""
    script = edit(scene(couple="friction 0.3", side=0.006), "-0.012 0.006 -0.012", "-0.006 0.006 -0.012")
    t = run(script.replace("boundary     f f f", "boundary     p f f").replace("single 0 0", "single 0.0055 0 ") + "run 1500\n", tmp_path, 2).table()
    check_books(t, figures, "periodic", 1.3e-4)
    whole = run(scene(couple="friction 0.3") + "run 1500\n", tmp_path).table()
    assert all(t[c][-1] == whole[c][-1] for c in (POINTS, FAILED, LEFT_POINTS, "atoms"))
    figures.below("energy that left against that in a fixed box", abs(t[LEFT_ENERGY][-1] / whole[LEFT_ENERGY][-1] - 1), 1.3e-10)


@pytest.mark.parametrize("more, side, limit", [("cracks split balance yes", 0.0025, 1e-3), ("kinematics updated", 0.0025, 1.5e-3)])
def test_fragments_of_other_runs(tmp_path, figures, more, side, limit):
    """Fragments leave while points go to other ranks, and with points that move through the grid."""
    t = run(scene(more, side=side, high=0.012, extra=WEIGHT) + "run 1500\n", tmp_path, 2).table()
    check_books(t, figures, more, 9e-5 if "updated" not in more else 9e-4)
    figures.below(f"{more}: imbalance of the energy", max(abs(t[IMBALANCE])), limit)


def test_updated_grain_leaves(tmp_path, figures):
    """A grain that is deleted takes the cement that is connected to it along, with `kinematics updated`."""
    t = run(scene("kinematics updated", B0=3e5) + "run 1500\n" + DELETE.format("upper") + "run 100\n", tmp_path, 2).table()
    check_books(t, figures, "updated", 3.8e-8)
    assert t["atoms"][-1] == 1 + t[POINTS][-1] and t[FAILED][0] < t[POINTS][0]


# name: (commands, points that are left of those there were)
DELETIONS = {
    "a grain": (DELETE.format("upper"), lambda n: 0 < n < 464),
    "both grains": (DELETE.format("grains"), lambda n: 0 < n < 464),
    "the cement of a separated bond": (DELETE.format("calcite"), lambda n: n == 0),
    "a grain, and cement with it": (
        "region r block INF INF INF INF 2e-4 INF units box\ngroup r region r\ngroup gone union r upper\n" + DELETE.format("gone"),
        lambda n: 0 < n < 464,
    ),
    "all": ("group gone union calcite grains\n" + DELETE.format("gone"), lambda n: n == 0),
    "a grain before a file": (DELETE.format("upper") + "write_restart some.restart\n", lambda n: 0 < n < 464),
}


@pytest.mark.parametrize("name", DELETIONS)
def test_deleted(tmp_path, figures, name):
    commands, is_right = DELETIONS[name]
    t = run(scene() + "run 300\n" + commands + "run 100\n", tmp_path).table()
    lost = t[LEFT_POINTS][-1]
    assert is_right(t[POINTS][-1]) and lost + t[POINTS][-1] == t[POINTS][0]
    figures.below(f"{name}: mass that left against mass that is missing", abs(t[LEFT_MASS][-1] / (t["c_mass"][0] - t["c_mass"][-1]) - 1), 2e-14)
    end = list(t["step"]).index(300)
    # the row at the end of the run, and that of the set-up of the next
    figures.below(f"{name}: imbalance of the energy over the departure", abs(t[IMBALANCE][end + 1] - t[IMBALANCE][end]), 6e-6)


def test_pair_deleted_before_it_breaks(tmp_path):
    run(
        scene(pull=0.0) + "run 50\ngroup gone union calcite grains\n" + DELETE.format("gone") + "run 50\nthermo_style one\nunfix bond\nunfix cem\nrun 50\n",
        tmp_path,
    )


def test_pair_without_points_deleted(tmp_path):
    """Cement that has no points yet leaves with both its grains."""
    script = edit(scene("condense yes", pull=0.0), "spacing 2e-4", "spacing 2e-4 points later")
    t = run(script + "run 50\n" + DELETE.format("grains") + "run 50\n", tmp_path, 2).table()
    assert t["atoms"][-1] == 0 and t[POINTS][-1] == 0 and t[LEFT_POINTS][-1] == t[POINTS][0] > 0


def test_mesh_deletes_grains(tmp_path):
    """A fix that deletes atoms takes the cement of a separated bond with them, wherever it stands among the fixes."""
    (tmp_path / "lid.stl").write_text(
        "solid lid\n"
        + "".join(
            "facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} 0.0042\n" for x, y in corners) + "endloop\nendfacet\n"
            for corners in (((-0.01, -0.01), (0.01, -0.01), (0.01, 0.01)), ((-0.01, -0.01), (0.01, 0.01), (-0.01, 0.01)))
        )
        + "endsolid lid\n"
    )
    lid = "fix lid all mesh/surface file lid.stl type 1\n" "fix count grains massflow/mesh mesh lid vec_side 0 0 1 count once delete_atoms yes\n"
    t = run(scene(high=0.012) + lid + "run 2000\n", tmp_path).table()
    assert t["atoms"][-1] == 1 + t[POINTS][-1] and t[LEFT_POINTS][-1] > 0


# name: (script, words of the message)
STOPS = {
    "joined grain leaves": (
        scene(B0=1e12, pull=2.0, high=0.0037, extra="") + "velocity lower set 0 0 2\nrun 2000\n",
        ["grain 2", "is lost at step", "larger box"],
    ),
    "joined grain deleted": (scene(B0=1e12, pull=0.0) + "run 50\n" + DELETE.format("upper") + "run 50\n", ["grain 2", "not separated", "keep"]),
    "attached points deleted": (
        scene()
        + "run 300\nregion r block 0 INF INF INF INF INF units box\ngroup r region r\ngroup gone subtract r grains\n"
        + DELETE.format("gone")
        + "run 50\n",
        ["are connected to grains which stay", "cannot"],
    ),
    "stiffness before the next run": (scene() + "run 300\n" + DELETE.format("upper") + "bond_stiffness bonds.csv\n", ["grain 2", "'run 0'", "separated"]),
    "attached points leave": (
        scene(side=0.001, B0=1e12, pull=0.0, extra="fix weight calcite gravity 2e7 vector 1 0 0\n").replace("-0.012 0.001", "-0.012 0.00155") + "run 2000\n",
        ["material point", "left the simulation box", "larger"],
    ),
}


@pytest.mark.parametrize("name", STOPS)
def test_stops(tmp_path, name):
    script, words = STOPS[name]
    result = launch(script, tmp_path)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-2000:]
    assert all(w in result.errors()[0] for w in ["fix mpm (id cem)", *words]), result.errors()


def test_cures(tmp_path):
    """`run 0` lets commands follow deletions, and deletions a file."""
    run(scene() + "run 300\nwrite_restart some.restart\n" + DELETE.format("upper") + "run 0\nbond_stiffness bonds.csv\n", tmp_path)
    run(restarted("some.restart") + "group upper id 2\n" + fixes("cracks split", 1e5) + "run 0\n" + DELETE.format("upper") + "run 10\n", tmp_path)
