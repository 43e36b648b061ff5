# SPDX-License-Identifier: GPL-2.0-or-later
"""`friction` of fix mpm/couple in a script: debonded cement touches again. Figures are in tests/unit/coupling/test_debonded_contact.cpp."""
import csv
from pathlib import Path

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, cement, edit, launch, pair, pull, restarted, run, thermo

CELL = 2.5e-4
WORDS = "friction 0.3"


def scene(words=WORDS, damage="check 20", **more):
    fixes = cement(CELL, 4e-9, elastic=CALCITE, axis="radial", damage=damage, couple=f"kn auto kt auto {words} csv 20 bond.csv", **more)
    return pair(CELL / 2, cement="content 0.01") + CONTACT + fixes + pull(4.0, 4e-6) + thermo(20, ["f_bond"])


@pytest.mark.parametrize(
    "words, damage, message",
    [
        ("friction -0.1", "check 20", "[0, 100]"),
        ("friction nan", "check 20", "friction"),
        ("friction", "check 20", "friction"),
        (WORDS, "check 20 kinematics updated", "'friction 0.3' does not go with 'kinematics updated' of fix mpm (id cem): it needs a reference that stays"),
        (WORDS, "check 20 cracks split mass_order 2", "with lumped masses"),
        ("", "check 20 unilateral maybe", "unilateral"),
        ("", "check 20 unilateral yes", "'unilateral yes' does not go with 'damage none': nothing fails without a law of damage"),
        (
            "",
            "damage tensor B0 9.6e3 check 20 kinematics updated unilateral yes",
            "'unilateral yes' does not go with 'kinematics updated': cracks are measured from a reference that stays",
        ),
        (WORDS, "check 20 reproject auto 0.1", "'friction 0.3' does not go with 'reproject auto 0.1' of fix mpm (id cem): it needs a reference that stays"),
    ],
)
def test_bad_options(tmp_path, words, damage, message):
    done = launch(scene(words, damage) + "run 0\n", tmp_path)
    assert done.status != 0
    assert len(done.errors()) == 1 and message in done.errors()[0], done.output[-1000:]


def test_other_friction_after_a_restart_is_refused(tmp_path):
    run(scene() + "run 10\nwrite_restart early\n", tmp_path)
    for words in ("", "friction 0.2"):
        done = launch(edit(scene(words), pair(CELL / 2, cement="content 0.01"), restarted("early")) + "run 1\n", tmp_path, name="in.other")
        assert done.status != 0 and any("'friction 0.3'" in e for e in done.errors()), done.output[-1000:]


def test_example_breaks_closes_and_slides(tmp_path, figures):
    """examples/pair_closed: tension until it breaks, compression when it is closed, friction mu N beyond what there is without, and the balance closes."""
    folder = Path(__file__).parents[2] / "examples" / "pair_closed"
    share = {}
    for mu in (0.3, 0):
        out = tmp_path / f"mu{mu}"
        assert launch((folder / "in.closed").read_text(), out, name="in.closed", arguments=["-var", "mu", str(mu)]).status == 0
        with open(out / "bond.csv") as f:
            rows = list(csv.DictReader(f))
        step, tension, shear, apart, touching, imbalance = (
            np.array([float(r[name]) for r in rows]) for name in ("step", "tension", "fx1", "separated", "touching_grain2", "energy_imbalance")
        )
        closed, sliding = step >= 2600, step >= 3400
        assert tension.max() > 50 and apart[-1] == 1 and touching[closed].mean() > 0.05 and touching[closed].min() > 0.01
        assert tension[closed].max() < -20
        share[mu] = shear[sliding].mean() / -tension[sliding].mean()
        figures.below(f"mu {mu}: energy imbalance through breaking, closing and sliding", abs(imbalance).max(), 0.001)
    figures.note("shear over normal force while the closed bond slides, mu 0.3 and 0", f"{share[0.3]:.3f} {share[0]:.3f}")
    assert 0.2 < share[0.3] - share[0] < 0.3 and share[0] < 0.1


