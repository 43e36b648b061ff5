# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS itself does almost nothing for the points of the cement."""
import re

import pytest
from scenes import CONTACT, cement, pair, pull, run
from test_mesh_walls import tiles

STEPS = 60


# Gravity of all atoms, and six mesh walls around the grains.
WALLS = """\
fix          g all gravity 9.81 vector 0 0 -1
fix          w1 all mesh/surface file square.stl type 1 move 0 0 -0.0115
fix          w2 all mesh/surface file square.stl type 1 move 0 0 0.0115
fix          w3 all mesh/surface file square.stl type 1 rotate axis 0 1 0 angle 90 move -0.0055 0 0
fix          w4 all mesh/surface file square.stl type 1 rotate axis 0 1 0 angle 90 move 0.0055 0 0
fix          w5 all mesh/surface file square.stl type 1 rotate axis 1 0 0 angle 90 move 0 -0.0055 0
fix          w6 all mesh/surface file square.stl type 1 rotate axis 1 0 0 angle 90 move 0 0.0055 0
fix          walls grains wall/gran model hertz/stiffness tangential history mesh n_meshes 6 meshes w1 w2 w3 w4 w5 w6
"""
FREE = WALLS + "velocity second set 0 0 0.1\nfix motion grains nve/sphere\n"


def scene(motion):
    return (
        pair(2.5e-5, gap=2e-5, cement="inner 1e-3 outer 2.1e-3")
        + CONTACT
        + cement(5e-5, 2e-9, axis="radial", damage="damage tensor B0 9.6e6 cutoff 0.9")
        + motion
        + f"modify_timing on\nthermo {STEPS}\nrun {STEPS}\n"
    )


def seconds(output, name):
    """Of a line of the breakdown that `modify_timing` adds, or of the loop."""
    return float(re.search(rf"^{re.escape(name)}( time \(%\) =| of) (\S+)", output, re.M)[2])


def average(output, name):
    return float(re.search(rf"^{name}: +(\S+) ave", output, re.M)[1])


@pytest.mark.slow
def test_cost(tmp_path, figures):
    share = 1.0
    for n in range(5):  # other load on the machine only adds
        share = min(share, cost(tmp_path / str(n), figures))
        if share < 0.02:
            break
    figures.below("cost of LIGGGHTS itself: share of the step outside the package", share, 0.02)


def cost(directory, figures):
    # The fixes' times hold what they do before and after the loop, which two lengths cancel, but not that of the first run.
    directory.mkdir()
    (directory / "square.stl").write_text(tiles(side=0.009, across=1))
    output = run(scene(FREE) + f"run {STEPS}\nrun {5 * STEPS}\n", directory).output
    points = int(re.search(r"(\d+) points\n", output)[1])
    assert points > 390000
    assert set(re.findall(r"Total # of neighbors = (\d+)", output)) == {"1"}, "pairs other than that of the grains"
    short, long = (output.split("Loop time")[n] for n in (2, 3))

    def each_step(*names):
        return sum(seconds("Loop time" + long, n) - seconds("Loop time" + short, n) for n in names) / (4 * STEPS)

    loop, ours = each_step("Loop time"), each_step("Fix cem mpm", "Fix bond mpm/couple")
    figures.note(f"cost with {points} points, 1 rank: step", f"{1e3 * loop:.3g} ms, of that the package {1e3 * ours:.3g} ms")
    for name in ("Pair ", "Neigh", "Comm ", "Outpt", "Fix motion nve/sphere", "Fix walls wall/gran", "Fix g gravity"):
        figures.note(f"cost with {points} points, 1 rank: {name}", f"{1e6 * each_step(name):.3g} us a step")
    return 1 - ours / loop


@pytest.mark.slow
def test_cost_of_neighbour_lists(tmp_path, figures):
    """With the lists built every 20 steps, on two ranks."""
    output = run(scene(pull(4.0, 4e-6) + "neigh_modify every 20 delay 0 check no\n"), tmp_path, 2).output
    builds = int(re.search(r"Neighbor list builds = (\d+)", output)[1])
    assert builds == STEPS // 20
    loop, lists = seconds(output, "Loop time"), seconds(output, "Neigh")
    figures.note("a build of the neighbour lists, 2 ranks", f"{lists / builds / (loop / STEPS):.2g} mean steps")
    # fix move looks at every atom of the rank, unlike the integrators of a `first` group
    figures.note("a fix move of one grain, 2 ranks", f"{100 * seconds(output, 'Fix pull move') / loop:.2f} % of the step")
    figures.below("pairs in the neighbour lists, 2 ranks (the grains)", average(output, "Neighs"), 1)
    figures.below("ghosts a rank, 2 ranks", average(output, "Nghost"), 2)
