# SPDX-License-Identifier: GPL-2.0-or-later
"""`interface cohesive` of fix mpm/couple in a script: a flat bond without damage pulled off its grains."""
import re

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, RADIUS, cement, edit, launch, pair, pull, restarted, run, thermo

CELL, STEP, RAMP = 2.5e-4, 4e-9, 4e-6
TN, TT, GN, GT = 10e6, 10e6, 40.0, 40.0  # the surfaces of the grains are tilted: one energy for all modes
WORDS = f"interface cohesive tn {TN} tt {TT} Gn {GN} Gt {GT}"
COLUMNS = ["f_bond", "f_bond[13]", "f_bond[16]", "f_bond[17]", "f_bond[18]", "f_cem[8]", "f_cem[9]", "f_cem[12]"]
STEPS, HALF = 2000, 1000


def scene(words=WORDS, damage="events events.csv check 20", every=20, ring="content 0.01"):
    fixes = cement(CELL, STEP, elastic=CALCITE, axis="radial", damage=damage, couple=f"kn auto kt auto {words} csv 20 bond.csv")
    return pair(CELL / 2, cement=ring) + CONTACT + fixes + pull(4.0, RAMP) + thermo(every, COLUMNS)


def events(directory, name="events.csv"):
    return [line.split(",") for line in (directory / name).read_text().splitlines()[1:]]


def areas(output):
    """Attached areas at either grain, as create_cement tells them."""
    return [float(a) for a in re.search(r"attached area (\S+) \+ (\S+?),", output).groups()]


def test_pulled_off_its_grains(tmp_path, figures):
    """Links debond although no point fails, take Gn times their area, are listed, and the mode of the bond is debonding; the same on two
    ranks and after a restart."""
    first = run(scene() + f"run {HALF}\nwrite_restart half\nrun {STEPS - HALF}\n", tmp_path)
    table = first.table()
    assert table["f_bond[18]"][-1] == 0, "points failed"
    listed = events(tmp_path)
    assert len(listed) == table["f_bond[17]"][-1] > 50
    assert {r[-1] for r in listed} == {"debonding"} and {r[4] for r in listed} <= {"1", "2"}
    row = (tmp_path / "bond.csv").read_text().splitlines()[-1].split(",")
    assert row[-1] == "debonding"
    peak = table["f_bond"].argmax()
    figures.below("imbalance of the energy from the peak on", abs(table["f_cem[12]"][peak:]).max(), 0.01)
    grain = {int(r[4]) for r in listed}
    assert len(grain) == 1
    # what is more than Gn times the area is the damage at the other grain, which stays on
    figures.below("energy over Gn times the area, less 1", abs(table["f_cem[8]"][-1] / (GN * areas(first.output)[grain.pop() - 1]) - 1), 0.05)
    assert any(int(r[0]) > HALF for r in listed) and any(int(r[0]) <= HALF for r in listed)

    run(edit(scene(), "events.csv", "ranks.csv") + f"run {STEPS}\n", tmp_path, ranks=2, name="in.ranks")
    assert [r[:5] for r in events(tmp_path, "ranks.csv")] == [r[:5] for r in listed]
    after = edit(edit(scene(), "events.csv", "after.csv"), pair(CELL / 2, cement="content 0.01"), restarted("half"))
    run(after + f"run {STEPS - HALF}\n", tmp_path, name="in.after")
    assert [r[:5] for r in events(tmp_path, "after.csv")] == [r[:5] for r in listed if int(r[0]) > HALF]


