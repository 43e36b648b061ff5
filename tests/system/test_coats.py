# SPDX-License-Identifier: GPL-2.0-or-later
"""Grains with coats: mass, moment of inertia and contact against closed forms, restart, ranks, and scenes in which a coat that weighs nothing is none."""
import re

import numpy as np
import pytest
from scenes import NEIGHBOURS, cement, host, launch, run, thermo

R, T = 1e-3, 5e-5
RHO, COAT = 2500.0, 8000.0  # a dense coat, so that its moment of inertia is not that of a full sphere
MASS = 4 / 3 * np.pi * R**3 * RHO
COAT_MASS = 4 / 3 * np.pi * ((R + T) ** 3 - R**3) * COAT
INERTIA = 0.4 * MASS * R**2 + 8 / 15 * np.pi * ((R + T) ** 5 - R**5) * COAT
YOUNG, NU, MU = 5e7, 0.25, 0.4
STAR = YOUNG / (2 * (1 - NU**2))

CONTACT = f"""\
fix          c1 all property/global youngsModulus peratomtype {YOUNG} {YOUNG}
fix          c2 all property/global poissonsRatio peratomtype {NU} {NU}
fix          c3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.9 0.9 0.9
fix          c4 all property/global coefficientFriction peratomtypepair 2 {MU} {MU} {MU} {MU}
pair_style   gran model hertz tangential history
pair_coeff   * *
"""
MPM = "fix cem calcite mpm cell 2e-4 elastic isotropic 6e10 0.2 coupling none\n"


def grains(centres, radii=None, half=1e-2, ranks=1, boundary="f f f"):
    """Grains without cement."""
    text = host(boundary=boundary, processors=f"{ranks} 1 1") + f"region box block {-half} {half} {-half} {half} {-half} {half} units box\ncreate_box 2 box\n"
    for n, x in enumerate(centres):
        text += "create_atoms 1 single " + " ".join(f"{c:.17g}" for c in x) + " units box\n"
    text += "group grains type 1\n"
    for n in range(len(centres)):
        text += f"set atom {n + 1} diameter {2 * (R if radii is None else radii[n]):.17g} density {RHO}\n"
    return text + NEIGHBOURS + CONTACT


def coat(thickness=T, density=COAT, group="grains", words=""):
    return f"create_cement calcite coat {group} thickness {thickness:.17g} density {density:.17g} {words}\n"


def state(columns, steps, every=None, file="grains"):
    formats = " ".join(["%d"] + ["%.17g"] * len(columns))
    return f"dump {file} grains custom {every or steps} {file}.*.txt id {' '.join(columns)}\ndump_modify {file} sort id format \"{formats}\"\n"


def test_mass_and_size(tmp_path, figures):
    """LIGGGHTS has the mass of grain and shell, its outer radius and its mean density, and gravity acts on that mass."""
    text = (
        grains([(0, 0, 0), (4e-3, 0, 0)])
        + "group one id 1\n"
        + coat(group="one")
        + MPM
        + "timestep 1e-6\nfix g all gravity 9.81 vector 0 0 -1\nfix m grains nve/sphere\n"
    )
    at = run(text + state(["mass", "radius", "density", "fz"], 1) + "run 1\n", tmp_path).points(1, "grains")
    for name, value, exact in (
        ("mass", at["mass"][0], MASS + COAT_MASS),
        ("radius", at["radius"][0], R + T),
        ("mean density", at["density"][0], (MASS + COAT_MASS) / (4 / 3 * np.pi * (R + T) ** 3)),
        ("weight", -at["fz"][0], 9.81 * (MASS + COAT_MASS)),
        ("mass without a coat", at["mass"][1], MASS),
    ):
        figures.below(f"{name} of a grain: off the closed form", abs(value / exact - 1), 1e-12)


