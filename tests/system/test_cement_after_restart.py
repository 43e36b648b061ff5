# SPDX-License-Identifier: GPL-2.0-or-later
"""Cement made after read_restart, as in the natural way of working: grains settle and are written, then cemented.

Four grains slide on each other, a floor and a mesh, with a history of their tangential contacts; one is moved, and all
carry values of fix property/atom.  The run goes on with cement, or from a restart file with the cement made there.
"""
import numpy as np
import pytest
from scenes import NEIGHBOURS, edit, host, launch, run

TILE = """solid tile
facet normal 0 0 1
 outer loop
  vertex -0.005 -0.005 {z}
  vertex 0.005 -0.005 {z}
  vertex 0.005 0.005 {z}
 endloop
endfacet
facet normal 0 0 1
 outer loop
  vertex -0.005 -0.005 {z}
  vertex 0.005 0.005 {z}
  vertex -0.005 0.005 {z}
 endloop
endfacet
endsolid tile
"""
GRAINS = """\
region       box block -0.005 0.005 -0.005 0.005 -0.001 0.006 units box
create_box   2 box
create_atoms 1 single -0.00099 0 0.000995 units box
create_atoms 1 single  0.00099 0 0.000995 units box
create_atoms 1 single  0 0 0.00271 units box
create_atoms 1 single  0 0.00299 0.000995 units box
set          type 1 diameter 0.002 density 2500
group        grains type 1
group        moved id 4
group        free subtract grains moved
velocity     grains set 0.01 0.02 -0.03
set          group grains omegaz 20
"""
MODEL = """\
fix          m1 all property/global youngsModulus peratomtype 1e8 1e8
fix          m2 all property/global poissonsRatio peratomtype 0.25 0.3
fix          m3 all property/global coefficientRestitution peratomtypepair 2 0.5 0.5 0.5 0.5
fix          m4 all property/global coefficientFriction peratomtypepair 2 0.5 0.5 0.5 0.5
fix          m5 all property/global characteristicVelocity scalar 1
pair_style   gran model {model} tangential history
pair_coeff   * *
timestep     1e-7
compute      contacts all pair/gran/local id force history
"""
WALLS = """\
fix          floor all mesh/surface file floor.stl type 1
fix          wall grains wall/gran model {model} tangential history mesh n_meshes 1 meshes floor
fix          side grains wall/gran model {model} tangential history primitive type 1 xplane -0.001985
compute      walls all wall/gran/local id force history
fix          move moved move linear 0.01 0.02 0
"""
SERVO = """\
fix          plate all mesh/surface/stress/servo file plate.stl type 1 com 0 0 0.0037 ctrlPV force axis 0 0 -1 &
             target_val 0.5 vel_max 0.1 kp 0.05
"""
VALUES = """\
fix          tint all property/atom tint scalar yes no no 7
fix          shade all property/atom shade vector yes no no 8 9
"""
MOTION = "fix motion free nve/sphere\nfix g all gravity 9.81 vector 0 0 -1\n"
SHAPE = "shape meniscus neck 4e-4 inner auto spacing 5e-5"
FORMS = {
    "contacts": f"create_cement calcite contacts grains gap 1e-5 {SHAPE}\n",
    "pair": f"create_cement calcite pair 1 2 {SHAPE}\n",
    "file": "create_cement calcite pair 1 2 file points.txt spacing 5e-5\n",
}
MPM = """\
fix          cem calcite mpm cell 1e-4 elastic isotropic 1e8 0.25 damage tensor B0 7e3 cutoff 0.9
fix          bond grains mpm/couple cem
"""
# IDs of grains and of points in one list: those of the points are the same on any number of ranks.
OUTPUT = """\
dump         atoms all custom 300 atoms.*.txt id x y z vx vy vz omegax omegay omegaz fx fy fz f_tint f_shade[1] f_shade[2]
dump_modify  atoms sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
dump         contacts all local 300 contacts.*.txt c_contacts[1] c_contacts[2] c_contacts[4] c_contacts[5] c_contacts[6] c_contacts[7] c_contacts[8] c_contacts[9]
dump_modify  contacts format "%.0f %.0f %.17g %.17g %.17g %.17g %.17g %.17g"
dump         walls all local 300 walls.*.txt c_walls[3] c_walls[4] c_walls[5] c_walls[6] c_walls[7] c_walls[8] c_walls[9]
dump_modify  walls format "%.0f %.17g %.17g %.17g %.17g %.17g %.17g"
"""


def start(ranks):
    return host(processors=f"{ranks} 1 1")


def rows(directory, name, step=300):
    return sorted((directory / f"{name}.{step}.txt").read_text().splitlines()[9:])


def meshes(directory):
    directory.mkdir(parents=True, exist_ok=True)
    (directory / "floor.stl").write_text(TILE.format(z=0))
    (directory / "plate.stl").write_text(TILE.format(z=0.0037))


