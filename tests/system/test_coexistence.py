# SPDX-License-Identifier: GPL-2.0-or-later
"""Cement in one scene with mesh walls, insertion during the run, gravity, grains of two types and contacts with
history and rolling friction: examples/rain, and variations of it."""
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from scenes import MOMENTA, RADIUS, edit, hosted, launch, run

FOLDER = Path(__file__).parents[2] / "examples" / "rain"
SCRIPT = (FOLDER / "in.rain").read_text()
TENSION, DEBONDED, SEPARATED = ("f_bond[{bond}][" + str(n) + "]" for n in (14, 17, 22))

# Without the pair that the rain hits; nothing comes near the other.
FREE_PAIR = """\
create_atoms 1 single  0.006 0 0.002 units box
create_atoms 2 single  0.010 0 0.002 units box
"""
SECOND_BOND = "create_cement calcite pair 3 4 shape flat outer 1.3e-3 spacing 1e-4\n"
OF_SECOND = " v_tension2 v_debond2 v_apart2"
THERMO = re.search(r"^thermo_style .*\n", SCRIPT, re.M)[0]
RUN = "run          ${steps} upto\n"


def section(title):
    """From one line of dashes with a title to the next."""
    return re.search(rf"^# -+ {title}\n(.*?)(?=^# ---)", SCRIPT, re.M | re.S)[1]


def with_columns(script, columns, every):
    """Names of the table are those of the columns as written here."""
    style = re.search(r"^thermo_style .*\nthermo .*\n", script, re.M)[0]
    return script.replace(
        style,
        f"thermo_style custom step {' '.join(columns)}\nthermo_modify format float %.17g\n" f"thermo {every}\nprint \"COLUMNS step {' '.join(columns)}\"\n",
    )


def start_in(directory):
    directory.mkdir(exist_ok=True)
    shutil.copy(FOLDER / "tray.stl", directory)
    return directory


def alone(script):
    """The scene with the pulled pair as its only cement."""
    return edit(edit(edit(script, FREE_PAIR, ""), SECOND_BOND, ""), OF_SECOND, "")


def faster(script):
    """At half of the stable step instead of a quarter."""
    return edit(script, "dt     index 1e-7", "dt     index 2e-7")


def shorter(script, steps):
    return edit(script, "steps  index 30000", f"steps  index {steps}")


def column(name, bond=1):
    return name.format(bond=bond)


COLUMNS = ["time", "atoms", "ke", "f_cem[12]", "f_cem[11]", "f_cem[8]", "f_cem[7]", "f_tray[3]"] + [
    column(n, b) for b in (1, 2) for n in (TENSION, DEBONDED, SEPARATED)
]
# How many inserted beads touch another bead, and how low the lowest is.
CONTACTS = """\
compute      touching free contact/atom
variable     inserted atom "(id > 4) * (c_touching > 0)"
compute      touched free reduce sum v_inserted
compute      lowest free reduce min z
variable     touched equal c_touched
variable     lowest equal c_lowest
"""


# Of beads and cement: motion, height, what the cement stores and what it has dissipated.
ENERGY = """\
variable     height atom "9.81*mass*z"
variable     motion atom "0.5*mass*(vx*vx+vy*vy+vz*vz)+0.2*mass*c_radius^2*(omegax*omegax+omegay*omegay+omegaz*omegaz)"
compute      height all reduce sum v_height
compute      motion grains reduce sum v_motion
variable     energy equal c_height+c_motion+f_cem[5]+f_cem[6]+f_cem[7]+f_cem[8]+f_cem[9]+f_cem[10]
"""


