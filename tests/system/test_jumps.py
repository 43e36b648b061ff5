# SPDX-License-Identifier: GPL-2.0-or-later
"""Velocities that jump where links add mass: the balance of the energy, and the energy itself, which is that of a small step."""
import numpy as np
import pytest
from scenes import CALCITE, CONTACT, MOMENTA, MOMENTUM_COLUMNS, cement, edit, pair, pull, restarted, run, thermo

CELL = 2.5e-4
HALF, SMALL = 1e-8, 2e-9  # half of the stable step; a step with which links add no mass
ENERGIES = [f"f_cem[{i}]" for i in (5, 6, 7, 12)]
HOLD = "fix hold first move linear 0 0 0\n"
MOTIONS = {
    "wiggle": HOLD + "fix pull second move wiggle 0 0 1e-8 4e-6\n",
    "linear": HOLD + "fix pull second move linear 0 0 0.01\n",
    "gravity": "fix g all gravity 9.81 vector 0 0 -1\n" + HOLD + "fix pull second move linear 0 0 0\n",
    # by a fix that comes later in the step than fix mpm, and on a grain that follows it
    "gravity on a free grain": HOLD + "fix free second nve/sphere\nfix g all gravity 9.81 vector 0 0 -1\n",
}
CHANGES = {  # of the motion after 30 steps
    "stop": (MOTIONS["linear"], "unfix pull\nfix then second move linear 0 0 0\n"),
    "turn round": (MOTIONS["linear"], "unfix pull\nfix then second move linear 0.01 0 -0.01\n"),
    "free": (MOTIONS["linear"], "unfix pull\nfix then second nve/sphere\n"),
    "catch": (HOLD + "fix pull second nve/sphere\nvelocity second set 0 0 0.01\n", "unfix pull\nfix then second move linear 0 0 0\n"),
    "turn": ("fix hold grains move linear 0 0 0\n", "set group second omegay 5\n"),
    "kick": ("fix free grains nve/sphere\nvelocity second set 0 0 0.01\n", "velocity second set 0.02 0 -0.03\n"),
    "spin": ("fix free grains nve/sphere\nvelocity second set 0 0 0.01\n", "set group first omegaz 5\n"),
}
WARNING = "the prescribed velocity of bonded grain"
STARTS = "the cement of grains 1 and 2 starts at a speed of "


def bond(timestep, words="", **options):
    return (
        pair(CELL / 2, cement="content 0.01", **options)
        + CONTACT
        + edit(cement(CELL, timestep, elastic=CALCITE, axis="radial"), f"cell {CELL}", f"cell {CELL} {words}")
    )


def energy(table):
    return sum(table[c] for c in ENERGIES[:3])


