# SPDX-License-Identifier: GPL-2.0-or-later
"""Time step of fix mpm: the limit is the true one, and a pull may be made in fewer steps."""
import re
from pathlib import Path

import numpy as np
import pytest
from scenes import CALCITE, MOMENTA, MOMENTUM_COLUMNS, RADIUS, cement, edit, launch, pair, pull, restarted, run, thermo

README = Path(__file__).resolve().parents[2] / "README.md"
CELL = 2e-4
SCENE = pair(CELL / 2) + cement(CELL, 1e-9) + pull(0.1, 2e-6)
ORDERS = (1, 2)  # terms of the mass


def auto(share, order=1):
    return edit(SCENE, "mpm cell 0.0002", f"mpm cell 0.0002 mass_order {order} timestep auto {share}")


def limit_of(order, folder):
    out = run(auto(1.0, order) + "run 0\n", folder).output
    return float(re.search(r"timestep auto: (\S+),", out).group(1))


@pytest.fixture(scope="module")
def limit(tmp_path_factory):
    return limit_of(1, tmp_path_factory.mktemp("limit"))


@pytest.fixture(scope="module")
def limits(tmp_path_factory, limit):
    """A second term of the mass at most doubles the largest eigenvalue."""
    of_two = limit_of(2, tmp_path_factory.mktemp("limit"))
    assert of_two == pytest.approx(limit / 2**0.5, rel=1e-6)
    return dict(zip(ORDERS, (limit, of_two)))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("share", [0.5, 0.9, 0.98])
def test_stable_below_the_limit(share, order, limits, tmp_path):
    scene = edit(edit(SCENE, "timestep     1e-09", f"timestep {share * limits[order]}"), "mpm cell 0.0002", f"mpm cell 0.0002 mass_order {order}")
    t = run(scene + thermo(50, ["f_cem[5]", "f_cem[12]", "f_cem[11]"]) + "run 3000\n", tmp_path).table()
    assert np.isfinite(t["f_cem[5]"]).all() and abs(t["f_cem[12]"]).max() < 0.01


@pytest.mark.parametrize("share", [1.02, 1.2])
def test_stopped_above_the_limit(share, limit, tmp_path):
    result = launch(edit(SCENE, "timestep     1e-09", f"timestep {share * limit}") + "run 10\n", tmp_path)
    assert result.status != 0 and "exceeds the stable step" in result.errors()[0], result.output[-500:]


def test_new_reference(tmp_path, figures):
    """Linear hat functions have another limit for each position of the points: the run stops when a new reference moves them to a worse one."""

    def drag(words):
        script = pair(CELL / 2) + edit(cement(CELL, 1e-9), "mpm cell 0.0002", f"mpm cell 0.0002 basis linear {words}")
        way = CELL / 2
        script += (
            "variable t equal step*dt\n"
            'variable r equal "(v_t<4e-6)*v_t/4e-6+(v_t>=4e-6)"\n'
            f'variable d equal "{way}*(v_r-sin(2*PI*v_r)/2/PI)"\nvariable v equal "{way / 4e-6}*(1-cos(2*PI*v_r))"\n'
            "variable o equal 0\nfix both grains move variable v_d v_d v_o v_v v_v v_o\n"
        )
        return launch(script + thermo(50, ["f_cem[5]"]) + "run 1000\n", tmp_path)

    result = drag("timestep auto 0.98 reproject auto 1e-7")
    assert result.status != 0, "goes on"
    for word in ("exceeds the stable step", "after the present was taken for the reference at step"):
        assert word in result.errors()[0], result.output[-500:]
    for words in ("timestep auto 0.98", "timestep auto 0.4 reproject auto 1e-7"):
        result = drag(words)
        assert result.status == 0, result.output[-500:]
        motion = result.table()["f_cem[5]"]
        figures.below(f"{words}: motion left when the grains are at rest again", motion[-1] / motion.max(), 0.01)


def test_auto_goes_to_other_fixes(tmp_path, limit):
    """`fix move` and `fix nve/sphere`, defined before and after, use the step that was found."""
    script = (
        auto(0.9).replace("fix          cem", "group one id 1\nfix early one nve/sphere\nfix          cem").replace("fix hold first move linear 0 0 0\n", "")
    )
    t = run(
        script + thermo(1, ["dt", "f_bond[13]"]) + "variable z2 equal z[2]\nvariable want equal v_dz\nrun 100\n"
        'variable err equal "abs(v_z2-0.005-v_want)/v_want"\nprint "ERR ${err}"\n',
        tmp_path,
    )
    assert t.value("ERR") < 1e-6
    assert abs(t.table()["dt"][-1] / (0.9 * limit) - 1) < 1e-4  # which free grains do not change


