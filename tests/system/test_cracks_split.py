# SPDX-License-Identifier: GPL-2.0-or-later
"""Nodes that split where a crack runs through the cement (`cracks split`): ranks, restart, momentum, energy, and that nothing pulls across."""
import shutil

import numpy as np
import pytest
from scenes import MOMENTA, MOMENTUM_COLUMNS, cement, dump, edit, in_cells, launch, pair, point_quantities, pull, restarted, run, shift, thermo
from test_point_file import read, write

CELL, ASKEW = 3e-4, (0.3, -0.2, 1.0)
BOND = dict(direction=ASKEW, shape="flat", cement="inner 1e-3 outer 2.2e-3", half_box=3 * (12.5e-3,))
DAMAGE = "damage tensor B0 9.6e4 cutoff 0.9 cracks split"
BEFORE, AFTER, EVERY = 188, 328, 4
COLUMNS = ["id", "x", "y", "z", "vx", "vy", "vz", "c_damage", "c_failed", "c_stress_zz"]
OUTPUT = point_quantities(["damage", "failed", "stress_zz"])
SCALARS = ["f_bond", "f_bond[4]", "f_bond[17]", "f_bond[18]", "f_bond[22]", "f_cem[8]", "f_cem[12]"]


def pulled(words=""):
    return cement(CELL, 8e-9, axis="radial", damage=f"{DAMAGE} {words}") + pull(3.0, 2e-6, ASKEW) + OUTPUT + thermo(EVERY, SCALARS)


def script(processors="* * *"):
    return (
        pair(CELL / 2, processors=processors, **BOND)
        + pulled()
        + f"run {BEFORE}\nwrite_restart middle.restart\n"
        + dump(BEFORE + AFTER, COLUMNS[1:])
        + f"run {AFTER}\n"
    )


@pytest.fixture(scope="module")
def one_rank(tmp_path_factory):
    return run(script(), tmp_path_factory.mktemp("one_rank"))


