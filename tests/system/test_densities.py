# SPDX-License-Identifier: GPL-2.0-or-later
"""Cements of unlike density in one scene: `density` of cement_material."""
import re

import numpy as np
import pytest
from scenes import CALCITE, MOMENTA, MOMENTUM_COLUMNS, SPINNING, cement, edit, launch, pair, point_quantities, restarted, run, thermo

RADIUS, GAP, HEAVY, CALCITE_DENSITY = 5e-3, 2e-4, 6000.0, 2710.0
FLAT = "inner 0.5e-3 outer 2e-3"
SHAPES = "shape coating thickness 3e-4 cap 24 material heavy shape flat inner 0.5e-3 outer 2e-3"
CELL = 3e-4
STEP = 1.5e-8
BAR = 0.4e-3  # radius of a bar
MATERIAL = f"cement_material heavy density {HEAVY}\n"


def scene(shapes, material="", density="", gap=GAP, cell=CELL):
    """Two grains whose cement is of these shapes."""
    text = pair(cell / 2, gap=gap, cement=FLAT)
    return edit(text, f"create_cement calcite pair 1 2 shape flat {FLAT} film grid", f"{material}create_cement calcite pair 1 2 {shapes} film grid {density}")


def fixes(words="", elastic=CALCITE, couple="kn auto kt auto"):
    return cement(CELL, STEP, elastic=elastic, axis="radial", damage=words, couple=couple)


MOTION = ["f_cem[5]", "f_cem[6]", "f_cem[12]", *(f"f_cem[{n}]" for n in range(13, 19)), "f_bond[9]"]


@pytest.mark.parametrize("words", ["", "condense yes", "mass_order 2", "reproject 7", "kinematics updated", "quasistatic 9 0.05", "subcycle 3"])
def test_all_cement_of_one_material(tmp_path, words):
    """A bond of a material with this density is bitwise that of a scene with this density."""
    rest = fixes(words) + SPINNING + thermo(20, MOTION) + "run 100\n"
    named = run(scene(f"shape flat {FLAT} material heavy", MATERIAL) + rest, tmp_path / "named").table()
    whole = run(scene(f"shape flat {FLAT}", "", f"density {HEAVY}") + rest, tmp_path / "whole").table()
    light = run(scene(f"shape flat {FLAT}") + rest, tmp_path / "light").table()
    assert all(np.array_equal(named[c], whole[c]) for c in MOTION)
    assert named["f_cem[5]"][0] > 2 * light["f_cem[5]"][0]


@pytest.mark.parametrize("words, ranks", [("", 1), ("", 2), ("condense yes", 1), ("condense yes", 2), ("mass_order 2", 1)])
def test_mass_and_momentum(tmp_path, figures, words, ranks):
    """A bond of two cements that moves as its grains: mass by volumes and densities, momentum m v, kinetic energy m v^2/2."""
    text = edit(scene(SHAPES, MATERIAL), "create_cement", "velocity all set 3 -2 5\ncreate_cement")
    text += fixes(words) + point_quantities(["volume", "material"]) + "fix motion grains nve/sphere\n"
    text += thermo(1, ["f_cem[5]", "f_cem[13]", "f_cem[14]", "f_cem[15]"])
    text += 'dump points calcite custom 1 points.*.txt id mass density c_volume c_material\ndump_modify points sort id format "%d %.17g %.17g %.17g %.17g"\n'
    result = run(text + "run 0\n", tmp_path, ranks)
    points, t = result.points(0), result.table()
    density = np.where(points["c_material"] == 1, HEAVY, CALCITE_DENSITY)
    assert np.array_equal(points["density"], density) and set(points["c_material"]) == {0, 1}
    mass = (density * points["c_volume"]).sum()
    what = f"two densities, {words or 'resolved'}, {ranks} ranks"
    figures.below(f"{what}: masses of points", abs(points["mass"].sum() / mass - 1), 1e-14)
    momentum = np.array([t[f"f_cem[{n}]"][0] for n in (13, 14, 15)])
    figures.below(f"{what}: momentum off m v, over it", np.abs(momentum / (mass * np.array([3, -2, 5])) - 1).max(), 1e-12)
    figures.below(f"{what}: kinetic energy off m v^2/2, over it", abs(t["f_cem[5]"][0] / (0.5 * mass * 38) - 1), 1e-12)
    content = float(re.search(r"content \(mass over mass of the grains\) (\S+),", result.output)[1])
    figures.below(f"{what}: content of create_cement off the sum of the points", abs(content / (mass / (2 * 2500 * 4 / 3 * np.pi * RADIUS**3)) - 1), 1e-5)


