# SPDX-License-Identifier: GPL-2.0-or-later
"""fix mpm ... condense yes: separated bonds become a rigid piece of each grain, against resolved ones."""
import re

import numpy as np
import pytest
from scenes import MOMENTA, MOMENTUM_COLUMNS, cement, dump, edit, pair, point_quantities, pull, restarted, run, thermo

AWAKE, SEPARATED = "f_cem[24]", "f_cem[19]"
STEP = 1.6e-8
PULLED = dict(gap=4e-4, cement="outer 1.5e-3 inner 0", half_box=(6e-3, 6e-3, 12.5e-3))


def broken(word, words="", motion=pull(1.0, 8e-6), damping=0.2, damage="", second=5e-3, **options):
    """Pulled until it breaks. The damping lets what is left come to rest."""
    damage = f"damage tensor B0 9.6e3 cutoff 0.9 {damage} quasistatic 1 {damping} check 10 condense {word} {words}"
    text = edit(pair(2e-4, **{**PULLED, **options}), "create_cement", f"set atom 2 diameter {2 * second}\ncreate_cement")
    return text + cement(4e-4, STEP, axis="radial", damage=damage) + motion


COLUMNS = ["f_bond"] + [f"f_bond[{n}]" for n in (1, 2, 3, 7, 8, 9)] + [AWAKE, SEPARATED, "f_cem[2]", "f_cem[5]", "f_cem[6]", "f_cem[7]", "f_cem[12]"]


def when(t):
    """Rows in which the bond is activated, separated, and condensed again; each once."""
    change = np.flatnonzero(np.diff(t[AWAKE])) + 1
    assert list(t[AWAKE][change]) == [1, 0], (change, t[SEPARATED][-1])
    apart = int(np.argmax(t[SEPARATED] > 0))
    assert change[0] < apart < change[1]
    return change[0], apart, change[1]


CASES = {
    "off the second grain": dict(),
    "off a grain, sheared": dict(motion=pull(1.0, 8e-6, (1, 0, 0)), damage="interface 0.1"),
    "through a waist": dict(shape="hourglass", gap=1.2e-3, cement="outer 1.6e-3 waist 0.6"),
    "nodes that split": dict(words="cracks split"),
    "through a waist, nodes that split": dict(shape="hourglass", gap=1.2e-3, cement="outer 1.6e-3 waist 0.6", words="cracks split"),
    "skew, unequal grains": dict(direction=(1, 2, -2), half_box=(9e-3, 9e-3, 9e-3), second=4.9e-3, motion=pull(1.0, 8e-6, (1, 2, -2))),
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long) if n in ("off a grain, sheared", "through a waist") else n for n in CASES])
def test_at_rest(name, tmp_path, figures):
    """Jumps of force and energy, and where points are in the end, against the resolved bond."""
    tables, points, failed = {}, {}, {}
    for word in ("yes", "no"):
        quantities = point_quantities(["failed"]) + dump(8000, ["x", "y", "z", "vx", "vy", "vz", "c_failed"])
        result = run(broken(word, **CASES[name]) + quantities + thermo(1, COLUMNS) + "run 8000\n", tmp_path / word)
        p = result.points(8000)
        tables[word], failed[word] = result.table(), p["c_failed"]
        points[word] = np.array([[p[d] for d in "xyz"], [p[f"v{d}"] for d in "xyz"]])
    t, r = tables["yes"], tables["no"]
    _, apart, rests = when(t)
    figures.note(f"{name}: steps from separation until it is condensed", f"{rests - apart}, after {t['f_cem[2]'][-1]:g} points failed")
    force = np.linalg.norm([t[f"f_bond[{n}]"] for n in range(1, 10) if n not in (4, 5, 6)], axis=0)
    peak, energy = force.max(), t["f_cem[5]"] + t["f_cem[6]"] + t["f_cem[7]"]
    figures.below(f"{name}: jump of the forces when it is condensed, over the peak", np.abs(np.diff(force))[rests - 2 : rests + 2].max() / peak, 1e-3)
    figures.below(f"{name}: jump of the energy, with that of dust, over the largest", np.abs(np.diff(energy))[rests - 2 : rests + 2].max() / energy.max(), 5e-3)
    figures.below(f"{name}: forces after that, over the peak", force[rests + 1 :].max() / peak, 1e-3)
    figures.below(f"{name}: energy imbalance beyond that of the resolved one", np.abs(t["f_cem[12]"]).max() - np.abs(r["f_cem[12]"]).max(), 1e-4)
    assert (failed["yes"] == failed["no"]).all()
    off = np.abs(points["yes"] - points["no"])[:, :, failed["no"] == 0]
    figures.below(f"{name}: points at the end against resolved, over a cell", off[0].max() / 4e-4, 1e-3)
    figures.below(f"{name}: their velocities over that of the grain", off[1].max(), 1e-3)


