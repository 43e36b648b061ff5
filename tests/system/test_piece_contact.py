# SPDX-License-Identifier: GPL-2.0-or-later
"""Contact of cement with other bodies and of broken cement as rigid pieces, and cohesive interfaces of condensed bonds."""
import numpy as np
import pytest
from scenes import CALCITE, CONTACT, cement, edit, in_cells, pair, pull, restarted, run, thermo

CRUSHED = pair(2e-4, gap=1.2e-3, cement="outer 1.8e-3 waist 0.6", shape="hourglass")
# Opens by 3 um until 2e-5 s, closes by 4 um until 6e-5 s, then slides at 5 m/s.
PATH = """\
variable t  equal step*dt
variable a  equal "0.5*(1-cos(PI*v_t/2e-5))*(v_t<2e-5)+(v_t>=2e-5)"
variable b  equal "0.5*(1-cos(PI*(v_t-2e-5)/4e-5))*(v_t>=2e-5)*(v_t<6e-5)+(v_t>=6e-5)"
variable da equal "0.5*PI/2e-5*sin(PI*v_t/2e-5)*(v_t<2e-5)"
variable db equal "0.5*PI/4e-5*sin(PI*(v_t-2e-5)/4e-5)*(v_t>=2e-5)*(v_t<6e-5)"
variable s  equal "(v_t>=6e-5)*(v_t<8e-5)*0.5*5*(v_t-6e-5-2e-5/PI*sin(PI*(v_t-6e-5)/2e-5))+(v_t>=8e-5)*5*(v_t-7e-5)"
variable ds equal "(v_t>=6e-5)*(v_t<8e-5)*0.5*5*(1-cos(PI*(v_t-6e-5)/2e-5))+(v_t>=8e-5)*5"
variable z  equal 3e-6*v_a-4e-6*v_b
variable w  equal 3e-6*v_da-4e-6*v_db
fix hold first  move linear 0 0 0
fix go   second move variable v_s NULL v_z v_ds NULL v_w
variable fz equal fz[2]
variable fx equal fx[2]
variable slip equal v_s
""" + thermo(
    500, ["v_slip", "v_fz", "v_fx", "f_bond[14]", "f_bond[1]", "f_cem[37]", "f_cem[38]", "f_cem[24]"]
)
SLIDE = CONTACT + cement(
    4e-4,
    2e-8,
    CALCITE,
    axis="radial",
    damage="damage tensor B0 9.6e3 cutoff 0.9 cracks split unilateral yes quasistatic 1 0.3 condense yes",
    couple="kn auto kt auto friction 0.3",
)


def slid(tmp_path, condense, ranks=1, steps=12000):
    return run(CRUSHED + edit(SLIDE, "condense yes", f"condense {condense}") + PATH + f"run {steps}\n", tmp_path, ranks)


@pytest.mark.parametrize("condense", ["yes", "no"])
def test_slip_of_any_length(condense, tmp_path):
    """Faces of a crack slide by two cells and more under pressure; the friction is that of Coulomb, up to the waves of the faces."""
    rows = slid(tmp_path, condense).table()
    after = rows["step"] >= 8000
    assert rows["v_slip"][after].max() > 8e-4 and not rows["f_cem[24]"][after].any()  # all pieces are rigid
    press, friction = rows["v_fz"][after], -rows["v_fx"][after]
    assert (press > 2.0).all()
    assert 0.2 < (friction / press).mean() < 0.4
    # the table of bonds has the force of contact, up to the inclination of the line of centres
    assert np.allclose(rows["f_bond[1]"][after], friction, rtol=0.01)
    assert (rows["f_cem[37]"][after] > 0).all() and (np.diff(rows["f_cem[38]"][after]) > 0).all()


def test_ranks_and_restart(tmp_path):
    one = slid(tmp_path / "one", "yes", steps=6000).table()
    two = slid(tmp_path / "two", "yes", ranks=2, steps=6000).table()
    for name in ("v_fz", "v_fx"):
        assert np.allclose(one[name], two[name], rtol=1e-8, atol=1e-8 * np.abs(one[name]).max())
    run(CRUSHED + SLIDE + PATH + "run 4500\nwrite_restart half\n", tmp_path / "half", 1)
    rest = run(restarted(tmp_path / "half" / "half") + "group grains type 1\n" + SLIDE + PATH + "run 1500\n", tmp_path / "rest", 1).table()
    assert rest["step"][-1] == 6000 and rest["v_slip"][-1] > 2e-4
    for name in ("v_fz", "v_fx", "f_cem[37]", "f_cem[38]"):
        assert rest[name][-1] == one[name][-1]


def test_crushed_pair_turns_without_force(tmp_path):
    """Cement that came apart turns with its grains: no force beside that of its mass, whatever the angle."""
    open_then_turn = """\
variable t equal step*dt
variable z equal "3e-5*0.5*(1-cos(PI*v_t/4e-5))*(v_t<4e-5)+3e-5*(v_t>=4e-5)"
variable w equal "3e-5*0.5*PI/4e-5*sin(PI*v_t/4e-5)*(v_t<4e-5)"
fix hold first  move linear 0 0 0
fix go   second move variable NULL NULL v_z NULL NULL v_w
run 4000
unfix hold
unfix go
fix turn grains move rotate 0 0 0 0 1 0 1e-2
variable force equal abs(f_bond[1])+abs(f_bond[2])+abs(f_bond[3])
variable x equal x[2]
"""
    open_then_turn += thermo(5000, ["v_force", "f_cem[24]", "v_x"]) + "run 125000\n"
    rows = run(CRUSHED + SLIDE + open_then_turn, tmp_path, 1).table()
    turned = rows["step"] > 4000
    assert rows["v_x"][-1] > 5e-3  # a quarter of a turn
    assert not rows["f_cem[24]"][turned].any()
    assert rows["v_force"][turned].max() < 0.01