BREAKS = "damage tensor B0 500 cutoff 0.6"


@pytest.mark.parametrize("words", ["", "condense yes", BREAKS, BREAKS + " cracks split", BREAKS + " condense yes"])
def test_momentum_of_a_free_pair(tmp_path, figures, words):
    """Momentum and angular momentum of a spinning pair with two cements are kept, also where nodes split and the bond breaks; its energy balance closes."""
    text = scene(SHAPES, MATERIAL) + fixes(words, couple="kn auto kt auto friction 0.3" if "split" in words else "kn auto kt auto")
    text += SPINNING + MOMENTA + thermo(50, ["f_cem[2]", "f_cem[12]", *MOMENTUM_COLUMNS])
    t = run(text + "run 800\n", tmp_path).table()
    assert (t["f_cem[2]"][-1] > 20) == ("damage" in words), t["f_cem[2]"]
    scales = {"P": max(np.abs(t[f"v_P{d}"]).max() for d in "xyz"), "L": max(np.abs(t[f"v_L{d}"]).max() for d in "xyz")}
    drift = max(np.ptp(t[f"v_{q}{d}"]) / scales[q] for q in "PL" for d in "xyz")
    figures.below(f"spinning pair of two densities, {words or 'elastic'}: drift of momenta, over them", drift, 5e-8 if "condense" in words else 1e-10)
    figures.below(f"spinning pair of two densities, {words or 'elastic'}: imbalance of the energy", np.abs(t["f_cem[12]"]).max(), 2e-4)


def bars(directory):
    """Two bars of length 2.4 mm between grains that are held after a stretch, the second of the heavy cement; the loads by time."""
    length, cell = 2.4e-3, 1.5e-4
    text = pair(cell / 2, gap=length, cement=f"inner 0 outer {BAR}", half_box=(14e-3, 6e-3, 12.5e-3))
    more = "".join(f"create_atoms 1 single 0.012 0 {side * (RADIUS + length / 2):.15g} units box\n" for side in (-1, 1))
    text = edit(text, "set          type 1 diameter", more + "set          type 1 diameter")
    made = text[text.index("create_cement") :]
    bar = made.split("pair 1 2 ")[1]
    text = edit(text, made, f"{MATERIAL}{made}create_cement calcite pair 3 4 material heavy {bar}")
    timestep = 8e-9
    text += cement(cell, timestep, elastic=(50e9, 50e9, 0.25, 0.25, 20e9)).replace("id 2", "id 2 4")
    text += "group held id 1 3\n"
    text = text.replace("group        first id 1\n", "")
    rise = 6e-7  # s, about half of the shorter period
    text += f'variable t equal step*dt\nvariable s equal "(v_t<{rise})*v_t/{rise}+(v_t>={rise})"\nvariable x equal "1e-8*(v_s-sin(2*PI*v_s)/2/PI)"\n'
    text += f'variable v equal "1e-8/{rise}*(1-cos(2*PI*v_s))"\n'
    text += "fix hold held move linear 0 0 0\nfix pull second move variable NULL NULL v_x NULL NULL v_v\n"
    text += thermo(2, ["f_bond[1][9]", "f_bond[2][9]"])
    return run(text + "run 1600\n", directory).table(), length, timestep


def frequency(force, time):
    """Of the strongest harmonic: the peak of the spectrum under a window."""
    force = (force - force.mean()) * np.hanning(len(force))
    spectrum = np.abs(np.fft.rfft(force, 64 * len(force)))
    return np.fft.rfftfreq(64 * len(force), time[1] - time[0])[spectrum.argmax()]


def test_frequency_of_a_bar(tmp_path, figures):
    """A bar that is held at both ends rings at c/(2 L), c^2 = E/rho of its own density, with 1 - (nu pi a/(2 L))^2 for its inertia across."""
    t, length, timestep = bars(tmp_path)
    late = t["step"] * timestep > 6e-7
    a = BAR
    sag = RADIUS - np.sqrt(RADIUS**2 - a**2)  # the bar ends on spheres
    for n, density in ((1, CALCITE_DENSITY), (2, HEAVY)):
        found = frequency(t[f"f_bond[{n}][9]"][late], t["step"][late] * timestep)
        exact = np.sqrt(50e9 / density) / (2 * (length + sag)) * (1 - (0.25 * np.pi * a / (2 * length)) ** 2)
        figures.note(f"bar of density {density:g}: frequency in kHz, by the program and by the closed form", f"{found / 1e3:.1f}, {exact / 1e3:.1f}")
        figures.below(f"bar of density {density:g} that is held at its ends: frequency off the closed form", abs(found / exact - 1), 0.02)


