# SPDX-License-Identifier: GPL-2.0-or-later
"""Loads that reverse, crush, tear off, and strengths from almost nothing to beyond everything."""
import numpy as np
import pytest
from bonds import BRITTLE, bond
from scenes import MOMENTA, MOMENTUM_COLUMNS, pull, run, thermo

DT = 2e-8


def ways(positions, duration):
    """Grain 2 goes to one position after the other, each path smooth."""
    text = "fix hold first move linear 0 0 0\n"
    at = 0.0
    for n, position in enumerate(positions):
        way, at = position - at, position
        x = f"((step-v_b{n})*dt/{duration})"
        text += (
            f'variable b{n} equal $(step)\nvariable z{n} equal "{way}*({x}-sin(2*PI*{x})/2/PI)"\n'
            f'variable w{n} equal "{way}/{duration}*(1-cos(2*PI*{x}))"\n'
            f"fix pull second move variable NULL NULL v_z{n} NULL NULL v_w{n}\nrun {round(duration / DT)}\nunfix pull\n"
        )
    return text


COLUMNS = ["f_bond", "f_bond[13]", "f_bond[17]", "f_bond[20]", "f_cem[8]", "f_cem[9]", "f_cem[12]", "f_cem[2]", "f_cem[6]"]


@pytest.mark.parametrize("words", ["", "kinematics updated", "basis cubic quasistatic 1 0.5"])
def test_unload_and_reload(words, tmp_path, figures):
    """Unloaded after damage and loaded again: no dissipation below the largest opening, no force at none.

    Softening cement is not at rest when the grains reverse. The damage that the vibration still causes, most with cubic splines,
    is in the figure of the dissipation.
    """
    opening = 8e-6 if "updated" in words else 9e-6  # at which damage has begun
    script = bond(words, timestep=f"{DT}", damage=BRITTLE) + thermo(10, COLUMNS) + ways([opening, 0.0, opening, 1.2 * opening], 4e-5)
    t = run(script, tmp_path).table()
    name, quarter = words or "default", len(t["step"]) // 4
    gap, force, spent = t["f_bond[13]"], t["f_bond"], t["f_cem[8]"] + t["f_cem[9]"]
    assert t["f_bond[20]"][quarter] > 1e-3 and t["f_cem[2]"][quarter] == 0, (t["f_bond[20]"][quarter], t["f_cem[2]"][quarter])
    assert (np.diff(t["f_cem[8]"]) >= 0).all()
    figures.below(
        f"{name}: dissipated while unloading and reloading, of all",
        (spent[3 * quarter - 2] - spent[quarter + 2]) / spent[-1],
        0.1 if "updated" in words else 0.05 if words else 0.02,
    )
    empty = slice(2 * quarter - 3, 2 * quarter + 3)
    figures.below(f"{name}: force left at zero opening, of the peak", abs(force[empty]).max() / force.max(), 0.02)
    down, up = slice(quarter + 5, 2 * quarter - 5), slice(2 * quarter + 5, 3 * quarter - 5)
    k = [np.polyfit(gap[part], force[part], 1)[0] for part in (down, up)]
    figures.below(f"{name}: stiffness of reloading against unloading", abs(k[1] / k[0] - 1), 0.02)
    figures.below(f"{name}: imbalance of the energy", abs(t["f_cem[12]"][10:]).max(), 0.005)


@pytest.mark.parametrize("words", ["", "kinematics updated"])
def test_reversal(words, tmp_path, figures, long):
    """Tension and compression alternately, through failure."""
    turns = 10 if long else 3
    script = bond(words, timestep=f"{DT}", damage=BRITTLE, gap=1e-4) + thermo(10, COLUMNS) + ways([4e-5, -4e-5] * turns + [0.0], 2e-5)
    t = run(script, tmp_path).table()
    assert all(np.isfinite(c).all() for c in t.values()) and t["f_cem[2]"][-1] > 50
    assert (np.diff(t["f_cem[8]"]) >= 0).all() and (np.diff(t["f_bond[17]"]) >= 0).all()
    figures.below(f"{words or 'default'}, {turns} turns: imbalance of the energy", abs(t["f_cem[12]"][20:]).max(), 0.02)


@pytest.mark.parametrize("words", ["kinematics updated", "kinematics updated transfer flip 0.99"])
def test_crushing(words, tmp_path, figures, long):
    """Compressed to half its thickness and through failure, with a new reference in every step."""
    script = bond(words, timestep=f"{DT}", damage=BRITTLE, gap=4e-4) + thermo(20, COLUMNS)
    script += ways([-3e-4], 3e-4 if long else 8e-5)
    t = run(script, tmp_path).table()
    assert all(np.isfinite(c).all() for c in t.values()) and t["f_cem[2]"][-1] > 200
    figures.note(f"{words}: failed points", f"{t['f_cem[2]'][-1]:.0f}")
    figures.below(f"{words}: imbalance of the energy", abs(t["f_cem[12]"][10:]).max(), 0.05)


