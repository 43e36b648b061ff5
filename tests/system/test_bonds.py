# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes other than one bond in the middle of a box."""
import re
from pathlib import Path

import numpy as np
import pytest
from scenes import CONTACT, NEIGHBOURS, RADIUS, RING, cement, edit, host, in_cells, pair, pull, run, shift, thermo, uncoupled

CELL = 2e-4
CREATE = f"create_cement calcite pair %d %d shape flat {in_cells(RING)} spacing {CELL / 2:g}\n"


def grains(centres, box, **options):
    """Grains on the z axis."""
    text = host(**options) + f"region box block {box} units box\ncreate_box 2 box\n"
    for x, y, z in centres:
        text += f"create_atoms 1 single {x:.15g} {y:.15g} {z:.15g} units box\n"
    return text + f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n" + NEIGHBOURS


def test_two_bonds_in_a_row(tmp_path, figures):
    """Three grains: the stiffness from end to end is half of that of one bond."""

    def stiffness(script, directory, moved):
        script += (
            cement(CELL, 1e-8).replace("second id 2", f"second id {moved}")
            + shift(1e-8, 8e-6)
            + "run 800\n"
            + "unfix pull\nfix pull second move linear 0 0 0\nrun 600\n"
            + thermo(4, ["f_bond"])
            + "run 400\n"
        )
        return run(script, directory).table()["f_bond"].mean() / 1e-8

    one = stiffness(pair(CELL / 2), tmp_path / "one", 2)
    row = grains([(0, 0, -0.01), (0, 0, 0.01), (0, 0, 0)], "-0.006 0.006 -0.006 0.006 -0.0165 0.0165")
    # the grain in the middle is held by its bonds alone; it comes to rest by damping
    row += CREATE % (1, 3) + CREATE % (3, 2) + "group middle id 3\n"
    row += "fix middle middle nve/sphere\nfix slow middle viscous 2000\n"
    two = stiffness(row, tmp_path / "two", 2)
    figures.below("two bonds in a row: stiffness over half of that of one, less 1", abs(2 * two / one - 1), 1e-3)


def test_bond_across_a_periodic_boundary(tmp_path, figures):
    """A bond broken through the boundary of the box is the bond in its middle."""

    def table(height, directory):
        centres = [(0, 0, z + height) for z in (-RADIUS, RADIUS)]
        centres = [(x, y, z - 0.04 if z > 0.02 else z) for x, y, z in centres]
        script = (
            grains(centres, "-0.006 0.006 -0.006 0.006 -0.02 0.02", boundary="f f p")
            + CREATE % (1, 2)
            + cement(CELL, 3e-9, axis="radial", damage="damage tensor B0 9.6e6 cutoff 0.9")
            + pull(4.0, 4e-6)
            + thermo(20, ["f_bond", "f_bond[13]", "f_bond[17]", "f_cem[8]", "f_cem[18]"])
            + "run 1500\n"
        )
        return run(script, directory, 2).table()

    inside, across = table(0.0, tmp_path / "inside"), table(0.018, tmp_path / "across")
    assert inside["f_bond[17]"][-1] > 100
    assert (inside["f_bond[17]"] == across["f_bond[17]"]).all()
    for name in ("f_bond", "f_bond[13]", "f_cem[8]"):
        error = abs(inside[name] - across[name]).max() / abs(inside[name]).max()
        figures.below(f"bond across a periodic boundary: {name} against the middle of the box", error, 1e-7)


def test_cement_alone(tmp_path, figures):
    """Without fix mpm/couple the cement is a free body."""
    script = (
        edit(pair(CELL / 2), "-0.006 0.006 -0.006", "-0.006 0.008 -0.006")
        + cement(CELL, 1e-8)
        + 'variable vx atom "1e4*y+3"\nvariable vy atom "-1e4*x"\nvelocity calcite set v_vx v_vy 0\n'
        + "fix motion grains nve/sphere\n"
    )
    script = uncoupled(script) + thermo(50, ["f_cem[5]", "f_cem[6]"] + [f"f_cem[{i}]" for i in range(13, 19)]) + "run 2000\n"
    table = run(script, tmp_path, 2).table()
    P = np.array([table[f"f_cem[{i}]"] for i in range(13, 19)])
    for name, p in (("momentum", P[:3]), ("angular momentum", P[3:])):
        assert np.linalg.norm(p[:, 0]) > 0
        figures.below(f"cement alone: drift of {name}", np.linalg.norm(p - p[:, :1], axis=0).max() / np.linalg.norm(p[:, 0]), 1e-13)


