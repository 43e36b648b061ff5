# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds whose shells have nodes of their own on the two sides of the unbonded gap beyond the ring where they meet, until they break.

The bond lies askew in the box. What its stiffness is, test_bond_stiffness.py measures.
"""
import shutil

import numpy as np
import pytest
from scenes import CONTACT, MOMENTA, MOMENTUM_COLUMNS, cement, dump, edit, launch, pair, point_quantities, pull, restarted, run, thermo

CELL, ASKEW = 2e-4, (0.3, -0.2, 1.0)
SHELLS = dict(direction=ASKEW, shape="coating", cement="thickness 4e-4 cap 24 inner 8e-4", half_box=3 * (12.5e-3,))
DAMAGE = "damage tensor B0 9.6e5 cutoff 0.9"
BEFORE, AFTER, EVERY = 600, 200, 4
COLUMNS = ["id", "x", "y", "z", "vx", "vy", "vz", "c_damage", "c_failed", "c_stress_zz"]
OUTPUT = point_quantities(["damage", "failed", "stress_zz"])
SCALARS = ["f_bond", "f_bond[4]", "f_bond[17]", "f_bond[19]", "f_cem[8]", "f_cem[12]"]


def pulled(words=""):
    return cement(CELL, 5e-9, axis="radial", damage=f"{DAMAGE} {words}") + pull(8.0, 4e-6, ASKEW) + OUTPUT + thermo(EVERY, SCALARS)


def script(processors="* * *", words=""):
    return (
        pair(CELL / 2, processors=processors, **SHELLS)
        + CONTACT
        + pulled(words)
        + f"run {BEFORE}\nwrite_restart middle.restart\n"
        + dump(AFTER, COLUMNS[1:])
        + f"run {AFTER}\n"
    )


@pytest.fixture(scope="module")
def one_rank(tmp_path_factory):
    return run(script(), tmp_path_factory.mktemp("one_rank"))


@pytest.mark.parametrize("ranks, processors", [(2, "1 1 2"), (2, "2 1 1"), (4, "2 2 1")])
def test_same_on_ranks(one_rank, tmp_path, figures, ranks, processors):
    other = run(script(processors), tmp_path, ranks)
    a, b = one_rank.table(), other.table()
    difference = abs(a["f_bond"] - b["f_bond"]) / a["f_bond"].max()
    intact, first = np.argmax(a["f_bond[19]"] > 0), np.argmax(a["f_bond[17]"] > 0)
    assert intact > 80 / EVERY and first > 200 / EVERY and a["f_bond[17]"][-1] > 100, (intact, first, a["f_bond[17]"][-1])
    name = f"shells askew, {ranks} ranks cut {processors}"
    figures.below(f"{name}: bond force against 1 rank, over the peak, intact (to step {EVERY * intact})", difference[:intact].max(), 1e-13)
    figures.below(f"{name}: the same up to the first failure (step {EVERY * first})", difference[:first].max(), 8e-13)
    p, q = one_rank.points(BEFORE + AFTER), other.points(BEFORE + AFTER)
    figures.below(f"{name}: points failed on one and not the other, of {p['c_failed'].sum():.0f}", (p["c_failed"] != q["c_failed"]).sum(), 0)


def test_restart(one_rank, tmp_path, figures):
    shutil.copy(one_rank.directory / "middle.restart", tmp_path)
    other = run(restarted("middle.restart") + CONTACT + pulled() + dump(AFTER, COLUMNS[1:]) + f"run {AFTER}\n", tmp_path)
    p, q = one_rank.points(BEFORE + AFTER), other.points(BEFORE + AFTER)
    different = [c for c in p if (p[c] != q[c]).any()]
    assert p["c_failed"].sum() > 100 and not different, different
    for name, column in other.table().items():
        assert (one_rank.table()[name][-AFTER // EVERY - 1 :] == column).all(), name
    figures.note("shells askew, restart while points fail", f"{len(p)} columns bitwise equal")


def test_other_restart_edge(one_rank, tmp_path):
    """Points of a file with an unbonded gap are not run without it."""
    shutil.copy(one_rank.directory / "middle.restart", tmp_path)
    other = launch(restarted("middle.restart") + CONTACT + pulled("edge free") + "run 1\n", tmp_path)
    assert other.status != 0 and "'edge" in other.output


def test_after_it_separated(tmp_path, figures):
    """Free grains fly away; pieces ring, but nothing pulls across the crack, and momenta are kept."""
    leaving = "velocity second set 0.3 -0.2 1\nfix motion grains nve/sphere\n"
    table = run(
        pair(CELL / 2, **{**SHELLS, "half_box": 3 * (16e-3,)})
        + cement(CELL, 5e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9", couple="kn 2e12 kt 3e11")
        + leaving
        + MOMENTA
        + thermo(20, MOMENTUM_COLUMNS + ["f_bond", "f_bond[17]", "f_bond[22]", "f_cem[12]"])
        + "run 4000\n",
        tmp_path,
        ranks=2,
    ).table()
    force = table["f_bond"]
    assert table["f_bond[17]"][-1] > 500 and table["f_bond[22]"][-1] == 1, table["f_bond[17]"][-1]
    assert abs(force[-120:].mean()) < 0.05 * force.max(), force[-120:] / force.max()
    P = np.array([table[c] for c in MOMENTUM_COLUMNS])
    linear, angular = (np.linalg.norm(p - p[:, :1], axis=0).max() for p in (P[:3], P[3:]))
    scale = np.linalg.norm(P[:3, 0])
    figures.below("shells come apart: drift of momentum", linear / scale, 9e-14)
    figures.below("shells come apart: drift of angular momentum over momentum and radius", angular / (scale * 5e-3), 1e-13)
    # of order dt^2; in the first 100 steps there is almost no energy to compare with
    figures.below("shells come apart: energy imbalance", abs(table["f_cem[12]"][5:]).max(), 0.005)


def weakened(directory, file):
    """The shells along z, damaged nearly through next to the first grain, as a file of points."""
    script = pair(CELL / 2, **{**SHELLS, "direction": (0, 0, -1)}) + cement(CELL, 5e-9, axis="radial", damage=DAMAGE)
    run(script + "run 0\nwrite_cement whole.txt\n", directory)
    lines, weak = (directory / "whole.txt").read_text().splitlines(), 0
    head = next(n for n, line in enumerate(lines) if line.startswith("grain_i"))
    columns = lines[head].split()
    for n in range(head + 1, len(lines)):
        words = lines[n].split()
        x = np.array([float(words[columns.index(c)]) for c in "xyz"])
        if np.linalg.norm(x - (0, 0, 5e-3)) < 5e-3 + CELL / 2:
            weak += 1
            for c in ("dxx", "dyy", "dzz"):
                words[columns.index(c)] = "0.88"
        lines[n] = " ".join(words)
    assert weak > 1000
    file.write_text("\n".join(lines) + "\n")


def test_a_side_of_the_gap_on_each_rank(tmp_path, figures):
    """A bond in flight that separates at one grain: nodes of what is left on the other side of the gap come from the other rank."""
    weakened(tmp_path, tmp_path / "weak.txt")
    results = []
    for ranks, processors in ((1, "1 1 1"), (2, "1 1 2")):
        scene = pair(CELL / 2, processors=processors, **{**SHELLS, "direction": (0, 0, -1), "half_box": 3 * (16e-3,)})
        scene = scene[: scene.index("create_cement")] + f"create_cement calcite pair 1 2 file {tmp_path}/weak.txt spacing {CELL / 2:g}\n"
        results.append(
            run(
                scene
                + cement(CELL, 5e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9", couple="kn 2e12 kt 3e11")
                + "velocity all set 100 30 20\nvelocity first set 0 0 1 sum yes\nfix motion grains nve/sphere\n"
                + MOMENTA
                + OUTPUT
                + dump(800, COLUMNS[1:])
                + thermo(5, MOMENTUM_COLUMNS + ["f_bond", "f_bond[17]", "f_bond[22]", "f_cem[12]"])
                + "run 800\n",
                tmp_path / str(ranks),
                ranks,
            )
        )
    one, two = (r.table() for r in results)
    separated = np.argmax(one["f_bond[22]"] > 0)
    assert 10 < separated < 120 and (one["f_bond[22]"] == two["f_bond[22]"]).all() and (one["f_bond[17]"] == two["f_bond[17]"]).all()
    p, q = (r.points(800) for r in results)
    assert (p["c_failed"] == q["c_failed"]).all()
    figures.below("shells part across ranks: difference of the points' velocity, m/s", max(abs(p[c] - q[c]).max() for c in ("vx", "vy", "vz")), 8e-10)
    for ranks, table in ((1, one), (2, two)):
        P = np.array([table[c] for c in MOMENTUM_COLUMNS[:3]])
        figures.below(
            f"shells part across ranks, {ranks} rank(s): drift of momentum", np.linalg.norm(P - P[:, :1], axis=0).max() / np.linalg.norm(P[:, 0]), 2e-14
        )
        figures.below(f"shells part across ranks, {ranks} rank(s): energy imbalance", abs(table["f_cem[12]"]).max(), 1e-4)


@pytest.mark.parametrize("grid", [(0, 0, 0), (2e-5, 0, 5e-5), (2.5e-5, 2.5e-5, 2.5e-5), (5e-5, 5e-5, 5e-5), (1e-4, 0, 0)])
def test_lattice_off_the_grid(tmp_path, figures, grid):
    """Where the lattice lies in the grid is no reason to find gaps in the cement, and does not stiffen it."""
    scene = pair(CELL / 2, **{**SHELLS, "direction": (0, 0, 1)})
    scene = edit(scene, f"spacing {CELL / 2:.15g}\n", f"spacing {CELL / 2:.15g} grid {grid[0]:g} {grid[1]:g} {grid[2]:g}\n")
    tail = pull(4.0, 1e-6) + thermo(20, ["f_bond"]) + "run 200\n"
    force = [
        run(scene + CONTACT + cement(CELL, 5e-9, axis="radial", damage=words) + tail, tmp_path / (words or "tied")).table()["f_bond"][-1]
        for words in ("", "edge free")
    ]
    figures.below(f"shells, lattice {grid} off the grid: force with split nodes against shared nodes", abs(force[0] / force[1] - 1), 0.08)


def full_cells(file, offset, R=5e-3, thickness=4e-4):
    """Points of a lattice of 0.1 mm within the shells, none of them cut."""
    line = (np.arange(-32, 32) + 0.5) * 1e-4
    x, y, z = (a.ravel() for a in np.meshgrid(*(line + o for o in offset), indexing="ij"))
    rho = np.hypot(x, y)
    to = [np.sqrt(rho**2 + (z + side * R) ** 2) for side in (1, -1)]
    shells = [(r < R + thickness) & (rho < r * np.sin(np.pi / 6)) for r in to]
    inside = (to[0] > R) & (to[1] > R) & (rho > 8e-4) & (shells[0] | shells[1])
    file.write_text("x y z volume\n" + "".join(f"{a:.17g} {b:.17g} {c:.17g} 1e-12\n" for a, b, c in zip(x[inside], y[inside], z[inside])))


@pytest.mark.parametrize("offset, spacing", [((0, 0, 0), 1e-4), ((2e-5, 0, 3e-5), 1e-4), ((-1.5e-5,) * 3, 1e-4), ((0, 0, 0), 9.5e-5)])
def test_points_of_a_file(tmp_path, figures, offset, spacing):
    """Points lie anywhere in their cells; with a spacing that is not theirs, empty planes are no gap, and there is a warning."""
    full_cells(tmp_path / "points.txt", offset)
    scene = pair(CELL / 2, half_box=3 * (12.5e-3,))
    scene = scene[: scene.index("create_cement")] + f"create_cement calcite pair 1 2 file {tmp_path}/points.txt spacing {spacing:g}\n"
    tail = pull(4.0, 1e-6) + thermo(20, ["f_bond"]) + "run 200\n"
    runs = [run(scene + CONTACT + cement(CELL, 5e-9, axis="radial", damage=words) + tail, tmp_path / (words or "tied")) for words in ("", "edge free")]
    force = [r.table()["f_bond"][-1] for r in runs]
    figures.below(f"shells of a file, offset {offset}, spacing {spacing:g}: force with split nodes against shared nodes", abs(force[0] / force[1] - 1), 0.08)
    assert ("use the spacing of the points" in runs[0].output) == (spacing < 1e-4)


def test_thin_shells_separate(tmp_path):
    """Cut cells on both sides of the unbonded gap share a face of the lattice, but their material does not touch."""
    thin = pair(CELL / 2, gap=2e-4, shape="coating", cement="thickness 2e-4 cap 20", half_box=3 * (12.5e-3,))
    out = run(
        thin
        + CONTACT
        + cement(CELL, 5e-9, axis="radial", damage="damage tensor B0 9.6e4 cutoff 0.9")
        + pull(4.0, 1e-6)
        + thermo(50, ["f_bond", "f_bond[22]"])
        + "run 600\n",
        tmp_path,
    )
    assert out.table()["f_bond[22]"][-1] == 1 and "intact" not in out.output


def test_taken_over_by_other_kinematics(tmp_path, figures):
    """A fix with `edge free` takes over points whose nodes were split at a gap."""
    first = pair(CELL / 2, **SHELLS) + CONTACT + cement(CELL, 5e-9, axis="radial")
    again = "fix cem calcite mpm cell 2e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 axis radial edge free\nfix bond grains mpm/couple cem\n"
    move = pull(4.0, 4e-6, ASKEW) + thermo(1, ["f_bond"])
    before = edit(first, "axis radial", "axis radial edge free")
    wanted = run(before + move + "run 200\n", tmp_path / "free").table()["f_bond"]
    found = run(first + "run 0\nunfix bond\nunfix cem\n" + again + move + "run 200\n", tmp_path / "after").table()["f_bond"]
    figures.below(
        "shells askew, split nodes given up before the run: force, over the largest", abs(found - wanted).max() / abs(wanted).max(), 1e-9
    )  # rounding feeds the springs of the links


@pytest.mark.parametrize("words", ["", "cracks split"])
def test_written_before_the_first_run(words, tmp_path):
    """What is written when fix mpm has been defined, but made no step, is the bond with its unbonded gap."""
    made = pair(CELL / 2, **SHELLS)
    fixes = CONTACT + pulled(words)
    one = run(made + fixes + "run 0\nrun 200\n", tmp_path / "one").table()
    run(made + fixes + "write_restart made.restart\n", tmp_path / "two")
    two = run(restarted("made.restart") + fixes + "run 0\nrun 200\n", tmp_path / "two", name="in.two").table()
    assert one["f_bond"].max() > 20
    for name in SCALARS:
        assert (one[name] == two[name]).all(), name
