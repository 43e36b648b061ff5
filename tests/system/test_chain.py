# SPDX-License-Identifier: GPL-2.0-or-later
"""Three grains in a row: a bond on one rank beside one that ranks cut, or beside none; and cement that is dragged apart."""
import numpy as np
import pytest
from scenes import edit, launch, run, thermo

SOFT = """\
fix          m1 all property/global youngsModulus peratomtype 1e7 1e7
fix          m2 all property/global poissonsRatio peratomtype 0.25 0.25
fix          m3 all property/global coefficientRestitution peratomtypepair 2 0.3 0.3 0.3 0.3
fix          m4 all property/global coefficientFriction peratomtypepair 2 0.5 0.5 0.5 0.5
pair_style   gran model hertz tangential history
pair_coeff   * *
"""


def chain(places, words, create="points now", timestep=3e-6, upper=0.011):
    """Grains of 4 mm at these places; the box is cut in the middle of its height on two ranks."""
    atoms = "".join(f"create_atoms 1 single {x} {y} {z}\n" for x, y, z in places)
    return f"""\
units        si
atom_style   mpdem
atom_modify  map array first grains
boundary     f f f
processors   1 1 *
newton       off
communicate  single vel yes
region       box block -0.006 0.006 -0.006 0.006 -0.005 {upper} units box
create_box   2 box
{atoms}set          type 1 diameter 0.004 density 2500
group        grains type 1
communicate  single vel yes group grains
neighbor     0.001 bin
neigh_modify include grains delay 0
{SOFT}timestep     {timestep}
create_cement calcite contacts grains gap 2e-5 shape flat outer 1.2e-3 inner auto spacing 3e-4 {create}
fix          cem calcite mpm cell 6e-4 elastic isotropic 1e7 0.25 damage tensor B0 300 {words}
fix          bond grains mpm/couple cem
"""


DRAGGED = """\
group        a id 1
group        c id 3
group        free subtract grains a c
variable     t equal step*dt
variable     y equal 0.5*40*v_t*v_t
variable     w equal 40*v_t
fix          ha a move linear 0 0 0
fix          hb free nve/sphere
fix          hc c move variable NULL v_y NULL NULL v_w NULL
"""
THREE = [(0, 0, -0.003), (0, 0, 0.001), (0, 0, 0.005)]


@pytest.mark.parametrize("cracks", ["bonds", "split"])
def test_second_run_beside_a_rank_without_cement(cracks, tmp_path):
    """It goes on as it does on one rank."""
    script = chain(THREE[:2], f"cracks {cracks}", timestep=2e-6, upper=0.05) + "fix motion grains nve/sphere\ngroup b id 2\nvelocity b set 0 0 0.05 units box\n"
    script += thermo(5, ["f_bond", "f_cem[2]"]) + "run 20\nrun 20\n"
    alone, two = (run(script, tmp_path / str(ranks), ranks, minutes=1).table() for ranks in (1, 2))
    assert alone["f_bond"].max() > 0 and two["f_bond"] == pytest.approx(alone["f_bond"], abs=1e-9 * abs(alone["f_bond"]).max())


@pytest.mark.parametrize("points", ["now", "later"])
def test_bond_is_activated_beside_one_that_ranks_cut(points, tmp_path):
    """The first bond is whole on a rank. It is activated, and gets its points, while the other one is resolved."""
    script = chain(THREE, "condense yes", f"points {points}") + DRAGGED + thermo(1, ["f_cem[24]", "f_cem[2]", "f_bond[1][2]", "f_bond[2][2]"]) + "run 1000\n"
    alone, two = (run(script, tmp_path / str(ranks), ranks, minutes=1).table() for ranks in (1, 2))
    awake = alone["f_cem[24]"]
    assert list(np.unique(awake)) == [0, 1, 2] and (two["f_cem[24]"] == awake).all() and (two["f_cem[2]"] == alone["f_cem[2]"]).all()
    for name in ("f_bond[1][2]", "f_bond[2][2]"):
        assert two[name] == pytest.approx(alone[name], abs=1e-7 * abs(alone[name]).max()), name


@pytest.mark.parametrize("points", ["now", "later"])
@pytest.mark.parametrize("ranks", [1, 2])
def test_ids_that_change(ranks, points, tmp_path):
    """Bonds know their grains by ID."""
    script = chain([(0, 0.004, 0.001), (0, 0.004, 0.009), *THREE[1:]], "condense yes", f"points {points}") + "fix motion grains nve/sphere\nrun 10\n"
    script = edit(script, "contacts grains", "contacts bonded") + "delete_atoms group loose\nrun 10\n"
    script = edit(script, "group        grains type 1\n", "group        grains type 1\ngroup bonded id 3 4\ngroup loose id 1\n")
    result = launch(script, tmp_path, ranks)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    for words in ("fix mpm (id cem)", "the IDs of atoms were changed", "compress no"):
        assert words in result.errors()[0], result.errors()[0]


@pytest.mark.parametrize("words, step", [("", 0.8), ("", 0.9), ("cracks split", 0.7)])
def test_fragments_that_close_make_no_energy(words, step, tmp_path, figures):
    """Long after bonds separated, fragments are squeezed and torn to any shape. With `unilateral yes` they are stiff where they close. One bond crosses the end of the box."""
    places = [(0, 0, -0.003), (0, 0, 0.001), (0, 1e-4, 0.005), (0.004, 0, -0.003)]
    script = (
        edit(chain(places, f"unilateral yes timestep auto {step} {words}", "overlap skip", upper=0.007), "boundary     f f f", "boundary     p p p") + DRAGGED
    )
    t = run(script + "fix g all gravity 9.81 vector 1 0 0\n" + thermo(100, ["f_cem[2]", "f_cem[12]", "f_cem[19]"]) + "run 3000\n", tmp_path).table()
    assert t["f_cem[2]"][-1] > 200 and t["f_cem[19]"][-1] >= 3
    figures.below(f"{words} step {step}: energy imbalance", abs(t["f_cem[12]"]).max(), 0.01)
