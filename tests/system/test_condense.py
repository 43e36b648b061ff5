# SPDX-License-Identifier: GPL-2.0-or-later
"""fix mpm ... condense yes: bonds by their static fields until they may break, against resolved ones."""
import csv
import re
from pathlib import Path

import numpy as np
import pytest
from elastic_pair import measure_case, references
from scenes import CALCITE, MOMENTA, MOMENTUM_COLUMNS, SPINNING, cement, edit, launch, pair, pull, restarted, run, shift, thermo
from test_stiffness_command import rows_of

CASES = references()
AWAKE = "f_cem[24]"
ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("load", ["tension", "shear", "torsion", "bending"])
def test_loads(load, tmp_path, figures):
    case = CASES["meniscus across a gap"]
    condensed, resolved = (measure_case(tmp_path / word, case, load, 2.5e-4, cracks=f"bonds condense {word}") for word in ("yes", "no"))
    figures.below(f"{load}: condensed against resolved", abs(condensed / resolved - 1), 1e-3)


@pytest.mark.parametrize("content", [0.002, 0.003])
def test_ring_one_cell_wide(content, tmp_path, figures):
    """Nodes beside a ring as thin as that move more than its grains, but carry nothing: it is condensed, is activated, and breaks as the resolved one does."""
    table = {}
    for word in ("no", "yes"):
        text = pair(2e-4, cement=f"content {content}", radius=1.85e-3)
        text += cement(4e-4, 2e-8, CALCITE, axis="radial", damage=f"damage tensor B0 9.6e3 zeta 0.1 quasistatic 1 0.05 condense {word}")
        done = run(text + shift(4e-7, 3e-4) + thermo(10, ["f_bond", AWAKE, "f_cem[12]"]) + "run 10000\n", tmp_path / word)
        assert word == "no" or "condensed 1 of 1 bonds, with 1 solutions found anew" in done.output and "stay resolved" not in done.output
        table[word] = done.table()
    condensed, resolved = (table[word]["f_bond"] for word in ("yes", "no"))
    peak, woke = resolved.argmax(), np.argmax(table["yes"][AWAKE] > 0)
    assert 0.6 * peak < woke < peak < len(resolved) - 50 and resolved[-1] < 0.9 * resolved[peak]
    figures.below("force until it wakes", abs(condensed - resolved)[:woke].max() / resolved[peak], 5e-3)
    figures.below("force from there to the peak", abs(condensed - resolved)[woke : peak - 30].max() / resolved[peak], 5e-3)
    figures.below("peak", abs(condensed.max() / resolved[peak] - 1), 2e-3)
    figures.below("imbalance of the energy", abs(table["yes"]["f_cem[12]"]).max(), 1e-4)


def test_rings_that_trim_each_other(tmp_path, figures):
    """Of three beads that touch. They are condensed, and their loads are those of resolved ones."""
    force = {}
    for word in ("no", "yes"):
        text = edit(
            pair(2e-4, radius=1.7e-3),
            "create_atoms 1 single 0 0 0.0017 units box\n",
            "create_atoms 1 single 0 0 0.0017 units box\ncreate_atoms 1 single 0 0.00294448637286709 0 units box\n",
        )
        text = edit(text, "pair 1 2 shape flat inner 1e-3 outer 2e-3", "contacts grains gap 1e-5 shape flat content 0.007 inner auto overlap trim")
        text += cement(4e-4, 2e-8, CALCITE, axis="radial", damage=f"quasistatic 1 0.05 condense {word}") + shift(1e-7, 2e-4, (0, 0.6, 0.8))
        text = edit(text, "fix hold first move", "group low id 1 3\nfix hold low move")
        text += "variable fy equal fy[2]\nvariable fz equal fz[2]\n"
        done = run(text + thermo(10, ["v_fy", "v_fz"]) + "run 10000\n", tmp_path / word)
        assert word == "no" or "condensed 3 of 3 bonds" in done.output and "stay resolved" not in done.output
        force[word] = np.array([done.table()[c] for c in ("v_fy", "v_fz")])
    figures.below("force on the bead that moves", abs(force["yes"] - force["no"]).max() / abs(force["no"]).max(), 5e-3)


def free_pair(word, axis="radial", words=""):
    """Unequal grains, skew, that fly, rotate and swing along all six motions."""
    text = pair(1e-4, gap=4e-4, cement="outer 1.5e-3 inner 0", direction=(0.36, -0.48, 0.8), half_box=(0.02, 0.02, 0.02))
    text = edit(text, "group        grains type 1\n", "group        grains type 1\nset atom 1 density 750\nset atom 2 density 450\n")
    text += cement(2e-4, 8e-9, axis=axis, couple="kn auto kt auto", damage=f"condense {word} {words}")
    return text + "fix motion grains nve/sphere\n"


