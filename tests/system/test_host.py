# SPDX-License-Identifier: GPL-2.0-or-later
"""liggghts-mpdem is LIGGGHTS: ordinary scripts run to the last digit as in the stock program."""
import re
import shutil

import pytest
from scenes import cement, dump, edit, hosted, launch, pair, point_quantities, pull, run, thermo

MATERIAL = """\
fix m1 all property/global youngsModulus peratomtype 5e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.3
fix m4 all property/global coefficientFriction peratomtypepair 1 0.5
"""
START = """\
units        si
atom_style   granular
atom_modify  map array
newton       off
communicate  single vel yes
"""
PRECISE = "thermo_style custom step atoms ke c_turning vol\nthermo_modify lost ignore norm no format float %.17g\n"

SCENES = {
    "spheres rain into a box": START
    + """\
boundary     f f f
region       box block -0.05 0.05 -0.05 0.05 0 0.15 units box
create_box   1 box
neighbor     0.002 bin
neigh_modify delay 0
"""
    + MATERIAL
    + """\
pair_style   gran model hertz tangential history
pair_coeff   * *
timestep     1e-5
fix gravity  all gravity 9.81 vector 0.3 0.0 -1.0
fix floor    all wall/gran model hertz tangential history primitive type 1 zplane 0.0
fix left     all wall/gran model hertz tangential history primitive type 1 xplane -0.05
fix right    all wall/gran model hertz tangential history primitive type 1 xplane 0.05
fix front    all wall/gran model hertz tangential history primitive type 1 yplane -0.05
fix back     all wall/gran model hertz tangential history primitive type 1 yplane 0.05
fix sphere   all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.004
fix mixture  all particledistribution/discrete 15485867 1 sphere 1.0
region       fill block -0.045 0.045 -0.045 0.045 0.01 0.14 units box
fix insert   all insert/pack seed 32452843 distributiontemplate mixture vel constant 0 0 -0.5 &
             insert_every once overlapcheck yes all_in yes particles_in_region 200 region fill
fix motion   all nve/sphere
compute      turning all erotate/sphere
"""
    + PRECISE
    + "thermo 100\nrun 3000\n",
    "two spheres collide": START
    + """\
boundary     f f f
region       box block -0.05 0.05 -0.05 0.05 -0.05 0.05 units box
create_box   1 box
create_atoms 1 single -0.011 0.002 0 units box
create_atoms 1 single 0.011 0 0 units box
set          group all diameter 0.02 density 2500
neighbor     0.002 bin
neigh_modify delay 0
"""
    + MATERIAL
    + """\
pair_style   gran model hertz tangential history rolling_friction off
pair_coeff   * *
timestep     1e-6
velocity     all set 0 0 0
group        left id 1
velocity     left set 1 0 0
fix motion   all nve/sphere
compute      turning all erotate/sphere
"""
    + PRECISE
    + "thermo 50\nrun 5000\n",
    "cohesive spheres": START
    + """\
boundary     p p p
region       box block 0 0.0594 0 0.0594 0 0.0594 units box
create_box   1 box
lattice      sc 0.0099
create_atoms 1 region box
set          group all diameter 0.01 density 2500
neighbor     0.002 bin
neigh_modify delay 0
"""
    + MATERIAL
    + """\
fix m5 all property/global cohesionEnergyDensity peratomtypepair 1 50000
pair_style   gran model hertz tangential history cohesion sjkr
pair_coeff   * *
timestep     1e-5
variable     vx atom "0.1*sin(1e3*y+1)"
variable     vy atom "0.1*sin(1e3*z+2)"
variable     vz atom "0.1*sin(1e3*x+3)"
velocity     all set v_vx v_vy v_vz
fix motion   all nve/sphere
compute      turning all erotate/sphere
"""
    + PRECISE
    + "thermo 50\nrun 2000\n",
}


def thermo_lines(output):
    """Rows of numbers, and the counts that end a run; nothing that depends on the clock."""
    return [
        line for line in output.splitlines() if re.fullmatch(r"\s*\d+( +[-+.\dena]+)+\s*", line) or re.match(r"Total #|Neighbor list builds|Dangerous", line)
    ]


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("ranks", [1, 2])
def test_ordinary_script(tmp_path, figures, name, ranks):
    stock = shutil.which("liggghts", path="/usr/bin:/usr/local/bin")
    if not stock:
        pytest.skip("the stock program liggghts is not installed")
    if not hosted():
        pytest.skip("a LIGGGHTS compiled anew rounds otherwise than Debian's")
    theirs = thermo_lines(run(SCENES[name], tmp_path / "stock", ranks, program=stock).output)
    ours = thermo_lines(run(SCENES[name], tmp_path / "mpdem", ranks).output)
    assert len(theirs) > 30
    assert ours == theirs
    figures.note(f"{name}, {ranks} rank(s)", f"{len(ours)} lines equal to those of {stock}")


def test_help_lists_the_styles(tmp_path):
    output = launch("", tmp_path, arguments=["-h"]).output
    words = output.replace(",", " ").split()
    for style in ("mpdem", "mpm", "mpm/couple", "check/timestep/mpm", "mpm/atom", "create_cement", "write_cement", "bond_stiffness"):
        assert style in words, style