@pytest.mark.parametrize("ranks", [1, 2])
def test_bead_rebounds_from_intact_cement(ranks, tmp_path):
    """A bead of 0.8 mm hits the cement between two others at 10 m/s: it touches at the sum of radii, and keeps its speed but for
    what the heavy grains take, whose masses and inertia at the arm of the contact are known."""
    scene = pair(2e-4, gap=1e-3, cement=in_cells("outer 3e-3"), half_box=(12e-3, 6e-3, 12e-3))
    scene = edit(
        scene, "set          type 1 diameter 0.01 density 2500\n", "create_atoms 1 single -0.006 0 0 units box\nset type 1 diameter 0.01 density 2500\n"
    )
    scene = edit(scene, "group        grains type 1\n", "group grains type 1\ngroup ball id 3\nset group ball diameter 0.0008\n")
    moves = """\
fix move grains nve/sphere
velocity ball set 10 0 0 units box
variable x equal x[3]
variable vx equal vx[3]
"""
    moves += thermo(100, ["v_x", "v_vx"]) + "run 16000\n"
    rows = run(
        scene
        + CONTACT
        + cement(4e-4, 2e-8, CALCITE, axis="radial", damage="damage tensor B0 9.6e3 condense yes", couple="kn auto kt auto friction 0.3")
        + moves,
        tmp_path,
        ranks,
    ).table()
    assert abs(rows["v_x"].max() + 3.4e-3) < 5e-5  # outer radius of the cement and radius of the bead
    ball, grain = 2500 * 4 / 3 * np.pi * 4e-4**3, 2500 * 4 / 3 * np.pi * 5e-3**3
    # the pair moves as one body: two spheres at 5.5 mm; the force acts on its middle
    lost = 2 * ball / (ball + 2 * grain)
    assert -10 < rows["v_vx"][-1] < -10 * (1 - 10 * lost)


def test_bead_rests_on_cement(tmp_path):
    """A bead that a force of 1 N presses on the cement of a pair comes to rest within half a spacing of the surface, and the stored
    energy is that of one to a hundred surface points in parallel. Closed forms of force and stiffness are in the unit tests."""
    scene = pair(2e-4, gap=2.4e-3, cement=in_cells("outer 3e-3"), half_box=(12e-3, 6e-3, 12e-3))
    set_grains = "set          type 1 diameter 0.01 density 2500\n"
    scene = edit(scene, set_grains, "create_atoms 1 single -0.00401 0 0 units box\n" + set_grains)
    scene = edit(scene, "group        grains type 1\n", "group grains type 1\ngroup ball id 3\nset group ball diameter 0.002\n")
    moves = """\
fix press ball addforce 1.0 0 0
fix slow ball viscous 5.0
fix move ball nve/sphere
fix hold first move linear 0 0 0
fix held second move linear 0 0 0
variable x equal x[3]
variable vx equal vx[3]
"""
    moves += thermo(1000, ["v_x", "v_vx", "f_cem[37]"]) + "run 12000\n"
    text = cement(4e-4, 2e-8, CALCITE, axis="radial", damage="damage tensor B0 9.6e3 condense yes", couple="kn auto kt auto friction 0.3")
    rows = run(scene + CONTACT + text + moves, tmp_path, 1).table()
    assert abs(rows["v_vx"][-1]) < 1e-4 < np.abs(rows["v_vx"]).max()
    sank = rows["v_x"][-1] + 4e-3  # the outer radius of the cement is 3 mm, and that of the bead 1 mm; the lattice is within half a spacing
    energy = rows["f_cem[37]"][-1]
    assert abs(sank) < 1e-4 and 0 < energy
    # as stiff as a few points of (0.2 mm)^2 at 8.5e12 Pa/m, C33 over the radius of a grain
    assert 1.0 / (2 * 100 * 4e-8 * 8.5e12) < energy < 1.0 / (2 * 1 * 4e-8 * 8.5e12)


@pytest.mark.parametrize("cement_words, limit", [("inner 1e-3 outer 2e-3", 1e-3), ("inner 4e-4 outer 1.2e-3 film joined", 1e-4)])
def test_cohesive_interface_of_condensed_bond(cement_words, limit, tmp_path):
    """The bond is condensed until its interface comes near its strength, and fails as the one that never was."""
    curves = {}
    for condense in ("no", "yes"):
        text = cement(
            4e-4,
            2e-8,
            damage=f"damage tensor B0 9.6e5 condense {condense}",
            axis="radial",
            couple="kn auto kt auto interface cohesive tn 4e6 tt 5e6 Gn 3 Gt 4",
        )
        moves = pull(0.02, 1e-4, (0.3, 0, 1)) + thermo(50, ["f_bond[14]", "f_bond[7]", "f_cem[24]"]) + "run 7500\n"
        curves[condense] = run(pair(2e-4, cement=cement_words) + CONTACT + text + moves, tmp_path / condense, 1).table()
    no, yes = curves["no"], curves["yes"]
    peak = no["f_bond[14]"].max()
    assert (yes["f_cem[24]"][:5] == 0).all() and yes["f_cem[24]"].max() == 1
    assert no["f_bond[14]"][-1] < 0.9 * peak  # it softened
    for name in ("f_bond[14]", "f_bond[7]"):
        assert np.abs(no[name] - yes[name]).max() < limit * peak