@pytest.mark.parametrize("walls", ["coat", "bare"])
def test_rolling(walls, tmp_path, figures):
    """A sphere slides over a wall until it rolls: v = v0/(1 + I/(m r^2)), by the angular momentum about the line of contact, and omega = v/r."""
    v0, radius = 0.05, R + T if walls == "coat" else R
    mass = MASS + COAT_MASS
    kn = 4 / 3 * YOUNG / (1 - NU**2) / 2 * np.sqrt(radius)  # a rigid wall has the same modulus
    overlap = (9.81 * mass / kn) ** (2 / 3)
    text = grains([(-5e-3, 0, radius - overlap)]) + coat(words=f"walls {walls}") + MPM
    text += "timestep 1e-6\nfix floor grains wall/gran model hertz tangential history primitive type 2 zplane 0.0\nfix g all gravity 9.81 vector 0 0 -1\nfix m grains nve/sphere\n"
    at = run(text + f"velocity grains set {v0} 0 0\n" + state(["vx", "omegay", "z"], 40000) + "run 40000\n", tmp_path).points(40000, "grains")
    lever = radius - overlap
    exact = v0 / (1 + INERTIA / (mass * lever**2))
    figures.below(f"{walls} at walls: speed of rolling off the closed form with the shell's moment of inertia", abs(at["vx"][0] / exact - 1), 1e-3)
    figures.below(f"{walls} at walls: speed of the surface over that of the centre, less 1", abs(at["omegay"][0] * lever / at["vx"][0] - 1), 1e-3)
    full = v0 / (1 + 0.4 * ((R + T) / lever) ** 2)
    assert abs(exact / full - 1) > 5e-3, "a full sphere would roll as fast"


def force_at_rest(text, directory):
    return run(
        text + (MPM if "create_cement" in text else "") + "timestep 1e-7\nfix m grains nve/sphere\n" + state(["fx", "fy", "fz"], 1) + "run 0\n", directory
    ).points(0, "grains")


@pytest.mark.parametrize("overlap", [-1e-9, 1e-9, 5e-6])
def test_contact_begins_at_the_coat(overlap, tmp_path, figures):
    """Of a coated grain and one without, and of two coated ones, which come together after they were coated: the force of Hertz with outer radii."""
    for name, group, coats in (("both", "grains", 2), ("one", "one", 1)):
        distance = 2 * R + coats * T - overlap
        text = (
            grains([(0, 0, 0), (4e-3, 0, 0)])
            + "group one id 1\ngroup two id 2\n"
            + coat(group=group)
            + f"displace_atoms two move {distance - 4e-3:.17g} 0 0 units box\n"
        )
        at = force_at_rest(text, tmp_path / name)
        r1, r2 = R + T, R + (coats - 1) * T
        exact = 0.0 if overlap < 0 else 4 / 3 * STAR * np.sqrt(r1 * r2 / (r1 + r2)) * overlap**1.5
        if overlap < 0:
            assert at["fx"][1] == 0.0
        else:
            figures.below(f"{name} coated, overlap {overlap} m: force off that of Hertz", abs(at["fx"][1] / exact - 1), 1e-6 if overlap > 1e-8 else 1e-3)


@pytest.mark.parametrize("gap", [-2e-6, 1e-6, 9e-5, 1.1e-4])
def test_near_grains_touch_bare(gap, tmp_path, figures):
    """Grains whose coats would overlap where they are touch as if they had none; others do not touch yet."""
    text = grains([(0, 0, 0), (2 * R + gap, 0, 0)])
    coated = run(text + coat() + MPM + "timestep 1e-7\nfix m grains nve/sphere\n" + state(["fx"], 1) + "run 0\n", tmp_path / "coated")
    at, bare = coated.points(0, "grains"), force_at_rest(text, tmp_path / "bare")
    assert int(re.search(r"nearer than their coats are (\d+) pairs", coated.output)[1]) == (gap < 2 * T)
    assert (bare["fx"][1] != 0.0) == (gap < 0)
    figures.below(
        f"gap {gap} m: difference of the forces over that of an overlap of 2 um",
        abs(at["fx"][1] - bare["fx"][1]) / (4 / 3 * STAR * np.sqrt(R / 2) * 2e-6**1.5),
        1e-12,
    )