def test_clear_and_a_second_scene(tmp_path):
    """The second scene of a script is the same as in a script of its own."""

    def scene(gap, name):
        return (
            pair(1e-4, gap=gap)
            + cement(2e-4, 2e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9")
            + pull(0.3, 5e-7)
            + point_quantities(["damage", "stress_zz"])
            + dump(400, ["x", "y", "z", "c_damage", "c_stress_zz"], f"{name}.*.txt")
            + "run 400\n"
        )

    both = run(scene(1e-4, "one") + "clear\nvariable t delete\nvariable along delete\nvariable speed delete\n" + scene(0.0, "two"), tmp_path / "both", 2)
    alone = run(scene(0.0, "two"), tmp_path / "alone", 2)
    p, q = both.points(400, "two"), alone.points(400, "two")
    assert p["c_damage"].max() > 0.1
    for column in p:
        assert (p[column] == q[column]).all(), column


def test_columns_of_a_dump(tmp_path):
    """They carry the names of the computes; atoms that are no points show zero."""
    names = ["damage", "damage_xx", "drive", "stress_zz", "stress_max", "pressure", "strain_yz", "attached", "grain", "failed", "volume", "axis_z", "bond"]
    script = (
        pair(1e-4)
        + cement(2e-4, 2e-9, damage="damage tensor B0 9.6e3 cutoff 0.9")
        + pull(0.25, 5e-7)
        + point_quantities(names, "all")
        + dump(500, [f"c_{n}" for n in names], group="all")
        + "run 500\n"
    )
    result = run(script, tmp_path, 2)
    with open(tmp_path / "points.500.txt") as f:
        head = [next(f) for _ in range(9)]
    assert head[8].split() == ["ITEM:", "ATOMS", "id"] + [f"c_{n}" for n in names]
    atoms = result.points(500)
    grains, points = atoms["id"] <= 2, atoms["id"] > 2
    assert points.sum() > 5000
    for n in names:
        assert (atoms[f"c_{n}"][grains] == 0).all(), n
    assert atoms["c_volume"][points].min() > 0
    assert set(atoms["c_attached"]) == {0, 1} and set(atoms["c_grain"]) == {0, 1, 2}
    assert set(atoms["c_bond"][points]) == {1}
    assert 0 < atoms["c_damage"].max() < 0.9 and abs(atoms["c_axis_z"][points]).min() > 0.99
    assert atoms["c_drive"].max() < 1 + 1e-9
    assert atoms["c_stress_zz"].max() > 1e6


def test_loads_of_points_are_zero(tmp_path, monkeypatch):
    """LIGGGHTS clears forces and torques of the grains alone; points come to lie in new memory, where other things were."""
    monkeypatch.setenv("MALLOC_PERTURB_", "90")  # so that new memory is not zero by chance
    names = ["fx", "fy", "fz", "tqx", "tqy", "tqz"]
    script = (
        edit(pair(2e-4, processors="2 1 1"), "create_cement", "velocity grains set 300 0 0\ncreate_cement")
        + cement(4e-4, 5e-8)
        + "fix motion grains nve/sphere\n"
        + "".join(f"compute {n} calcite property/atom {n}\n" for n in names)
        + f"compute least calcite reduce min {' '.join('c_' + n for n in names)}\ncompute most calcite reduce max {' '.join('c_' + n for n in names)}\n"
    )
    columns = [f"c_{which}[{k}]" for which in ("least", "most") for k in range(1, 7)]
    table = run(script + thermo(5, columns) + "run 30\n", tmp_path, 2).table()
    for name in columns:
        assert (table[name] == 0).all(), (name, table[name])


def test_dump_vtk(tmp_path):
    script = (
        pair(1e-4)
        + cement(2e-4, 2e-9)
        + "fix hold grains freeze\n"
        + point_quantities(["damage", "stress_zz"])
        + "dump points calcite custom/vtk 10 points.*.vtk id type x y z vx vy vz c_damage c_stress_zz\nrun 10\n"
    )
    result = launch(script, tmp_path, 1)
    if "Invalid dump style" in result.output:
        pytest.skip("this LIGGGHTS has no dump custom/vtk")
    assert result.status == 0 and not result.errors(), result.output[-1500:]
    for step in (0, 10):
        data = (tmp_path / f"points.{step}.vtk").read_bytes()
        assert b"c_damage" in data and b"c_stress_zz" in data


@pytest.mark.skipif("not hosted()", reason="LIGGGHTS' own main() leaves output in a buffer")
@pytest.mark.parametrize("ranks", [1, 2])
def test_output_is_there_at_once(ranks, tmp_path):
    """Output that goes to a file can be followed while the program runs."""
    # mpirun may take its time to pass a line on
    (tmp_path / "look.sh").write_text("for k in $(seq 50); do grep -q 'of the script' in.test.out && break; sleep 0.2; done\ncp in.test.out then.txt\n")
    result = run('print "a line of the script"\nshell sh look.sh\n', tmp_path, ranks)
    assert "a line of the script" in result.output
    assert "a line of the script" in (tmp_path / "then.txt").read_text()
