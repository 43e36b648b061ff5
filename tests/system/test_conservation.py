# SPDX-License-Identifier: GPL-2.0-or-later
"""Free grains and their cement keep momentum and angular momentum, whole or breaking."""
import numpy as np
import pytest
from scenes import CALCITE, MOMENTA, MOMENTUM_COLUMNS, RING, SPINNING, cement, edit, pair, restarted, run, thermo

# Grain 2 leaves, and rotates about the bond while it does.
LEAVING = """\
velocity     second set 0.1 0.2 0.6
set          group second omegaz 200
fix          motion grains nve/sphere
"""


def drift(table):
    """Largest change of the momentum and of the angular momentum over their initial norms."""
    P = np.array([table[c] for c in MOMENTUM_COLUMNS])
    return [np.linalg.norm(p - p[:, :1], axis=0).max() / np.linalg.norm(p[:, 0]) for p in (P[:3], P[3:])]


def test_spinning_pair(tmp_path, figures):
    script = (
        pair(1e-4, gap=2e-4, direction=(0, 0.02, 1), cement="outer 2e-3", half_box=3 * (16e-3,))
        + cement(2e-4, 1e-8, axis="radial", couple="kn 2e12 kt 3e11")
        + SPINNING
        + MOMENTA
        + thermo(200, MOMENTUM_COLUMNS + ["f_cem[6]"])
        + "run 10000\n"
    )
    linear, angular = drift(run(script, tmp_path, ranks=2).table())
    figures.below("spinning pair, 10 000 steps: drift of momentum", linear, 2e-12)
    figures.below("spinning pair, 10 000 steps: drift of angular momentum", angular, 1e-13)