@pytest.mark.parametrize("cracks", ["bonds", "split"])
def test_crushed_cement_keeps_the_balance(cracks, tmp_path, figures):
    """Compression through failure and beyond: pieces and contact points are pressed, come off and meet again, in ten runs one after the other."""
    script = Path(__file__).parents[2] / "examples" / "pair_table" / "in.pair_table"
    for mu in (0, 0.3):
        out = tmp_path / f"mu{mu}"
        words = dict(
            shape="flat",
            load="compression",
            content=0.02,
            inner=1e-3,
            film="grid",
            spacing=2.5e-4,
            cracks=cracks,
            speed=0.3,
            limit=1000,
            frames=10**8,
            bonding=f"penalty friction {mu}",
            regularization="nonlocal 5e-4 energy 26.5",
        )
        result = launch(script.read_text(), out, name="in.pair_table", arguments=[w for k, v in words.items() for w in ("-var", k, str(v))])
        assert result.status == 0, result.output[-2000:]
        with open(out / "bond_run.csv") as f:
            rows = list(csv.DictReader(f))
        assert int(rows[-1]["failed"]) > 300 and max(float(r["touching_grain1"]) for r in rows) > 0.03
        figures.below(f"crushed, cracks {cracks}, mu {mu}: energy imbalance", max(abs(float(r["energy_imbalance"])) for r in rows), 0.01)


@pytest.mark.parametrize("zeta", [1, 0.1])
@pytest.mark.parametrize("cracks", ["bonds", "split"])
def test_points_that_fail_under_compression_keep_the_balance(cracks, zeta, tmp_path, figures):
    """With `unilateral yes` a pressed point goes on with the pressure that it had. If it were as stiff as whole cement from its reference on, energy would come of nothing."""
    script = (Path(__file__).parents[2] / "examples" / "pair_table" / "in.pair_table").read_text()
    words = dict(
        shape="flat",
        load="compression",
        content=0.02,
        inner=1e-3,
        film="grid",
        spacing=2.5e-4,
        cracks=cracks,
        speed=0.3,
        zeta=zeta,
        limit=1000,
        frames=10**8,
        regularization="nonlocal 5e-4 energy 26.5",
    )
    result = launch(
        script.replace("check ${chunk}", "check ${chunk} unilateral yes"),
        tmp_path,
        name="in.pair_table",
        arguments=[w for k, v in words.items() for w in ("-var", k, str(v))],
    )
    assert result.status == 0, result.output[-2000:]
    with open(tmp_path / "bond_run.csv") as f:
        rows = list(csv.DictReader(f))
    assert int(rows[-1]["failed"]) > 300
    figures.below(f"pressed, cracks {cracks}, zeta {zeta}: energy imbalance", max(abs(float(r["energy_imbalance"])) for r in rows), 0.001)


@pytest.mark.parametrize("cracks", ["bonds", "split"])
def test_cement_beside_residue_touches_it(cracks, tmp_path, figures):
    """A cohesive interface stronger than the cement: the bond breaks beside the grains, residue stays on these, and carries what is pressed on it until that is crushed."""
    way = "(4e-6*(0.5*(1-cos(PI*v_t/1.35e-5))*(v_t<1.35e-5)+(v_t>=1.35e-5))-8e-6*(0.5*(1-cos(PI*(v_t-1.35e-5)/4e-5))*(v_t>=1.35e-5)))"
    speed = "(4e-6*(0.5*PI/1.35e-5*sin(PI*v_t/1.35e-5)*(v_t<1.35e-5))-8e-6*(0.5*PI/4e-5*sin(PI*(v_t-1.35e-5)/4e-5)*(v_t>=1.35e-5)))"
    text = pair(1.25e-4, gap=3e-4, cement="inner 1e-3 outer 2e-3")
    text += cement(
        2.5e-4,
        9e-9,
        axis="radial",
        damage=f"damage tensor B0 9.6e3 regularization nonlocal 4e-4 cracks {cracks} quasistatic 1 0.3 check 20",
        couple="kn auto kt auto interface cohesive tn 4e7 tt 4e7 Gn 20 Gt 20 friction 0.3",
    )
    text += f'variable t equal step*dt\nvariable z equal "{way}"\nvariable w equal "{speed}"\n'
    text += "fix hold first move linear 0 0 0\nfix pull second move variable NULL NULL v_z NULL NULL v_w\n"
    columns = ["f_bond", "f_bond[17]", "f_bond[22]", "f_bond[36]", "f_bond[37]", "f_cem[12]", "v_z"]
    t = run(text + thermo(50, columns) + "run 4600\n", tmp_path).table()
    apart = t["f_bond[22]"] == 1
    assert t["f_bond"].max() > 100 and apart.any() and t["f_bond[17]"].max() < 20, "breaks, and hardly a link debonds"
    touching = (t["f_bond[36]"] + t["f_bond[37]"])[apart]
    figures.note(
        f"cracks {cracks}: largest force that presses the halves, N, and share of the beads' surface that touches",
        f"{-t['f_bond'][apart].min():.3g} {touching.max():.2g}",
    )
    assert -t["f_bond"][apart].min() > 25 and touching.max() > 0.1
    figures.below(f"cracks {cracks}: energy imbalance", abs(t["f_cem[12]"]).max(), 0.01)


