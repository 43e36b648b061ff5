# SPDX-License-Identifier: GPL-2.0-or-later
"""Many steps: energy of a vibration, stress and damage of a bond that rotates."""
import numpy as np
import pytest
from bonds import LAW, bond
from scenes import run, shift, thermo

GRAIN_ENERGY = """\
compute      kin grains reduce sum v_kinetic
variable     energy equal c_kin+f_cem[5]+f_cem[6]+f_cem[7]
"""


@pytest.mark.parametrize("words, steps", [("", 1_000_000), ("basis cubic", 100_000), ("basis linear", 100_000)])
def test_free_vibration(words, steps, tmp_path, figures, long):
    """Two grains are drawn apart smoothly and released: they oscillate on their bond, and the energy of
    grains and cement neither drifts nor ebbs.

    Within a period it rises and falls: at nine tenths of the stable step the mass that stabilises the links is as much
    as that of the grains, and moves with nodes, not with them. The change scales with the square of the step.
    """
    steps = steps if long else steps // 40
    script = (
        bond(words)
        + shift(1e-8, "(2000*dt)")
        + ("run 2000\nunfix pull\nunfix hold\nfix motion grains nve/sphere\n" 'variable kinetic atom "0.5*mass*(vx^2+vy^2+vz^2)"\n' + GRAIN_ENERGY)
    )
    t = run(script + thermo(steps // 1000, ["v_energy", "f_bond"]) + f"run {steps}\n", tmp_path).table()
    E, force = t["v_energy"], t["f_bond"]
    assert force.max() > 0 > force.min()
    tenth = len(E) // 10
    drift = abs(E[-tenth:].mean() / E[:tenth].mean() - 1)
    swings = abs(np.diff(np.sign(force))).sum() / 4
    figures.note(f"{words or 'default'}: steps", steps)
    figures.below(
        f"{words or 'default'}, {steps} steps, at least {swings:.0f} swings: drift of the energy", drift, 1e-2 if "cubic" in words else 2e-3
    )  # of cubic splines a beat is seen: +0.6 and -0.5 % alternately, no trend
    figures.below(f"{words or 'default'}, {steps} steps: energy of any step against the mean", abs(E[5:] / E.mean() - 1).max(), 0.03)


@pytest.mark.parametrize("words", ["kinematics updated", "kinematics updated transfer flip 1", "reproject 1"])
def test_damped_vibration(words, tmp_path, figures, long):
    """The same with a transfer in every step, which damps where the cement is held: energy never
    grows, and what is lost is counted."""
    steps = 40000 if long else 4000
    script = (
        bond(words)
        + shift(1e-8, "(2000*dt)")
        + ("run 2000\nunfix pull\nunfix hold\nfix motion grains nve/sphere\n" 'variable kinetic atom "0.5*mass*(vx^2+vy^2+vz^2)"\n' + GRAIN_ENERGY)
    )
    t = run(script + thermo(20, ["v_energy", "f_cem[10]"]) + f"run {steps}\n", tmp_path).table()
    E, damped = t["v_energy"], t["f_cem[10]"]
    figures.below(f"{words}: largest energy against the start", E.max() / E[0] - 1, 0.01)
    balance = E + damped - damped[0]
    figures.below(f"{words}, {steps} steps: energy with what was damped, against the start", abs(balance / E[0] - 1).max(), 0.06)
    half = steps / 20 if E[-1] > 0.5 * E[0] else np.argmax(E < 0.5 * E[0])
    figures.note(f"{words}: steps until half of the energy is left", f"{'over ' if E[-1] > 0.5 * E[0] else ''}{20 * half:.0f}")


def turning(rate, ramp):
    """Both grains about the y axis: angle, rate and omega from one formula, smooth at the start."""
    a = f'"(v_s<{ramp})*0.5*{rate}*(v_s-{ramp}/PI*sin(PI*v_s/{ramp}))+(v_s>={ramp})*{rate}*(v_s-0.5*{ramp})"'
    w = f'"(v_s<{ramp})*0.5*{rate}*(1-cos(PI*v_s/{ramp}))+(v_s>={ramp})*{rate}"'
    text = f"variable from equal $(step)\nvariable s equal (step-v_from)*dt\nvariable a equal {a}\nvariable w equal {w}\n"
    for name, sign in (("first", -1), ("second", 1)):
        # The arm is the present one, `fix move` counts from where the grain is.
        text += (
            f"variable r{name} equal {sign}*$({'z[1]' if sign < 0 else 'z[2]'}*{sign})\n"
            f"variable x{name} equal v_r{name}*sin(v_a)\nvariable z{name} equal v_r{name}*(cos(v_a)-1)\n"
            f"variable u{name} equal v_r{name}*cos(v_a)*v_w\nvariable q{name} equal -v_r{name}*sin(v_a)*v_w\n"
            f"fix turn{name} {name} move variable v_x{name} NULL v_z{name} v_u{name} NULL v_q{name}\n"
        )
    return text


@pytest.mark.parametrize("words", ["", pytest.param("basis linear", marks=pytest.mark.long), "basis cubic"])
def test_rotation(words, tmp_path, figures, long):
    """A bond pulled until it is damaged rotates as a whole, ten times; stress, damage and energy stay."""
    revolutions = 10 if long else 0.25
    opening = 2.9e-7  # between the first damage and the first failure
    dt, rate, every = 1.5e-8, 1e4, 10
    ramp = 4000 * dt
    steps = int(np.ceil(2 * np.pi * revolutions / rate / dt / 1000)) * 1000
    # Damping towards the motion of the grains, so that no vibration hides a drift.
    script = bond(f"{words} quasistatic 1 0.2", timestep=f"{dt}", damage=LAW, half_box=3 * (12e-3,)) + shift(opening, "(3000*dt)")
    script += "run 3000\nunfix pull\nunfix hold\nfix hold grains move linear 0 0 0\nrun 3000\nunfix hold\n" + turning(rate, ramp)
    script += f'variable sm equal v_s+{every / 2}*dt\nvariable om atom "(v_sm<{ramp})*0.5*{rate}*(1-cos(PI*v_sm/{ramp}))+(v_sm>={ramp})*{rate}"\n'
    script += thermo(250, ["f_bond", "f_bond[19]", "f_bond[20]", "f_cem[6]", "f_cem[2]"])
    script += f'set group grains omegay v_om\nrun 4000 every {every} "set group grains omegay v_om"\nset group grains omegay {rate}\nrun 3000\nrun {steps}\n'
    t = run(script, tmp_path).table()
    start = t["step"] >= t["step"][0] + 6900
    name = f"{words or 'default'}, {revolutions} turns"
    figures.note(f"{name}: largest damage", f"{t['f_bond[19]'][-1]:.3f}")
    assert 0.05 < t["f_bond[19]"][-1] < 0.9
    assert t["f_cem[2]"][-1] == 0
    for column, what in (("f_bond", "tension"), ("f_cem[6]", "elastic energy")):
        v = t[column][start]
        figures.below(f"{name}: change of {what}", abs(v / v[0] - 1).max(), 2e-3)
    figures.below(f"{name}: growth of the mean damage", np.ptp(t["f_bond[20]"][start]), 2e-4)