@pytest.mark.parametrize("ranks", [1, 2])
def test_through_failure(ranks, tmp_path, figures):
    """The example to its end: both bonds separate, nothing is lost, what rains in collides."""
    script = edit(SCRIPT, THERMO, CONTACTS + THERMO)
    table = run(with_columns(script, COLUMNS + ["v_touched", "v_lowest"], 40), start_in(tmp_path), ranks)
    output, table = table.output, table.table()
    inserted = int(re.findall(r"a total of (\d+) particle templates", output)[-1])
    points = sum(int(n) for n in re.findall(r"(\d+) points", output.split("Setting up run")[0])[:2])
    assert inserted >= 25 and points > 2000
    assert table["atoms"][-1] == 4 + inserted + points
    for bond in (1, 2):
        assert table[column(SEPARATED, bond)][-1] == 1, f"bond {bond} holds"
    assert table["v_touched"].max() >= 2, "inserted beads touch nothing"
    peak = table[column(TENSION)].max()
    figures.note(f"rain, {ranks} rank(s): peak force of the pulled pair", f"{peak:.4g} N")
    figures.below(f"rain, {ranks} rank(s): pulled pair at the end, over the peak", abs(table[column(TENSION)][-20:].mean()) / peak, 0.02)
    working = table["f_cem[11]"] > 0.01 * table["f_cem[11]"].max()  # before, it is relative to almost nothing
    figures.below(f"rain, {ranks} rank(s): energy imbalance of the cement", abs(table["f_cem[12]"][working]).max(), 5e-4)
    # The smaller beads have a radius of 1 mm; walls as soft as these yield a little.
    figures.below(f"rain, {ranks} rank(s): how deep a bead sinks into the floor, over its radius", (1e-3 - table["v_lowest"].min()) / 1e-3, 0.15)


def test_what_is_far_changes_nothing(tmp_path, figures):
    """The bond is the same with and without tray and rain; the rain is that of `liggghts` without cement."""
    ranks = 2
    script = faster(shorter(alone(SCRIPT), 8000))
    columns = [column(n) for n in (TENSION, DEBONDED)] + ["f_bond[13]", "f_cem[8]"]
    last = (
        "compute radius free property/atom radius\n"
        "dump beads free custom 8000 beads.*.txt id x y z vx vy vz omegax omegay omegaz fx fy fz\n"
        'dump_modify beads sort id format "%d' + 12 * " %.17g" + '"\n'
    )
    busy = run(with_columns(edit(script, RUN, last + RUN), columns, 40), start_in(tmp_path / "busy"), ranks)
    quiet = script.replace(section("insertion"), "")
    for line in re.findall(r"^fix +(?:tray|wall) .*\n", quiet, re.M):
        quiet = edit(quiet, line, "")
    quiet = run(with_columns(quiet, columns, 40), start_in(tmp_path / "quiet"), ranks)
    p, q = busy.table(), quiet.table()
    assert p[column(DEBONDED)][-1] > 200
    force, intact = q[column(TENSION)], q[column(DEBONDED)] == 0
    difference = abs(p[column(TENSION)] - force) / force.max()
    figures.below(f"bond with rain and tray against without, {ranks} rank(s), while intact: force over the peak", difference[intact].max(), 1e-10)
    figures.below(f"bond with rain and tray against without, {ranks} rank(s), to the end: force over the peak", difference.max(), 1e-10)
    assert (p[column(DEBONDED)] == q[column(DEBONDED)]).all()

    stock = shutil.which("liggghts", path="/usr/bin:/usr/local/bin")
    if not stock:
        pytest.skip("the stock program liggghts is not installed")
    plain = edit(alone(SCRIPT), "atom_style   mpdem", "atom_style   granular").replace(section("cement"), "")
    plain = edit(plain, "create_cement calcite pair 1 2 shape flat outer 1.3e-3 spacing 1e-4\n", "")
    plain = edit(faster(shorter(plain, 8000)), RUN, last + RUN)
    plain = edit(plain, re.search(r"^thermo_style .*\n", plain, re.M)[0], "thermo_style custom step atoms ke\n")
    theirs = run(plain, start_in(tmp_path / "stock"), ranks, program=stock).points(8000, "beads")
    ours = busy.points(8000, "beads")
    assert len(ours["id"]) == len(theirs["id"]) >= 20
    for vector in ("xyz", ("vx", "vy", "vz"), ("omegax", "omegay", "omegaz"), ("fx", "fy", "fz")):
        a, b = (np.array([of[c] for c in vector]) for of in (ours, theirs))
        assert abs(b).max() > 0
        figures.below(
            f"beads beside cement against those of liggghts, {ranks} rank(s): {''.join(vector)}", abs(a - b).max() / abs(b).max(), 0 if hosted() else 1e-6
        )  # another compilation rounds otherwise