def test_ranks(tmp_path, figures):
    """Cements of two densities on two ranks."""
    text = scene(SHAPES, MATERIAL) + fixes() + SPINNING + thermo(50, MOTION)
    one, two = (run(text + "run 200\n", tmp_path / str(r), r).table() for r in (1, 2))
    for group in (MOTION[:1], MOTION[1:2], MOTION[3:6], MOTION[6:9], MOTION[9:]):
        scale = max(np.abs(one[c]).max() for c in group)
        off = max(np.abs(one[c] - two[c]).max() for c in group) / scale
        figures.below(f"two ranks, two densities: difference of {group[0]} and its like, over the largest", off, 1e-7)


@pytest.mark.parametrize("condense", ["", "condense yes", BREAKS + " cracks split"])
def test_restart(tmp_path, condense):
    """A run continued from a restart file is bitwise that without one."""
    text = scene(SHAPES, MATERIAL) + fixes(condense) + SPINNING + thermo(50, MOTION)
    whole = run(text + "run 300\nwrite_restart half.rst\nrun 300\n", tmp_path).table()
    again = run(
        restarted("half.rst") + fixes(condense) + "fix motion grains nve/sphere\n" + thermo(50, MOTION) + "run 300\n", tmp_path, name="in.again"
    ).table()
    late = whole["step"] >= 350
    for c in MOTION:
        assert np.array_equal(whole[c][late][-6:], again[c][-6:]), c


def test_content_and_deleted_mass(tmp_path):
    """`content` of a shape is a mass of its own cement, and delete_bond counts the mass of the bond."""
    volume = []
    for words in ("material heavy", ""):
        made = run(scene(f"shape flat inner 0.5e-3 content 0.002 {words}", MATERIAL) + fixes() + "run 0\ndelete_bond pair 1 2\n", tmp_path)
        volume.append(float(re.search(r"\n  volume (\S+), content \(mass over mass of the grains\) 0.002,", made.output)[1]))
        mass = float(re.search(r"delete_bond: 1 of 1 bonds, \d+ points, mass (\S+),", made.output)[1])
        assert abs(mass / (0.002 * 2 * 2500 * 4 / 3 * np.pi * RADIUS**3) - 1) < 1e-4
    assert abs(volume[0] * HEAVY / (volume[1] * CALCITE_DENSITY) - 1) < 1e-4


def test_cement_of_the_scene_may_come_later(tmp_path):
    """A scene whose cement all has a density of its own takes cement of another density after a run."""
    text = scene(f"shape flat {FLAT} material heavy", MATERIAL)
    text = edit(text, "set          type 1 diameter", "create_atoms 1 single 0 0 0.0156 units box\nset          type 1 diameter").replace(
        "0.0125 units", "0.025 units"
    )
    text += fixes() + "fix motion grains nve/sphere\n" + thermo(1, ["f_cem[1]", "f_cem[28]"])
    r = run(text + f"run 10\ncreate_cement calcite pair 2 3 shape flat {FLAT} film grid spacing {CELL / 2}\nrun 10\ndelete_bond pair 2 3\n", tmp_path)
    made = re.findall(r"\n  volume (\S+), content \(mass", r.output)
    mass = float(re.search(r"delete_bond: 1 of 2 bonds, \d+ points, mass (\S+),", r.output)[1])
    assert abs(mass / (float(made[1]) * CALCITE_DENSITY) - 1) < 1e-4


@pytest.mark.parametrize(
    "material, create, more, message",
    [
        ("cement_material heavy density 0\n", "", "", "'density 0': must be greater than 0"),
        ("cement_material heavy density\n", "", "", "a number for 'density'"),
        (MATERIAL, "material heavy density 2710", "", "leave the word out, or change 'density' of cement_material"),
        (MATERIAL, "material heavy", "set group calcite density 3000\n", "points of a material with a 'density' of its own have another density"),
        (MATERIAL, "", f"create_cement calcite pair 1 2 shape flat {FLAT} spacing 1.5e-4 density 2000\n", "cement"),
    ],
)
def test_refused(tmp_path, material, create, more, message):
    """One error that names the word and the cure."""
    r = launch(scene(f"shape flat {FLAT} {create}", material) + more + fixes() + "fix motion grains nve/sphere\nrun 0\n", tmp_path, ranks=2)
    assert r.status != 0 and any(message in e for e in r.errors()), r.output[-1500:]
    assert len(set(r.errors())) == 1
