# SPDX-License-Identifier: GPL-2.0-or-later
"""Kinetic share of the energy and unbalanced force, against dumps of LIGGGHTS and the table of the bonds; the warning of loads that are not quasi-static."""
import csv
import re

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, NEIGHBOURS, cement, edit, host, pair, pull, restarted, run, thermo

G = 9.81
HEIGHT, MOVED, LOOSE = 3, (9, 10, 11, 12), (13, 14, 15)
DASHPOTS = edit(
    edit(CONTACT, "gamman peratomtypepair 2 0 0 0 0", "gamman peratomtypepair 2 5e6 5e6 5e6 5e6"),
    "gammat peratomtypepair 2 0 0 0 0",
    "gammat peratomtypepair 2 1e6 1e6 1e6 1e6",
)
TOLD = """\
compute      pairs grains pair/gran/local id force
compute      walls grains wall/gran/local id force
dump         pairs grains local 20 pairs.*.txt c_pairs[1] c_pairs[2] c_pairs[4] c_pairs[5] c_pairs[6]
dump         walls grains local 20 walls.*.txt c_walls[3] c_walls[4] c_walls[5] c_walls[6]
dump         beads grains custom 20 beads.*.txt id mass radius vx vy vz omegax omegay omegaz
dump_modify  pairs format "%.17g %.17g %.17g %.17g %.17g"
dump_modify  walls format "%.17g %.17g %.17g %.17g"
dump_modify  beads format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
"""


def scene(words="", contact=CONTACT, told=TOLD, directory=None, damage=""):
    """Twelve cemented beads in three layers: the lowest is held, the highest moves, and those between are free. A wall presses two of these. One loose bead presses
    another, and two loose beads press each other."""
    text = host(processors="1 1 *") + "region box block -0.012 0.03 -0.012 0.012 -0.006 0.03 units box\ncreate_box 2 box\n"
    centres = [(x, y, z) for z in range(HEIGHT) for y in (0, 1) for x in (0, 1)]
    for x, y, z in centres:
        text += f"create_atoms 1 single {-0.005 + 0.009999 * x:.17g} {-0.005 + 0.009999 * y:.17g} {0.009999 * z:.17g} units box\n"
    for x, y, z in ((0.0149975, -0.005, 0.009999), (0.0249, 0.0, 0.001), (0.0249, 0.0, 0.0109985)):
        text += f"create_atoms 1 single {x:.17g} {y:.17g} {z:.17g} units box\n"
    text += "set type 1 diameter 0.01 density 2500\ngroup grains type 1\ngroup bonded id 1:12\n" + NEIGHBOURS
    text += "create_cement calcite contacts bonded gap 1e-6 shape flat inner 1.4e-3 outer 2e-3 spacing 2.5e-4\n" + contact
    (directory / "wall.stl").write_text(
        "solid wall\nfacet normal 1 0 0\nouter loop\nvertex 0 -0.0115 -0.005\nvertex 0 0.0115 -0.005\nvertex 0 0 0.028\nendloop\nendfacet\nendsolid wall\n"
    )
    text += "fix wall all mesh/surface file wall.stl type 1 move -0.009999 0 0\nfix touch grains wall/gran model hertz/stiffness tangential history mesh n_meshes 1 meshes wall\n"
    text += f"fix weight all gravity {G} vector 0.6 0 -0.8\n"
    text += edit(cement(5e-4, 2e-8, CALCITE, "radial", damage, "csv 20 bond.csv"), "mpm cell", f"mpm {words} cell")
    text = text.replace("group        first id 1\ngroup        second id 2\n", "group low id 1:4\ngroup high id 9:12\ngroup free subtract grains low high\n")
    text += (
        "variable t equal step*dt\nvariable d equal 1e-4*v_t*v_t/4e-5\nvariable v equal 2e-4*v_t/4e-5\nfix hold low move linear 0 0 0\n"
        "fix go high move variable v_d NULL v_d v_v NULL v_v\nfix motion free nve/sphere\n"
    )
    return text + told + thermo(20, ["f_cem[5]", "f_cem[11]", "f_cem[33]", "f_cem[34]", "f_bond[39]", "f_bond[40]"])


