# SPDX-License-Identifier: GPL-2.0-or-later
"""compute mpm/stress against the forces that LIGGGHTS finds at walls, and compute mpm/fragment against a count by hand."""
import numpy as np
import pytest
from scenes import NEIGHBOURS, edit, host, launch, run, thermo

R = 1e-3
SIDE, HIGH = 2 * R, 3.999 * R  # half of the width of the block, and of its height
STRESS = [f"c_s[{k}]" for k in range(1, 7)]
WALLS = ["f_floor[3]", "f_lid[3]", "f_east[1]", "f_west[1]", "f_north[2]", "f_south[2]"]
SUMS = [f"c_sums[{k}]" for k in range(1, 7)]
PRESSED, DT, SPEED = 4000, 2e-7, 0.01  # steps, s, m/s of the lid
BOX = 0.01**3
PIECES = [f"c_pieces[{k}]" for k in range(1, 6)]


def plate(path, half=4e-3):
    text = "solid plate\n"
    for corners in (((-1, -1), (1, -1), (1, 1)), ((-1, -1), (1, 1), (-1, 1))):
        text += "facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x * half} {y * half} 0\n" for x, y in corners) + "endloop\nendfacet\n"
    (path / "plate.stl").write_text(text + "endsolid plate\n")


def grains():
    """Four columns of four beads of two sizes, a little out of line, which touch their neighbours above and below and beside them."""
    rng = np.random.default_rng(3)
    text = ""
    for k in range(4):
        for i in range(2):
            for j in range(2):
                x, y = ((2 * n - 1) * R + 0.002 * R * rng.uniform(-1, 1) for n in (i, j))
                text += f"create_atoms 1 single {x:.9g} {y:.9g} {(2 * k - 3) * R * 0.999 + 1e-9:.9g} units box\n"
    return text


FIXES = """\
fix          m1 all property/global youngsModulus peratomtype 1e9 1e9
fix          m2 all property/global poissonsRatio peratomtype 0.25 0.25
fix          m3 all property/global coefficientRestitution peratomtypepair 2 0.3 0.3 0.3 0.3
fix          m4 all property/global coefficientFriction peratomtypepair 2 0.5 0 0 0
pair_style   gran model hertz tangential history
pair_coeff   * *
"""
MOTION = f"""\
fix          wall grains wall/gran model hertz tangential history mesh n_meshes 6 meshes floor lid east west north south
fix          press all move/mesh mesh lid linear 0 0 -{SPEED}
fix          calm grains viscous 0.05
fix          motion grains nve/sphere
"""
MPM = """\
fix          cem calcite mpm cell 2e-4 elastic isotropic 1e9 0.25 quasistatic 1 0.3 {}
fix          bond grains mpm/couple cem
"""


def meshes():
    """Floor, lid and four sides, as they stand at the beginning."""
    text = ""
    for name, turn, place in (
        ("floor", "", (0, 0, -HIGH)),
        ("lid", "", (0, 0, HIGH)),
        ("east", "rotate axis 0 1 0 angle 90", (SIDE, 0, 0)),
        ("west", "rotate axis 0 1 0 angle 90", (-SIDE, 0, 0)),
        ("north", "rotate axis 1 0 0 angle 90", (0, SIDE, 0)),
        ("south", "rotate axis 1 0 0 angle 90", (0, -SIDE, 0)),
    ):
        text += f"fix {name} all mesh/surface/stress file plate.stl type 2 {turn} move {place[0]} {place[1]} {place[2]}\n"
    return text


def scene(path, more="condense yes", cemented=True, stress="", pressed=PRESSED, rest=8000):
    """A block of beads between a floor, a lid that presses it and two sides. The other sides are open."""
    plate(path)
    columns = STRESS + WALLS + SUMS + (PIECES if cemented else [])
    return (
        host()
        + "region box block -0.005 0.005 -0.005 0.005 -0.005 0.005 units box\ncreate_box 2 box\n"
        + grains()
        + f"set type 1 diameter {2 * R} density 2500\ngroup grains type 1\ngroup calcite type 2\n"
        + NEIGHBOURS
        + ("create_cement calcite contacts grains gap 2e-5 shape flat outer 6e-4 inner auto spacing 1e-4\n" if cemented else "")
        + FIXES
        + f"timestep {DT}\n"
        + (MPM.format(more) if cemented else "")
        + meshes()
        + MOTION
        + f"compute s grains mpm/stress {stress}\n"
        + "compute each grains mpm/stress\ncompute sums grains reduce sum "
        + " ".join(f"c_each[{k}]" for k in range(1, 7))
        + "\n"
        + ("compute pieces grains mpm/fragment\n" if cemented else "")
        + thermo(500, columns)
        + f"run {pressed}\nunfix press\nrun {rest}\n"
    )