# They rotate together, and a little against each other, while they are torn apart.
FREE = """\
variable     vx atom "1500*z+0.4"
variable     vz atom "-1500*x+100*z"
velocity     all set v_vx 0.1 v_vz
set          group grains omegay 1500
set          atom 1 omegax 40
set          atom 2 omegaz -60
fix          motion grains nve/sphere
"""


def free(word, words=""):
    """Free grains fly apart, and rotate by more than a third of a revolution with their pieces."""
    return broken(word, words, motion=FREE, half_box=(0.02, 0.02, 0.02))


def test_flight(tmp_path, figures):
    """Momentum and angular momentum of grains and pieces, and the energy of the pieces, while both rotate; the path against that of the resolved pair."""
    tables, points = {}, {}
    for word in ("yes", "no"):
        columns = MOMENTUM_COLUMNS + [AWAKE, SEPARATED] + [f"f_cem[{n}]" for n in (2, 5, 6, 7, 8, 12)]
        quantities = point_quantities(["failed"]) + dump(60000, ["x", "y", "z", "c_failed"])
        result = run(free(word) + quantities + MOMENTA + thermo(50, columns) + "run 60000\n", tmp_path / word)
        tables[word], points[word] = result.table(), result.points(60000)
    t = tables["yes"]
    when(t)
    P = np.array([t[c] for c in MOMENTUM_COLUMNS])
    drift = np.abs(P - P[:, :1]).max(axis=1)
    figures.below("drift of momentum", drift[:3].max() / np.linalg.norm(P[:3, 0]), 1e-7)
    figures.below("drift of angular momentum", drift[3:].max() / np.linalg.norm(P[3:, 0]), 1e-7)
    figures.below("energy imbalance", np.abs(t["f_cem[12]"]).max(), 1e-3)
    holds = (points["yes"]["c_failed"] == 0) & (points["no"]["c_failed"] == 0)
    assert holds.sum() > 300
    off = np.max([np.abs(points["yes"][d] - points["no"][d])[holds] for d in "xyz"])
    figures.below("points at the end against resolved, over a cell", off / 4e-4, 0.02)


def test_momentum_of_a_row(tmp_path, figures):
    """Three light free grains in a row. One bond breaks; what its pieces have of momentum goes on through the other bond, which is condensed and whole."""
    text = edit(broken("yes", motion="", half_box=(0.02, 0.02, 0.02)), "density 2500", "density 600")
    text = edit(text, "set          type 1", "create_atoms 1 single 0 0 0.0156 units box\nset          type 1")
    text = edit(
        text,
        "create_cement calcite pair 1 2",
        "create_cement calcite pair 2 3 shape flat outer 2.8e-3 inner 0 film grid spacing 2e-4\ncreate_cement calcite pair 1 2",
    )
    text += 'variable vz atom "-2*(z<-3e-4)+0.7*(z>=-3e-4)"\nvelocity all set 0.2 0.1 v_vz\nfix motion grains nve/sphere\n'
    result = run(text + MOMENTA + thermo(10, MOMENTUM_COLUMNS + [AWAKE, SEPARATED, "f_cem[12]"]) + "run 12000\n", tmp_path)
    t = result.table()
    change = np.flatnonzero(np.diff(t[AWAKE])) + 1
    assert t[SEPARATED][-1] == 1 and t[AWAKE][-1] == 0, (change, t[SEPARATED][-1], t[AWAKE][-1])
    last, P = change[-1], np.array([t[c] for c in MOMENTUM_COLUMNS])
    jump = np.abs(P[:, last + 1] - P[:, last - 1])
    figures.below("jump of momentum as the pieces are condensed, over all", jump[:3].max() / np.linalg.norm(P[:3, 0]), 7e-10)


STATE = MOMENTUM_COLUMNS + [AWAKE, SEPARATED] + [f"f_cem[{n}]" for n in (2, 5, 6, 7, 8, 9, 10, 11)] + ["f_bond[1]", "f_bond[2]", "f_bond[3]", "f_bond[9]"]