@pytest.mark.parametrize("ranks", [1, 2])
def test_cement_added_between_runs(tmp_path, ranks):
    """A second bond, made while the first is loaded, carries load and leaves the first alone."""
    scene = grains([(0, 0, -0.005), (0, 0, 0.005), (0.01, 0, 0.005)], "-0.006 0.016 -0.006 0.006 -0.0105 0.0105")
    scene += CREATE % (1, 2) + cement(CELL, 1e-8) + pull(0.01, 2e-6)
    alone = run(scene + "run 400\nrun 0\n" + thermo(10, ["f_bond"]) + "run 400\n", tmp_path / "alone", ranks).table()
    both = run(
        scene
        + "run 400\n"
        + CREATE % (2, 3)
        + "group third id 3\nfix rest third freeze\nrun 0\n"
        + thermo(10, ["f_bond", "f_bond[2][16]", "f_bond[2][3]"])
        + "run 400\n",
        tmp_path / "both",
        ranks,
    )
    table = both.table()
    assert (table["f_bond"] == alone["f_bond"]).all()
    assert table["f_bond[2][16]"][-1] > 1000
    force = table["f_bond[2][3]"]  # on grain 2, which moves up
    assert abs(force[0]) < 1e-6 * abs(force[-1]) and force[-1] < 0


def test_values_are_not_divided_by_the_number_of_atoms(tmp_path):
    names = ["f_cem", "f_cem[1]", "f_cem[6]", "f_cem[12]", "f_bond", "f_bond[3]", "f_bond[1][16]", "f_limit[1]", "f_limit[2]"]
    script = pair(CELL / 2) + cement(CELL, 1e-8) + pull(0.1, 1e-6) + "fix limit all check/timestep/mpm 10 cem 0.9\n" + thermo(50, names)
    with_norm = run(script + "thermo_modify norm yes\nrun 50\n", tmp_path / "yes").table()
    without = run(script + "run 50\n", tmp_path / "no").table()
    assert without["f_cem[1]"][-1] > 1000 and without["f_bond[3]"][-1] != 0
    for name in names:
        assert (with_norm[name] == without[name]).all(), name


def test_rows_of_bonds_that_are_made_after_the_fix(tmp_path):
    """thermo_style and fix ave/time look at their number before the first run."""
    scene = grains([(0, 0, -0.005), (0, 0, 0.005), (0.01, 0, 0.005)], "-0.006 0.016 -0.006 0.006 -0.0105 0.0105")
    scene += CREATE % (1, 2) + cement(CELL, 1e-8) + CREATE % (2, 3) + "fix motion grains nve/sphere\n"
    scene += "fix rows all ave/time 1 1 5 f_bond[15] mode vector file rows.txt\n" + thermo(5, ["f_bond[1][15]", "f_bond[2][15]"]) + "run 5\n"
    table = run(scene, tmp_path).table()
    rows = [line.split() for line in (tmp_path / "rows.txt").read_text().splitlines()[-3:]]
    assert rows[0] == ["5", "2"] and [row[0] for row in rows[1:]] == ["1", "2"]
    assert table["f_bond[2][15]"][-1] == pytest.approx(float(rows[2][1]), rel=1e-4)