@pytest.mark.parametrize("friction", ["", " friction 0.3"])
def test_sheared_off_its_grains(tmp_path, figures, friction):
    """The grain is free across the shear, so one side of the bond is pressed, and links debond under pressure. The energy of the pressure is
    released, or taken over by contact points; that of friction's springs is frictional dissipation where these open again."""
    motion = edit(pull(0.2, 2e-6, (1, 0, 0)), "variable v_dx v_dy v_dz v_vx v_vy v_vz", "variable v_dx NULL NULL v_vx NULL NULL")
    fixes = cement(
        CELL, 8e-9, elastic=CALCITE, axis="radial", damage="check 20", couple="kn auto kt auto interface cohesive tn 1e7 tt 1e7 Gn 1.06 Gt 1.06" + friction
    )
    text = pair(CELL / 2, cement="content 0.01") + CONTACT + fixes + motion + thermo(20, COLUMNS)
    table = run(text + "run 1200\n", tmp_path).table()
    assert table["f_bond[18]"][-1] == 0 and table["f_bond[17]"][-1] > 0.8 * table["f_bond[16]"][0]
    figures.below(f"links that debonded under pressure{',' * bool(friction)}{friction}: imbalance of the energy", abs(table["f_cem[12]"]).max(), 1e-3)


B0, G = 9.6e3, 4.0  # strength of the cement: 19 MPa
# strength of the interface, how cracks split, mode, share of the fracture surface at a grain
MODES = {
    "weak interface": (5e6, "bonds", "debonding", (1, 1)),
    "strong interface": (4e7, "bonds", "internal", (0, 0)),
    "strong interface, split": (4e7, "split", "internal", (0, 0)),
    "near the boundary": (1.8e7, "bonds", "mixed", (0.5, 0.85)),
    "near the boundary, split": (1.8e7, "split", "mixed", (0.5, 0.85)),
    "strong interface, updated": (4e7, "bonds kinematics updated", "internal", (0, 0)),
}


def breaking(strength, cracks, ring="content 0.01"):
    damage = f"damage tensor B0 {B0} cracks {cracks} {'' if 'updated' in cracks else 'quasistatic 1 0.1'} events events.csv check 20"
    fixes = cement(
        CELL,
        STEP,
        elastic=CALCITE,
        axis="radial",
        damage=damage,
        couple=f"kn auto kt auto interface cohesive tn {strength} tt {strength} Gn {G} Gt {G} csv 20 bond.csv",
    )
    return pair(CELL / 2, cement=ring) + CONTACT + fixes + pull(2.0, RAMP) + thermo(20, [*COLUMNS, "f_bond[22]", "f_bond[23]", "f_bond[24]"])


