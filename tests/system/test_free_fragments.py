# SPDX-License-Identifier: GPL-2.0-or-later
"""Fragments that hold to no grain are bodies of their own: they rest on walls, beads push them, and they push each other."""
import numpy as np
import pytest
from scenes import CONTACT, NEIGHBOURS, cement, dump, edit, host, pair, restarted, run, thermo

E, SPACING, RADIUS, STEP = 1e8, 2e-4, 5e-3, 4e-7
CALCITE, BEADS = 2710.0, 2500.0  # densities
KN = E * 0.75 / (1.25 * 0.5) / RADIUS  # C33 for a Poisson's ratio of 0.25, over the radius of a grain
# The cement is a disc of 3 mm between two beads that fly apart along z. It comes off both at once, and stays at rest.
MATERIAL = edit(
    cement(
        4e-4,
        STEP,
        (E, E, 0.25, 0.25, E / 2.5),
        damage="damage tensor B0 1e12 condense yes check 20",
        couple="kn auto kt auto interface cohesive tn 1e4 tt 1e4 Gn 1e-3 Gt 1e-3 friction 0.3",
    ),
    "group        first id 1\ngroup        second id 2\n",
    "",
)
FLY = "fix down first move linear 0 0 -1\nfix up second move linear 0 0 1\n"
MEASURES = "compute at calcite com\nvariable m atom mass\ncompute mass calcite reduce sum v_m\n"
COLUMNS = ["c_at[1]", "c_mass", "f_cem[12]", "f_cem[13]", "f_cem[19]", "f_cem[24]", "f_cem[37]", "f_cem[38]"]
GROUPS = "group nobody subtract grains grains\ngroup first id 1\ngroup second id 2\n"
MODEL = "model hertz/stiffness tangential history"
BALL = 5e-4  # radius of the bead that pushes

PUSHES = CONTACT + MATERIAL + FLY + "fix ball ball nve/sphere\n" + MEASURES + "variable v equal vx[3]\n" + thermo(20, COLUMNS + ["v_v"])


def beads(ball=False, **options):
    """Two beads with a disc of cement. ball: and a third bead that flies to the middle of the disc at 2 m/s."""
    scene = pair(SPACING, gap=1.2e-3, cement="outer 1.5e-3", half_box=(8e-3, 8e-3, 20e-3), **options)
    if ball:
        set_grains, grains = f"set          type 1 diameter {2 * RADIUS} density 2500\n", "group        grains type 1\n"
        scene = edit(scene, set_grains, "create_atoms 1 single -2.2e-3 0 0 units box\n" + set_grains)
        scene = edit(scene, grains, grains + f"group ball id 3\nset group ball diameter {2 * BALL}\nvelocity ball set 2 0 0 units box\n")
    return scene + GROUPS


def floor_at(z, mesh, directory):
    """A plane that only fragments touch, since the group of its fix is empty."""
    if not mesh:
        return f"fix wall nobody wall/gran {MODEL} primitive type 1 zplane {z}\n"
    corners = [(-4e-3, -4e-3, z), (4e-3, -4e-3, z), (4e-3, 4e-3, z), (-4e-3, 4e-3, z)]
    text = "solid plane\n"
    for part in ((0, 1, 2), (0, 2, 3)):
        text += "facet normal 0 0 1\n outer loop\n" + "".join("  vertex {:.9g} {:.9g} {:.9g}\n".format(*corners[k]) for k in part) + " endloop\nendfacet\n"
    directory.mkdir(exist_ok=True)
    (directory / "plane.stl").write_text(text + "endsolid plane\n")
    return f"fix plane all mesh/surface/stress file plane.stl type 1\nfix wall nobody wall/gran {MODEL} mesh n_meshes 1 meshes plane\n"


@pytest.mark.parametrize("mesh, ranks", [(False, 1), (True, 2)])
def test_rests_on_a_floor(tmp_path, figures, mesh, ranks):
    """The weight grows slowly. The floor carries it on the rim of the disc: each point that it overlaps pushes back by its area, the
    stiffness and its overlap. These sum up to the weight at some depth, and store the energy of that."""
    floor, check, grows, pull = -0.85125e-3, 1000, 4e-3, 200.0
    start = check * STEP  # when the fragment becomes a body; the beads are away then, and the lowest points lose their overlap with the floor
    weight = f"variable t equal step*dt-{start}\nvariable g equal {pull}*((v_t>0)*(v_t<{grows})*v_t/{grows}+(v_t>={grows}))\n"
    weight += "fix weight calcite gravity v_g vector 0 0 -1\n"
    columns = COLUMNS + ["c_at[3]"] + (["f_plane[3]"] if mesh else [])
    scene = edit(beads(), "neighbor     0.0005", "neighbor     0.004")  # ranks know the triangles that the cement at the beads may touch
    text = scene + weight + CONTACT + floor_at(floor, mesh, tmp_path) + edit(MATERIAL, "check 20", f"check {check}") + FLY + MEASURES
    r = run(text + dump(10**6, ["z", "mass"]) + thermo(50, columns) + "run 16000\n", tmp_path, ranks)
    t, points = r.table(), r.points(0)
    side = np.cbrt(points["mass"] / CALCITE)
    radius = np.minimum(0.5 * side, points["z"] - floor)

    def overlaps(fall):
        return np.maximum(radius - (points["z"] - fall - floor), 0.0)

    load, low, high = t["c_mass"][0] * pull, 0.0, 1e-4
    for _ in range(60):
        fall = 0.5 * (low + high)
        low, high = (fall, high) if KN * (side**2 * overlaps(fall)).sum() < load else (low, fall)
    rests = t["step"] > 11000
    assert t["f_cem[19]"][-1] == 1 and t["f_cem[24]"][-1] == 1  # separated, and resolved
    stored, name = 0.5 * KN * (side**2 * overlaps(fall) ** 2).sum(), f"{ranks} ranks"
    figures.below(f"{name}: fall of a fragment to its rest on a floor", abs(-t["c_at[3]"][rests].mean() / fall - 1), 0.01)
    figures.below(f"{name}: energy of the contact at rest", abs(t["f_cem[37]"][rests].mean() / stored - 1), 0.03)
    figures.below(f"{name}: motion at rest over the fall", np.ptp(t["c_at[3]"][rests]) / fall, 0.2)
    figures.below(f"{name}: imbalance of the energy", np.abs(t["f_cem[12]"]).max(), 0.01)
    if mesh:
        figures.below("force on the mesh against the weight", abs(-t["f_plane[3]"][rests].mean() / load - 1), 0.01)