@pytest.mark.parametrize("ranks, processors", [(1, "* * *"), (2, "1 1 2"), (2, "1 2 1")])
def test_beside_bonds_that_break(tmp_path, ranks, processors):
    """Each bond that separates causes a new layout of all; one that does not is bitwise identical to that without them."""
    centres = [(x, 0, z) for x in (0, 0.02, 0.04) for z in (-0.005, 0.005)]
    scene = grains(centres, "-0.006 0.046 -0.0061 0.006 -0.0125 0.0125", processors=processors)
    physics = cement(CELL, 1e-8, axis="radial", damage="damage tensor B0 9.6e3")
    # the bonds of 3, 4 and 5, 6 break one after the other, that of 1, 2 stays far below its strength
    move = pull(0.005, 4e-6).replace("second", "lifted")
    for name, grain, speed in (("one", 4, 2.0), ("two", 6, 1.0)):
        move += f"group {name} id {grain}\nvariable s{name} equal {speed}/0.005*v_along\nvariable w{name} equal {speed}/0.005*v_speed\n"
        move += f"fix {name} {name} move variable NULL NULL v_s{name} NULL NULL v_w{name}\n"
    move = "group lifted id 2\n" + move + "group still id 3 5\nfix still still move linear 0 0 0\n"
    every = 4
    end = thermo(every, ["f_bond[1][14]", "f_bond[1][1]", "f_bond[1][11]", "f_bond[1][18]"]) + "run 900\n"
    alone = run(scene + CREATE % (1, 2) + physics + move + end, tmp_path / "alone", ranks).table()
    both = end.replace("f_bond[1][18]", "f_bond[1][18] f_bond[2][22] f_bond[3][22]")
    beside = run(scene + CREATE % (1, 2) + CREATE % (3, 4) + CREATE % (5, 6) + physics + move + both, tmp_path / "beside", ranks).table()
    first, second = (np.argmax(beside[f"f_bond[{n}][22]"] > 0) for n in (2, 3))
    assert 0 < first < second < 800 / every
    assert beside["f_bond[1][14]"][-1] > 0.1 and beside["f_bond[1][18]"].max() == 0
    for column in ("f_bond[1][14]", "f_bond[1][1]", "f_bond[1][11]"):
        assert (beside[column] == alone[column]).all(), column


@pytest.mark.parametrize("boundary, ranks, processors", [("f f f", 2, "1 1 2"), ("f f p", 1, "* * *")])
def test_contacts_keep_their_history(tmp_path, figures, boundary, ranks, processors):
    """Cement made between runs: grains that touch and have slid, across ranks or a periodic boundary, go on as they did."""

    def force(directory, boundary, ranks, processors, middle):
        # 1 and 2 touch, at z = 0 or through the boundary, 3 and 4 get the cement
        z = (-0.00499, 0.00499) if middle else (0.00501, -0.00501)
        scene = grains(
            [(0, 0, z[0]), (0, 0, z[1]), (0.015, 0, -0.005), (0.015, 0, 0.005)],
            "-0.006 0.021 -0.006 0.006 -0.01 0.01",
            boundary=boundary,
            processors=processors,
        )
        scene += CONTACT + "timestep 1e-8\ngroup first id 1\ngroup others id 2 3 4\n"
        scene += "fix slide first move linear 0.01 0 0\nfix rest others move linear 0 0 0\n"
        scene += "compute push first reduce sum fx\n" + thermo(1, ["c_push"]) + "run 100\n" + CREATE % (3, 4)
        scene += cement(CELL, 1e-8).replace("group        first id 1\ngroup        second id 2\n", "") + "run 100\n"
        return run(scene, directory, ranks).table()["c_push"]

    one = force(tmp_path / "one", "f f f", 1, "* * *", True)
    other = force(tmp_path / "other", boundary, ranks, processors, boundary == "f f f")
    assert abs(one[-1]) > 1.9 * abs(one[100]) > 0
    figures.below(f"contact of {ranks} ranks, {boundary}: sliding force against one rank, over the largest", abs(other - one).max() / abs(one).max(), 1e-9)