def of_walls(t):
    """Sums of the force of each wall on the grains times its place at the end, for x, y and z. Walls have no friction."""
    high = HIGH - SPEED * PRESSED * DT
    return {
        1: -(t["f_east[1]"][-1] - t["f_west[1]"][-1]) * SIDE,
        2: -(t["f_north[2]"][-1] - t["f_south[2]"][-1]) * SIDE,
        3: -(t["f_lid[3]"][-1] * high - t["f_floor[3]"][-1] * HIGH),
    }


@pytest.mark.parametrize("more, ranks", [("condense yes", 1), ("condense yes", 2), ("condense no", 1), (None, 1), (None, 2)])
def test_stress_is_that_of_the_walls(tmp_path, figures, more, ranks):
    """At rest the mean stress of bonds and contacts is that of the forces on the boundary; without cement only the lid presses."""
    t = run(scene(tmp_path, more, cemented=more is not None), tmp_path, ranks).table()
    walls = of_walls(t)
    for k in (1, 2, 3) if more else (3,):
        found = BOX * t[f"c_s[{k}]"][-1]
        assert walls[k] < -1e-5
        figures.below(f"{more or 'no cement'}, {ranks} ranks: stress along {'xyz'[k - 1]} against that of the walls", abs(found / walls[k] - 1), 3e-3)
    for k in range(6):
        figures.below(f"{more or 'no cement'}, {ranks} ranks: sum of the grains", max(abs(t[SUMS[k]] - BOX * t[STRESS[k]])), 1e-12)


def test_volume(tmp_path):
    """The mean is over the volume of the script."""
    found = []
    for stress in ("", "volume 2e-6", "volume v_room"):
        script = scene(tmp_path, stress=stress, pressed=300, rest=0)
        found.append(run(edit(script, "compute s grains", "variable room equal 4e-6\ncompute s grains"), tmp_path).table()["c_s[3]"][-1])
    np.testing.assert_allclose([found[1] / found[0], found[2] / found[0]], [0.5, 0.25], rtol=1e-12)


def row_of_beads(path, bonds=((1, 2), (2, 3), (3, 4))):
    """Six beads in a row, of which the first four are joined. The last is 1.6 times as heavy as any other."""
    plate(path)
    beads = "".join(f"create_atoms 1 single 0 0 {(2 * k - 5) * R:.9g} units box\n" for k in range(6))
    return (
        host()
        + "region box block -0.005 0.005 -0.005 0.005 -0.008 0.008 units box\ncreate_box 2 box\n"
        + beads
        + f"set type 1 diameter {2 * R} density 2500\ngroup last id 6\nset group last density 4000\ngroup grains type 1\n"
        + NEIGHBOURS
        + "".join(f"create_cement calcite pair {i} {j} shape flat outer 6e-4 inner auto spacing 1e-4\n" for i, j in bonds)
        + FIXES
        + f"timestep {DT}\n"
        + MPM.format("condense yes")
        + "fix motion grains nve/sphere\ncompute pieces grains mpm/fragment\ncompute each grains mpm/fragment\n"
        + thermo(1, PIECES)
    )


def pieces_of(path, name):
    return [int(line.split()[1]) for line in (path / name).read_text().splitlines()[9:] if int(line.split()[0]) <= 6]