def period_of(force, step, guess):
    """Period of the sine that fits best, and its amplitude."""

    def fit(period):
        x = 2 * np.pi * step / period
        base = np.stack([np.cos(x), np.sin(x), np.ones_like(x)], axis=1)
        c, rest, *_ = np.linalg.lstsq(base, force, rcond=None)
        return rest[0], np.hypot(c[0], c[1])

    for width in (0.05, 0.002):
        periods = guess * (1 + width * np.linspace(-1, 1, 201))
        guess = min(periods, key=lambda p: fit(p)[0])
    return guess, fit(guess)[1]


def test_frequency(tmp_path, figures):
    """Of the swing along the line of centres, of grains that weigh twenty to forty times their cement. The resolved bond rings besides."""
    found, guess = {}, None
    for word in ("yes", "no"):
        text = free_pair(word) + "velocity first set -0.00036 0.00048 -0.0008\nvelocity second set 0.0006 -0.0008 0.001333\n"
        t = run(text + thermo(1, ["f_bond"]) + "run 8000\n", tmp_path / word).table()
        f = t["f_bond"] - t["f_bond"].mean()
        guess = guess or len(f) / np.argmax(np.abs(np.fft.rfft(f)))  # of the condensed one, which does not ring
        found[word] = period_of(f, t["step"], guess)
    figures.note("period in steps and amplitude, condensed and resolved", str(found))
    figures.below("period, condensed against resolved", abs(found["yes"][0] / found["no"][0] - 1), 2e-3)
    figures.below(
        "amplitude of the force, condensed against resolved", abs(found["yes"][1] / found["no"][1] - 1), 2e-2
    )  # resolved cement starts at rest, and is struck


def test_frequency_of_light_grains(tmp_path, figures):
    """Grains of six to twelve times their cement. The added mass of the links of the resolved bond scales with the square of the step, and is a tenth
    of its cement here; with twice the step it is more than the cement, and the period of the resolved bond 4e-3 longer."""
    found, guess = {}, None
    for word in ("yes", "no"):
        text = edit(edit(edit(free_pair(word), "density 750", "density 225"), "density 450", "density 135"), "timestep     8e-09", "timestep 4e-9")
        text += "velocity first set -0.00036 0.00048 -0.0008\nvelocity second set 0.0006 -0.0008 0.001333\n"
        t = run(text + thermo(1, ["f_bond"]) + "run 6000\n", tmp_path / word).table()
        f = t["f_bond"] - t["f_bond"].mean()
        guess = guess or len(f) / np.argmax(np.abs(np.fft.rfft(f)))
        found[word] = period_of(f, t["step"], guess)
    figures.below("light grains: period, condensed against resolved", abs(found["yes"][0] / found["no"][0] - 1), 2e-3)


# Bonds of equal and unequal grains, on a line that lies skew in the box.
SKEW = dict(direction=(0.36, -0.48, 0.8), half_box=(0.02, 0.02, 0.02))
SHAPES = {
    "flat ring, unequal grains": edit(
        pair(1e-4, gap=2e-4, cement="outer 1.5e-3 inner 0.3e-3", **SKEW),
        "group        grains type 1\n",
        "group        grains type 1\nset atom 2 diameter 0.0097\n",
    ),
    "meniscus": pair(1e-4, gap=2e-4, shape="meniscus", cement="neck 1e-3 contact 1.5e-3", **SKEW),
    "coating": pair(1e-4, gap=1e-4, shape="coating", cement="thickness 3e-4 cap 25", **SKEW),
}
LOADS = {
    "x": ("0.06 0 0", ""),
    "y": ("0 0.06 0", ""),
    "z": ("0 0 0.06", ""),
    "about x": ("0 0 0", "omegax 30"),
    "about y": ("0 0 0", "omegay 30"),
    "about z": ("0 0 0", "omegaz 30"),
}