@pytest.mark.parametrize("ranks", [1, 3])
def test_all_contacts(tmp_path, ranks):
    """A packing of grains of three sizes in a periodic box, and a pair at a time: the points are bitwise identical."""
    size = 4 * 2 * RADIUS
    centres = [(2 * RADIUS * i, 2 * RADIUS * j, 2.0001 * RADIUS * k) for i in range(4) for j in range(4) for k in range(2)]
    scene = grains(centres, f"0 {size:.15g} 0 {size:.15g} -0.0061 0.0162", boundary="p p f")
    scene += "".join(f"group small{i} id {i}\nset group small{i} diameter {1.5 * RADIUS} density 2500\n" for i in (3, 12, 26))
    words = "shape flat inner 1.4e-3 outer 2.3e-3 film grid spacing 2.5e-4"
    far = 2.5e-4 * (1 - 1e-9)  # between rows, not to the smaller grains

    def apart(a, b):
        d = np.array(centres[a]) - centres[b]
        d[:2] -= size * np.round(d[:2] / size)
        small = sum(n + 1 in (3, 12, 26) for n in (a, b))
        return np.linalg.norm(d) - (2 - 0.25 * small) * RADIUS

    pairs = [(a + 1, b + 1) for a in range(32) for b in range(a + 1, 32) if apart(a, b) <= far]
    assert len(pairs) == 4 * 4 * 2 * 2 + 16 - 3 * 5
    end = "write_cement cement.txt\n"
    one = run(scene + "".join(f"create_cement calcite pair {a} {b} {words}\n" for a, b in pairs) + end, tmp_path / "pairs", ranks)
    command = f"create_cement calcite contacts grains gap {far:.15g} {words}\n"
    # some before, and nothing is left for a second time; points of the first bond come first in both
    a, b = pairs[0]
    all_ = run(scene + f"create_cement calcite pair {a} {b} {words}\n" + command + command + end, tmp_path / "contacts", ranks)
    assert f"Cement at {len(pairs) - 1} contacts of group 'grains'" in all_.output and "; 1 had cement before" in all_.output
    assert "Cement at 0 contacts of group 'grains'" in all_.output
    assert (one.directory / "cement.txt").read_text() == (all_.directory / "cement.txt").read_text()


@pytest.mark.parametrize("high, pairs", [(4 * RADIUS, 1), (5 * RADIUS, 0)])
def test_contacts_at_two_places(tmp_path, high, pairs):
    """Two grains that touch directly and through the boundary get cement at one place; the command tells."""
    text = grains([(0, 0, RADIUS), (0, 0, 3 * RADIUS)], f"-0.006 0.006 -0.006 0.006 0 {high:.15g}", boundary="f f p")
    text += "create_cement calcite contacts grains gap 1e-6 shape flat inner 1.4e-3 outer 2.3e-3 film grid spacing 2.5e-4\n"
    output = run(text, tmp_path).output
    assert "Cement at 1 contacts" in output
    assert (f"{pairs} pairs of grains are in contact at more than one place" in output) == (pairs > 0)


@pytest.mark.parametrize("ranks", [1, 2])
def test_many_bonds_that_break(tmp_path, ranks):
    """Twenty-five columns of two beads are pulled apart: the first twenty have a line at the end, all are counted."""
    scene = pair(4e-4, half_box=(28e-3, 28e-3, 12.5e-3))
    places = [(x, y, z) for x in range(-2, 3) for y in range(-2, 3) for z in (-1, 1)]
    beads = "".join(f"create_atoms 1 single {2.05 * RADIUS * x} {2.05 * RADIUS * y} {RADIUS * z} units box\n" for x, y, z in places)
    scene = (
        scene[: scene.index("create_atoms")]
        + beads
        + scene[scene.index("set          type") : scene.index("create_cement")]
        + f"create_cement calcite contacts grains gap 1e-4 shape flat {in_cells(RING)} spacing 4e-4\n"
    )
    script = (
        scene
        + cement(8e-4, 4e-8, axis="radial", damage="damage tensor B0 9.6e3")
        + "region low block INF INF INF INF INF 0 units box\nregion high block INF INF INF INF 0 INF units box\n"
        "group low region low\ngroup low subtract low calcite\ngroup high region high\ngroup high subtract high calcite\n"
        "fix hold low move linear 0 0 0\nfix pull high move linear 0 0 3\n" + thermo(100, ["f_cem[2]"]) + "run 400\n"
    )
    out = run(script, tmp_path, ranks).output
    assert out.count(": bond ") == 20
    found = re.findall(r"25 of 25 bonds have points that failed, 20 are listed; failure modes of all 25:(.*)", out)
    assert len(found) == 1 and sum(int(n) for n in re.findall(r"(\d+) (?:debonding|internal|mixed|intact)", found[0])) == 25