def test_a_run_in_parts(tmp_path):
    """Ended and continued in the very step in which the bond is activated, or is condensed, or while its pieces are found at rest, and from files of these steps: bitwise identical."""
    script, steps = free("yes"), 14000
    whole = run(script + MOMENTA + thermo(1, STATE) + f"run {steps}\n", tmp_path).table()
    wakes, _, rests = when(whole)
    for at in (wakes, rests - 25, rests):
        parts = run(script + MOMENTA + thermo(1, STATE) + f"run {at}\nwrite_restart r\nrun {steps - at}\n", tmp_path, name="in.parts").table()
        fixes = script[script.index("timestep") : script.index("variable     vx")] + "fix          motion grains nve/sphere\n"
        again = run(restarted("r") + fixes + MOMENTA + thermo(1, STATE) + f"run {steps - at}\n", tmp_path, name="in.again").table()
        for name in STATE:
            assert (np.delete(parts[name], at + 1) == whole[name]).all(), (at, name)
            assert (again[name] == whole[name][at:]).all(), (at, name)


def test_ranks(tmp_path):
    """Pieces of a bond that ranks cut stay as they are; others are condensed at the same step on any number of ranks, and go from rank to rank."""
    tables = {}
    for ranks, grid in ((1, "* * *"), (2, "1 1 2"), (2, "2 1 1"), (4, "2 1 2")):
        # the lower grain keeps all of it, on the lower side of the cut between ranks
        text = edit(broken("yes", motion=pull(1.0, 8e-6), damage="interface 0.1"), "processors   * * *", f"processors   {grid}")
        text = edit(text, "-0.0125 0.0125 units", "-0.0165 0.0135 units")
        tables[ranks, grid] = run(text + thermo(1, COLUMNS) + "run 6000\n", tmp_path / f"{ranks} {grid}", ranks).table()
    one = tables[1, "* * *"]
    when(one)
    for key, t in tables.items():
        assert (t["f_cem[2]"] == one["f_cem[2]"]).all() and (t[SEPARATED] == one[SEPARATED]).all(), key
        if key[1] == "1 1 2":
            assert (t[AWAKE] == one[AWAKE]).all()


def test_over_the_cuts_of_ranks(tmp_path, figures):
    """Pieces that were condensed on one rank rotate into the subdomains of others, are cut by ranks, and give their grains the same loads as on one rank."""
    quantities = point_quantities(["failed"]) + dump(40000, ["x", "y", "z", "vx", "vy", "vz"])
    found = {}
    for ranks, grid in ((1, "* * *"), (2, "2 1 1")):
        text = edit(
            edit(free("yes"), "processors   * * *", f"processors   {grid}"),
            "-0.02 0.02 -0.02 0.02 -0.02 0.02 units",
            "-0.02 0.0236 -0.02 0.02 -0.02 0.02 units",
        )
        result = run(text + quantities + MOMENTA + thermo(10, STATE) + "run 40000\n", tmp_path / str(ranks), ranks)
        found[ranks] = result.table(), result.points(40000), result.output
    (one, points, _), (two, others, output) = found[1], found[2]
    when(one)
    assert (one[AWAKE] == two[AWAKE]).all() and (one["f_cem[2]"] == two["f_cem[2]"]).all()
    assert int(re.search(r"^Nlocal: +\S+ ave (\d+) max", output, re.M)[1]) < 940, "pieces on two ranks at the end"
    figures.below("momenta on two ranks against one", max(np.abs(one[c] - two[c]).max() / np.abs(one[c]).max() for c in MOMENTUM_COLUMNS), 1e-6)
    figures.below("points on two ranks against one, over a cell", max(np.abs(points[d] - others[d]).max() for d in "xyz") / 4e-4, 3e-14)
    figures.below("their velocities, m/s", max(np.abs(points[d] - others[d]).max() for d in ("vx", "vy", "vz")), 5e-14)