def test_nothing_pulls_across(one_rank, figures):
    t = one_rank.table()
    apart = np.argmax(t["f_bond[22]"] > 0)
    assert t["f_bond[18]"][BEFORE // EVERY] > 50 and BEFORE < EVERY * apart < BEFORE + AFTER - 100, EVERY * apart
    force = t["f_bond"][apart:]
    figures.below("cracks split: mean force after the bond came apart, over the peak", abs(force.mean()) / t["f_bond"].max(), 0.01)
    figures.below("cracks split: energy imbalance through failure", abs(t["f_cem[12]"][10:]).max(), 0.01)


@pytest.mark.parametrize("ranks, processors", [(2, "1 1 2"), (4, "2 2 1")])
def test_same_on_ranks(one_rank, tmp_path, figures, ranks, processors):
    other = run(script(processors), tmp_path, ranks)
    a, b = one_rank.table(), other.table()
    assert a["f_bond[18]"][-1] > 500 and (a["f_bond[18]"] == b["f_bond[18]"]).all() and (a["f_bond[22]"] == b["f_bond[22]"]).all()
    figures.below(
        f"cracks split, {ranks} ranks cut {processors}: bond force against 1 rank, over the peak",
        (abs(a["f_bond"] - b["f_bond"]) / a["f_bond"].max()).max(),
        1e-12,
    )
    p, q = one_rank.points(BEFORE + AFTER), other.points(BEFORE + AFTER)
    figures.below(
        f"cracks split, {ranks} ranks: points failed on one and not the other, of {p['c_failed'].sum():.0f}", (p["c_failed"] != q["c_failed"]).sum(), 0
    )


def test_hat_functions_on_ranks(tmp_path, figures):
    """The added mass depends on the eigenvalue, which is found anew where nodes split: of whole bonds, whichever rank has them."""
    tables = {
        n: run(pair(CELL / 2, processors=processors, **BOND) + edit(pulled(), "mpm cell", "mpm basis linear cell") + "run 420\n", tmp_path / str(n), n).table()
        for n, processors in ((1, "* * *"), (2, "1 1 2"))
    }
    one, two = tables.values()
    assert one["f_bond[18]"][-1] > 300 and (one["f_bond[18]"] == two["f_bond[18]"]).all()
    figures.below(
        "linear basis, nodes that split, 2 ranks: bond force against 1 rank, over the peak",
        abs(one["f_bond"] - two["f_bond"]).max() / one["f_bond"].max(),
        7e-13,
    )


@pytest.mark.parametrize("off", ["7.5e-5 0 0", "0 7.5e-5 7.5e-5"])
def test_points_on_faces_of_cells(tmp_path, figures, off):
    """The grid is half a spacing off, so that points lie where the supports of nodes end: phantom nodes may have no more of them than rounding."""
    t = run(pair(CELL / 2, **{**BOND, "cement": f"inner 1e-3 outer 2.2e-3 grid {off}"}) + pulled() + f"run {BEFORE + AFTER}\n", tmp_path).table()
    assert t["f_bond[18]"][-1] > 500 and t["f_bond[22]"][-1] == 1
    figures.below(f"cracks split, grid {off} off: energy imbalance through failure", abs(t["f_cem[12]"][10:]).max(), 0.01)


def test_nonlocal_on_ranks(tmp_path, figures):
    """Averages meet split nodes: one rank changes them in place, two lay out the bond that they share anew."""
    tables, events = [], []
    for ranks, processors in ((1, "* * *"), (2, "1 1 2")):
        words = f"regularization nonlocal {CELL} events events.csv"
        done = run(pair(CELL / 2, processors=processors, **BOND) + pulled(words) + "run 560\n", tmp_path / str(ranks), ranks)
        tables.append(done.table())
        events.append(sorted((tmp_path / str(ranks) / "events.csv").read_text().splitlines()))
    a, b = tables
    assert len(events[0]) > 500 and a["f_bond[22]"][-1] == 1
    assert [line.split(",")[:3] for line in events[0]] == [line.split(",")[:3] for line in events[1]]
    figures.below("cracks split and nonlocal, 2 ranks against 1: bond force over the peak", abs(a["f_bond"] - b["f_bond"]).max() / a["f_bond"].max(), 1e-12)


MENISCUS = dict(shape="meniscus", cement="neck 1.6e-3 inner 8e-4")


@pytest.mark.parametrize(
    "bond, cell, dt, words, speed, steps",
    [
        (BOND, CELL, 8e-9, f"{DAMAGE} regularization nonlocal {CELL}", 3.0, 700),
        (BOND, CELL, 8e-9, f"{DAMAGE} quasistatic 1 0.2", 3.0, 600),
        (MENISCUS, 2e-4, 1.2e-8, "damage tensor B0 9.6e6 cutoff 0.9 viscosity 1e-6 cracks split", 12.0, 1000),
    ],
    ids=["flat", "damped", "meniscus"],
)
@pytest.mark.parametrize("ranks, processors", [(1, "* * *"), (2, "1 1 2")])
def test_failed_points_without_nodes(tmp_path, figures, bond, cell, dt, words, speed, steps, ranks, processors):
    """Blocks whose points have all failed have aliases of nodes. With `skip failed no` they have nodes of their own, and go through the pass. In the
    meniscus intact points join such blocks again."""
    found = []
    for skip in ("yes", "no"):
        found.append(
            run(
                pair(cell / 2, processors=processors, **bond)
                + cement(cell, dt, axis="radial", damage=f"{words} skip failed {skip}")
                + pull(speed, 2e-6, bond.get("direction", (0, 0, 1)))
                + OUTPUT
                + thermo(EVERY, SCALARS)
                + dump(steps, COLUMNS[1:4])
                + f"run {steps}\n",
                tmp_path / skip,
                ranks,
            )
        )
    p, q = (done.points(steps) for done in found)
    t, u = (done.table() for done in found)
    assert t["f_bond[18]"][-1] > 500 and (t["f_bond[22]"] == u["f_bond[22]"]).all()
    name = f"cracks split, {bond['shape']}{', damped' if 'quasistatic' in words else ''}, {ranks} ranks"
    figures.below(
        f"{name}: place of points that failed, with and without nodes of their own, over the cell", max(abs(p[c] - q[c]).max() for c in "xyz") / cell, 2e-11
    )
    figures.below(f"{name}: bond force with and without nodes of failed points, over the peak", abs(t["f_bond"] - u["f_bond"]).max() / t["f_bond"].max(), 6e-12)


@pytest.mark.parametrize("cracks", ["split", "bonds"])
def test_damped_sides_on_ranks(tmp_path, figures, cracks):
    """Each side of a separated bond is damped against its own grain. Which nodes these are does not depend on ranks."""
    tables = []
    for ranks, processors in ((1, "* * *"), (2, "1 1 2")):
        words = f"{DAMAGE} quasistatic 1 0.1".replace("cracks split", f"cracks {cracks}")
        tables.append(
            run(
                pair(CELL / 2, processors=processors, **BOND)
                + cement(CELL, 8e-9, axis="radial", damage=words)
                + pull(3.0, 2e-6, ASKEW)
                + OUTPUT
                + thermo(EVERY, SCALARS)
                + "run 900\n",
                tmp_path / str(ranks),
                ranks,
            ).table()
        )
    a, b = tables
    assert a["f_bond[22]"][-1] == 1 and (a["f_bond[22]"] == b["f_bond[22]"]).all()
    figures.below(f"cracks {cracks}, damped: bond force on 2 ranks against 1, over the peak", abs(a["f_bond"] - b["f_bond"]).max() / a["f_bond"].max(), 1e-12)


def test_strain_of_failed_points_while_condensed(tmp_path, figures):
    """Points that failed in a file have no nodes of their own. What is shown of them while the bond is condensed, and after it was activated, is that of those that have."""
    cell, steps, columns = 2e-4, 400, ["strain_xx", "strain_zz", "axis_x", "axis_z"]
    bond = dict(gap=4e-4, shape="flat")
    run(pair(cell / 2, cement="inner 0 outer 1.5e-3", **bond) + "write_cement cement.txt\n", tmp_path / "made")
    points = read(tmp_path / "made" / "cement.txt")
    points["failed"] = ((abs(points["z"]) < 0.6 * cell) & (points["x"] < 0.0)).astype(float)
    assert points["failed"].sum() > 300
    found = []
    for skip in ("yes", "no"):
        (tmp_path / skip).mkdir()
        write(tmp_path / skip / "cement.txt", points)
        words = f"damage tensor B0 9.6e4 cutoff 0.9 cracks split condense yes wake 0.02 skip failed {skip}"
        made = edit(pair(cell / 2, cement="inner 0 outer 1.5e-3", **bond), "shape flat inner 0 outer 1.5e-3 film grid", "file cement.txt")
        found.append(
            run(
                made
                + cement(cell, 4e-9, axis="radial", damage=words)
                + pull(0.5, 2e-6)
                + point_quantities(["failed"] + columns)
                + thermo(4, ["f_bond", "f_cem[24]"])
                + dump(20, ["c_failed"] + [f"c_{c}" for c in columns])
                + f"run {steps}\n",
                tmp_path / skip,
            )
        )
    awake = found[0].table()["f_cem[24]"]
    assert awake[5] == 0 and awake[-1] == 1
    for step, state in ((20, "condensed"), (steps, "awake again")):
        p, q = (done.points(step) for done in found)
        failed = q["c_failed"] > 0
        for name in ("strain", "axis"):
            of = [f"c_{c}" for c in columns if c.startswith(name)]
            worst = max(abs(p[c] - q[c])[failed].max() for c in of) / max(abs(q[c])[failed].max() for c in of)
            figures.below(f"{state}: {name} of points that failed, with and without nodes of their own", worst, 1e-8)


@pytest.mark.parametrize(
    "gap, edge, outer, cracked, ranks",
    [(0.0, "", 2e-3, True, 1), (0.0, "", 2e-3, True, 2), (2e-4, "edge free", 2e-3, True, 1), (0.0, "edge free", 1.7e-3, False, 1)],
)
def test_what_holds_by_almost_nothing_stays_resolved(tmp_path, gap, edge, outer, cracked, ranks):
    """Points of a ring failed in a file, or its edge is free. Where nodes hold by almost nothing, statics moves them by metres: such a bond is not condensed.

    The last one has its fields, but they make it 19 times as heavy as it is.
    """
    cell, cem, bond = 3e-4, f"inner 1e-3 outer {outer}", dict(shape="flat")
    if gap:
        bond["gap"] = gap
    run(pair(cell / 2, cement=cem, **bond) + "write_cement cement.txt\n", tmp_path / "made")
    points = read(tmp_path / "made" / "cement.txt")
    points["failed"] = ((abs(points["z"]) < 0.6 * cell) & (points["x"] < -1e-3) & cracked).astype(float)
    assert not cracked or 100 < points["failed"].sum() < 0.5 * len(points["failed"])
    found, ring = [], bond | dict(processors=f"1 1 {ranks}")
    for condense in ("no", "yes wake 0.3"):
        folder = tmp_path / condense[:2]
        folder.mkdir()
        write(folder / "cement.txt", points)
        words = f"damage tensor B0 9.6e4 cutoff 0.9 cracks split {edge} condense {condense}"
        made = edit(pair(cell / 2, cement=cem, **ring), f"shape flat {in_cells(cem)}", "file cement.txt")
        found.append(
            run(made + cement(cell, 4e-9, axis="radial", damage=words) + pull(0.5, 2e-6) + thermo(10, ["f_bond", "f_cem[24]"]) + "run 600\n", folder, ranks)
        )
    resolved, asked = (done.table()["f_bond"] for done in found)
    assert resolved.max() > 200 and (asked == resolved).all()
    assert (
        "condensed 0 of 1 bonds, with 0 solutions found anew; 1 stay resolved, since pieces of them are connected by almost nothing: of grains 1 and 2"
        in (tmp_path / "ye" / "log.liggghts").read_text()
    )


def test_restart(one_rank, tmp_path, figures):
    shutil.copy(one_rank.directory / "middle.restart", tmp_path)
    other = run(restarted("middle.restart") + pulled() + dump(BEFORE + AFTER, COLUMNS[1:]) + f"run {AFTER}\n", tmp_path)
    p, q = one_rank.points(BEFORE + AFTER), other.points(BEFORE + AFTER)
    different = [c for c in p if (p[c] != q[c]).any()]
    assert not different, different
    for name, column in other.table().items():
        assert (one_rank.table()[name][-AFTER // EVERY - 1 :] == column).all(), name
    figures.note("cracks split, restart while points fail", f"{len(p)} columns bitwise equal")


@pytest.mark.parametrize("ranks, processors", [(1, "* * *"), (2, "1 1 2")])
def test_run_in_parts(tmp_path, figures, ranks, processors):
    """A run of both parts, a run in two, divided where a crack runs, and one from a restart file that was written there."""
    start, again = pair(CELL / 2, processors=processors, **BOND) + pulled(), pulled() + dump(360, COLUMNS[1:])
    whole = run(start + again.replace(pulled(), "") + "run 360\n", tmp_path / "whole", ranks)
    parts = run(start + again.replace(pulled(), "") + "run 173\nwrite_restart middle.restart\nrun 187\n", tmp_path / "parts", ranks)
    (tmp_path / "on").mkdir()
    shutil.copy(tmp_path / "parts" / "middle.restart", tmp_path / "on")
    on = run(restarted("middle.restart") + again + "run 187\n", tmp_path / "on", ranks)
    p, q, r = (done.points(360) for done in (whole, parts, on))
    assert p["c_failed"].sum() > 500 and (p["c_failed"] == q["c_failed"]).all()
    worst = max(abs(p[c] - q[c]).max() / abs(p[c]).max() for c in p)
    figures.below(f"cracks split, {ranks} ranks: points of a run in parts against the run as a whole, over the largest", worst, 1e-12)
    different = [c for c in q if (q[c] != r[c]).any()]
    assert not different, different
    force, forces = parts.table()["f_bond"], on.table()["f_bond"]
    assert (force[-len(forces) + 1 :] == forces[1:]).all()


def test_damping_of_the_sides(tmp_path, figures):
    """A bond that separated under a moving grain rings on; quasistatic damps each side against its own grain."""
    left = {}
    for damping in (0.0, 0.2):
        words = f"quasistatic 1 {damping}"
        t = run(pair(CELL / 2, **BOND) + pulled(words) + "run 1500\n", tmp_path / str(damping)).table()
        apart = np.argmax(t["f_bond[22]"] > 0)
        assert EVERY * apart < 700, EVERY * apart
        left[damping] = abs(t["f_bond"][-100:]).max() / t["f_bond"].max()
    figures.note("cracks split: ringing after the bond came apart, over the peak, without damping", f"{left[0.0]:.2e}")
    figures.below("cracks split: ringing with quasistatic damping, over that without", left[0.2] / left[0.0], 0.1)


def test_other_option(one_rank, tmp_path):
    shutil.copy(one_rank.directory / "middle.restart", tmp_path)
    other = launch(edit(restarted("middle.restart") + pulled() + "run 1\n", "cracks split", "cracks bonds"), tmp_path)
    assert other.status != 0 and "'cracks bonds' but the restart file was written with 'cracks split'" in other.output


@pytest.mark.parametrize("ranks", [1, 2])
def test_momentum(tmp_path, figures, ranks):
    """Free grains fly apart: node splitting keeps momentum and angular momentum."""
    leaving = "velocity second set 0.3 -0.2 1\nfix motion grains nve/sphere\n"
    table = run(
        pair(CELL / 2, **{**BOND, "half_box": 3 * (16e-3,)})
        + cement(CELL, 8e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9 cracks split", couple="kn 2e12 kt 3e11")
        + leaving
        + MOMENTA
        + thermo(20, MOMENTUM_COLUMNS + ["f_bond", "f_bond[17]", "f_bond[22]", "f_cem[12]"])
        + "run 1200\n",
        tmp_path,
        ranks,
    ).table()
    assert table["f_bond[22]"][-1] == 1
    P = np.array([table[c] for c in MOMENTUM_COLUMNS])
    linear, angular = (np.linalg.norm(p - p[:, :1], axis=0).max() for p in (P[:3], P[3:]))
    scale = np.linalg.norm(P[:3, 0])
    figures.below(f"cracks split, {ranks} ranks: drift of momentum", linear / scale, 1e-13)
    figures.below(f"cracks split, {ranks} ranks: drift of angular momentum over momentum and radius", angular / (scale * 5e-3), 6e-14)


def test_momentum_where_supports_end(tmp_path, figures):
    """The grid is half a spacing off: all intact material of a node may lie where its support ends, and the node keeps what failed points left there."""
    table = run(
        pair(CELL / 2, gap=6e-4, cement="outer 1.5e-3 grid 7.5e-5 7.5e-5 0", half_box=3 * (16e-3,))
        + cement(CELL, 2.4e-8, elastic=(6e10, 6e10, 0.2, 0.2, 2.5e10), damage="damage tensor B0 9.6e3 cracks split", couple="kn auto kt auto")
        + "velocity second set 0.1 0.15 0.5\nfix motion grains nve/sphere\n"
        + MOMENTA
        + thermo(1, MOMENTUM_COLUMNS + ["f_bond[18]", "f_bond[22]"])
        + "run 300\n",
        tmp_path,
    ).table()
    assert table["f_bond[18]"][-1] > 900 and table["f_bond[22]"][-1] == 1
    P = np.array([table[c] for c in MOMENTUM_COLUMNS[:3]])
    figures.below("points where supports end: drift of momentum", np.linalg.norm(P - P[:, :1], axis=0).max() / np.linalg.norm(P[:, 0]), 3e-14)


def test_cut_but_for_a_point(tmp_path, figures):
    """A crack through the middle that leaves one point: with shared nodes the bond holds and carries, with split ones it does not."""
    words = "inner 1e-3 outer 2e-3"
    scene = pair(CELL / 2, shape="flat", cement=words)
    run(scene + "write_cement cement.txt\n", tmp_path)
    columns = read(tmp_path / "cement.txt")
    plane = abs(columns["z"]) < CELL / 2
    first = np.flatnonzero(plane)[0]
    bridge = (abs(columns["x"] - columns["x"][first]) < CELL / 8) & (abs(columns["y"] - columns["y"][first]) < CELL / 8)
    force = {}
    for name in ("whole", "bonds", "split"):
        columns["failed"] = (plane & ~bridge & (name != "whole")).astype(float)
        write(tmp_path / name / "cement.txt", columns)
        t = run(
            edit(scene, f"shape flat {in_cells(words)}", "file cement.txt")
            + cement(CELL, 8e-9, axis="radial", damage=f"damage tensor B0 9.6e9 cutoff 0.9 cracks {name.replace('whole', 'bonds')}")
            + shift(1e-9, 2e-6)
            + thermo(5, ["f_bond", "f_bond[22]"])
            + "run 1000\n",
            tmp_path / name,
        ).table()
        force[name] = t["f_bond"][-100:].mean()
        assert t["f_bond[22]"][-1] == (name == "split")
    figures.note("cut but for a point, shared nodes: force over that of the whole bond", f"{force['bonds'] / force['whole']:.4f}")
    figures.below("cut but for a point, split nodes: force over that of the whole bond", abs(force["split"] / force["whole"]), 1e-3)


def test_new_cement_leaves_other_bonds_alone(tmp_path, figures):
    """A bond is made while another one breaks, between two checks for separation."""
    third = "create_atoms 1 single -0.0098 0 -0.003 units box\n"
    scene = edit(pair(CELL / 2, shape="flat", cement="inner 1e-3 outer 2.2e-3", half_box=3 * (15e-3,)), "set          type 1", third + "set          type 1")
    columns = [f"f_bond[1][{n}]" for n in (14, 18)]
    words = (
        cement(CELL, 8e-9, axis="radial", damage=f"{DAMAGE} check 1000")
        + pull(3.0, 2e-6)
        + "group third id 3\nfix third third move linear 0 0 0\n"
        + thermo(1, columns)
    )
    more = f"create_cement calcite pair 1 3 shape flat content 0.005 inner auto spacing {CELL / 2:.15g}\n"
    for cut in (215, 274):
        alone, beside = (run(scene + words + f"run {cut}\n{made}run 60\n", tmp_path / f"{cut}{bool(made)}").table() for made in ("", more))
        failed = alone["f_bond[1][18]"]
        assert failed[cut] > failed[cut - 5] > 0
        assert (failed == beside["f_bond[1][18]"]).all()
        figures.below(
            f"cement made at step {cut}: force of the other bond, over the peak",
            abs(alone["f_bond[1][14]"] - beside["f_bond[1][14]"]).max() / abs(alone["f_bond[1][14]"]).max(),
            1e-12,
        )