def test_auto_never_lengthens(tmp_path):
    """Cement that softens and fails leaves longer steps behind; motion by step*dt would jump with them."""
    script = pair(CELL / 2) + edit(cement(CELL, 1e-9, damage="damage tensor B0 9.6e3 cutoff 0.9"), "mpm cell 0.0002", "mpm cell 0.0002 timestep auto 0.9")
    script += pull(1.0, 4e-6) + thermo(10, ["dt", "f_cem[2]", "f_bond[13]"])
    t = run(script + 4 * "run 250\n", tmp_path).table()
    assert t["f_cem[2]"][-1] > 0.5 * 6000 and (t["dt"] == t["dt"][0]).all()
    assert np.diff(t["f_bond[13]"]).max() < 1.5 * 10 * t["dt"][0]  # m, at 1 m/s


def test_auto_keeps_a_stable_step(tmp_path):
    """Pieces that separate have another limit. A step that is below it stays, since motion by step*dt would jump with it."""
    first = re.search(r"```liggghts\n(.*?)```", README.read_text(), re.S)[1]
    for old, new in (
        ("content 0.01 inner 1.5e-3", "inner 1e-3 outer 2e-3"),
        (" regularization nonlocal 2e-4 energy 10 timestep auto 0.7", " timestep auto 0.9"),  # the limit of split nodes is not the same
        ("z equal 2500*", "z equal 5000*"),
        ("w equal 5000*", "w equal 10000*"),
    ):
        first = edit(first, old, new)
    result = run(first[: first.index("run          400")] + thermo(50, ["dt", "v_apart"]) + "run 150\n" + 4 * "run 100\n", tmp_path)
    t = result.table()
    assert t["v_apart"][-1] == 1 and (t["dt"] == t["dt"][0]).all()
    limits = [float(x) for x in re.findall(r"the limit is now (\S+),", result.output)]
    assert len(limits) == 4 and 0.9 * max(limits) > 1.005 * t["dt"][0] and t["dt"][0] < min(limits)  # nine tenths of it would be another step


@pytest.mark.parametrize("words", ["", "mass_order 2", "edge free", "basis linear", "quasistatic 100 0"])
def test_step_that_the_start_tells(words, tmp_path, figures):
    """With a step far below the limit its bound is enough for the run. What is told is near the limit that `timestep auto` finds precisely."""
    script = pair(CELL / 2) + edit(cement(CELL, 1e-10), f"mpm cell {CELL}", f"mpm cell {CELL} {words}") + "fix hold grains freeze\n"
    told = float(re.search(r"stable up to (?:about )?(\S+)", run(script + "run 1\n", tmp_path).output)[1])
    auto = edit(script, f"mpm cell {CELL}", f"mpm cell {CELL} timestep auto 0.5") + thermo(1, ["dt"]) + "run 1\n"
    limit = 2 * run(auto, tmp_path, name="in.auto").table()["dt"][-1]
    figures.below(f"{words or 'defaults'}: step told at the start against the limit", abs(told / limit - 1), 0.03)


def test_auto_of_a_restart(tmp_path):
    """A run from a restart file keeps the step with the same share or a larger one. A smaller share is obeyed."""
    start = pair(CELL / 2)
    fixes = "fix hold grains freeze\n" + edit(cement(CELL, 1e-9), "mpm cell 0.0002", "mpm cell 0.0002 timestep auto 0.8")
    first = run(start + fixes + thermo(1, ["dt"]) + "run 1\nwrite_restart one.restart\n", tmp_path).table()["dt"][0]
    for share, expected in ((0.8, 1.0), (0.9, 1.0), (0.4, 0.5)):
        again = restarted("one.restart") + edit(fixes, "timestep auto 0.8", f"timestep auto {share}") + thermo(1, ["dt"]) + "run 1\n"
        assert abs(run(again, tmp_path).table()["dt"][-1] / (expected * first) - 1) < 1e-4


@pytest.mark.parametrize("words, share", [("", 0.7), ("mass_order 2", 0.7), ("unilateral yes", 0.6)])
def test_auto_warns_of_splits(words, share, tmp_path):
    script = pair(CELL / 2) + edit(
        cement(CELL, 1e-9, damage="damage tensor B0 9.6e3 cutoff 0.9"), "mpm cell 0.0002", f"mpm cell 0.0002 timestep auto 0.71 cracks split {words}"
    )
    assert f"use 'timestep auto {share}' or less" in run(script + "fix hold grains freeze\n" + 2 * "run 1\n", tmp_path).output