def dumped(directory, name, step):
    with open(directory / f"{name}.{step}.txt") as f:
        lines = f.read().splitlines()[9:]
    return np.array([[float(w) for w in line.split()] for line in lines]) if lines else np.zeros((0, 9))


FREE = {**{i: np.array([1, 1, 1]) for i in range(5, 9)}, **{i: np.array([0, 1, 0]) for i in range(9, 13)}}  # components, by ID; the latter do not rotate


def expected(directory, step, of_cement, put_in, scale, mass):
    """Kinetic share and unbalanced force by their definitions, from sums over dumps. mass: of the cement of a bond."""
    beads = {int(r[0]): r[1:] for r in dumped(directory, "beads", step)}
    kinetic = 0.0
    for i, free in FREE.items():
        m, radius, v, omega = beads[i][0], beads[i][1], beads[i][2:5] * free, beads[i][5:8] * free.all()
        kinetic += 0.5 * m * (v @ v + 0.4 * radius**2 * omega @ omega)
    share = (of_cement + scale * kinetic) / (scale * kinetic + max(put_in, of_cement))
    weight = G * np.array([0.6, 0, -0.8])
    resultant = {i: beads[i][0] * weight for i in FREE}
    magnitudes = []

    def push(grain, force):
        if grain in FREE:
            resultant[grain] = resultant[grain] + force

    for i, j, *force in dumped(directory, "pairs", step):
        push(i, np.array(force))
        push(j, -np.array(force))
        if not (i in LOOSE and j in LOOSE):
            magnitudes.append(np.linalg.norm(force))
    walls = dumped(directory, "walls", step)
    for i, *force in walls:
        push(i, np.array(force))
    contacts = len(magnitudes)
    with open(directory / "bond.csv", newline="") as f:
        bonds = [r for r in csv.DictReader(f) if int(r["step"]) == step]
    for r in bonds:
        on = [np.array([float(r[f"f{c}{s}"]) for c in "xyz"]) for s in (1, 2)]
        magnitudes.append(0.5 * np.linalg.norm(on[0] - on[1]))
        for s in (0, 1):
            push(int(r[f"grain{s + 1}"]), on[s] + 0.5 * (mass * weight - on[0] - on[1]))
    squares = [(resultant[i] * free) @ (resultant[i] * free) for i, free in FREE.items()]
    return share, np.sqrt(np.mean(squares)) / np.mean(magnitudes), contacts, len(walls), len(bonds)


def mass_of_a_bond(output):
    bonds = re.search(r"^Cement at (\d+) contacts", output, re.M)
    return float(re.search(r"in all \d+ points, volume \S+, mass (\S+),", output)[1]) / int(bonds[1])


@pytest.mark.parametrize("words, scale", [("", 1), ("condense yes", 1), ("quasistatic 50 0.1", 50), ("subcycle 4", 1)])
def test_values(words, scale, tmp_path, figures):
    """Both against sums over dumps of beads and contacts and the table of the bonds; on one rank and two."""
    tables = {}
    for ranks in (1, 2):
        directory = tmp_path / str(ranks)
        directory.mkdir()
        done = run(scene(words, directory=directory) + "run 200\n", directory, ranks)
        t = tables[ranks] = done.table()
        mass = mass_of_a_bond(done.output)
        off = {"f_cem[33]": [], "f_cem[34]": []}
        for row in range(1, len(t["step"])):
            share, force, *numbers = expected(directory, int(t["step"][row]), t["f_cem[5]"][row], t["f_cem[11]"][row], scale, mass)
            assert numbers == [21, 4, 20] and 0.05 < share < 1 and 0.05 < force < 2
            off["f_cem[33]"].append(abs(t["f_cem[33]"][row] / share - 1))
            off["f_cem[34]"].append(abs(t["f_cem[34]"][row] / force - 1))
        figures.below(f"{words or 'plain'}: kinetic share against sums over dumps, which lack the energy at the start, over it", max(off["f_cem[33]"]), 1e-4)
        figures.below(f"{words or 'plain'}: unbalanced force against sums over tables of ten digits, over it", max(off["f_cem[34]"]), 1e-8)
        assert (t["f_cem[33]"] == t["f_bond[39]"]).all() and (t["f_cem[34]"] == t["f_bond[40]"]).all()
        with open(directory / "bond.csv", newline="") as f:
            rows = [r for r in csv.DictReader(f) if r["bond"] == "1"]
        assert max(abs(float(r["unbalanced_force"]) / u - 1) for r, u in zip(rows, t["f_cem[34]"])) < 1e-9
    for name in ("f_cem[33]", "f_cem[34]"):
        figures.below(
            f"{words or 'plain'}: {name} on two ranks against one, over the largest",
            abs(tables[2][name] - tables[1][name]).max() / tables[1][name].max(),
            1e-13,
        )