# Residue on a grain vibrates undamped, unless the script damps it.
@pytest.mark.parametrize("words", ["quasistatic 1 0.5", "kinematics updated", "kinematics updated transfer flip 0.9"])
def test_fly_away(words, tmp_path, figures, long):
    """Both grains fly apart, the bond breaks, and its fragments fly on."""
    # Every point of the fragments has nodes of its own: the further apart, the longer a step of `updated` takes.
    far = (0.1 if "updated" in words else 0.2) if long else 0.02
    script = bond(words, timestep=f"{DT}", damage=BRITTLE, gap=2e-4, half_box=(0.05, 0.05, 3 * far))
    script += "velocity first set 0 0 -40\nvelocity second set 3 0 40\nfix motion grains nve/sphere\n" + MOMENTA
    steps = int((far - 0.012) / 40 / DT)
    script += thermo(20, MOMENTUM_COLUMNS + ["f_bond", "f_bond[22]", "f_cem[1]", "f_bond[13]"]) + f"run {steps}\n"
    t = run(script, tmp_path, minutes=20).table()
    name = f"{words or 'default'}, {t['f_bond[13]'][-1] / 0.01:.1f} diameters apart"
    assert t["f_bond[22]"][-1] == 1 and t["f_cem[1]"].min() == t["f_cem[1]"].max()
    P = np.array([t[c] for c in MOMENTUM_COLUMNS[:3]])
    scale = 1.3e-3 * 40  # of a grain
    # What flip keeps is in the points and not in the nodes.
    figures.below(f"{name}: momentum at any step", abs(P - P[:, :1]).max() / scale, 2e-5 if "flip" in words else 4e-14)
    figures.below(f"{name}: momentum at the end", abs(P[:, -1] - P[:, 0]).max() / scale, 1e-9)
    figures.below(f"{name}: force, of the peak", abs(t["f_bond"][-5:]).max() / abs(t["f_bond"]).max(), 1e-6)


@pytest.mark.parametrize("B0", [1e-12, 1e-3])
@pytest.mark.parametrize("words", ["", "kinematics updated"])
def test_no_strength(B0, words, tmp_path, figures):
    """B0 almost zero: the cement fails at once and in order."""
    script = bond(words, timestep=f"{DT}", damage=f"damage tensor B0 {B0} cutoff 0.9") + pull(0.1, 2e-6)
    t = run(script + thermo(10, COLUMNS + ["f_bond[22]", "f_cem[1]"]) + "run 1500\n", tmp_path).table()
    assert all(np.isfinite(c).all() for c in t.values())
    figures.below(f"{words or 'default'}, B0 {B0:g}: share of points not failed", 1 - t["f_cem[2]"][-1] / t["f_cem[1]"][-1], 0.2)
    figures.below(f"{words or 'default'}, B0 {B0:g}: last force", abs(t["f_bond"][-1]), 1e-3)


@pytest.mark.parametrize("B0", [1e20, 1e300])
def test_all_strength(B0, tmp_path, figures):
    """B0 beyond everything: as without damage, whatever the load."""

    def pulled(damage, name):
        script = bond(timestep=f"{DT}", damage=damage) + pull(100.0, 2e-6) + thermo(10, ["f_bond", "f_cem[6]", "f_cem[2]"])
        return run(script + "run 500\n", tmp_path / name).table()

    strong, none = pulled(f"damage tensor B0 {B0} cutoff 0.9", "strong"), pulled("damage none", "none")
    assert strong["f_cem[2]"][-1] == 0
    figures.below(f"B0 {B0:g}: force against no damage", abs(strong["f_bond"] - none["f_bond"]).max() / abs(none["f_bond"]).max(), 1e-9)


@pytest.mark.parametrize("words, share", [("", 0.2), ("transfer flip 0.99", 0.9)])
def test_flight(words, share, tmp_path, figures):
    """A stress-free pair in flight goes through a few cells: what rounding leaves in it adds up, but does not grow by
    itself, as it does with apic where links need much added mass."""
    script = bond(
        f"kinematics updated {words}", timestep=f"auto {share}", boundary="p p p", half_box=(6.5e-3, 6.5e-3, 12e-3), cement="inner 0 outer 2e-3", gap=2e-4
    )
    script += "fix motion grains nve/sphere\nvelocity all set 100 70 30 units box\n"
    energy = run(script + thermo(400, ["f_cem[6]"]) + "run 12000\n", tmp_path).table()["f_cem[6]"]
    third = len(energy) // 3
    # positions are rounded in proportion to the path, and errors add up: 27 to 81 times in three times the steps
    figures.below(
        f"flight, {words or 'apic'}, timestep auto {share}: elastic energy of the end over that of a third of the way",
        energy[-3:].max() / energy[third - 3 : third].max(),
        200,
    )
