# SPDX-License-Identifier: GPL-2.0-or-later
"""What acts on a bond besides the pull of its grains: weight, spins that are prescribed, torques of fixes that come later."""
import numpy as np
import pytest
from scenes import CONTACT, cement, edit, pair, point_quantities, run, thermo, uncoupled

DENSITY, CELL, RING = 2710.0, 4e-4, "inner 1.4e-3 outer 2.2e-3"


@pytest.mark.parametrize("scale", [1, 25])
def test_weight(scale, tmp_path, figures):
    """Cement that falls alone: `quasistatic` multiplies its inertia by S, not its weight, so that it falls with g/S."""
    g, dt, steps = 9.81e4, 1e-8, 200
    fixes = uncoupled(cement(CELL, dt))
    fixes = edit(fixes, f"cell {CELL}", f"cell {CELL} quasistatic {scale} 0")
    script = pair(CELL / 2, cement=RING) + fixes + "fix hold grains freeze\n"
    script += f"fix weight calcite gravity {g} vector 0.6 0 -0.8\n" + point_quantities(["volume"])
    script += "compute V calcite reduce sum c_volume\n"
    columns = ["c_V"] + [f"f_cem[{i}]" for i in (5, 6, 11, 12, 13, 14, 15)]
    t = run(script + thermo(50, columns) + f"run {steps}\n", tmp_path).table()
    time, mass = t["step"][1:] * dt, DENSITY * t["c_V"][0]
    impulse = mass * g * time
    for name, column, share in (("x", 13, 0.6), ("y", 14, 0.0), ("z", 15, -0.8)):
        figures.below(f"S {scale}: momentum along {name} against the weight times time", abs(t[f"f_cem[{column}]"][1:] / impulse - share).max(), 1e-13)
    energy = impulse**2 / (2 * scale * mass)
    figures.below(f"S {scale}: kinetic energy against p^2/(2 S m)", abs(t["f_cem[5]"][1:] / energy - 1).max(), 2e-13)
    # What central differences count of it differs by the square of a step in the whole time.
    figures.below(f"S {scale}: work of the weight against it", abs(t["f_cem[11]"][1:] / energy - 1).max(), 1e-13)


def test_a_grain_without_links_is_free(tmp_path, figures):
    """With the last of its links a grain loses the mass that these added, too, at the next check: it may accelerate as it
    likes and feels nothing, to the last digit."""
    dt, check, steps, way = 7e-8, 20, 300, 6e-6
    fixes = cement(CELL, dt, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 interface 0.2 check {check}")
    script = pair(CELL / 2, cement=RING) + fixes
    script += (
        f'variable d equal "{way}*(step/{steps})^2"\nvariable v equal "{2 * way / (steps * dt)}*step/{steps}"\n'
        "fix hold first move linear 0 0 0\nfix pull second move variable NULL NULL v_d NULL NULL v_v\n"
    )
    forces = [f"f_bond[{i}]" for i in range(1, 13)]
    done = run(script + thermo(1, forces + ["f_bond[16]"]) + f"run {steps}\n", tmp_path)
    t = done.table()
    last = int(t["step"][np.argmax(t["f_bond[16]"] == 0)])
    assert 0 < last < steps - 3 * check
    held = np.abs([t[f] for f in forces])
    assert held[:, last].max() > 0.1, "no added mass is left to be dropped"
    assert not held[:, last + check + 1 :].any()


def test_spin_up(tmp_path, figures):
    """Both grains spin up about their line together, and the cement with them, added mass included: nothing strains it, and
    the torque that this takes is its moment of inertia times the angular acceleration."""
    dt, steps, rate = 8e-8, 200, 1000.0
    script = pair(CELL / 2, cement=RING) + cement(CELL, dt) + "fix hold grains move linear 0 0 0\n"
    script += f'variable t equal step/{steps}\nvariable omega atom "{rate}*(v_t-sin(2*PI*v_t)/2/PI)"\n'
    columns = ["f_bond[6]", "f_bond[12]", "f_cem[5]", "f_cem[6]", "f_cem[18]"]
    spin = "set group grains omegaz v_omega"
    t = run(script + thermo(1, columns) + f'{spin}\nrun {steps} every 1 "{spin}"\n', tmp_path).table()
    each = np.unique(t["step"], return_index=True)[1]  # `every` prints the steps between twice
    t = {k: v[each] for k, v in t.items()}
    torque, momentum = -t["f_bond[6]"] - t["f_bond[12]"], t["f_cem[18]"]
    inertia = momentum[-1] / rate
    # The change of omega to a step is at the middle of that step; the force that answers it is told in the next.
    expected = inertia * rate / (steps * dt) * (1 - np.cos(2 * np.pi * (t["step"] - 1.5) / steps))
    figures.below("spin-up: torque against inertia times angular acceleration, over the largest", abs(torque - expected).max() / expected.max(), 0.004)
    figures.below("spin-up: elastic energy over the kinetic energy at the end", t["f_cem[6]"].max() / (0.5 * inertia * rate**2), 2e-3)


def test_torque_of_a_later_fix(tmp_path, figures):
    """A wall slides with friction on a free bead, whose links add twice its mass: its torque counts, too, where the wall is defined after
    fix mpm and only that of the step before is known."""
    dt, steps = 7e-8, 400
    wall = "fix wall all wall/gran model hertz/stiffness tangential history primitive type 2 xplane 0.0049998 shear z 20\n"
    start = pair(CELL / 2, cement=RING, gap=2e-4) + "set group grains density 500\n" + CONTACT
    rest = (
        "fix hold first move linear 0 0 0\nfix motion second nve/sphere\ncompute w second property/atom omegay\n"
        "compute spin second reduce sum c_w\n" + thermo(20, ["c_spin", "f_cem[11]", "f_cem[12]"]) + f"run {steps}\n"
    )
    former = run(start + wall + cement(CELL, dt) + rest, tmp_path / "former").table()
    later = run(start + cement(CELL, dt) + wall + rest, tmp_path / "later").table()
    assert abs(former["c_spin"]).max() > 0.1
    figures.below(
        "wall defined later: spin of the bead against the wall defined before, over the largest",
        abs(later["c_spin"] - former["c_spin"]).max() / abs(former["c_spin"]).max(),
        0.015,
    )
    work = later["f_cem[11]"]
    figures.below("wall defined later: imbalance of the energy, over the largest work", abs(later["f_cem[12]"] * work).max() / work.max(), 1e-3)