def test_ranks_with_dashpots(tmp_path, figures):
    """Dashpots take the velocities of both beads of a contact at one time, whichever rank has them."""
    tables = []
    for ranks in (1, 2):
        (tmp_path / str(ranks)).mkdir()
        tables.append(run(scene(contact=DASHPOTS, told="", directory=tmp_path / str(ranks)) + "run 200\n", tmp_path / str(ranks), ranks).table()["f_cem[34]"])
    figures.below("unbalanced force with dashpots on two ranks against one, over the largest", abs(tables[1] - tables[0]).max() / tables[0].max(), 1e-13)


def test_asking_changes_nothing(tmp_path):
    """Other rows, or none at all, leave the run bitwise as it is, and a compute of the script has its contacts."""
    ends = []
    for number, (told, every) in enumerate(((TOLD, 20), (TOLD.replace(" 20 ", " 200 "), 200), ("", 200))):
        folder = tmp_path / str(number)
        folder.mkdir()
        script = (
            scene(contact=DASHPOTS, told=told, directory=folder)
            .replace("csv 20 bond.csv", f"csv {every} bond.csv")
            .replace("\nthermo 20\n", f"\nthermo {every}\n")
        )
        end = 'dump end grains custom 200 end.*.txt id x y z vx vy vz fx fy fz\ndump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"\n'
        run(script + end + "run 200\n", folder)
        ends.append((folder / "end.200.txt").read_text())
        if told:
            assert len(dumped(folder, "pairs", 200)) == 22
    assert ends[0] == ends[1] == ends[2]


def test_between_runs_and_after_a_restart(tmp_path, figures):
    """Between runs the values are those of the end of the last one, in parts with `pre no`, too. A run from a restart file goes on with them."""
    told = 'print "BETWEEN $(f_cem[33]) $(f_cem[34])"\n'
    directory = tmp_path / "whole"
    directory.mkdir()
    whole = run(scene(told="", directory=directory) + "run 100\n" + told + "run 100 pre no\n" + told + "write_restart half\nrun 100\n" + told, directory)
    t, at = whole.table(), [[float(w) for w in line.split()[1:]] for line in whole.output.splitlines() if line.startswith("BETWEEN ")]
    for step, values in zip((100, 200, 300), at):
        row = int(np.flatnonzero(t["step"] == step)[0])  # the last row of a run
        for name, value in zip(("f_cem[33]", "f_cem[34]"), values):
            figures.below(f"{name} between runs against that of the last row, over it", abs(value / t[name][row] - 1), 1e-6)
    script = scene(told="", directory=directory)
    script = restarted("half") + script[script.index("fix          c1") :]
    for line in script.splitlines(True):
        if line.startswith("group"):
            script = script.replace(line, "")
    again = run(script + "run 100\n", directory, name="in.again").table()
    for name in ("f_cem[33]", "f_cem[34]"):
        figures.below(
            f"{name} of a run from a restart file against that of the run as a whole, over it",
            abs(again[name][1:] / t[name][-len(again[name]) + 1 :] - 1).max(),
            1e-12,
        )


CELL = 4e-4
FAST, SLOW = pull(0.5, 4e-6), pull(0.01, 2e-5)
TENTH = 0.1  # share of the energy that damage has dissipated when a pair counts as breaking