def cloud(seed=3):
    """Grains of two sizes that touch some others and fly about."""
    random = np.random.default_rng(seed)
    radii = np.where(np.arange(27) % 2, R, 0.85 * R)
    places = np.array([(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]) * 1.845 * R
    return places + random.uniform(-0.03, 0.03, (27, 3)) * R, radii


FLIGHT = "variable vx atom -60*x+20*y\nvariable vy atom -60*y-20*z\nvariable vz atom -60*z\nvelocity grains set v_vx v_vy v_vz\nfix m grains nve/sphere\ntimestep 5e-7\n"
STEPS = 4000


def fly(words, directory, ranks=1, run_text=f"run {STEPS}\n"):
    centres, radii = cloud()
    text = (
        grains(centres, radii, ranks=ranks)
        + words
        + (MPM if words else "")
        + FLIGHT
        + "compute p all pressure thermo_temp virial\ncompute s grains stress/atom virial\ncompute ss grains reduce sum c_s[1]\n"
    )
    text += thermo(STEPS // 8, ["ke", "c_p", "c_ss", "c_touch"]).replace("thermo_style", "compute touch grains reduce sum c_near\nthermo_style", 1)
    text = text.replace("compute touch", "compute near grains contact/atom\ncompute touch", 1)
    return run(text + state(["x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz"], STEPS) + run_text, directory, ranks)


def test_weightless_coat_is_none(tmp_path, figures):
    """27 grains that collide, some of which touch at the start: with coats of a picometre and next to no density all goes as without."""
    plain, coated = fly("", tmp_path / "plain"), fly(coat(1e-12, 1e-6), tmp_path / "coated")
    pairs = int(re.search(r"nearer than their coats are (\d+) pairs", coated.output)[1])
    assert pairs >= 20
    a, b = plain.points(STEPS, "grains"), coated.points(STEPS, "grains")
    for what in (("x", "y", "z"), ("vx", "vy", "vz"), ("omegax", "omegay", "omegaz")):
        size = max(np.abs(a[c]).max() for c in what)
        figures.below(
            f"{what[0][:-1] or 'position'} of 27 grains with weightless coats: difference over the largest",
            max(np.abs(a[c] - b[c]).max() for c in what) / size,
            1e-6,
        )
    s, t = plain.table(), coated.table()
    assert s["c_touch"].max() > 20
    for c in ("c_p", "c_ss"):
        figures.below(f"{c} of 27 grains with weightless coats: difference over the largest", np.abs(s[c] - t[c]).max() / np.abs(s[c]).max(), 1e-5)


@pytest.mark.parametrize(
    "words, centre, ranks, number",
    [("walls coat", R, 1, 1), ("walls coat", R, 2, 1), ("walls bare", R, 1, 0), ("walls coat", R + T * 0.999, 1, 0), ("walls coat", R - 0.5 * T, 1, 1)],
)
def test_coats_that_walls_press(words, centre, ranks, number, tmp_path):
    """New coats that overlap a wall are told once, with how many and how deep; coats of a restart file are not."""
    text = grains([(-2e-3, 0, centre), (2e-3, 0, centre), (0, 0, 4 * R)], ranks=ranks) + coat(words=words) + MPM
    rest = "timestep 1e-7\nfix floor grains wall/gran model hertz tangential history primitive type 2 zplane 0.0\nfix m grains nve/sphere\n"
    result = run(text + rest + "run 1\nrun 1\nwrite_restart coated.restart\n", tmp_path, ranks)
    told = [line for line in result.output.splitlines() if "coated grains press walls" in line]
    assert len(told) == number, told
    if number:
        share = float(re.search(r"the deepest by (\S+) of the thickness", told[0])[1])
        assert "2 coated grains" in told[0] and "'walls bare'" in told[0] and abs(share - (R + T - centre) / T) < 1e-3, told
    again = run(host() + "read_restart coated.restart\n" + NEIGHBOURS + CONTACT + MPM + rest + "run 0\n", tmp_path, name="in.again")
    assert "coated grains press walls" not in again.output


def test_rotational_energy_of_liggghts(tmp_path, figures):
    """compute erotate/sphere counts a coated grain as a full sphere of its mass and of the radius with coat, which is not its moment of inertia."""
    text = grains([(0, 0, 0)]) + coat() + MPM + "timestep 1e-7\nfix m grains nve/sphere\nset group grains omegaz 300\ncompute e grains erotate/sphere\n"
    energy = run(text + thermo(1, ["c_e"]) + "run 1\n", tmp_path).table()["c_e"][-1]
    figures.below(
        "compute erotate/sphere of a coated grain off m (R + t)^2 w^2/5", abs(energy / (0.2 * (MASS + COAT_MASS) * (R + T) ** 2 * 300**2) - 1), 1e-12
    )
    assert abs(energy / (0.5 * INERTIA * 300**2) - 1) > 0.01


def test_ranks_and_restart(tmp_path, figures):
    """Coated grains go on from a restart file bitwise, and fly the same on 1, 2 and 4 ranks."""
    words = coat(2e-5, 2710, words="walls bare")
    half = f"run {STEPS // 2}\nwrite_restart half.restart\nrun {STEPS // 2}\n"
    whole = fly(words, tmp_path / "whole", run_text=half).points(STEPS, "grains")
    again = (
        host()
        + "read_restart half.restart\n"
        + NEIGHBOURS
        + CONTACT
        + MPM
        + "fix m grains nve/sphere\ntimestep 5e-7\n"
        + state(["x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz"], STEPS)
        + f"run {STEPS // 2}\n"
    )
    restarted = run(again, tmp_path / "whole").points(STEPS, "grains")
    for c in whole:
        assert (whole[c] == restarted[c]).all(), c
    one = fly(words, tmp_path / "1").points(STEPS, "grains")
    for ranks in (2, 4):
        several = fly(words, tmp_path / str(ranks), ranks).points(STEPS, "grains")
        worst = max(np.abs(one[c] - several[c]).max() / np.abs(one[c]).max() for c in one)
        figures.below(f"{ranks} ranks: difference of positions and velocities over the largest", worst, 1e-7)


def test_angular_momentum_of_a_coated_pair(tmp_path, figures):
    """A bond between coated grains that fly, turn and move apart: angular momentum with the moments of inertia of the shells, stay."""
    half = R + 5e-6
    text = grains([(-half, 0, 0), (half, 0, 0)]) + coat() + "create_cement calcite pair 1 2 shape flat content 0.01 spacing 1e-4 overlap skip\n"
    text += cement(2e-4, 2e-8).split("fix          bond")[0] + "fix bond grains mpm/couple cem kn auto kt auto\n"
    text += "variable vx atom 0.2+3*x\nvariable vy atom 300*x\nvelocity all set v_vx v_vy 0.1\nset group grains omegaz 300\nfix m grains nve/sphere\n"
    L = "".join(f"variable l{c} atom mass*({a}*v{b}-{b}*v{a})+{INERTIA:.17g}*omega{c}\n" for a, b, c in ("yzx", "zxy", "xyz"))
    text += L + "compute l grains reduce sum v_lx v_ly v_lz\n" + "".join(f"variable L{c} equal c_l[{n + 1}]+f_cem[{n + 16}]\n" for n, c in enumerate("xyz"))
    table = run(text + thermo(200, ["v_Lx", "v_Ly", "v_Lz"]) + "run 2000\n", tmp_path).table()
    size = np.abs(table["v_Lz"][0])
    figures.below(
        "angular momentum of a coated pair: change over its value", max(np.abs(table[c] - table[c][0]).max() for c in ("v_Lx", "v_Ly", "v_Lz")) / size, 1e-9
    )


PAIR = [(0, 0, 0), (4e-3, 0, 0)]
BAD = {
    "twice": (coat() + coat(), "grain 1 has a coat already"),
    "too thick": (coat(3e-4), "0.2 of the radius of grain 1"),
    "no size": ("create_cement calcite coat grains density 2710\n", "needs one of 'thickness' and 'calcite'"),
    "two sizes": ("create_cement calcite coat grains thickness 1e-5 calcite 0.01\n", "needs one of 'thickness' and 'calcite'"),
    "too much": ("create_cement calcite coat grains calcite 0.9\n", "give at most"),
    "no group": ("create_cement calcite coat gravel thickness 1e-5\n", "there is no such group"),
    "walls": (coat(words="walls none"), "must be one of coat, bare"),
    "no fix mpm": (coat() + "timestep 1e-7\nfix m grains nve/sphere\nrun 1\n", "has a coat, and fix mpm is not there"),
    "diameter": (coat() + MPM + "timestep 1e-7\nset atom 1 diameter 0.002\nfix m grains nve/sphere\nrun 1\n", "has radius"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input(name, tmp_path):
    words, message = BAD[name]
    result = launch(grains(PAIR) + words, tmp_path)
    assert result.status != 0 and message in result.output, result.output[-1500:]