def pushed(before="", steps=1200, after=""):
    return beads(True) + PUSHES + before + f"run {steps}\n" + after


@pytest.mark.parametrize("ranks", [1, 2])
def test_bead_pushes_a_fragment(tmp_path, figures, ranks):
    """The velocities after the push are those of a central elastic impact of two bodies."""
    t = run(pushed(), tmp_path, ranks).table()
    bead, disc, name = BEADS * 4 / 3 * np.pi * BALL**3, t["c_mass"][0], f"{ranks} ranks"
    assert t["f_cem[37]"].max() > 0 == t["f_cem[37]"][-1]
    figures.below(f"{name}: velocity of the bead after it", abs(t["v_v"][-1] / (2.0 * (bead - disc) / (bead + disc)) - 1), 1e-3)
    speed = (t["c_at[1]"][-1] - t["c_at[1]"][-11]) / (10 * 20 * STEP)
    figures.below(f"{name}: velocity of the disc", abs(speed / (2.0 * 2.0 * bead / (bead + disc)) - 1), 1e-3)
    momentum = (bead * t["v_v"] + t["f_cem[13]"])[t["step"] > 100]
    figures.below(f"{name}: change of the momentum", np.ptp(momentum) / (2.0 * bead), 1e-13)
    figures.below(f"{name}: imbalance of the energy", np.abs(t["f_cem[12]"]).max(), 0.01)


@pytest.mark.parametrize("ranks", [1, 2])
def test_restart_while_pushed(tmp_path, ranks):
    """A run from a restart file in the middle of the push goes on bitwise identically, and one rank and two agree up to rounding."""
    whole = run(pushed(), tmp_path / "whole", ranks).table()
    run(pushed(steps=300, after="write_restart half\n"), tmp_path / "half", ranks)
    rest = run(
        restarted(tmp_path / "half" / "half") + "group grains type 1\n" + GROUPS + "group ball id 3\n" + PUSHES + "run 900\n", tmp_path / "rest", ranks
    ).table()
    at = whole["step"] >= 300
    assert whole["f_cem[37]"][at][0] > 0.0
    # a file has sums over time of all ranks together, so their rounding differs on two ranks
    for name in ["f_cem[13]", "f_cem[19]", "f_cem[24]", "f_cem[37]", "v_v"] + (["f_cem[12]", "f_cem[38]"] if ranks == 1 else []):
        assert np.array_equal(whole[name][at], rest[name]), name
    if ranks > 1:
        one = run(pushed(), tmp_path / "one", 1).table()
        for name in ("v_v", "f_cem[13]", "f_cem[37]"):
            assert np.allclose(one[name], whole[name], rtol=1e-6, atol=1e-9 * np.abs(one[name]).max()), name


def test_fragment_pushes_a_fragment(tmp_path, figures):
    """A disc that flew along with its beads at 2 m/s hits one at rest in the middle of its rim. Equal bodies exchange their velocities."""
    scene = host() + "region box block -14e-3 14e-3 -8e-3 8e-3 -20e-3 20e-3 units box\ncreate_box 2 box\n"
    for x in (-5.1e-3, 5.1e-3):
        scene += "".join(f"create_atoms 1 single {x} 0 {z} units box\n" for z in (-5.6e-3, 5.6e-3))
    scene += f"set type 1 diameter {2 * RADIUS} density {BEADS}\ngroup grains type 1\ngroup fly id 1 2\nvelocity fly set 2 0 0 units box\n" + NEIGHBOURS
    for two in ("1 2", "3 4"):
        scene += f"create_cement calcite pair {two} shape flat outer 1.5e-3 film grid spacing {SPACING}\n"
    scene += CONTACT + MATERIAL
    for bead, (along, up) in enumerate(((2, -1), (2, 1), (0, -1), (0, 1)), 1):
        scene += f"group bead{bead} id {bead}\nfix move{bead} bead{bead} move linear {along} 0 {up}\n"
    r = run(scene + dump(500, ["x"]) + thermo(500, ["f_cem[12]", "f_cem[13]", "f_cem[24]", "f_cem[37]"]) + "run 10500\n", tmp_path)
    t, before, after = r.table(), r.points(10000), r.points(10500)
    assert t["f_cem[24]"][-1] == 2 and t["f_cem[37]"].max() > 0 == t["f_cem[37]"][-1]
    half = len(before["id"]) // 2
    speeds = [(after["x"][part].mean() - before["x"][part].mean()) / (500 * STEP) for part in (slice(half), slice(half, None))]
    figures.below("velocity of the first fragment, of 2 m/s", abs(speeds[0]) / 2, 1e-3)
    figures.below("velocity of the second", abs(speeds[1] / 2 - 1), 1e-3)
    figures.below("change of the momentum", np.ptp(t["f_cem[13]"]) / t["f_cem[13]"][0], 2e-13)
    figures.below("imbalance of the energy", np.abs(t["f_cem[12]"]).max(), 0.01)