@pytest.mark.parametrize("shape", [pytest.param(s, marks=[pytest.mark.long] if s == "coating" else []) for s in SHAPES])
def test_six_loads(shape, tmp_path, figures):
    """Loads on both grains just before a bond is activated, and just after, when they are those of its links."""
    worst = 0.0
    for load, (velocity, turn) in LOADS.items():
        text = SHAPES[shape] + cement(2e-4, 4e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9 condense yes wake 0.01")
        text += f"fix hold first move linear 0 0 0\nfix pull second move linear {velocity}\n" + (f"set group second {turn}\n" if turn else "")
        t = run(text + thermo(1, [f"f_bond[{k}]" for k in range(1, 13)] + [AWAKE]) + "run 400\n", tmp_path / load.replace(" ", "_")).table()
        at = int(np.argmax(t[AWAKE] > 0))
        assert 21 < at < 390, (load, at)
        loads = np.array([t[f"f_bond[{k}]"] for k in range(1, 13)])
        # the last steps before it, on a straight line, against the mean of the steps after
        before, after = loads[:, at - 20 : at + 1], loads[:, at + 1 : at + 9]
        slope = (before[:, -1] - before[:, 0]) / 20
        expected = before[:, -1:] + slope[:, None] * np.arange(1, 9)
        off = np.abs((after - expected).mean(axis=1))
        for part in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)):
            size = np.linalg.norm(before[part, -1])
            worst = max(worst, off[part].max() / size)
            figures.note(f"{shape}, {load}: loads {part.start + 1} to {part.stop}", f"{off[part].max() / size:.2g} of {size:.3g}")
    figures.below(f"{shape}: loads, resolved against condensed", worst, 1e-3)


BREAKING = pair(1e-4, gap=2e-4, cement="outer 1.5e-3 inner 0.3e-3", half_box=(6e-3, 6e-3, 12.5e-3))