def pulled(words, motion, steps, couple="kn auto kt auto"):
    """A pair that is pulled; its peak load is at some 3e-7 m."""
    return (
        pair(CELL / 2)
        + edit(cement(CELL, 1e-8, CALCITE, "radial", "damage tensor B0 9.6e3 cutoff 0.9", couple), "mpm cell", f"mpm {words} cell")
        + motion
        + thermo(100, ["f_cem[2]", "f_cem[8]", "f_cem[11]", "f_cem[33]", "f_bond[17]"])
        + f"run {steps}\n"
    )


def told(result):
    return [line for line in result.output.splitlines() if "WARNING" in line and "kinetic share" in line]


def share_before_it_broke(result):
    """By the rows, of which each is a check; and the step of it."""
    t = result.table()
    rows = np.flatnonzero(t["step"] % 100 == 0)
    broke = (t["f_cem[2]"] > 0) | (t["f_cem[8]"] > TENTH * t["f_cem[11]"])
    before = rows[np.flatnonzero(broke[rows])[0] - 1]
    return t["f_cem[33]"][before], t["step"][before]


def test_fast_load_warns_once(tmp_path, figures):
    """The warning has the share at the last check before the cement began to break, the limit and the cure, and comes once in three runs, on any number of ranks."""
    for ranks in (1, 2):
        result = run(pulled("", FAST, 200) + 2 * "run 100\n", tmp_path / str(ranks), ranks)
        (line,) = told(result)
        for words in ("fix mpm (id cem)", "more than 0.003 ('kinetic_share')", "not quasi-static", "times as slowly", "'kinetic_share no'"):
            assert words in line
        assert "'quasistatic" not in line
        step, share, factor = (
            float(re.search(pattern, line)[1]) for pattern in (r"after step (\d+) ", r"energy of ([-+.\de]+),", r"grains ([-+.\de]+) times as slowly")
        )
        wanted, at = share_before_it_broke(result)
        assert step == at
        figures.below(f"{ranks} ranks: share of the warning against that of the row, over it", abs(share / wanted - 1), 1e-5)
        figures.below(f"{ranks} ranks: square of how much slower, times the limit, against the share", abs(3e-3 * factor**2 / share - 1), 1e-4)


@pytest.mark.parametrize(
    "words, motion, steps, number",
    [("", SLOW, 4500, 0), ("kinetic_share 1e-5", SLOW, 4500, 1), ("kinetic_share no", FAST, 300, 0), ("kinetic_share 1", FAST, 300, 0)],
    ids=["slow", "slow, lower limit", "fast, none", "fast, highest limit"],
)
def test_limit(words, motion, steps, number, tmp_path):
    """A slow load has no warning but with a lower limit, though the share is larger once points fail. A fast one has none where the script says so."""
    result = run(pulled(words, motion, steps), tmp_path)
    t = result.table()
    assert t["f_cem[2]"][-1] > 50 and len(told(result)) == number
    if motion is SLOW:
        assert t["f_cem[33]"][t["f_cem[8]"] > TENTH * t["f_cem[11]"]].max() > 30 * share_before_it_broke(result)[0]


def test_scaled_inertia_counts(tmp_path):
    """Inertia that is scaled makes a slow load as fast as one of so much more speed. The warning names a scale that would do, and it does."""
    (line,) = told(run(pulled("quasistatic 2500 0", SLOW, 4500), tmp_path))
    scale = float(re.search(r"or 'quasistatic ([-+.\de]+)' or less in the place of 2500", line)[1])
    assert 1 < scale < 2500
    assert not told(run(pulled(f"quasistatic {0.8 * scale:.6g} 0", SLOW, 4500), tmp_path))


def test_first_steps(tmp_path):
    """Cement that breaks before the first check is judged all the same."""
    result = run(pulled("check 1000", pull(3.0, 1e-6), 90), tmp_path)
    assert result.table()["f_cem[2]"][-1] > 10 and len(told(result)) == 1


@pytest.mark.parametrize("rest, steps", [("run 0\nrun 0\n", 0), ("run 400\n", 400), ("run 400\nrun 0\n", 400)])
def test_rest_before_a_fast_load(rest, steps, tmp_path):
    """Checks at rest, before the load began, do not make a load that breaks cement before the next check a slow one."""
    script = edit(pulled("", pull(3.0, 1e-6), 90), "variable t equal step*dt", f'variable t equal "(step-{steps})*dt*(step>{steps})"')
    result = run(edit(script, "run 90\n", rest + "run 90\n"), tmp_path)
    assert result.table()["f_cem[2]"][-1] > 10 and len(told(result)) == 1