def cement_of(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return dict(zip(lines[0].split(), np.array([[float(w) for w in line.split()] for line in lines[1:]]).T))


@pytest.mark.parametrize("case", MODES)
def test_the_link_or_the_point(case, tmp_path, figures):
    """Links fail by debonding; internal failure is points that fail and stay on the grain as residue: in the mode, the events, the
    columns, the report, the cement that is written, and in the bond that is made of it."""
    strength, cracks, mode, (least, most) = MODES[case]
    done = run(
        breaking(strength, cracks) + f"run {600 if mode == 'mixed' else 1000}\nwrite_cement cement.txt\n", tmp_path
    )  # a mixed surface is found by what broke until the bond separated
    t = done.table()
    listed = events(tmp_path)
    assert t["f_bond[22]"][-1] == 1 and (tmp_path / "bond.csv").read_text().splitlines()[-1].endswith("," + mode)
    told = next(line for line in done.output.splitlines() if "bond 1 of grains 1 and 2: " in line)
    assert f": {mode}, {t['f_bond[18]'][-1]:g} points failed, {t['f_bond[17]'][-1]:g} links debonded" in told
    share = t["f_bond[23]"][-1] + t["f_bond[24]"][-1]
    figures.note(
        f"{case}: share of the fracture surface at a grain, links that debonded, points that failed", [share, t["f_bond[17]"][-1], t["f_bond[18]"][-1]]
    )
    assert least <= share <= most
    by_link, by_point = ([r for r in listed if r[-1] == m] for m in ("debonding", "internal"))
    assert len(by_link) == t["f_bond[17]"][-1] and all(r[4] in "12" for r in by_link)
    assert len(by_point) == t["f_bond[18]"][-1] and all(r[4] == "0" for r in by_point)
    c = cement_of(tmp_path / "cement.txt")
    links = sum((c[f"area_{s}"] > 0).sum() for s in "ij")
    holds = sum(((c[f"area_{s}"] > 0) & (c[f"attached_{s}"] == 1)).sum() for s in "ij")
    residue = sum(((c[f"attached_{s}"] == 1) & (c["failed"] == 1)).sum() for s in "ij")
    assert links - holds == len(by_link) and t["f_bond[16]"][-1] == holds
    assert (residue > 50) == (mode != "debonding")
    figures.below(f"{case}: imbalance of the energy", abs(t["f_cem[12]"][t["f_bond"].argmax() :]).max(), 0.01)
    if mode == "debonding" or cracks != "bonds":  # fragments of split nodes fly off their lattice
        return
    again = from_file(strength, t) + "fix hold grains move linear 0 0 0\n" + thermo(20, ["f_bond[16]", "f_bond[17]", "f_bond[22]", "f_bond[23]", "f_bond[24]"])
    again = run(again.replace("events events.csv", "").replace("csv 20 bond.csv", "") + "write_cement again.txt\nrun 40\n", tmp_path, name="in.again").table()
    b = cement_of(tmp_path / "again.txt")
    for column in ("damage_i", "damage_j", "attached_i", "attached_j", "failed"):
        assert (b[column] == c[column]).all(), column
    assert again["f_bond[16]"][-1] == holds and again["f_bond[22]"][-1] == 1
    assert again["f_bond[23]"][-1] + again["f_bond[24]"][-1] == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize("cracks", ["bonds", "split"])
def test_residue_carries_nothing(tmp_path, figures, cracks):
    """Half of the points at a grain failed and stayed on it: the bond carries what it carries when these are debonded from the grain."""
    run(pair(CELL / 2, cement="content 0.01") + "write_cement whole.txt\n", tmp_path)
    c = cement_of(tmp_path / "whole.txt")
    loads = []
    for residue in (True, False, None):
        c["failed"] = ((c["area_i"] > 0) & (c["x"] < 0) & (residue is not None)).astype(float)
        c["attached_i"] = ((c["area_i"] > 0) & ((c["failed"] == 0) | bool(residue))).astype(float)
        c["damage_i"] = c["damage_j"] = 0 * c["x"]
        np.savetxt(tmp_path / "cement.txt", np.column_stack(list(c.values())), fmt="%.17g", header=" ".join(c), comments="")
        text = (
            edit(breaking(4e7, cracks), "shape flat content 0.01 inner auto", "file cement.txt").replace("events events.csv", "").replace("csv 20 bond.csv", "")
        )
        t = run(text + "run 200\n", tmp_path).table()
        assert t["f_bond[18]"][-1] == c["failed"].sum()
        loads.append(t["f_bond"][-1])
    figures.below(f"{cracks}: load of a bond with residue against links that debonded", abs(loads[0] / loads[1] - 1), 1e-9)
    assert loads[0] < 0.7 * loads[2]


def from_file(strength, table):
    """The cement that was written, with grain 2 where it was then."""
    text = edit(breaking(strength, "bonds"), "shape flat content 0.01 inner auto", "file cement.txt")
    return edit(text[: text.index("variable t equal")], f"0 0 {RADIUS:.15g}", f"0 0 {RADIUS + table['f_bond[13]'][-1]:.17g}")


def test_the_same_mode_on_ranks_and_after_a_restart(tmp_path):
    """Where links and points break side by side."""
    listed = []
    first = breaking(1.8e7, "bonds")
    run(first + "run 540\nwrite_restart half\nrun 110\n", tmp_path)
    listed.append(events(tmp_path))
    run(edit(first, "events.csv", "ranks.csv") + "run 650\n", tmp_path, ranks=2, name="in.ranks")
    listed.append(events(tmp_path, "ranks.csv"))
    assert {r[-1] for r in listed[0]} == {"debonding", "internal"}
    key = lambda rows: [(*r[:1], *r[2:5], r[-1]) for r in rows]
    assert key(listed[0]) == key(listed[1])
    after = edit(edit(first, "events.csv", "after.csv"), pair(CELL / 2, cement="content 0.01"), restarted("half"))
    run(after + "run 110\n", tmp_path, name="in.after")
    later = key(events(tmp_path, "after.csv"))
    assert {k[-1] for k in later} == {"debonding", "internal"} and later == [k for k in key(listed[0]) if int(k[0]) > 540]


def test_link_damage_is_for_the_law_that_knows_it(tmp_path):
    """Cement with damaged links, read for the penalty, is refused; bad values are named with their line."""
    table = run(breaking(1.8e7, "bonds") + "run 540\nwrite_cement cement.txt\n", tmp_path).table()
    c = cement_of(tmp_path / "cement.txt")
    assert 0.5 < max(c["damage_i"].max(), c["damage_j"].max()) <= 1
    text = from_file(1.8e7, table) + "fix hold grains move linear 0 0 0\n"
    refused = launch(edit(text, f"interface cohesive tn {1.8e7} tt {1.8e7} Gn {G} Gt {G}", "") + "run 0\n", tmp_path)
    assert refused.status != 0 and len(refused.errors()) == 1
    for words in ("fix mpm/couple (id bond)", "grains 1 and 2", "'interface penalty' does not know", "damage_i damage_j"):
        assert words in refused.errors()[0], refused.errors()
    row = int(np.flatnonzero((c["area_i"] > 0) & (c["attached_i"] == 1))[0])
    for value, attached, words in (
        (1.5, 1, "'damage_i' is 1.5; the damage of a link must lie between 0 and 1"),
        (-0.1, 1, "'damage_i' is -0.1"),
        (1.0, 1, "has debonded"),
    ):
        bad = {n: v.copy() for n, v in c.items()}
        bad["damage_i"][row], bad["attached_i"][row] = value, attached
        np.savetxt(tmp_path / "cement.txt", np.column_stack(list(bad.values())), fmt="%.17g", header=" ".join(bad), comments="")
        done = launch(text + "run 0\n", tmp_path)
        assert done.status != 0 and len(done.errors()) == 1 and words in done.errors()[0] and "line" in done.errors()[0], done.output[-1000:]
    gone = {n: v for n, v in c.items() if n not in ("attached_i", "attached_j")}
    np.savetxt(tmp_path / "cement.txt", np.column_stack(list(gone.values())), fmt="%.17g", header=" ".join(gone), comments="")
    done = launch(text + "run 0\n", tmp_path)
    assert done.status != 0 and "'damage_i damage_j' need 'attached_i attached_j'" in done.errors()[0]


@pytest.mark.parametrize("words, formula", [("tn 2e7 tt 1e6 Gn 4 Gt 4", "E Gn/tn^2"), ("tn 1e6 tt 1.5e7 Gn 4 Gt 4", "G Gt/tt^2")])
def test_cells_that_do_not_resolve_the_interface(tmp_path, words, formula):
    """A warning with the cell to take; none with that cell, nor in the run after."""
    n, t = (float(words.split()[i]) for i in (1, 3))
    length = {"E Gn/tn^2": CALCITE[1] * 4 / n**2, "G Gt/tt^2": CALCITE[4] * 4 / t**2}[formula]
    assert length < 2 * CELL
    done = run(scene(f"interface cohesive {words}", damage="") + "run 0\nrun 0\n", tmp_path)
    told = [line for line in done.output.splitlines() if "softens over" in line]
    assert len(told) == 1 and formula in told[0] and "WARNING" in told[0], done.output[-2000:]
    cell = float(re.search(r"use 'cell (\S+)' or less", told[0])[1])
    assert cell == pytest.approx(length / 2, rel=1e-4)
    finer = (
        scene(f"interface cohesive {words}", damage="")
        .replace(f"cell {CELL:.15g}", f"cell {0.999 * cell:.15g}")
        .replace(f"spacing {CELL / 2:.15g}", f"spacing {0.4995 * cell:.15g}")
    )
    assert "softens over" not in run(finer + "run 0\n", tmp_path).output


@pytest.mark.parametrize(
    "words, message",
    [
        ("interface cohesive tn 1e6 tt 0 Gn 1 Gt 1", "'interface cohesive tt 0': must be greater than 0"),
        ("interface cohesive tn 1e6 tt 1e6 Gn -1 Gt 1", "'interface cohesive Gn -1': must be greater than 0"),
        ("interface cohesive tn 1e6 tt 1e6 Gn 1 Gt 0", "'interface cohesive Gt 0': must be greater than 0"),
        ("interface cohesive tn 1e6 tt 1e9 Gn 1 Gt 1e-3", "'Gt 0.001' must be above"),
        ("interface cohesive tn nan tt 1e6 Gn 1 Gt 1", "tn"),
        ("interface cohesive tn 1e6 tt 1e6 Gn inf Gt 1", "Gn"),
        ("interface cohesive tn 1e6 tt 1e6 Gn 1 Gt 1 tn 2e6", "tn"),
        ("interface cohesive tn 1e6 tt 1e6 Gn 1", "'interface cohesive' needs 'Gt', the energy per area that shear takes"),
        ("interface cohesive tn -1 tt 1e6 Gn 1 Gt 1", "'interface cohesive tn -1': must be greater than 0"),
        ("interface cohesive tn 1e9 tt 1e6 Gn 1e-3 Gt 1", "'Gn 0.001' must be above"),
        ("interface glue", "interface"),
    ],
)
def test_bad_options(tmp_path, words, message):
    done = launch(scene(words) + "run 0\n", tmp_path)
    assert done.status != 0
    assert len(done.errors()) == 1 and message in done.errors()[0], done.output[-1000:]


def test_another_law_after_a_restart_is_refused(tmp_path):
    run(scene() + "run 10\nwrite_restart early\n", tmp_path)
    for words, told in (("", "interface penalty"), (edit(WORDS, f"Gn {GN}", "Gn 21"), "interface cohesive")):
        done = launch(edit(scene(words), pair(CELL / 2, cement="content 0.01"), restarted("early")) + "run 1\n", tmp_path, name="in.other")
        assert done.status != 0 and any(told in e and f"Gn {GN:g}" in e for e in done.errors()), done.output[-1000:]


@pytest.mark.parametrize("words", ["", "basis cubic"])
def test_struck(words, tmp_path, figures):
    """A free grain is thrown away from the other: links jump over their peak in a step, open and close, and the energy balance is that of central differences."""
    cell = 5e-4
    script = (
        pair(cell / 2, gap=4e-4, cement="content 0.01")
        + CONTACT
        + cement(cell, 3.9e-8, elastic=CALCITE, axis="radial", damage=f"{words} check 20", couple="kn auto kt auto interface cohesive tn 2e7 tt 4e7 Gn 4 Gt 4")
        + "fix motion grains nve/sphere\nvelocity second set 0 0 0.1\n"
        + thermo(1, ["f_bond", "f_bond[17]", "f_cem[8]", "f_cem[12]"])
        + "run 300\n"
    )
    table = run(script, tmp_path).table()
    assert table["f_cem[8]"][-1] > 0
    figures.below(f"{words or 'quadratic'}: imbalance of the energy", abs(table["f_cem[12]"]).max(), 1e-5)


def test_events_of_points_that_did_not_hold(tmp_path):
    """By the rule of the paper an event names the grain of a link that debonded with its point, not that of one that was never bonded."""
    run(pair(CELL / 2, cement="content 0.01") + "write_cement whole.txt\n", tmp_path)
    c = cement_of(tmp_path / "whole.txt")
    loose = (c["area_i"] > 0) & (c["x"] < 0)
    c["attached_i"] = ((c["area_i"] > 0) & ~loose).astype(float)
    np.savetxt(tmp_path / "cement.txt", np.column_stack(list(c.values())), fmt="%.17g", header=" ".join(c), comments="")
    text = edit(scene("", "damage tensor B0 9.6e3 cutoff 0.9 check 20 events events.csv"), "shape flat content 0.01 inner auto", "file cement.txt")
    run(text + "dump d calcite custom 1 places.txt id x\nrun 0\nundump d\nrun 1200\n", tmp_path)
    x = {row.split()[0]: float(row.split()[1]) for row in (tmp_path / "places.txt").read_text().split("ITEM: ATOMS id x")[1].splitlines() if row.strip()}
    at = [(r[4], x[r[2]] < 0) for r in events(tmp_path)]
    assert ("1", False) in at and ("0", True) in at, "points beside both halves of the first grain fail"
    assert ("1", True) not in at