@pytest.mark.parametrize("ranks", [1, 2])
def test_fragments(tmp_path, ranks):
    """A grain has the smallest ID of those to which bonds join it, before and after a bond is deleted."""
    dump = 'write_dump grains custom pieces.{} id c_each modify sort id format "%d %.0f"\n'
    script = row_of_beads(tmp_path) + "run 0\n" + dump.format(1) + "delete_bond pair 3 2\nrun 0\n" + dump.format(2)
    t = run(script, tmp_path, ranks).table()
    assert pieces_of(tmp_path, "pieces.1") == [1, 1, 1, 1, 5, 6]
    assert pieces_of(tmp_path, "pieces.2") == [1, 1, 3, 3, 5, 6]
    # pieces, of these joined ones, grains of the heaviest and its share of the mass, single grains
    rows = np.array([[t[name][n] for name in PIECES] for n in (0, -1)])
    np.testing.assert_allclose(rows, [[3, 1, 4, 4 / 6.6, 2], [4, 2, 2, 2 / 6.6, 2]], rtol=1e-12)


BAD = {
    "compute f grains mpm/fragment cem": ["compute mpm/fragment (id f)", "'cem' is one word too many"],
    "compute f grains mpm/stress cem": ["compute mpm/stress (id f)", "'cem' is one word too many", "volume"],
    "compute f grains mpm/stress volume 0": ["'volume", "greater than 0"],
    "compute f grains mpm/stress volume v_none\nrun 0": ["'volume v_none'", "no equal-style variable", "define it"],
    "variable no equal -1\ncompute f grains mpm/stress volume v_no\nthermo_style custom step c_f[1]\nrun 0": ["'volume v_no' is -1", "above 0"],
    "run 0\ncompute f grains mpm/stress\nwrite_dump grains custom x.txt id c_f[1]": ["within a run only", "'run 0'"],
}


@pytest.mark.parametrize("command", BAD)
def test_bad_input(tmp_path, command):
    result = launch(row_of_beads(tmp_path) + command + "\n", tmp_path)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-2000:]
    assert all(w in result.errors()[0] for w in BAD[command]), result.errors()


@pytest.mark.parametrize("ranks", [1, 2])
def test_plane_walls(ranks, tmp_path, figures):
    """A bead between two planes, of which one has slid. Hertz' closed form, and the same forces and motion as without the compute."""
    near, far, E, nu, steps = 0.998 * R, 0.9995 * R, 1e9, 0.25, 50
    text = host(processors=f"{ranks} 1 1") + "region box block -0.005 0.005 -0.005 0.005 -0.005 0.005 units box\ncreate_box 2 box\n"
    text += "create_atoms 1 single 0.001 0 0 units box\ncreate_atoms 1 single -0.003 0 0 units box\n"
    text += f"set type 1 diameter {2 * R} density 2500\ngroup grains type 1\n{NEIGHBOURS}{FIXES}timestep 1e-8\n"
    text += f"fix floor grains wall/gran model hertz tangential history primitive type 1 zplane {-near:.15g} shear x 0.02\n"
    text += f"fix lid grains wall/gran model hertz tangential history primitive type 1 zplane {far:.15g}\nfix motion grains nve/sphere\n"
    bead = [f"v_{n}" for n in ("fx", "fz", "x")]
    text += "group bead id 1\nvariable fx equal fcm(bead,x)\nvariable fz equal fcm(bead,z)\nvariable x equal xcm(bead,x)\n"
    watched = run(text + "compute s grains mpm/stress\n" + thermo(1, STRESS + bead) + f"run {steps}\n", tmp_path / "watched", ranks).table()
    alone = run(text + thermo(1, bead) + f"run {steps}\n", tmp_path / "alone", ranks).table()
    for name in bead:
        assert (watched[name] == alone[name]).all(), name
    modulus, volume = E / (2 * (1 - nu * nu)), BOX
    force = [4 / 3 * modulus * np.sqrt(R) * (R - gap) ** 1.5 for gap in (near, far)]
    assert abs(force[0] - force[1]) > 0.5 * force[0]
    figures.below("normal stress at the start, two beads", abs(watched["c_s[3]"][0] / (-2 * (force[0] * near + force[1] * far) / volume) - 1), 1e-9)
    shear = watched["v_fx"] * -near / (2 * volume)  # of one bead: the floor drags it at its lowest point
    assert abs(watched["c_s[5]"][-1]) > 0
    figures.below("shear stress", abs(watched["c_s[5]"][-1] / (2 * shear[-1]) - 1), 0.05)