def test_auto_and_the_order_of_fixes(tmp_path):
    """`fix move` and `fix nve/sphere` between fix mpm and fix mpm/couple use the step too."""
    couple = next(line for line in SCENE.splitlines(True) if "mpm/couple" in line)
    moving = "group first id 1\ngroup second id 2\nfix pull second move linear 0 0 0.01\nfix free first nve/sphere\n"
    head = pair(CELL / 2) + edit(cement(CELL, 1e-9), "mpm cell 0.0002", "mpm cell 0.0002 timestep auto 0.9")
    head = edit(head, couple, "COUPLE").replace("group        first id 1\ngroup        second id 2\n", "")
    look = "variable z1 equal z[1]\nvariable z2 equal z[2]\n" + thermo(20, ["dt", "f_bond[13]", "f_bond[14]", "f_cem[12]", "v_z1", "v_z2"])
    before = run(edit(head, "COUPLE", couple + moving) + look + "run 100\n", tmp_path / "before").table()
    after = run(edit(head, "COUPLE", moving + couple) + look + "run 100\n", tmp_path / "after").table()
    assert before["dt"][-1] > 1e-8
    for c in before:
        assert (before[c] == after[c]).all(), c


@pytest.mark.parametrize("act, status", [("warn", 0), ("stop", 1)])
def test_check_timestep(act, status, tmp_path):
    script = auto(0.95) + f"fix ts all check/timestep/mpm 50 cem 0.9 {act}\n" + thermo(50, ["f_ts[1]", "f_ts[2]"]) + "run 100\n"
    result = launch(script, tmp_path, 2)
    assert (result.status != 0) == bool(status)
    assert "more than 0.9; use 'timestep" in result.output
    if not status:
        assert abs(result.table()["f_ts[1]"] - 0.95).max() < 0.01