def test_breaking_pair(tmp_path, figures):
    script = (
        pair(1e-4, gap=2e-4, cement=RING, half_box=3 * (16e-3,))
        + cement(2e-4, 1e-8, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9", couple="kn 2e12 kt 3e11")
        + LEAVING
        + MOMENTA
        + thermo(50, MOMENTUM_COLUMNS + ["f_bond", "f_bond[17]", "f_bond[22]"])
        + "run 3000\n"
    )
    table = run(script, tmp_path, ranks=2).table()
    force = table["f_bond"]  # the halves ring
    assert table["f_bond[17]"][-1] > 1000 and table["f_bond[22]"][-1] == 1 and abs(force[-40:].mean()) < 0.1 * force.max(), "not broken"
    linear, angular = drift(table)
    figures.below("breaking pair: drift of momentum", linear, 1e-13)
    # Mass goes back to nodes beside the crack, which are no longer constrained. That moves the middle of the cement by a hair.
    figures.below("breaking pair: drift of angular momentum", angular, 1e-6)


# A free grain is pressed on the cement, which breaks, debonds and touches again. Added mass comes and goes with contact points, and transfers
# change the velocities of nodes that have some. Grains take the impulse of that in two halves.
PRESSED = {
    "friction": ("damage tensor B0 9.6e3 cutoff 0.9 check 20", " friction 0.3"),
    "friction, split": ("damage tensor B0 9.6e3 cutoff 0.9 check 20 cracks split unilateral yes", " friction 0.3"),
    "pic": ("reproject 10 transfer pic", ""),
    "updated": ("kinematics updated", ""),
}
PRESSED_PAIR = pair(2e-4, gap=4e-4, cement="outer 1.5e-3", half_box=3 * (12.5e-3,))
PRESSING = "velocity second set 0.3 0.1 -0.5\n"


def pressed(words, start=PRESSED_PAIR, go=PRESSING):
    damage, more = PRESSED[words]
    return (
        start
        + cement(4e-4, 2e-8, axis="radial", damage=damage, couple="kn auto kt auto" + more)
        + go
        + "fix motion grains nve/sphere\n"
        + MOMENTA
        + thermo(1, MOMENTUM_COLUMNS + ["f_bond[3]", "f_bond[4]", "f_bond[36]", "f_cem[12]"])
    )


@pytest.mark.parametrize("words", PRESSED)
def test_grains_take_impulses_in_two_halves(tmp_path, figures, words):
    """Momentum holds at any step. A run that is divided between the halves goes on as the run left alone, from a restart file too."""
    whole = run(pressed(words) + "run 350\n", tmp_path / "whole").table()
    parts = run(pressed(words) + "run 200\nrun 1\n" + "run 5\n" * 20 + "write_restart middle.restart\nrun 49\n", tmp_path / "parts").table()
    on = run(pressed(words, restarted("../parts/middle.restart"), "") + "run 49\n", tmp_path / "on").table()
    assert abs(whole["f_bond[3]"]).max() > 200 and (whole["f_bond[36]"].max() > 0.3) == words.startswith("friction")
    for kind, table in (("run", whole), ("run in parts", parts)):
        linear, angular = drift(table)
        figures.below(f"{words}: drift of momentum at any step of a {kind}", linear, 4e-14)
        if words == "updated":  # the others change it by more: constraints are given up, and pic filters it
            figures.below(f"{words}: drift of angular momentum at any step of a {kind}", angular, 1e-13)
    steps, ends = np.unique(parts["step"], return_index=True)  # of two rows of a step the one that ends a run
    assert (steps == whole["step"]).all()
    for name in ("f_bond[3]", "f_bond[4]"):
        figures.below(
            f"{words}: {name} of a run in parts against the run left alone, over the largest",
            abs(parts[name][ends] - whole[name]).max() / abs(whole[name]).max(),
            1e-9,
        )
    different = [name for name in on if (on[name] != parts[name][-50:]).any()]
    assert not different, different


@pytest.mark.parametrize("cracks, limit", [("bonds", 6e-7), ("split", 5e-6)])
def test_breaking_pair_with_constrained_nodes(tmp_path, figures, cracks, limit):
    """Nodes at edges are constrained, so mass goes back to them where constraints are given up: nodes that split give up most."""
    script = (
        pair(1.5e-4, gap=6e-4, cement="outer 1.5e-3", half_box=3 * (18e-3,))
        + cement(3e-4, 2.4e-8, damage=f"damage tensor B0 9.6e3 cracks {cracks}", couple="kn auto kt auto")
        + LEAVING
        + MOMENTA
        + thermo(5, MOMENTUM_COLUMNS + ["f_bond[22]"])
        + "run 400\n"
    )
    table = run(script, tmp_path).table()
    assert table["f_bond[22]"][-1] == 1
    linear, angular = drift(table)
    figures.below(f"pair with ties, cracks {cracks}: drift of momentum", linear, 1e-13)
    figures.below(f"pair with ties, cracks {cracks}: drift of angular momentum", angular, limit)


def test_energy_where_layouts_are_made_often(tmp_path, figures):
    """A breaking pair goes from rank to rank, with a new layout in steps that check for pieces: the energies are those of one rank."""

    def table(ranks):
        script = pair(1e-4, boundary="p f f", processors="* 1 1")
        script = edit(script, "neigh_modify include grains delay 0", "neigh_modify include grains every 1 delay 0 check no")
        script += edit(
            cement(2e-4, 1e-8, elastic=CALCITE, damage="damage tensor B0 9.6e3 interface 0.5"), "mpm cell 0.0002", "mpm cell 0.0002 timestep auto 0.8 check 20"
        )
        script += (
            "velocity grains set 60 0 0\nvelocity calcite set 60 0 0\nvariable x equal 60*step*dt\nvariable vx equal 60\n"
            "variable z equal 0.02*step*dt*step*dt/4e-6\nvariable vz equal 0.04*step*dt/4e-6\n"
            "fix hold first move linear 60 0 0\nfix pull second move variable v_x NULL v_z v_vx NULL v_vz\n"
        )
        return run(script + thermo(20, ["f_cem[7]", "f_cem[8]", "f_cem[9]", "f_cem[12]", "f_bond[18]"]) + "run 400\n", tmp_path / str(ranks), ranks).table()

    one, two = table(1), table(2)
    assert one["f_bond[18]"][-1] > 1000 and one["f_cem[9]"][-1] > 0
    for name, column in (("of the coupling", "f_cem[7]"), ("dissipated", "f_cem[8]"), ("released", "f_cem[9]")):
        figures.below(
            f"pair that goes through the ranks: energy {name}, 1 against 2 ranks", abs(one[column] - two[column]).max() / abs(one[column]).max(), 3e-9
        )


@pytest.mark.parametrize("cracks, friction", [("bonds", ""), ("split", ""), ("split", " friction 0.3")])
def test_flight_changes_nothing(tmp_path, figures, cracks, friction):
    """A pair is pulled apart while it flies: masses of nodes change where constraints are given up, added mass where links debond, and the velocity of the flight must not show."""

    def table(V, boundary="f f f", ranks=1):
        script = (
            pair(1.5e-4, gap=6e-4, cement="outer 1.5e-3", half_box=3 * (18e-3,), boundary=boundary)
            + cement(3e-4, 2.4e-8, damage=f"damage tensor B0 9.6e3 cracks {cracks}", couple="kn auto kt auto" + friction)
            + f"velocity all set {V} {V} {V}\nvelocity second set {V + 0.2} {V} {V + 0.5}\nfix motion grains nve/sphere\n"
            + thermo(1, ["f_bond", "f_bond[1]", "f_bond[18]", "f_bond[22]", "f_cem[9]"])
            + "run 400\n"
        )
        return run(script, tmp_path / f"{V}{boundary[0]}", ranks).table()

    rest, fast, following = table(0), table(300), table(-100, "s s s", 2)
    assert rest["f_bond[18]"][-1] > 500 and rest["f_bond[22]"][-1] == 1
    assert (rest["f_bond[18]"] == fast["f_bond[18]"]).all()
    assert (rest["f_bond[18]"] == following["f_bond[18]"]).all(), "points are the outermost atoms of a box that follows them"
    for name in ("f_bond", "f_bond[1]", "f_cem[9]"):
        figures.below(
            f"cracks {cracks}{friction}: {name} of a pair that flies at 300 m/s against one at rest, over the largest",
            abs(rest[name] - fast[name]).max() / abs(rest[name]).max(),
            1e-7,
        )