def test_ranks(tmp_path, figures):
    """The pulled bond on one rank and on two, until it begins to fail."""
    tables = [run(with_columns(shorter(SCRIPT, 6000), COLUMNS, 40), start_in(tmp_path / str(n)), n).table() for n in (1, 2)]
    intact = tables[0][column(DEBONDED)] == 0
    force = tables[0][column(TENSION)][intact]
    assert intact.sum() > 90
    figures.below(
        "rain, 2 ranks against 1: force of the pulled pair while intact, over the peak",
        abs(tables[1][column(TENSION)][intact] - force).max() / force.max(),
        1e-10,
    )


@pytest.mark.parametrize("ranks", [1, 2])
def test_restart(ranks, tmp_path, figures):
    """Continued from the middle, between two insertions and while both bonds fail."""
    middle, end = 6600, 10400
    script = with_columns(faster(shorter(SCRIPT, end)), COLUMNS, 40)
    first = edit(script, RUN, f"run {middle}\nwrite_restart ${{file}}\n" + RUN)
    whole = run(first, start_in(tmp_path), ranks).table()
    begin = script.index("region       box")
    made = script[begin : script.index("communicate  single vel yes group grains")]
    groups = "".join(re.findall(r"^group .*\n", made, re.M))
    again = edit(script, made, "read_restart ${file}\n")
    again = edit(again, re.search(r"^create_cement .*\ncreate_cement .*\n", again, re.M)[0], "")
    assert groups.count("\n") == 3
    rest = run(again, tmp_path, ranks, name="in.again").table()
    # The last row of a step: at the restart that of the second run's beginning, as in the continued one.
    at = [int(np.flatnonzero(whole["step"] == s)[-1]) for s in rest["step"]]
    assert rest["step"][0] == middle and rest["step"][-1] == end and rest["atoms"][-1] > rest["atoms"][0]
    for name in COLUMNS:
        a, b = whole[name][at], rest[name]
        if name == "f_tray[3]":  # mesh forces are not in restart files: known from the first step on
            a, b = a[1:], b[1:]
        scale = 1.0 if name == "f_cem[12]" else max(abs(whole[name]).max(), 1e-300)  # the imbalance is relative already, and next to rounding
        figures.below(f"rain, restart on {ranks} rank(s): {name}, over its largest", abs(a - b).max() / scale, 1e-10)


@pytest.mark.parametrize("ranks", [1, 2])
def test_inserted_into_another_group(ranks, tmp_path):
    """Beads that are not in the group of `atom_modify first` fall through everything: an error, not silence."""
    script = edit(SCRIPT, "fix          small grains", "fix          small free")
    script = edit(script, "fix          large grains", "fix          large free")
    result = launch(shorter(script, 4000), start_in(tmp_path), ranks)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-2000:]
    for word in ("fix mpm (id cem)", "is not in group 'grains'", "fix insert"):
        assert word in result.errors()[0]


def test_near_the_stable_step(tmp_path, figures):
    """At nine tenths of the stable step links add dozens of times the mass of the cement, which moves with the beads."""
    script = edit(shorter(SCRIPT, 7895), "dt     index 1e-7", "dt     index 3.8e-7")
    table = run(with_columns(script, COLUMNS, 500), start_in(tmp_path)).table()
    working = table["f_cem[11]"] > 0.01 * table["f_cem[11]"].max()
    figures.below("rain at 0.9 of the stable step: energy imbalance of the cement", abs(table["f_cem[12]"][working]).max(), 0.003)
    for bond in (1, 2):
        assert table[column(SEPARATED, bond)][-1] == 1, f"bond {bond} holds"