def test_quasistatic(tmp_path, figures):
    """Ten times fewer steps to the same peak force. The law is viscous: without a time of its own
    cement that softens fails at a force that falls with the speed of the pull, however slow."""

    def peak(words, dt):
        steps = 200 * round(4e-5 / dt / 200)
        script = pair(CELL / 2, cement="inner 1e-3 outer 1.3e-3") + edit(
            cement(CELL, dt, axis="radial", damage="damage tensor B0 9.6e6 cutoff 0.9 viscosity 5e-6"), "mpm cell 0.0002", f"mpm cell 0.0002 {words}"
        )
        script += pull(0.5, 3.2e-5) + thermo(steps // 200, ["f_bond", "f_bond[21]", "f_cem[5]", "f_cem[6]"]) + f"run {steps}\n"
        t = run(script, tmp_path / (words.replace(" ", "_") or "plain")).table()
        at = t["f_bond"].argmax()
        assert 0 < at < len(t["f_bond"]) - 1  # the peak was passed
        return t["f_bond[21]"][-1], t["f_cem[5]"][at] / (t["f_cem[5]"][at] + t["f_cem[6]"][at])

    slow, share = peak("", 5.5e-9)
    for words in ("quasistatic 100 0", "quasistatic 100 0.3"):
        fast, fast_share = peak(words, 5.5e-8)
        figures.below(f"{words}: peak force against ten times the steps", abs(fast / slow - 1), 0.01)
        figures.below(f"{words}: kinetic share of the energy at the peak", fast_share, 0.01)


@pytest.mark.parametrize("density", [25, 1])
def test_damping_that_light_free_grains_admit(tmp_path, figures, density):
    """The damping that the warning advises leaves nine tenths of the step without damping; the one of the script leaves less than unscaled inertia does."""

    def step(words, **where):
        script = edit(pair(CELL / 2), "density 2500", f"density {density}") + edit(
            cement(CELL, 1e-9), "mpm cell 0.0002", f"mpm cell 0.0002 timestep auto 1 {words}"
        )
        out = run(script + "fix motion grains nve/sphere\nrun 0\n", tmp_path).output
        return float(re.search(r"timestep auto: (\S+),", out).group(1)), re.findall(r"WARNING.*use 'quasistatic 100 (\S+)'", out)

    plain, free, (damped, advice) = step("")[0], step("quasistatic 100 0")[0], step("quasistatic 100 0.2")
    assert damped < plain and len(advice) == 1
    admitted, none = step(f"quasistatic 100 {advice[0]}")
    figures.below(
        f"grains of density {density}: step with the damping that is advised, over 0.9 of that without, minus 1", abs(admitted / free / 0.9 - 1), 1e-4
    )
    assert not none and abs(free / plain / 10 - 1) < 1e-3


def test_a_fragment_is_damped_with_no_grain(tmp_path, figures):
    """Both grains debond and leave to either side: neither draws the fragment in the middle along."""
    script = pair(CELL / 2) + edit(
        cement(CELL, 1e-8, elastic=CALCITE, damage="damage tensor B0 9.6e3 interface 0.1"),
        "mpm cell 0.0002",
        "mpm cell 0.0002 timestep auto 0.9 quasistatic 1 1 check 50",
    )
    script += (
        "variable zz equal 0.2*step*dt*step*dt/4e-6\nvariable w equal 0.4*step*dt/4e-6\n"
        "variable zm equal -v_zz\nvariable wm equal -v_w\n"
        "fix hold first move variable NULL NULL v_zm NULL NULL v_wm\nfix pull second move variable NULL NULL v_zz NULL NULL v_w\n"
    )
    t = run(script + thermo(50, ["f_bond[16]", "f_bond[22]", "f_cem[15]", "v_w"]) + "run 600\n", tmp_path).table()
    assert t["f_bond[16]"][-1] == 0 and t["f_bond[22]"][-1] == 1
    mass = 2710 * np.pi / (2 * RADIUS) * (2e-3**4 - 1e-3**4)
    figures.below("loose piece between grains that leave: its speed over theirs", abs(t["f_cem[15]"][-1]) / (mass * t["v_w"][-1]), 0.01)


@pytest.mark.parametrize("basis", ["quadratic", "cubic"])
def test_points_that_move(basis, tmp_path):
    """Points of `updated` come to other positions in the cells. So the step holds for points anywhere, wherever they start."""
    steps = []
    for place in ("0 0 0", "5e-5 2e-5 3e-5", "1e-4 1e-4 1e-4"):
        text = edit(pair(CELL / 2), "spacing 0.0001", f"spacing 0.0001 grid {place}") + edit(
            cement(CELL, 1e-9), "mpm cell 0.0002", f"mpm cell 0.0002 basis {basis} kinematics updated timestep auto 1"
        )
        out = run(text + "fix hold grains move linear 0 0 0\nrun 1\n", tmp_path).output
        steps.append(float(re.search(r"timestep auto: (\S+),", out).group(1)))
    assert steps[0] == steps[1] == steps[2], steps
    longer = launch(
        edit(text, "timestep     1e-09", f"timestep {1.01 * steps[0]:.15g}").replace("timestep auto 1", "") + "fix hold grains move linear 0 0 0\nrun 1\n",
        tmp_path,
    )
    assert longer.status != 0 and "exceeds the stable step" in longer.errors()[0], longer.output[-500:]


@pytest.mark.parametrize("dt", [5e-9, 1.3e-8])
def test_another_step_keeps_momentum(dt, tmp_path, figures):
    """Added mass depends on the time step. A run with another step goes on with the momentum of the one before."""
    start = edit(pair(CELL / 2, half_box=3 * (15e-3,)), "create_cement", "set atom 2 diameter 0.008\ncreate_cement")
    go, fixes = "velocity second set 0.2 -0.1 0.3\nset atom 2 omegax 200\n", cement(CELL, 1e-8, axis="radial")
    moved = "fix motion grains nve/sphere\n" + MOMENTA + thermo(5, MOMENTUM_COLUMNS[:3] + ["f_cem[12]"])
    t = run(start + fixes + go + moved + f"run 40\nwrite_restart middle.restart\ntimestep {dt}\nrun 40\n", tmp_path).table()
    again = run(restarted("middle.restart") + fixes + moved + f"timestep {dt}\nrun 40\n", tmp_path).table()
    for name in t:
        assert (again[name] == t[name][-9:]).all(), f"{name}: a run from a restart file goes on with another step as the run itself does"
    P = np.array([t[c] for c in MOMENTUM_COLUMNS[:3]])
    figures.below(f"momentum after a step of {dt} instead of 1e-8, against the start", abs(P - P[:, :1]).max() / abs(P).max(), 1e-12)
    figures.below(f"energy imbalance with a step of {dt} after 1e-8", abs(t["f_cem[12]"])[-8:].max(), 0.01)


def test_check_sees_grains_that_become_free(tmp_path):
    """With sub-steps the limit of grains on their bonds is found anew when grains are free that were held."""
    text = edit(pair(CELL / 2), "density 2500", "density 25") + edit(cement(CELL, 1e-7), "mpm cell 0.0002", "mpm cell 0.0002 subcycle 50")
    text += (
        "fix ts all check/timestep/mpm 5 cem 0.9\nfix hold grains move linear 0 0 0\n"
        + thermo(5, ["f_ts[2]"])
        + "run 5\nunfix hold\nfix free grains nve/sphere\nrun 5\n"
    )
    limit = run(text, tmp_path).table()["f_ts[2]"]
    assert limit[-1] < 0.2 * limit[0], limit