@pytest.mark.parametrize(
    "ranks, model, form, cement_first",
    [
        (1, "hertz", "contacts", True),
        (1, "hooke", "contacts", False),
        (2, "hertz", "contacts", False),
        (2, "hooke", "contacts", True),
        (2, "hertz", "file", True),
        (1, "hertz", "pair", True),
    ],
)
def test_as_in_one_run(tmp_path, ranks, model, form, cement_first):
    """Bitwise identical: grains, points, histories of contacts, and values of fixes, wherever in the script the cement is made."""
    whole, part = tmp_path / "whole", tmp_path / "part"
    meshes(whole)
    meshes(part)
    setup = MODEL.format(model=model)
    fixes = WALLS.format(model=model) + VALUES
    cement = FORMS[form]
    settle = start(ranks) + GRAINS + NEIGHBOURS + setup + fixes + MOTION + "run 100\nset group grains property/atom tint 3\n" "run 100\nwrite_restart r.bin\n"
    if form == "file":
        run(settle + FORMS["pair"] + "write_cement points.txt\n", whole, ranks)
        (part / "points.txt").write_text((whole / "points.txt").read_text())
    after = OUTPUT + MPM + "run 100\n"
    run(settle + cement + after, whole, ranks)
    rest = cement + setup + fixes if cement_first else setup + fixes + cement
    again = run(start(ranks) + "read_restart ../whole/r.bin\n" + NEIGHBOURS + rest + MOTION + after, part, ranks)
    for name in ("atoms", "contacts", "walls"):
        assert rows(part, name) == rows(whole, name), name
    atoms = again.points(300, "atoms")
    points = atoms["id"] > 4
    assert points.sum() > 500 and (atoms["f_tint"][points] == 7).all() and (atoms["f_tint"][~points] == 3).all()
    assert (atoms["f_shade[1]"] == 8).all() and (atoms["f_shade[2]"] == 9).all()
    for name, least in (("contacts", 3), ("walls", 3)):
        history = np.array([[float(w) for w in row.split()] for row in rows(part, name)])
        assert len(history) >= least and (abs(history[:, -3:]).max(axis=1) > 0).all(), name


@pytest.mark.parametrize("ranks", [1, 2])
def test_servo(tmp_path, ranks):
    """LIGGGHTS writes place and velocity of a servo mesh, not all of its controller: the run from the file is no longer the
    one that wrote it, with or without cement.  So cement made after the file is compared with cement that is in the file."""
    for name in ("with", "without"):
        meshes(tmp_path / name)
    fixes = MODEL.format(model="hertz") + SERVO + edit(WALLS.format(model="hertz"), "1 meshes floor", "2 meshes floor plate") + VALUES + MOTION
    cement = FORMS["contacts"]
    table = 'thermo_style custom step f_plate[3] f_plate[9]\nthermo_modify format float %.17g\nthermo 20\nprint "COLUMNS step force z"\n'
    first = start(ranks) + GRAINS + NEIGHBOURS + fixes + "run 200\nwrite_restart bare.bin\n" + cement + "write_restart cemented.bin\n"
    run(first, tmp_path / "with", ranks)
    second = OUTPUT + MPM + table + "run 100\n"
    a = run(start(ranks) + "read_restart cemented.bin\n" + NEIGHBOURS + fixes + second, tmp_path / "with", ranks)
    b = run(start(ranks) + "read_restart ../with/bare.bin\n" + NEIGHBOURS + cement + fixes + second, tmp_path / "without", ranks)
    for name in ("atoms", "contacts", "walls"):
        assert rows(b.directory, name) == rows(a.directory, name), name
    p, q = a.table(), b.table()
    assert abs(p["force"]).max() > 0.01 and np.ptp(p["z"]) > 1e-8
    for name in p:
        assert (p[name] == q[name]).all(), name


def test_bad_state_of_fixes(tmp_path):
    """A length of what a fix has of an atom that is no length."""
    meshes(tmp_path)
    fixes = MODEL.format(model="hertz") + VALUES
    run(start(1) + GRAINS + NEIGHBOURS + fixes + MOTION + "run 10\nwrite_restart r.bin\n", tmp_path)
    data = (tmp_path / "r.bin").read_bytes()[:-40]
    at = data.index(b"MPDEMrst")
    data = data[: at + 24] + bytes(4) + data[at + 28 :]  # of a program that writes no seal
    state = np.array([2.0, 7.0, 3.0, 8.0, 9.0]).tobytes()  # tint and shade
    places = [i for i in range(len(data)) if data.startswith(state, i)]
    assert len(places) == 4
    for bad in (0.0, -2.0, 1e9, np.nan):
        broken = data[: places[1]] + np.array([bad]).tobytes() + data[places[1] + 8 :]
        (tmp_path / "r.bin").write_bytes(broken)
        result = launch(start(1) + "read_restart r.bin\n" + NEIGHBOURS + FORMS["pair"], tmp_path)
        assert result.status != 0 and "the state of fixes is not as long" in result.errors()[0]
