# SPDX-License-Identifier: GPL-2.0-or-later
"""The same bond at other masses, moduli, units and speeds."""
import numpy as np
import pytest
from bonds import BRITTLE, CELL, bond
from scenes import VTI, edit, pull, run, thermo


def rows(t):
    return np.array([t[c] for c in t if c != "step"])


@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e9, 1e12])
def test_mass_ratio(ratio, tmp_path, figures):
    """Free grains of up to 1e12 times the mass of their cement fly apart slowly."""
    volume_of_cement, volume_of_grain = 6.1e-9, 4 / 3 * np.pi * 5e-3**3
    density = ratio * volume_of_cement * 2710 / volume_of_grain
    script = edit(bond(), "density 2500", f"density {density:.6g}") + (
        "velocity first set 0 0 -1e-3\nvelocity second set 0 0 1e-3\nfix motion grains nve/sphere\n"
        "variable p atom mass*vz\ncompute p grains reduce sum v_p\nvariable p equal c_p+f_cem[15]\n"
        f'variable P equal "{density}*{volume_of_grain}*1e-3"\nvariable drift equal v_p/v_P\n'
    ).replace("variable p equal", "variable q equal").replace("v_p/v_P", "v_q/v_P")
    t = run(script + thermo(20, ["v_drift", "f_bond", "f_bond[13]", "f_cem[12]"]) + "run 2000\n", tmp_path).table()
    assert all(np.isfinite(c).all() for c in t.values())
    figures.below(f"mass of a grain {ratio:g} times that of the cement: momentum over that of a grain", abs(t["v_drift"]).max(), 7e-14)
    if ratio > 1e5:  # grains go on as they were: a pull at constant speed
        gap, force = t["f_bond[13]"], t["f_bond"]
        late = slice(len(gap) // 3, None)
        fit = np.polyfit(gap[late], force[late], 1)
        figures.note(f"mass ratio {ratio:g}: stiffness", f"{fit[0]:.4g} N/m")
        figures.below(f"mass ratio {ratio:g}: opening against 2e-3 m/s times time", abs(gap[-1] / (2e-3 * 2000 * step(t)) - 1), 1e-3)


def step(t):
    return t["f_bond[13]"][-1] / 2e-3 / (t["step"][-1] - t["step"][0])


def pulled(E_scale=1.0):
    """A pull to failure where every stress is E_scale times the usual, and time scales with it."""
    s = E_scale**0.5
    elastic = tuple(e * E_scale if e > 1 else e for e in VTI)
    return (
        bond(timestep=f"{2e-8 / s:.15g}", elastic=elastic, damage=f"damage tensor B0 {9.6e6 * E_scale:.15g} cutoff 0.9")
        + pull(f"{4.0 * s:.15g}", f"{4e-6 / s:.15g}")
        + thermo(5, ["f_bond", "f_bond[13]", "f_cem[8]", "f_cem[2]"])
        + "run 600\n"
    )


@pytest.mark.parametrize("modulus", [1.0, 1e3, 1e6, 1e12])
def test_modulus(modulus, tmp_path, figures):
    """Moduli of 1 Pa to 1 TPa: force and energy scale, the rest is the same."""
    usual, other = (run(pulled(f), tmp_path / str(n)).table() for n, f in enumerate((1.0, modulus / VTI[0])))
    f = modulus / VTI[0]
    assert usual["f_cem[2]"][-1] > 100
    for column, scale in (("f_bond", f), ("f_bond[13]", 1.0), ("f_cem[8]", f)):
        figures.below(f"modulus {modulus:g} Pa: {column} after scaling", abs(other[column] / scale - usual[column]).max() / abs(usual[column]).max(), 1e-9)


# length, mass and time of one SI unit
UNITS = {"si": (1.0, 1.0, 1.0), "cgs": (1e2, 1e3, 1.0), "micro": (1e6, 1e15, 1e6)}


def in_units(name):
    L, M, T = UNITS[name]
    pressure, density = M / L / T**2, M / L**3
    box = f"{-6e-3 * L:.15g} {6e-3 * L:.15g}"
    return (
        f"""\
units        {name}
atom_style   mpdem
atom_modify  map array first grains
boundary     f f f
newton       off
communicate  single vel yes
region       box block {box} {box} {-12.5e-3 * L:.15g} {12.5e-3 * L:.15g} units box
create_box   2 box
create_atoms 1 single 0 0 {-5e-3 * L:.15g} units box
create_atoms 1 single 0 0 {5e-3 * L:.15g} units box
set          type 1 diameter {1e-2 * L:.15g} density {2500 * density:.15g}
group        grains type 1
communicate  single vel yes group grains
neighbor     {5e-4 * L:.15g} bin
neigh_modify include grains delay 0
create_cement calcite pair 1 2 shape flat inner {1.4e-3 * L:.15g} outer {2.2e-3 * L:.15g} film grid spacing {CELL / 2 * L:.15g}
timestep     {2e-8 * T:.15g}
fix          cem calcite mpm cell {CELL * L:.15g} elastic vti {60e9 * pressure:.15g} {40e9 * pressure:.15g} 0.25 0.2 {18e9 * pressure:.15g} damage tensor B0 {9.6e6 * pressure:.15g}
fix          bond grains mpm/couple cem
group        first id 1
group        second id 2
"""
        + pull(f"{4.0 * L / T:.15g}", f"{4e-6 * T:.15g}")
        + thermo(5, ["f_bond", "f_bond[13]", "f_cem[8]", "f_cem[2]"])
        + "run 600\n"
    )


@pytest.mark.parametrize("name", ["cgs", "micro"])
def test_units(name, tmp_path, figures):
    """The same scene in cgs and micro units gives the same numbers after scaling, with the default density."""
    si, other = (run(in_units(n), tmp_path / n).table() for n in ("si", name))
    L, M, T = UNITS[name]
    assert si["f_cem[2]"][-1] > 100
    for column, scale in (("f_bond", M * L / T**2), ("f_bond[13]", L), ("f_cem[8]", M * L**2 / T**2)):
        figures.below(f"units {name}: {column} after scaling", abs(other[column] / scale - si[column]).max() / abs(si[column]).max(), 3e-9)


@pytest.mark.parametrize("speed", [400.0, 40.0, 4.0, 0.4, pytest.param(0.04, marks=pytest.mark.long), pytest.param(0.004, marks=pytest.mark.long)])
def test_loading_rate(speed, tmp_path, figures):
    """Pulled apart at 400 m/s down to 4 mm/s: energy is kept, the bond breaks. Cement that breaks in a
    few steps needs shorter ones."""
    dt = 2e-8 * min(1.0, 10.0 / speed)
    ramp = min(2e-6, 2e-5 / speed)
    steps = int((3e-5 / speed + 3e-5) / dt)
    # Wide enough for fragments, which fly on meanwhile.
    script = bond(timestep=f"{dt}", damage=BRITTLE, half_box=(4e-2, 4e-2, 4e-2)) + pull(speed, ramp)
    script += thermo(max(1, steps // 400), ["f_bond", "f_bond[17]", "f_bond[21]", "f_cem[12]", "f_cem[2]"]) + f"run {steps}\n"
    t = run(script, tmp_path).table()
    assert all(np.isfinite(c).all() for c in t.values()) and t["f_cem[2]"][-1] > 100
    peak = t["f_bond"].argmax()
    figures.below(f"{speed:g} m/s, {steps} steps: imbalance of the energy after the peak", abs(t["f_cem[12]"][peak:]).max(), 0.002)
    figures.note(f"{speed:g} m/s: peak force", f"{t['f_bond'].max():.0f} N")