def test_links_that_debond(tmp_path):
    """Debonded links count alone, where neither points fail nor much was dissipated."""
    result = run(pulled("", FAST, 300, "interface cohesive tn 1e6 tt 1e6 Gn 1e-4 Gt 1e-4"), tmp_path)
    t = result.table()
    assert t["f_bond[17]"].max() > 10 and t["f_cem[2]"].max() == 0 and (t["f_cem[8]"][1:] < TENTH * t["f_cem[11]"][1:]).all()
    assert len(told(result)) == 1


@pytest.mark.parametrize("words", ["", "quasistatic 50 0.1"])
def test_warning_of_free_grains_on_ranks(words, tmp_path, figures):
    """The share of the warning is the median of those of the last three checks, with the free grains, in the inertia that the run gives them. Ranks
    change nothing."""
    lines = []
    for ranks in (1, 2):
        directory = tmp_path / str(ranks)
        directory.mkdir()
        result = run(scene(f"check 20 {words}", told="", directory=directory, damage="damage tensor B0 0.5 cutoff 0.9") + "run 600\n", directory, ranks)
        (line,) = told(result)
        lines.append(line)
        t = result.table()
        step, share = (float(re.search(pattern, line)[1]) for pattern in (r"after step (\d+) ", r"energy of ([-+.\de]+),"))
        shares = t["f_cem[33]"][t["step"] <= step]
        assert len(shares) > 5 and len(set(shares[-3:])) == 3
        figures.below(
            f"{words or 'plain'}, {ranks} ranks: share of the warning against the median of three rows", abs(share / np.median(shares[-3:]) - 1), 1e-4
        )
    assert [re.search(r"after step (\d+) ", line)[1] for line in lines] == [re.search(r"after step (\d+) ", lines[0])[1]] * 2


SLOW_THEN_FAST = """\
variable     u equal (step-{start})*dt
unfix        pull
variable     along2 equal "0.5*0.5*(v_u-4e-6/PI*sin(PI*v_u/4e-6))"
variable     speed2 equal "0.5*0.5*(1-cos(PI*v_u/4e-6))"
group        third id 3
group        fourth id 4
fix          hold2 third move linear 0 0 0
fix          pull2 fourth move variable NULL NULL v_along2 NULL NULL v_speed2
"""


def test_what_breaks_after_a_rest(tmp_path):
    """After a bond broke slowly, what breaks next is judged once all was at rest between, and not before."""
    text = pulled("quasistatic 1 0.5 check 10", SLOW, 4500)
    second = text.replace(
        "create_atoms 1 single 0 0 0.005 units box\n",
        "create_atoms 1 single 0 0 0.005 units box\ncreate_atoms 1 single 0.02 0 -0.005 units box\ncreate_atoms 1 single 0.02 0 0.005 units box\n",
    )
    create = re.search(r"create_cement .*\n", second)[0]
    second = edit(edit(second, create, create + create.replace("pair 1 2", "pair 3 4")), "block -0.006 0.006", "block -0.006 0.026")
    group = "group        third id 3\ngroup        fourth id 4\nfix          hold2 third move linear 0 0 0\nfix          rest2 fourth move linear 0 0 0\n"
    second = edit(second, "variable t equal", group + "variable t equal")
    fast = SLOW_THEN_FAST.replace("group        third id 3\ngroup        fourth id 4\nfix          hold2 third move linear 0 0 0\n", "unfix        rest2\n")
    calm = "unfix pull\nfix rest second move linear 0 0 0\nrun 1500\n"
    result = run(second + calm + fast.replace("unfix        pull\n", "").format(start=6000) + "run 300\n", tmp_path)
    t = result.table()
    before = t["f_cem[33]"][t["step"] <= 4500]
    assert before[1:].max() > 30 * share_before_it_broke(result)[0] and t["f_cem[33]"][t["step"] == 6000][0] < 3e-4
    (line,) = told(result)
    assert float(re.search(r"after step (\d+) ", line)[1]) > 6000