def test_added_mass(tmp_path, figures):
    """What the fix prints of the mass that links add, on one rank and on two, and how it falls with the time step."""
    said, held = {}, []
    steps = np.array([1e-7, 2e-7, 2.7e-7])
    for dt in steps:
        script = shorter(edit(SCRIPT, "dt     index 1e-7", f"dt     index {dt}"), 0)
        for ranks in (1, 2):
            output = run(script, start_in(tmp_path), ranks).output
            found = re.findall(r"links +added mass (\S+), (\S+) of the mass of the cement; up to (\S+) of the mass of a free grain", output)
            assert len(found) == 1, output
            assert said.setdefault(dt, found[0]) == found[0]
        script = edit(
            edit(script, "upper move variable NULL NULL v_z NULL NULL v_w", "upper move linear 0 0 0"),
            "motion free nve/sphere",
            "motion free move linear 0 0 0",
        )
        output = run(script, start_in(tmp_path)).output
        held.append(float(re.findall(r"links +added mass (\S+), \S+ of the mass of the cement$", output, re.M)[0]))
        figures.note(f"rain, {dt} s: mass that links add, over that of the cement, and of a free grain over that of the grain", f"{said[dt][1]}, {said[dt][2]}")
    total, share, of_grain = (np.array([float(said[dt][n]) for dt in said]) for n in range(3))
    held, cement = np.array(held), total / share
    # Links of free grains count (1 + t)-fold, t 7/2 of the mass of the cement over that of the grain, or less. A node has the
    # mass that the bound asks for less its own, so that free grains add up to t of both.
    mass = 4 / 3 * np.pi * 0.002**3 * 1200  # of the lightest, whose bond is one of two that are alike
    t = 3.5 * cement / 2 / mass
    assert (0.05 < t).all() and (t < 0.6).all(), t
    assert (total > held).all() and (total < (1 + t) * held + t * cement).all(), (total, held, t)
    # four ends of bonds, of which that at the lightest grain has the most; the others have more than if held
    of_lightest = of_grain * mass
    assert (4 * of_lightest > total).all() and (of_lightest < total - 0.5 * held).all(), (of_lightest, total, held)
    figures.below("rain: mass of the cement that the shares imply, against each other", abs(cement / cement[0] - 1).max(), 3e-5)
    assert total[1] > 4 * total[0] and total[2] > total[1]


def test_momentum(tmp_path, figures):
    """Cement, grains and gravity without walls: what rains onto the free pair and breaks it takes no momentum away."""
    script = SCRIPT.replace("outer 1.3e-3 spacing", "outer 1.3e-3 inner auto spacing")  # a film has no mass in motion
    for line in re.findall(r"^fix +(?:tray|wall|hold|pull) .*\n", script, re.M):
        script = edit(script, line, "")
    # The pulled pair flies too; the other is high enough to fall for 2 ms.
    script = edit(script, "fix          motion free nve/sphere", "fix          motion grains nve/sphere")
    script = edit(script, "insert_every ${pause}", "insert_every once")
    momenta = MOMENTA.replace(f"0.4*mass*{RADIUS}^2", "0.4*mass*c_radius^2")
    script = edit(script, RUN, "run 1\n" + RUN)  # the insertion
    script = edit(
        script,
        THERMO,
        "compute radius grains property/atom radius\nvariable mass atom mass\n"
        "compute mass all reduce sum v_mass\nvariable weight equal 9.81*c_mass\n" + momenta + ENERGY + THERMO,
    )
    names = ["v_Px", "v_Py", "v_Pz", "v_Lz", "v_weight", "v_energy", "time", column(DEBONDED, 2)]
    table = run(with_columns(shorter(script, 12000), names, 40), start_in(tmp_path), 2).table()
    table = {n: c[table["step"] >= 1] for n, c in table.items()}
    assert table[column(DEBONDED, 2)][-1] > 100
    # What contacts store is not in the sum: it is less than at the beginning as long as one lasts, and never more.
    energy = table["v_energy"]
    figures.below("rain without walls: energy gained, over all there is", (energy - energy[0]).max() / energy[0], 1e-6)
    figures.note("rain without walls: energy that contacts took, over all there was", f"{1 - energy[-1] / energy[0]:.3g}")
    assert energy[-1] < 0.95 * energy[0]
    t = table["time"] - table["time"][0]
    fall = table["v_Pz"] + table["v_weight"] * t
    scale = abs(table["v_Pz"]).max()
    for name, drift in (("x", table["v_Px"]), ("y", table["v_Py"]), ("z, with gravity", fall)):
        figures.below(f"rain without walls: drift of momentum, {name}", abs(drift - drift[0]).max() / scale, 3e-11)
    # Mass goes back to nodes that are no longer constrained, which moves the middle of the cement by a hair.
    figures.below("rain without walls: drift of angular momentum about the vertical", abs(table["v_Lz"] - table["v_Lz"][0]).max() / (scale * 0.01), 1e-8)