def test_grains_that_are_apart_are_not_dragged(tmp_path, figures):
    """The cement comes off a free grain, and the other grain takes it away, faster and faster: nothing holds the free one back."""
    fixes = edit(
        cement(4e-4, 3e-8, damage="quasistatic 1 0.1", couple=f"kn auto kt auto interface cohesive tn 3e6 tt 3e6 Gn 2 Gt 2 {WORDS}"), "timestep     3e-08", ""
    )
    text = pair(2e-4, gap=4e-4, half_box=(8e-3, 8e-3, 3e-2), cement="outer 1.5e-3") + edit(fixes, "mpm cell 0.0004", "mpm cell 0.0004 timestep auto 0.9")
    text += (
        "fix free first nve/sphere\nvariable t equal step*dt\nvariable z equal 1e4*v_t*v_t\nvariable w equal 2e4*v_t\n"
        "fix pull second move variable NULL NULL v_z NULL NULL v_w\nvariable v equal vz[1]\n"
    )
    t = run(text + thermo(50, ["f_bond[22]", "f_bond[3]", "v_v", "f_cem[12]"]) + "run 1600\n", tmp_path).table()
    apart = np.flatnonzero(t["f_bond[22]"] == 1)
    assert 5 < apart[0] < 18 and t["v_v"][-1] > 0.1
    figures.below(
        "force on a free grain that the cement came off, over the largest", abs(t["f_bond[3]"][apart[0] + 8 :]).max() / abs(t["f_bond[3]"]).max(), 0.02
    )  # it rings a while
    figures.below("change of the velocity of that grain", abs(t["v_v"][-1] / t["v_v"][apart[0] + 4] - 1), 0.01)
    figures.below("free grain: energy imbalance", abs(t["f_cem[12]"]).max(), 1e-5)