@pytest.mark.parametrize("words", ["", "mass_order 2", "kinematics updated"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_start(tmp_path, figures, motion, words):
    """From rest, of the first step on. Waves are resolved after some 1e-7 s: until then a surface that is jerked differs."""
    tables = {}
    for timestep in (HALF, SMALL):
        every = round(2e-8 / timestep) if timestep == SMALL else 1
        script = bond(timestep, words) + MOTIONS[motion] + thermo(every, ENERGIES) + f"run {round(7.2e-7 / timestep)}\n"
        result = run(script, tmp_path / str(timestep))
        tables[timestep] = result.table()
        assert result.output.count(WARNING) == ("gravity" not in motion), "one warning of a jump, and none without"
    figures.below(
        f"{motion}, {words or 'total'}: imbalance of the energy at half of the stable step", max(abs(t["f_cem[12]"]).max() for t in tables.values()), 1e-4
    )
    if motion in ("wiggle", "linear"):
        late, small = energy(tables[HALF])[::2][10:], energy(tables[SMALL])[10:]
        figures.below(f"{motion}, {words or 'total'}: mean energy against that of a small step", abs(late.mean() / small.mean() - 1), 0.04)


@pytest.mark.parametrize("words", ["quasistatic 1 1", "quasistatic 100 0.2"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_start_with_damping(tmp_path, figures, motion, words):
    """Dampers take power from the first step on, half of each step's is ahead."""
    # Dampers count the velocity that a prescribed motion is expected to have next. Where that motion curves, as in `wiggle`,
    # they miss what the work of the grain has of the true one. The error does not grow.
    result = run(bond(HALF, "timestep auto 0.5 " + words) + MOTIONS[motion] + thermo(1, ENERGIES + ["f_cem[10]"]) + "run 40\n", tmp_path)
    table = result.table()
    damped = table["f_cem[10]"]
    figures.below(f"{motion}, {words}: imbalance of the energy with dampers", abs(table["f_cem[12]"]).max(), 0.005 if motion == "wiggle" else 1e-5)
    assert damped[0] == 0 and damped[10] > 1e-3 * energy(table)[10], "dampers take part"


@pytest.mark.parametrize("words", ["", "mass_order 2", "kinematics updated"])
@pytest.mark.parametrize("change", CHANGES)
def test_change(tmp_path, figures, change, words):
    """Another motion from one run to the next, or a command that changes a velocity: the same on two ranks."""
    first, second = CHANGES[change]
    tables = [
        run(
            bond(1.2e-8, words, processors="1 1 *") + first + thermo(1, ENERGIES + ["f_bond[14]"]) + f"run 30\n{second}run 30\n", tmp_path / str(ranks), ranks
        ).table()
        for ranks in (1, 2)
    ]
    one, two = (energy(t) for t in tables)
    assert one[-1] > 1e-10
    figures.below(
        f"{change}, {words or 'total'}: imbalance of the energy",
        max(abs(t["f_cem[12]"]).max() for t in tables),
        0.01 if change in ("free", "catch") else 1e-5 if "updated" in words else 1e-6,
    )
    figures.below(f"{change}, {words or 'total'}: energy, 2 ranks against 1", abs(two - one).max() / one.max(), 2e-10)


@pytest.mark.parametrize("steps", [5, 10, 30])
@pytest.mark.parametrize("change", ["free", "catch"])
def test_grain_that_goes_over_between_prescribed_and_free(tmp_path, figures, change, steps):
    """What doc/fix_mpm_couple.md says of it: there is little energy in the first steps of a motion."""
    first, second = CHANGES[change]
    table = run(bond(1.2e-8) + first + thermo(1, ["f_cem[12]"]) + f"run {steps}\n{second}run 30\n", tmp_path).table()
    figures.below(f"{change} after {steps} steps: imbalance of the energy", abs(table["f_cem[12]"]).max(), 0.13 if steps <= 10 else 0.02)


@pytest.mark.parametrize("words", ["", "mass_order 2"])
@pytest.mark.parametrize("change", ["stop", "turn round", "kick"])
def test_change_of_what_is_heavy(tmp_path, figures, change, words):
    """The work of weight and of inertial forces depends on the velocities that jumps give to nodes, too."""
    first, second = CHANGES[change]
    weight = "fix g all gravity 1e4 vector 0 0 -1\n"
    table = run(bond(1.2e-8, words) + weight + first + thermo(1, ["f_cem[12]"]) + f"run 30\n{second}run 30\n", tmp_path).table()
    figures.below(f"{change}, {words or 'lumped mass'}, under a weight: imbalance of the energy", abs(table["f_cem[12]"]).max(), 1e-6)


@pytest.mark.parametrize("words, timestep", [("", SMALL), ("", 1.2e-8), ("condense yes", 1.2e-8), ("subcycle 2", 2 * SMALL)])
def test_kick_of_a_loaded_bond(tmp_path, figures, words, timestep):
    """The bond pulls at the grain that gets another velocity, whether or not its links add mass."""
    steps = round(1.5e-6 / timestep)
    t = run(
        bond(timestep, words)
        + "fix free grains nve/sphere\nvelocity second set 0 0 0.05\n"
        + thermo(5, ["f_bond[14]", "f_cem[12]"])
        + f"run {steps}\nvelocity second set 0.2 0 0.5\nset group first omegaz 5\nrun {steps}\n",
        tmp_path,
    ).table()
    figures.below(f"kick of a loaded bond, {words} step {timestep}: imbalance of the energy", abs(t["f_cem[12]"]).max(), 5e-4 if "condense" in words else 5e-6)


def test_momentum(tmp_path, figures):
    """A free pair whose velocities a command changes has the momentum that this gives it, from that step on."""
    script = (
        bond(1.2e-8, half_box=(15e-3, 15e-3, 15e-3))
        + "fix free grains nve/sphere\nvelocity second set 0.02 0 0.01\n"
        + MOMENTA
        + thermo(1, MOMENTUM_COLUMNS)
        + "run 10\nvelocity second set 0.02 0.01 -0.03\nset group first omegaz 5\nrun 10\n"
    )
    table = run(script, tmp_path).table()
    P = np.array([table[c] for c in MOMENTUM_COLUMNS])
    for what, p in (("momentum", P[:3]), ("angular momentum", P[3:])):
        for part in (p[:, :11], p[:, 11:]):
            drift = np.linalg.norm(part - part[:, -1:], axis=0).max() / np.linalg.norm(part[:, -1])
            figures.below(f"velocities changed by a command: drift of {what}", drift, 9e-13)
        assert np.linalg.norm(p[:, -1] - p[:, 0]) > 0.1 * np.linalg.norm(p[:, 0])


@pytest.mark.parametrize("change", ["turn round", "kick"])
def test_restart(tmp_path, change):
    """A change of motion after read_restart is bitwise identical to that between two runs."""
    first, second = CHANGES[change]
    columns = thermo(1, ENERGIES + ["f_bond[14]"])
    whole = run(bond(1.2e-8) + first + "run 30\nwrite_restart middle.restart\n" + second + columns + "run 10\n", tmp_path).table()
    fixes = bond(1.2e-8).split("create_cement", 1)[1].split("\n", 1)[1]
    again = restarted("middle.restart") + "group grains type 1\n" + fixes + first.replace("velocity second set 0 0 0.01\n", "")
    parts = run(again + second + columns + "run 10\n", tmp_path).table()
    assert parts["step"][-1] == 40
    for c in whole:
        assert (whole[c][1:] == parts[c][1:]).all(), c


def test_warning(tmp_path):
    """Once a run, with the grain, the step and the cure; a smooth pull needs none, however fast it is in the end."""
    jump = bond(1.2e-8) + MOTIONS["linear"] + "run 10\nunfix pull\nfix then second move linear 0 0 -0.01\nrun 10\nrun 10\n"
    for ranks in (1, 2):
        output = run(jump, tmp_path / str(ranks), ranks).output
        told = [line for line in output.splitlines() if WARNING in line]
        assert len(told) == 2 and "grain 2 jumps by 0.01 in step 1," in told[0] and "grain 2 jumps by 0.02 in step 11," in told[1], told
        assert all("smoothly" in line for line in told)
    damage = edit(bond(1.2e-8), "axis radial ", "axis radial damage tensor B0 9.6e3 ")
    for motion, warnings in (
        (pull(0.1265, 4e-6), 0),
        (HOLD + "fix pull second move linear 0 0 0.1265\n", 1),
        (HOLD + "fix pull second move linear 0 0 1e-4\n", 0),
    ):
        assert run(damage + motion + "run 10\n", tmp_path / "damage").output.count(WARNING) == warnings


# a rotation about the middle of the bond, of 100 rad/s, with a translation
FLIGHT = 'variable vx atom "20 - 100*y"\nvariable vy atom "100*x"\nvelocity grains set v_vx v_vy 20\n' "set group grains omegaz 100\n"


@pytest.mark.parametrize("axis", [(1, 0, 0), (1, 2, 3)])
def test_cement_made_between_moving_grains(tmp_path, figures, axis):
    """It flies on with them, and is loaded by the rotation alone, as cement that follows its grains without waves."""
    tables = {}
    for condense in ("no", "yes"):
        script = edit(
            bond(SMALL, f"damage tensor B0 9.6e3 condense {condense}", direction=axis, half_box=3 * (14e-3,)), "create_cement", FLIGHT + "create_cement"
        )
        result = run(script + "fix free grains nve/sphere\n" + thermo(50, ENERGIES + ["f_cem[2]", "f_bond[21]"]) + "run 2000\n", tmp_path / condense)
        assert STARTS not in result.output
        tables[condense] = result.table()
    no, yes = tables["no"], tables["yes"]
    assert no["f_cem[2]"].max() == 0
    figures.below(
        f"cement made in flight, axis {axis}: largest load against that of a condensed bond", abs(no["f_bond[21]"][-1] / yes["f_bond[21]"][-1] - 1), 0.005
    )
    figures.below(f"cement made in flight, axis {axis}: imbalance of the energy", abs(no["f_cem[12]"]).max(), 2e-13)


def test_warning_of_another_start(tmp_path):
    """Grains that get their velocity after the cement was made."""
    free = "fix free grains nve/sphere\n" + thermo(1, ENERGIES)
    late = run(bond(SMALL) + "velocity grains set 0 0 20\n" + free + "run 1\n", tmp_path / "late", 2)
    assert late.output.count(STARTS + "20 against one of them") == 1
    alike = run(bond(SMALL) + "velocity all set 0 0 20\n" + free + "run 1\n", tmp_path / "alike", 2)
    assert STARTS not in alike.output