@pytest.mark.parametrize("substeps", [1, 4])
def test_fall(substeps, tmp_path, figures):
    """Weight and inertia of the pieces, which fall with their grains; with sub-steps, too."""
    text = edit(free("yes"), "fix          cem", "fix g all gravity 20000 vector 1 2 3\nfix          cem")
    if substeps > 1:
        text = edit(edit(text, "check 10", f"check 10 subcycle {substeps}"), f"timestep     {STEP}", f"timestep     {substeps * STEP}")
    n = 20000 // substeps
    result = run(text + MOMENTA + thermo(10, STATE + ["f_cem[12]"]) + f"run {n}\n", tmp_path)
    t = result.table()
    _, _, rests = when(t)
    volume = float(re.search(r"^  volume (\S+),", result.output, re.M)[1])
    mass = 2710 * volume + 2 * 2500 * 4 / 3 * np.pi * 5e-3**3
    since = substeps * STEP * (t["step"] - t["step"][0])
    for name, share in zip(MOMENTUM_COLUMNS[:3], np.array([1, 2, 3]) / 14**0.5):
        gained = (t[name] - t[name][0])[1:] / (mass * 20000 * share * since[1:])
        figures.below(f"{substeps} sub-steps: {name} gained over weight times time, less 1", np.abs(gained - 1)[len(gained) // 4 :].max(), 2e-5)
    figures.below(f"{substeps} sub-steps: energy imbalance", np.abs(t["f_cem[12]"]).max(), 3e-3)


def test_halves_on_two_ranks(tmp_path, figures):
    """A bond that broke through its waist is condensed on one rank, and its halves move apart over the cut between ranks: momentum stays, and so does the energy."""
    columns = MOMENTUM_COLUMNS + [AWAKE, SEPARATED, "f_cem[5]", "f_cem[12]"]
    found = {}
    for ranks, grid in ((1, "* * *"), (2, "1 1 2")):
        motion = FREE.replace("1500", "0").replace("100*z", "60*z")
        # the cut is above the bond, which both halves pass at different times
        text = edit(
            broken(
                "yes", motion=motion.replace("+60*z", "+5+60*z"), shape="hourglass", gap=1.2e-3, cement="outer 1.6e-3 waist 0.6", half_box=(0.02, 0.02, 0.02)
            ),
            "processors   * * *",
            f"processors   {grid}",
        )
        text = edit(text, "-0.02 0.02 -0.02 0.02 -0.02 0.02 units", "-0.02 0.02 -0.02 0.02 -0.02 0.0236 units")
        found[ranks] = run(text + MOMENTA + thermo(10, columns) + "run 24000\n", tmp_path / str(ranks), ranks)
    assert int(re.search(r"^Nlocal: +\S+ ave \S+ max (\d+) min", found[2].output, re.M)[1]) > 200, "both ranks have points at the end"
    one = found.pop(1).table()
    when(one)
    for ranks, result in found.items():
        t = result.table()
        assert (t[AWAKE] == one[AWAKE]).all() and (t[SEPARATED] == one[SEPARATED]).all()
        P = np.array([t[c] for c in MOMENTUM_COLUMNS])
        figures.below(f"{ranks} ranks: drift of momentum", np.abs(P - P[:, :1]).max(axis=1)[:3].max() / np.linalg.norm(P[:3, 0]), 1e-8)
        figures.below(f"{ranks} ranks: kinetic energy of the cement against one rank", np.abs(t["f_cem[5]"] / one["f_cem[5]"] - 1).max(), 2e-14)


def test_energy_of_fragments_is_the_same_in_flight(tmp_path, figures):
    """What is damped when a broken bond is condensed does not depend on the speed of the flight: what grains gain with the momentum of fragments is work."""
    taken = {}
    for V in (0, 30, -30):
        motion = f"velocity grains set 0 0 {V}\nvelocity second set 0 0 {V + 2.0}\nset group second omegax 1000\nfix free grains nve/sphere\n"
        text = edit(broken("yes", motion=motion, half_box=(6e-3, 6e-3, 3e-2)), "quasistatic 1 0.2", "quasistatic 1 0.05")
        t = run(text + thermo(1, [AWAKE, SEPARATED, "f_cem[2]", "f_cem[10]", "f_cem[12]"]) + "run 8000\n", tmp_path / str(V)).table()
        _, _, rests = when(t)
        taken[V] = t["f_cem[10]"][rests] - t["f_cem[10]"][rests - 1]
        figures.below(f"flight at {V} m/s: energy imbalance", abs(t["f_cem[12]"]).max(), 0.01)
    for V in (30, -30):
        figures.below(f"energy of dust damped in a flight at {V} m/s, against that at rest", abs(taken[V] / taken[0] - 1), 0.03)