@pytest.mark.parametrize("cracks", ["bonds", "split"])
def test_a_broken_bond_flies_to_other_ranks(cracks, tmp_path, figures):
    """Phantom nodes and contact points come along, from a rank that has no point of the bond any more; and contact points go on between two ranks."""
    script = (
        pair(2.5e-4, gap=5e-4, half_box=(1.2e-2, 1.2e-2, 2e-2), cement="content 0.01")
        + cement(5e-4, 2.9e-8, elastic=CALCITE, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 cracks {cracks}", couple=f"kn auto kt auto {WORDS}")
        + "fix motion grains nve/sphere\nvelocity all set 0 0 150\nvelocity second set 0.2 -0.3 151\n"
        + thermo(10, ["f_bond", "f_bond[18]", "f_bond[22]", "f_bond[36]", "f_bond[37]"])
        + "run 400\n"
    )
    tables = {ranks: run(script, tmp_path / f"{ranks}", ranks).table() for ranks in (1, 2, 4)}
    alone = tables[1]
    assert alone["f_bond[22]"][-1] == 1 and alone["f_bond[36]"].max() > 0.005
    for ranks in (2, 4):
        figures.below(
            f"cracks {cracks}, {ranks} ranks: force of the broken bond against one rank, over the peak",
            abs(tables[ranks]["f_bond"] - alone["f_bond"]).max() / alone["f_bond"].max(),
            1e-8,
        )
        assert (tables[ranks]["f_bond[18]"] == alone["f_bond[18]"]).all()


def test_restart_of_a_bond_that_ranks_cut(tmp_path):
    """The faces of a split bond touch again long after the file was written. The nodes of a rank do not depend on when it found the constraints at the edge."""
    fixes = cement(4e-4, 2e-8, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9 check 20 cracks split", couple=f"kn auto kt auto {WORDS}")
    z, w = (
        "(2e-6*(1-cos(PI*v_t/8e-6))*(v_t<8e-6)+(4e-6-2.6e-6*(1-cos(PI*(v_t/1.2e-5-2/3))))*(v_t>=8e-6))",
        "(PI/4*sin(PI*v_t/8e-6)*(v_t<8e-6)-2.6/12*PI*sin(PI*(v_t/1.2e-5-2/3))*(v_t>=8e-6))",
    )
    x, v = "1e-6*(1-cos(PI*v_t/1e-5))", "0.1*PI*sin(PI*v_t/1e-5)"
    fixes += (
        f'variable t equal step*dt\nvariable z equal "{z}"\nvariable w equal "{w}"\nvariable x equal "{x}"\nvariable v equal "{v}"\n'
        "variable y equal 0.3*v_x\nvariable u equal 0.3*v_v\nfix hold first move linear 0 0 0\nfix pull second move variable v_x v_y v_z v_v v_u v_w\n"
        + thermo(10, [f"f_bond[{n}]" for n in range(1, 13)] + ["f_bond[18]", "f_cem[23]"])
    )
    start = pair(2e-4, gap=4e-4, cement="outer 1.5e-3", processors="2 1 1")
    two = run(start + fixes + "run 300\nwrite_restart middle.restart\nrun 310\n", tmp_path / "two", 2).table()
    on = run(restarted("../two/middle.restart", processors="2 1 1") + fixes + "run 310\n", tmp_path / "on", 2).table()
    assert two["f_bond[18]"][30] > 100 and two["f_cem[23]"][-4] < 0.95 * two["f_cem[23]"][-1], "faces slide in the last steps"
    different = [name for name in on if (on[name] != two[name][-32:]).any()]
    assert not different, different


@pytest.mark.parametrize("share", [0.4, 0.8])
def test_debonded_cement_that_is_hit(tmp_path, figures, share):
    """A free grain pulls its cement off and hits it again and again, with steps that links need much added mass for. Contact needs some, and makes
    no energy by adding it: the energy grew by 40 % with the longer step when nodes kept their velocity then."""
    text = edit(
        pair(1.25e-4, gap=3e-4, cement="inner 1e-3 outer 2e-3", half_box=3 * (12.5e-3,)),
        "create_cement",
        "group first id 1\ngroup second id 2\nvelocity second set 0 0 0.2\ncreate_cement",
    )
    words = (
        cement(
            2.5e-4,
            1e-8,
            elastic=(60e9, 60e9, 0.2, 0.2, 25e9),
            damage=f"timestep auto {share} check 20",
            couple="kn auto kt auto interface cohesive tn 1e6 tt 1e6 Gn 0.2 Gt 0.2 friction 0.3",
        )
        .split("group        first")[0]
        .replace("timestep     1e-08\n", "")
    )
    back = "".join(f"velocity second set 0 0 {v}\nrun {int(600 / share)}\n" for v in (-0.1, 0.1))
    grain = "variable kinetic equal 0.5*mass[2]*(vx[2]^2+vy[2]^2+vz[2]^2)\n"
    t = run(
        text
        + CONTACT
        + words
        + "fix hold first move linear 0 0 0\nfix go second nve/sphere\n"
        + grain
        + thermo(5, ["f_bond[17]", "v_kinetic"] + [f"f_cem[{i}]" for i in (5, 6, 7, 12)])
        + f"run {int(600 / share)}\n"
        + back,
        tmp_path,
    ).table()
    energy = sum(t[c] for c in ("v_kinetic", "f_cem[5]", "f_cem[6]", "f_cem[7]"))
    assert t["f_bond[17]"][-1] > 500
    first = len(energy) // 3
    figures.below(f"step of {share:g}: largest energy of the pulled pair over the first", energy[:first].max() / energy[0], 1.01)
    for n in (1, 2):
        part = energy[n * first + 2 : (n + 1) * first]
        figures.below(f"step of {share:g}: largest energy over the first, hit {n}", part.max() / part[0], 1.03)
    figures.below(f"step of {share:g}: energy imbalance", abs(t["f_cem[12]"][10:]).max(), 0.004)