def test_packing(tmp_path, figures):
    """examples/packing, of 27 beads: each of the nine columns breaks; on one rank and on two."""
    example = (Path(__file__).parents[2] / "examples" / "packing" / "in.packing").read_text()
    found = {}
    for ranks in (1, 2):
        script = edit(example, "index 4  ", "index 3  ")
        style = re.search(r"^thermo_style .*\nthermo .*\n", script, re.M)[0]
        done = run(script.replace(style, thermo(50, ["c_force", "f_cem[2]", "f_cem[12]"])), tmp_path / str(ranks), ranks)
        found[ranks] = done.table()
        modes = re.findall(r"bond \d+ of grains (\d+) and (\d+): (\w+)", done.output)
        apart = [(int(a) - 1, int(b) - 1) for a, b, mode in modes if mode != "intact"]
        assert {a % 9 for a, b in apart if b - a == 9} == set(range(9)), modes
        figures.below(f"packing, {ranks} rank(s): energy imbalance", abs(found[ranks]["f_cem[12]"]).max(), 0.01)
    one, two = found[1], found[2]
    intact = one["f_cem[2]"] == 0
    peak = abs(one["c_force"]).max()
    assert intact.sum() > 4 and abs(one["c_force"][-3:]).max() < 0.05 * peak
    figures.below("packing, two ranks against one: force while intact, over the peak", abs(one["c_force"] - two["c_force"])[intact].max() / peak, 1e-10)
    figures.below("packing, two ranks against one: force, over the peak", abs(one["c_force"] - two["c_force"]).max() / peak, 1e-3)


def test_equal_bonds(tmp_path):
    """54 contacts of a cubic packing, points of equal ones made once: the same on any number of ranks as pair by pair; 20 are listed."""
    centres = [(2 * RADIUS * i, 2 * RADIUS * j, 2 * RADIUS * k) for k in range(3) for j in range(3) for i in range(3)]
    scene = grains(centres, "-0.0051 0.0251 " * 3)
    words, end = "shape flat outer 2.5e-3 inner auto spacing 4e-4 grid 1e-4 0 0", "write_cement cement.txt\n"
    pairs = sorted((a + 1, b + 1) for a in range(27) for b in range(a + 1, 27) if np.linalg.norm(np.subtract(centres[a], centres[b])) < 2.01 * RADIUS)
    one = run(scene + "".join(f"create_cement calcite pair {a} {b} {words}\n" for a, b in pairs) + end, tmp_path / "pairs")
    assert len(pairs) == 54 and one.output.count("Cement between grains") == 54
    for ranks in (1, 2, 3):
        all_ = run(scene + f"create_cement calcite contacts grains gap 1e-6 {words}\n" + end, tmp_path / str(ranks), ranks)
        assert all_.output.count("Cement between grains") == 20 and "  ... and 34 more bonds\n" in all_.output
        assert (one.directory / "cement.txt").read_text() == (all_.directory / "cement.txt").read_text()


def test_fix_before_its_cement(tmp_path):
    script = pair(CELL / 2) + cement(CELL, 1e-8)
    line = CREATE % (1, 2)
    script = edit(script, line, "group calcite subtract all all\n") + line + pull(1.0, 1e-6) + thermo(10, ["f_bond"]) + "run 100\n"
    early = run(script, tmp_path / "early").table()
    usual = run(pair(CELL / 2) + cement(CELL, 1e-8) + pull(1.0, 1e-6) + thermo(10, ["f_bond"]) + "run 100\n", tmp_path / "usual").table()
    assert (early["f_bond"] == usual["f_bond"]).all() and usual["f_bond"][-1] > 0