def breaking(word, direction=(0, 0, 1)):
    return BREAKING + cement(2e-4, 4e-9, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 check 10 condense {word}") + pull(0.5, 8e-6, direction)


@pytest.mark.parametrize("load, direction", [("tension", (0, 0, 1)), ("shear", (1, 0, 0))])
def test_activation(load, direction, tmp_path, figures):
    tables = {}
    for word in ("yes", "no"):
        tables[word] = run(
            breaking(word, direction)
            + thermo(1, ["f_bond", "f_bond[7]", "f_bond[9]", AWAKE, "f_cem[5]", "f_cem[6]", "f_cem[7]", "f_cem[12]", "f_cem[2]"])
            + "run 6000\n",
            tmp_path / word,
        ).table()
    column = "f_bond[9]" if load == "tension" else "f_bond[7]"
    t, r = tables["yes"], tables["no"]
    force, resolved = np.abs(t[column]), np.abs(r[column])
    at = int(np.argmax(t[AWAKE] > 0))
    assert 100 < at < len(force) - 1 and (t[AWAKE][at:] == 1).all() and (r[AWAKE] == 1).all()
    assert t["f_cem[2]"][at] == 0 and r["f_cem[2]"][at] == 0
    # what the step after the activation adds beyond the slope of those before
    jump = abs(force[at + 1] - 2 * force[at] + force[at - 1]) / force[at]
    energy = t["f_cem[5]"] + t["f_cem[6]"] + t["f_cem[7]"]
    figures.below(f"{load}: jump of the force when it wakes", jump, 1e-3)
    figures.below(f"{load}: jump of the energy when it wakes", abs(energy[at + 1] - 2 * energy[at] + energy[at - 1]) / energy[at], 1e-3)
    balance = t["f_cem[12]"]  # what the bond has more or less than before is counted as released
    figures.below(f"{load}: jump of the energy imbalance when it wakes", np.abs(np.diff(balance)[at - 1 : at + 2]).max(), 5e-10)
    ringing = force[at + 1 : at + 200] - resolved[at + 1 : at + 200]
    figures.note(f"{load}: largest difference of the force in the 200 steps after", f"{np.abs(ringing).max() / force[at]:.3g}")
    figures.below(f"{load}: peak against resolved", abs(force.max() / resolved.max() - 1), 5e-3)
    figures.below(f"{load}: energy imbalance beyond that of the resolved one", np.abs(t["f_cem[12]"]).max() - np.abs(r["f_cem[12]"]).max(), 2e-4)


@pytest.mark.parametrize("words", ["", "zeta 0.1", "interface 0.5", "regularization nonlocal 3e-4"])
def test_threshold(words, tmp_path):
    """Activated at the threshold itself, a bond is damaged a few steps later, when the resolved one is: the driving force is that of the law."""
    script = edit(breaking("yes wake 0.999", (1, 0, 0)), "cutoff 0.9", f"cutoff 0.9 {words}" if "regul" not in words else "cutoff 0.9")
    if "regul" in words:
        script = edit(script, "check 10", f"check 10 {words}")
    t, r = (
        run(s + thermo(1, [AWAKE, "f_cem[8]"]) + "run 1000\n", tmp_path / name).table()
        for name, s in (("yes", script), ("no", edit(script, "condense yes wake 0.999", "condense no")))
    )
    wakes, damage, resolved = int(np.argmax(t[AWAKE] > 0)), int(np.argmax(t["f_cem[8]"] > 0)), int(np.argmax(r["f_cem[8]"] > 0))
    assert 100 < wakes < damage <= wakes + 6 and abs(damage - resolved) <= 3, (wakes, damage, resolved)


def cycles(word, most, steps, count=1):
    """The second grain goes to and fro by `most` along the line of centres, `count` times in `steps` each."""
    text = BREAKING + cement(2e-4, 4e-9, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 check 10 condense {word}")
    turn = f"2*PI*v_t/{4e-9 * steps}"
    return text + (
        f"variable t equal step*dt\nvariable z equal {most / 2}*(1-cos({turn}))\nvariable w equal {most * np.pi / (4e-9 * steps)}*sin({turn})\n"
        "fix hold first move linear 0 0 0\nfix pull second move variable NULL NULL v_z NULL NULL v_w\n"
    )


AGAIN = ["f_bond[9]", AWAKE, "f_cem[5]", "f_cem[6]", "f_cem[7]", "f_cem[8]", "f_cem[12]", "f_cem[10]"]


@pytest.mark.parametrize("cracks", ["bonds", pytest.param("split", marks=pytest.mark.long)])
def test_condensed_again(cracks, tmp_path, figures):
    """Corners are damaged, the load goes back, and the bond is condensed with its damage until the load comes again."""
    steps, onset = 5000, 83.3  # force at the threshold
    t, r = (run(cycles(f"{word} cracks {cracks}", 1.18e-7, steps) + thermo(1, AGAIN) + f"run {2 * steps}\n", tmp_path / word).table() for word in ("yes", "no"))
    change = np.flatnonzero(np.diff(t[AWAKE]))
    assert list(t[AWAKE][change + 1]) == [1, 0, 1, 0], change
    assert t["f_cem[8]"][change[1]] > 0
    force, energy = t["f_bond[9]"], t["f_cem[5]"] + t["f_cem[6]"] + t["f_cem[7]"]
    for at in change:
        jump = np.abs(force[at + 1] - 2 * force[at] + force[at - 1]).max()
        figures.below(f"step {at}: jump of the force over that at the threshold", jump / onset, 1e-3)
        figures.below(f"step {at}: jump of the energy", np.abs(energy[at + 1] - 2 * energy[at] + energy[at - 1]).max() / energy[at], 1e-3)
        after = slice(at + 1, at + 200)
        figures.below(f"step {at}: ringing in the 200 steps after", np.abs(force - r["f_bond[9]"])[after].max() / onset, 1e-3)
    figures.below("force against resolved, all of it", np.abs(force - r["f_bond[9]"]).max() / onset, 2e-3)
    figures.below("energy imbalance", np.abs(t["f_cem[12]"]).max(), 1e-4)
    figures.below("energy dissipated, against resolved", abs(t["f_cem[8]"][-1] / r["f_cem[8]"][-1] - 1), 2e-2)


def test_restart_of_one_condensed_again(tmp_path):
    """The damage is in the points, from which the bond is solved again."""
    script = cycles("yes", 1.18e-7, 5000)
    whole = run(script + thermo(50, AGAIN) + "run 4000\nwrite_restart r\nrun 3500\n", tmp_path).table()
    fixes = script[script.index("timestep") :]
    again = run(restarted("r") + fixes + thermo(50, AGAIN) + "run 3500\n", tmp_path, name="in.again").table()
    rows = len(again["step"])
    assert again[AWAKE][0] == 0 and again[AWAKE][-1] == 1
    assert (whole[AWAKE][-rows:] == again[AWAKE]).all()
    for name in AGAIN[:1] + AGAIN[2:6]:
        assert whole[name][-rows:] == pytest.approx(again[name], rel=1e-9, abs=1e-9 * np.abs(whole[name]).max()), name


@pytest.mark.parametrize("cracks", [pytest.param("bonds", marks=pytest.mark.long), "split"])
def test_momentum_of_one_condensed_again(cracks, tmp_path, figures):
    """Free grains swing apart, their bond is activated, damaged, and condensed again."""
    text = BREAKING + cement(2e-4, 4e-9, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 check 10 condense yes cracks {cracks}")
    text += "velocity first set 0.3 0 0.93\nvelocity second set 0.3 0 1.07\nfix motion grains nve/sphere\n"
    t = run(text + MOMENTA + thermo(10, MOMENTUM_COLUMNS + [AWAKE, "f_cem[8]", "f_cem[12]"]) + "run 3000\n", tmp_path).table()
    change = np.flatnonzero(np.diff(t[AWAKE]))
    assert t["f_cem[8]"][-1] > 0 and len(change) >= 2 and t[AWAKE][change[1] + 1] == 0, (change, t["f_cem[8]"][-1])
    P = np.array([t[c] for c in MOMENTUM_COLUMNS])
    drift = np.abs(P - P[:, :1]).max(axis=1)
    figures.below("drift of momentum", drift[:3].max() / np.linalg.norm(P[:3, 0]), 1e-13)
    figures.below("drift of angular momentum", drift[3:].max() / (np.linalg.norm(P[:3, 0]) * 5e-3), 8e-14)
    figures.below("energy imbalance", np.abs(t["f_cem[12]"]).max(), 1e-4)


def test_velocity_between_runs(tmp_path, figures):
    """Commands that change the velocity of grains that move already give energy to their condensed cement, which is counted as work."""
    text = free_pair("yes") + "velocity grains set 0 0.2 1\n" + thermo(10, ["f_cem[5]", "f_cem[12]", AWAKE])
    t = run(text + "run 50\nvelocity grains set 0.5 0 2\nrun 50\nvelocity grains set -0.5 0 0.1\nrun 50\n", tmp_path).table()
    assert (t[AWAKE] == 0).all() and t["f_cem[5]"].max() > 3 * t["f_cem[5]"][5] > 0
    figures.below("energy imbalance", np.abs(t["f_cem[12]"]).max(), 3e-13)


def test_computes_between_outputs(tmp_path):
    """A compute that another fix asks for sees points as they are, without an output in that step."""

    def averaged(every):
        asks = "compute szz calcite mpm/atom cem stress_zz\ncompute sum calcite reduce sum c_szz\n" "fix record all ave/time 10 1 10 c_sum file sum.txt\n"
        run(pair(1e-4) + cement(2e-4, 1e-8, damage="condense yes") + pull(1.0, 2e-6) + asks + thermo(every, ["f_bond"]) + "run 100\n", tmp_path / str(every))
        return np.loadtxt(tmp_path / str(every) / "sum.txt")

    often, seldom = averaged(10), averaged(1000)
    assert len(often) > 9 and abs(often[-1, 1]) > 10 * abs(often[1, 1]) > 0
    assert (often == seldom).all()


def test_second_run(tmp_path):
    """Bonds are solved for once, equal ones together, and not again in a second run."""
    text = (ROOT / "examples" / "packing" / "in.packing").read_text() + "run 5\n"
    result = launch(
        text, tmp_path, arguments=["-var", "condense", "yes", "-var", "speed", "1e-3", "-var", "side", "3", "-var", "steps", "5", "-var", "record", "5"]
    )
    assert result.status == 0, result.output[-1500:]
    found = [tuple(map(int, w)) for w in re.findall(r"condensed (\d+) of (\d+) bonds, with (\d+) solutions", result.output)]
    assert [f[:2] for f in found] == [(54, 54)] * 2 and found[1][2] == 0 and 0 < found[0][2] < 54, found


def test_weight(tmp_path):
    """Both grains held: they carry the weight of the cement, each half of it where the bond is its mirror image."""
    text = pair(1e-4, gap=2e-4, cement="outer 1.5e-3 inner 0") + cement(2e-4, 4e-9, axis="bond", damage="condense yes")
    text += "fix g all gravity 1e6 vector 1 0 -2\nfix hold grains move linear 0 0 0\n"
    result = run(text + thermo(1, ["f_bond[1]", "f_bond[3]", "f_bond[7]", "f_bond[9]", AWAKE]) + "run 20\n", tmp_path)
    t = result.table()
    weight = 2710 * float(re.search(r"^  volume (\S+),", result.output, re.M)[1]) * 1e6 / 5**0.5
    assert (t[AWAKE] == 0).all()
    for grain in (("f_bond[1]", "f_bond[3]"), ("f_bond[7]", "f_bond[9]")):
        assert t[grain[0]][-1] == pytest.approx(0.5 * weight, rel=1e-4) and t[grain[1]][-1] == pytest.approx(-weight, rel=1e-4)


@pytest.mark.parametrize("held", [True, False], ids=["hanging", "falling"])
@pytest.mark.parametrize("ranks", [1, 2])
def test_work_of_gravity(held, ranks, tmp_path, figures):
    """The cement's weight does work while grains move; that of the grains is not the cement's."""
    text = pair(1e-4, gap=2e-4, cement="outer 1.5e-3 inner 0") + cement(2e-4, 1e-8, axis="bond", damage="condense yes")
    text += "fix g all gravity 9.81 vector 0 0 -1\nfix move second nve/sphere\n"
    text += f"fix {'hold first move linear 0 0 0' if held else 'also first nve/sphere'}\n"
    result = run(text + thermo(100, ["f_cem[5]", "f_cem[11]", "f_cem[12]", AWAKE]) + "run 1000\n", tmp_path, ranks)
    t = result.table()
    assert (t[AWAKE] == 0).all()
    work = np.abs(t["f_cem[11]"])  # of a grain that swings it comes back to 0, where a relative error says nothing
    figures.below("energy imbalance over the largest work", np.abs(t["f_cem[12]"] * work).max() / work.max(), 1e-6)
    if held:
        return
    mass = 2710 * float(re.search(r"^  volume (\S+),", result.output, re.M)[1])
    assert t["f_cem[11]"][-1] == pytest.approx(0.5 * mass * (9.81 * 1e-5) ** 2, rel=1e-6)


@pytest.mark.parametrize("words", ["", "regularization nonlocal 3e-4"], ids=["local", "nonlocal"])
def test_ranks(words, tmp_path):
    """A bond that ranks cut is activated at the same step and is separated by the same failures. Averages are over the points of all ranks."""
    script = edit(breaking("yes"), "check 10", f"check 10 {words}")
    tables = {
        ranks: run(script + thermo(10, ["f_bond", AWAKE, "f_cem[2]", "f_cem[19]"]) + "run 3000\n", tmp_path / str(ranks), ranks).table() for ranks in (1, 2, 4)
    }
    for ranks in (2, 4):
        for name in (AWAKE, "f_cem[2]", "f_cem[19]"):
            assert (tables[ranks][name] == tables[1][name]).all(), (ranks, name)
        assert tables[ranks]["f_bond"] == pytest.approx(tables[1]["f_bond"], abs=1e-6 * tables[1]["f_bond"].max())


@pytest.mark.parametrize("at", [400, 700])
def test_restart(at, tmp_path):
    """While it is condensed, and while it is resolved: bitwise identical."""
    columns = ["f_bond", AWAKE, "f_cem[2]", "f_cem[5]", "f_cem[6]", "f_cem[7]", "f_cem[12]"]
    script = breaking("yes")
    whole = run(script + thermo(50, columns) + f"run {at}\nwrite_restart r\nrun 600\n", tmp_path, 2).table()
    fixes = script[script.index("timestep") :]
    again = run(restarted("r") + fixes + thermo(50, columns) + "run 600\n", tmp_path, 2, name="in.again").table()
    rows = len(again["step"])
    for name in columns[:-1]:
        assert (whole[name][-rows:] == again[name]).all(), name
    assert whole["f_cem[12]"][-rows:] == pytest.approx(again["f_cem[12]"], abs=1e-12)  # a sum over ranks
    assert whole[AWAKE][len(whole["step"]) - rows] == (at > 628) and whole[AWAKE][-1] == 1


BAD = {
    "wake beyond the threshold": ("condense yes", "condense yes wake 1.1", ["fix mpm (id cem)", "'condense ... wake 1.1'", "(0, 1]"]),
    "wake at nothing": ("condense yes", "condense yes wake 0", ["fix mpm (id cem)", "'condense ... wake 0'", "(0, 1]"]),
    "neither yes nor no": ("condense yes", "condense 0.8", ["fix mpm (id cem)", "condense", "0.8", "yes"]),
    "updated": (
        "condense yes",
        "condense yes kinematics updated",
        ["fix mpm (id cem)", "'condense yes' does not go with 'kinematics updated'", "'kinematics total'"],
    ),
    "a new reference": (
        "condense yes",
        "condense yes reproject 10",
        ["fix mpm (id cem)", "'condense yes' does not go with 'reproject 10'", "without 'reproject'"],
    ),
    "cubic splines": (
        "condense yes",
        "condense yes basis cubic",
        ["fix mpm (id cem)", "'condense yes' does not go with 'basis cubic'", "'basis quadratic' or 'linear'"],
    ),
    "the other mass": (
        "condense yes",
        "condense yes mass_order 2",
        ["fix mpm (id cem)", "'condense yes' does not go with 'mass_order 2'", "or 'mass_order 1'"],
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_message(name, tmp_path):
    old, new, needed = BAD[name]
    result = launch(edit(breaking("yes") + "run 10\n", old, new), tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    missing = [word for word in needed if word not in result.errors()[0]]
    assert not missing, result.errors()[0]


GOES_WITH = {
    "cracks that close": ("condense yes", "condense yes unilateral yes"),
    "friction": ("kn auto", "friction 0.3 kn auto"),
    "cohesive links": ("kn auto kt auto", "kn auto kt auto interface cohesive tn 1e8 tt 1e8 Gn 4000 Gt 4000"),
}


@pytest.mark.parametrize("name", GOES_WITH)
def test_goes_with_condensed_bonds(name, tmp_path):
    """Bonds are condensed with these words, too, and carry what they carry without them."""
    end = thermo(10, ["f_bond"]) + "run 50\n"
    plain, other = (run(text + end, tmp_path / str(n), 2) for n, text in enumerate((breaking("yes"), edit(breaking("yes"), *GOES_WITH[name]))))
    assert "condensed 1 of 1 bonds" in other.output
    force = other.table()["f_bond"]
    assert abs(force).max() > 0.01 and force == pytest.approx(plain.table()["f_bond"], rel=1e-6, abs=1e-9)


def test_condensed_no_more(tmp_path):
    script = breaking("yes")
    run(script + "run 10\nwrite_restart r\n", tmp_path, 2)
    result = launch(restarted("r") + script[script.index("timestep") :].replace("condense yes", "condense no") + "run 10\n", tmp_path, 2, name="in.again")
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    assert all(w in result.errors()[0] for w in ("fix mpm (id cem)", "bonds were condensed", "grains 1 and 2", "use 'condense yes'")), result.errors()[0]


def test_flight(tmp_path, figures):
    """A pair that spins fast, whatever its rotation: momenta, and the load by the centripetal force, as of the resolved one."""
    found = {}
    for word in ("yes", "no"):
        text = pair(2e-4, gap=4e-4, cement="outer 1.5e-3 inner 0", half_box=(0.02, 0.02, 0.02)) + cement(4e-4, 1.6e-8, damage=f"condense {word}")
        text = edit(text, "density 2500", "density 250")
        found[word] = run(text + SPINNING + MOMENTA + thermo(50, MOMENTUM_COLUMNS + ["f_bond", "f_cem[5]"]) + "run 20000\n", tmp_path / word).table()
    t, r = found["yes"], found["no"]
    P = np.array([t[c] for c in MOMENTUM_COLUMNS])
    drift = np.abs(P - P[:, :1]).max(axis=1) / np.repeat([np.linalg.norm(P[:3, 0]), np.linalg.norm(P[3:, 0])], 3)
    figures.below("spinning pair: drift of momentum", drift[:3].max(), 1e-12)
    figures.below("spinning pair: drift of angular momentum", drift[3:].max(), 1e-7)
    figures.below("spinning pair: mean force of 52 swings against resolved", abs(t["f_bond"].mean() / r["f_bond"].mean() - 1), 3e-3)
    figures.below("spinning pair: mean kinetic energy of the cement against resolved", abs(t["f_cem[5]"].mean() / r["f_cem[5]"].mean() - 1), 1e-3)


def test_activation_of_one_that_rotated(tmp_path, figures):
    """After a fifth of a revolution: the axes of its material have rotated with it, so its force goes on."""
    words = [cement(4e-4, 1.6e-8, damage=f"damage tensor B0 9.6e3 condense yes wake {wake}", axis="bond") for wake in (1, 1e-9)]
    text = pair(2e-4, gap=4e-4, cement="outer 1.5e-3 inner 0", half_box=(0.02, 0.02, 0.02))
    run(text + words[0] + SPINNING + "run 12000\nwrite_restart r\n", tmp_path)
    condensed, awake = (
        run(
            restarted("r") + w + "fix motion grains nve/sphere\n" + thermo(1, ["f_bond", AWAKE, "f_cem[6]", "f_cem[7]"]) + "run 60\n", tmp_path, name=f"in.{n}"
        ).table()
        for n, w in enumerate(words)
    )
    assert (condensed[AWAKE] == 0).all() and awake[AWAKE][0] == 0 and (awake[AWAKE][2:] == 1).all()
    for name in ("f_bond", "f_cem[6]"):
        figures.below(f"turned: {name}, awake against condensed", np.abs(awake[name] - condensed[name]).max() / np.abs(condensed[name]).max(), 1e-2)


def test_stiffness_of_condensed_bonds(tmp_path):
    """In flight, and after a restart: the matrix rotates with the bond, by a fifth of a revolution here."""
    text = (
        pair(2e-4, gap=4e-4, cement="outer 1.5e-3 inner 0", half_box=(0.02, 0.02, 0.02)) + cement(4e-4, 1.6e-8, damage="condense yes", axis="bond") + SPINNING
    )
    run(text + "bond_stiffness a.csv\nrun 25000\nbond_stiffness b.csv\nwrite_restart r\n", tmp_path)
    run(restarted("r") + cement(4e-4, 1.6e-8, damage="condense yes", axis="bond") + "bond_stiffness c.csv\n", tmp_path, 2)
    a, b, c = (rows_of(tmp_path / f"{name}.csv")[0] for name in "abc")
    assert abs(b["nx"]) > 0.5
    for name in ("tension", "shear_min", "shear_max", "torsion", "bending_min", "bending_max"):
        assert b[name] == pytest.approx(a[name], rel=1e-5) and c[name] == pytest.approx(b[name], rel=1e-8), name
    for name in ("k11", "k13", "k33", "x", "z", "nx", "nz"):
        assert c[name] == pytest.approx(b[name], rel=1e-6, abs=1e-9), name
    assert b["k33"] == pytest.approx(a["k33"] * b["nz"] ** 2 + a["k11"] * b["nx"] ** 2, rel=1e-3)


def test_memory(tmp_path):
    """Fields of a condensed bond take 288 bytes a point and 144 a node. They are printed with what the condensed bond takes, by this fix and by LIGGGHTS."""
    took = {}
    for word in ("yes", "no"):
        output = run(free_pair(word) + "run 1\n", tmp_path / word).output
        took[word] = [float(re.search(words, output)[1]) for words in (r"(\S+) bytes a point", r"Memory usage per processor = (\S+) Mbytes")]
    points = int(re.search(r"steps with (\d+) atoms", output)[1]) - 2
    assert 288 < took["yes"][0] - took["no"][0] < 600, took
    assert took["yes"][1] - took["no"][1] > 288 * points / 2**20, (took, points)


def test_packing(tmp_path, figures):
    """examples/packing, smaller: free beads with many bonds each. The same bonds separate at the same steps, by the same modes."""
    script = (ROOT / "examples" / "packing" / "in.packing").read_text()
    apart, force = {}, {}
    for word in ("yes", "no"):
        result = launch(
            script, tmp_path, 2, name=f"in.{word}", arguments=["-var", "condense", word, "-var", "side", "3", "-var", "steps", "600", "-var", "record", "10"]
        )
        assert result.status == 0 and not result.errors(), result.output[-2000:]
        with open(tmp_path / "bond.csv") as f:
            rows = list(csv.DictReader(f))
        apart[word] = {}
        for row in rows:
            if float(row["separated"]) > 0:
                apart[word].setdefault(row["bond"], (int(row["step"]), row["mode"]))
        lines = [line.split() for line in result.output.splitlines() if re.fullmatch(r"( +\S+){7} *", line)]
        force[word] = np.array([float(w[2]) for w in lines if w[0].isdigit()])
    assert len(apart["no"]) >= 9 and apart["yes"] == apart["no"]
    peak = int(np.argmax(force["no"]))
    figures.below("packing: force up to the peak, over the peak", np.abs(force["yes"] - force["no"])[: peak + 1].max() / force["no"][peak], 1e-2)


def test_packing_on_eight_ranks(tmp_path):
    """examples/packing, smaller, on as many ranks as a cube has corners: the same points fail at the same steps, the same bonds separate, are activated and stay condensed."""
    script = (ROOT / "examples" / "packing" / "in.packing").read_text().replace("custom step ", "custom step f_cem[24] f_cem[19] ")
    cement_made, rest = script.index("communicate  single vel yes group"), script.index("fix          kn")
    words = ["-var", "condense", "yes", "-var", "side", "3", "-var", "steps", "500", "-var", "record", "10"]
    run(script[:rest] + "write_restart made.restart\n", tmp_path, arguments=words)  # IDs of beads that LIGGGHTS makes depend on its ranks
    start, told = script[: script.index("region       box")], {}
    for ranks, processors in ((1, "1 1 1"), (8, "2 2 2")):
        settings = "\n".join(line for line in script[cement_made:rest].splitlines() if not line.startswith("create_cement"))
        result = run(
            start + f"processors {processors}\nread_restart ../made.restart\n" + settings + "\n" + script[rest:], tmp_path / str(ranks), ranks, arguments=words
        )
        with open(tmp_path / str(ranks) / "events.csv") as f:
            failed = sorted((int(r["step"]), int(r["point"]), int(r["bond"]), r["mode"]) for r in csv.DictReader(f))
        with open(tmp_path / str(ranks) / "bond.csv") as f:
            apart = sorted((int(r["step"]), int(r["bond"]), r["mode"]) for r in csv.DictReader(f) if float(r["separated"]) > 0)
        told[ranks] = failed, apart, [w[:3] for w in (line.split() for line in result.output.splitlines()) if len(w) == 9 and w[0].isdigit()]
    failed, apart, steps = told[1]
    assert len(failed) > 100 and len({bond for _, bond, _ in apart}) >= 9
    assert any(0 < float(awake) < 54 for _, awake, _ in steps) and float(steps[-1][1]) < 54, "bonds are condensed, awake and broken"
    assert told[8] == told[1]
