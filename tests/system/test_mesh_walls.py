# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS loops over the grains only where mesh walls and gravity act, and nothing but its time changes.

Grains that no cement touches slide, spin and roll over the triangles of two meshes, and one, the last of all, moves back and forth over
the edge of two. A pair with cement stands beside them. The same grains without cement are moved by LIGGGHTS alone, which goes over all
atoms then.
"""
import pytest
from scenes import NEIGHBOURS, edit, host, run, thermo

STEPS = 8000
GRAINS = """\
region       box block -0.0066 0.0066 -0.0066 0.0066 -0.0066 0.009 units box
create_box   2 box
create_atoms 1 single -0.00105 0 0.006 units box
create_atoms 1 single  0.00105 0 0.006 units box
create_atoms 1 single -0.0045 -0.00291 0.00099 units box
create_atoms 1 single -0.0012 -0.0015 0.00099 units box
create_atoms 1 single -0.0002 0.0022 0.000992 units box
create_atoms 1 single  0.0030 -0.00292 0.00099 units box
create_atoms 1 single  0.0040 0.0010 0.000991 units box
create_atoms 1 single  0.003501 0.0037 0.00099 units box
set          type 1 diameter 0.002 density 2500
group        grains type 1
group        held id 1 2
group        swings id 8
group        free subtract grains held swings
"""
MOTION = """\
velocity     free set 1.1 -0.4 0
set          group free omegay 300 omegaz 200
velocity     held set 0 0 0
velocity     swings set 0 0 0
"""
MODEL = """\
fix          m1 all property/global youngsModulus peratomtype 1e8 1e8
fix          m2 all property/global poissonsRatio peratomtype 0.25 0.3
fix          m3 all property/global coefficientRestitution peratomtypepair 2 0.5 0.5 0.5 0.5
fix          m4 all property/global coefficientFriction peratomtypepair 2 0.5 0.5 0.5 0.5
pair_style   gran model hertz tangential history
pair_coeff   * *
timestep     1e-7
fix          floor all mesh/surface file floor.stl type 1
fix          side all mesh/surface file floor.stl type 1 rotate axis 1 0 0 angle -90 move 0 -0.0039 0
fix          walls grains wall/gran model hertz tangential history mesh n_meshes 2 meshes floor side
compute      walls all wall/gran/local id force history
fix          g all gravity 5000 vector 0.1 -0.7 -1
fix          hold held move linear 0 0 0
fix          swing swings move wiggle 5e-6 0 0 1.3e-5
fix          move free nve/sphere
"""
CEMENT = "create_cement calcite pair 1 2 shape meniscus neck 5e-4 spacing 1e-4\n"
MPM = """\
fix          cem calcite mpm cell 2e-4 elastic isotropic 1e7 0.25 damage tensor B0 7e9 cutoff 0.9
fix          bond grains mpm/couple cem
"""
# IDs of grains are the same with and without cement
OUTPUT = f"""\
dump         grains grains custom {STEPS // 4} grains.*.txt id x y z vx vy vz omegax omegay omegaz fx fy fz tqx tqy tqz
dump_modify  grains sort id format "%d{" %.17g" * 15}"
dump         walls grains local {STEPS // 4} walls.*.txt c_walls[1] c_walls[2] c_walls[3] c_walls[4] c_walls[5] c_walls[6] c_walls[7] c_walls[8] c_walls[9]
dump_modify  walls format "%.0f %.0f %.0f %.17g %.17g %.17g %.17g %.17g %.17g"
"""


def tiles(side=0.0007, across=18):
    """An STL file of squares of two triangles each in the plane z = 0."""
    text = "solid tiles\n"
    for i in range(across):
        for j in range(across):
            x, y = ((k - 0.5 * across) * side for k in (i, j))
            a, b, c, d = ((x, y), (x + side, y), (x + side, y + side), (x, y + side))
            for corners in ((a, b, c), (a, c, d)):
                text += "facet normal 0 0 1\n outer loop\n" + "".join(f"  vertex {p:.9g} {q:.9g} 0\n" for p, q in corners) + " endloop\nendfacet\n"
    return text + "endsolid tiles\n"


def go(directory, script, ranks):
    directory.mkdir(exist_ok=True)
    (directory / "floor.stl").write_text(tiles())
    return run(host(processors=f"{ranks} 1 1") + script, directory, ranks)


def shown(directory):
    """State of the grains and of their contacts with walls, by step, without the two grains of the pair."""
    found = {}
    for name in ("grains", "walls"):
        for path in directory.glob(f"{name}.*.txt"):
            rows = path.read_text().splitlines()[9:]
            found[path.name] = sorted(row for row in rows if name == "walls" or row.split()[0] not in ("1", "2"))
    return found


WHOLE, HALVES = f"run {STEPS}\n", f"run {STEPS // 2}\n"


def scene(directory, ranks, cement, restart):
    """One run, or two over a restart file. LIGGGHTS itself goes on from a file with other lists of neighbours, and so not bitwise identically."""
    make, fixes = (CEMENT, MODEL + MPM) if cement else ("", MODEL)
    go(directory, GRAINS + NEIGHBOURS + make + fixes + MOTION + OUTPUT + (HALVES + "write_restart r.bin\n" if restart else WHOLE), ranks)
    if restart:
        go(directory, "read_restart r.bin\n" + NEIGHBOURS + fixes + OUTPUT + HALVES, ranks)
    return shown(directory)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The grains without cement, on one and two ranks, without and with a restart."""
    return {(ranks, restart): scene(tmp_path_factory.mktemp("alone"), ranks, False, restart) for ranks in (1, 2) for restart in (False, True)}


def test_the_scene(alone):
    """Contacts slide and cross triangles, some in a corner of two meshes; ranks change nothing."""
    assert alone[1, False] == alone[2, False]
    walls = {step: [row.split() for row in alone[1, False][f"walls.{step}.txt"]] for step in (0, STEPS // 4, STEPS)}
    triangles = {step: {tuple(row[:3]) for row in rows} for step, rows in walls.items()}
    assert len(triangles[STEPS]) >= 6 and len({t[2] for t in triangles[STEPS]}) == 6, "every grain touches"
    assert {t[0] for t in triangles[STEPS]} == {"0", "1"}, "both meshes"
    assert not triangles[STEPS // 4] & triangles[STEPS], "triangles change"
    sides = {step: float(alone[1, False][f"grains.{step}.txt"][2].split()[1]) > 0 for step in (0, STEPS)}
    assert sides == {0: False, STEPS: True}, "grain 5 goes to the other rank"
    assert all(max(abs(float(h)) for h in row[6:9]) > 0 for row in walls[STEPS]), "tangential springs"


@pytest.mark.parametrize("restart", [False, True])
@pytest.mark.parametrize("ranks", [1, 2])
def test_as_without_cement(tmp_path, alone, ranks, restart):
    """Motion, forces and histories are bitwise identical."""
    assert scene(tmp_path, ranks, True, restart) == alone[ranks, restart]


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("gravity", ["5000", "v_g"])
def test_energy_of_gravity(tmp_path, ranks, gravity):
    """The scalar of fix gravity is the potential energy of grains and points, also where points have no forces of gravity."""
    script = (
        GRAINS
        + NEIGHBOURS
        + CEMENT
        + "variable g equal 5000+step\n"
        + edit(MODEL, "gravity 5000", f"gravity {gravity}")
        + MPM
        + MOTION
        + "variable mine atom -mass*(v_g-step)*(0.1*x-0.7*y-z)/sqrt(0.1^2+0.7^2+1)\n"
    )
    columns = ["f_g", "c_all", "c_grains", "c_force"]
    script += (
        "compute all all reduce sum v_mine\ncompute grains grains reduce sum v_mine\nvariable f atom abs(fx)+abs(fy)+abs(fz)\n"
        "compute force calcite reduce max v_f\n" + thermo(20, columns) + "thermo_modify norm no\nrun 200\n"
    )
    table = go(tmp_path, script if gravity == "5000" else script.replace("(v_g-step)", "v_g"), ranks).table()
    # LIGGGHTS loops over points itself where gravity has a variable, and has their positions as they were reported last
    assert table["f_g"] == pytest.approx(table["c_all"], rel=1e-12 if gravity == "5000" else 1e-6, abs=0)
    assert (abs(table["c_all"] - table["c_grains"]) > 1e-3 * abs(table["c_all"])).all()
    assert (table["c_force"] == 0).all(), "forces that points show"
