# SPDX-License-Identifier: GPL-2.0-or-later
"""fix mpm ... subcycle: the cement takes sub-steps in a step of LIGGGHTS."""
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import CONTACT, MOMENTA, MOMENTUM_COLUMNS, SPINNING, cement, edit, launch, pair, pull, restarted, run, thermo

ROOT = Path(__file__).parents[2]
STEP = 4e-9
BREAKING = pair(1e-4, gap=2e-4, cement="outer 1.5e-3 inner 0.3e-3", half_box=(6e-3, 6e-3, 12.5e-3))
SUMS = ["f_cem[2]", "f_cem[5]", "f_cem[6]", "f_cem[7]", "f_cem[8]", "f_cem[9]", "f_cem[11]", "f_cem[12]", "f_cem[19]"]


def breaking(n, word=None, more=""):
    """n steps of the cement in one of LIGGGHTS."""
    return (
        BREAKING
        + cement(2e-4, n * STEP, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 check {100 // n} subcycle {word or n} {more}")
        + pull(0.5, 8e-6)
    )


def test_one_is_none(tmp_path):
    """Bitwise identical."""
    tables = [
        run(edit(breaking(1), " subcycle 1 ", words) + thermo(50, ["f_bond"] + SUMS) + "run 1000\n", tmp_path / str(k)).table()
        for k, words in enumerate(["  ", " subcycle no ", " subcycle 1 "])
    ]
    for t in tables[1:]:
        for name in t:
            assert (t[name] == tables[0][name]).all(), name


@pytest.mark.parametrize("more", ["", "cracks split", "regularization nonlocal 2e-4"])
def test_breaking(more, tmp_path, figures):
    """A pair that is pulled until it breaks: force, energies and mode of the pair that takes short steps."""
    fine = run(breaking(1, more=more) + thermo(100, ["f_bond"] + SUMS) + "run 6000\n", tmp_path / "fine").table()
    coarse = run(breaking(10, more=more) + thermo(10, ["f_bond"] + SUMS) + "run 600\n", tmp_path / "coarse").table()
    figures.below("peak of the force", abs(coarse["f_bond"].max() / fine["f_bond"].max() - 1), 5e-3)
    figures.below("work", abs(coarse["f_cem[11]"][-1] / fine["f_cem[11]"][-1] - 1), 5e-3)
    figures.below("imbalance", np.abs(coarse["f_cem[12]"]).max(), 1e-2)
    assert coarse["f_cem[19]"][-1] == 1 and fine["f_cem[19]"][-1] == 1
    modes = [
        [line for line in (tmp_path / d / "in.test.out").read_text().splitlines() if "debonding" in line or "internal" in line or "mixed" in line]
        for d in ("fine", "coarse")
    ]
    assert [m.split(":")[0] for m in modes[0]] == [m.split(":")[0] for m in modes[1]]


def test_condensed(tmp_path, figures):
    """Condensed bonds take sub-steps, too: a pair that is lifted, whose other grain is free and weighs. It is activated and breaks, as in short steps."""
    text = (ROOT / "examples" / "two_clocks" / "in.two_clocks").read_text()
    peak = {}
    for word, step in (("auto", "4e-7"), ("no", "5e-8")):
        result = launch(
            edit(text, "subcycle ${substeps}", f"condense yes subcycle {word}"),
            tmp_path,
            name=f"in.{word}",
            arguments=["-var", "side", "2", "-var", "step", step, "-var", "time", "4e-5", "-var", "rows", "100"],
        )
        assert result.status == 0 and not result.errors(), result.output[-2000:]
        rows = [line.split(",") for line in (tmp_path / "bond.csv").read_text().splitlines()]
        tension, mode = (rows[0].index(name) for name in ("tension", "mode"))
        peak[word] = max(float(row[tension]) for row in rows[1:])
        assert rows[-1][mode] == "debonding"
    figures.below("peak, against short steps", abs(peak["auto"] / peak["no"] - 1), 5e-3)


def test_ranks(tmp_path):
    tables = {n: run(breaking(10) + thermo(10, ["f_bond", "f_cem[2]", "f_cem[19]"]) + "run 600\n", tmp_path / str(n), n).table() for n in (1, 2, 4)}
    for n in (2, 4):
        for name in ("f_cem[2]", "f_cem[19]"):
            assert (tables[n][name] == tables[1][name]).all(), (n, name)
        assert tables[n]["f_bond"] == pytest.approx(tables[1]["f_bond"], abs=1e-6 * tables[1]["f_bond"].max())


def flying(n, word=None):
    """A free pair that spins; it oscillates as its cement pulls it around. With a contact that presses on it."""
    text = pair(2e-4, cement="outer 1.5e-3 inner 0.3e-3", half_box=(0.02, 0.02, 0.02))
    return edit(text, "density 2500", "density 250") + CONTACT + cement(4e-4, n * 1.6e-8, damage=f"subcycle {word or n}") + SPINNING


def test_flight(tmp_path, figures):
    """Momentum to rounding, angular momentum as well as the positions of grains that oscillate are known; energy of grains and cement."""
    found = {}
    for n in (1, 8):
        energy = "compute k grains reduce sum v_kin\nvariable E equal c_k+f_cem[5]+f_cem\n"
        kin = 'variable kin atom "0.5*mass*(vx^2+vy^2+vz^2)+0.2*mass*0.005^2*(omegax^2+omegay^2+omegaz^2)"\n'
        text = edit(flying(n), "velocity     all set", kin + "velocity     all set") + MOMENTA + energy
        text = text.replace(CONTACT, "")
        found[n] = run(text + thermo(80 // n, MOMENTUM_COLUMNS + ["v_E", "f_bond"]) + f"run {16000 // n}\n", tmp_path / str(n)).table()
    for n, t in found.items():
        P = np.array([t[c] for c in MOMENTUM_COLUMNS])
        drift = np.abs(P - P[:, :1]).max(axis=1) / np.repeat([np.linalg.norm(P[:3, 0]), np.linalg.norm(P[3:, 0])], 3)
        figures.below(f"{n}: drift of momentum", drift[:3].max(), 1e-12)
        figures.below(f"{n}: drift of angular momentum", drift[3:].max(), 1e-13)
        figures.below(f"{n}: drift of energy", np.abs(t["v_E"] / t["v_E"][0] - 1).max(), 1e-4)
    assert found[8]["f_bond"][:50] == pytest.approx(found[1]["f_bond"][:50], abs=1e-4 * np.abs(found[1]["f_bond"]).max())


@pytest.mark.parametrize("at", [60, 110])
def test_restart(at, tmp_path):
    """Of free grains that oscillate on the cement and a contact: bitwise identical."""
    columns = ["f_bond", "f_cem[5]", "f_cem[6]", "f_cem[7]"]
    script = flying(8)
    whole = run(script + thermo(10, columns) + f"run {at}\nwrite_restart r\nrun 200\n", tmp_path, 2).table()
    fixes = CONTACT + cement(4e-4, 8 * 1.6e-8, damage="subcycle 8") + "fix          motion grains nve/sphere\n"
    again = run(restarted("r") + fixes + thermo(10, columns) + "run 200\n", tmp_path, 2, name="in.again").table()
    rows = len(again["step"])
    for name in columns:
        assert (whole[name][-rows:] == again[name]).all(), name


def test_auto(tmp_path, figures):
    """LIGGGHTS takes a step of the grains, the cement as many as it needs."""
    text = edit(flying(1, word="auto"), "subcycle auto", "subcycle auto timestep auto 0.5").replace(CONTACT, "").replace("density 250", "density 2500")
    result = run(
        text
        + "thermo_style custom step dt f_cem[25]\nthermo 10\n"
        + 'variable d equal dt\nvariable n equal f_cem[25]\nrun 10\nprint "dt ${d}"\nprint "n ${n}"\n',
        tmp_path,
    )
    dt, n = result.value("dt"), result.value("n")
    assert 4 < n < 50 and 3e-8 < dt / n < 7.5e-8, (dt, n)
    assert f"subcycle auto: {n:.0f} sub-steps" in result.output


def test_auto_while_cement_softens(tmp_path, figures):
    """Damage leaves a longer stable step behind, but sub-steps stay as long as they were: a run in parts keeps its energy balance, and goes on bitwise from a file."""
    fixes = (
        cement(4e-4, 2.1e-7, damage="damage mazars kappa0 3e-4 At 0.95 Bt 2e3 regularization nonlocal 4e-4 subcycle auto")
        + "variable t equal step*dt\nvariable z equal 1e3*v_t*v_t\nvariable w equal 2e3*v_t\n"
        + "fix hold first move linear 0 0 0\nfix pull second move variable NULL NULL v_z NULL NULL v_w\n"
        + thermo(10, ["f_bond", "f_bond[18]", "f_cem[25]", "f_cem[5]", "f_cem[9]", "f_cem[12]"])
    )
    whole = run(pair(2e-4, gap=4e-4, half_box=(8e-3, 8e-3, 1.4e-2), cement="outer 1.5e-3") + fixes + "run 140\nwrite_restart r\nrun 60\n", tmp_path).table()
    again = run(restarted("r") + fixes + "run 60\n", tmp_path, name="in.again").table()
    rows = len(again["step"])
    assert whole["f_bond[18]"][-rows] > 50 and len(set(whole["f_cem[25]"])) == 1
    for name in again:
        assert (whole[name][-rows:] == again[name]).all(), name
    figures.below("softening with subcycle auto: imbalance of the energy", abs(whole["f_cem[12]"]).max(), 1e-4)


@pytest.mark.parametrize("ratio, n", [(0.1, 1), (0.1, 3), (1, 2), (100, 5)])
def test_free_pairs(ratio, n, tmp_path, figures):
    """Grains lighter and heavier than their cement, in sub-steps of 0.9 of its limit. Links to both grains share nodes here and add 4500 times the mass of the
    cement to light grains, whose accelerations take thousands of sweeps. More: tests/verification/subcycle_free_pairs.py."""
    sys.path.insert(0, str(ROOT / "tests" / "verification"))
    from subcycle_free_pairs import limits, swings

    density, sub, _ = limits(tmp_path, ratio)
    last, largest = swings(tmp_path / "run", density, n, 0.9 * sub, 2000)
    figures.below(f"grains of {ratio} times the mass of the cement, {n} sub-steps: energy of the last tenth over the first, less 1", abs(last - 1), 0.02)
    figures.below(f"grains of {ratio} times the mass of the cement, {n} sub-steps: largest energy over the first, less 1", largest - 1, 0.1)


def test_check_of_the_step(tmp_path, figures):
    """fix check/timestep/mpm with sub-steps: grains on their bonds limit the step, too. That of a free pair against its stiffness, as the command tells it."""
    text = (
        edit(flying(1, word=12), "timestep     1.6e-08", "timestep     4e-7").replace(CONTACT, "")
        + "bond_stiffness k.csv\nfix ts all check/timestep/mpm 5 cem 0.9\n"
    )
    result = run(text + thermo(5, ["f_ts[1]", "f_ts[2]"]) + "run 5\n", tmp_path)
    names, row = (line.split(",") for line in (tmp_path / "k.csv").read_text().splitlines())
    K = np.array([[float(row[names.index(f"k{min(i, j)}{max(i, j)}")]) for j in range(1, 7)] for i in range(1, 7)])
    # motions of both grains about their centres to that of the middle, as symmetric as the pair is
    arm, mass = 5e-3, 250 * 4 / 3 * np.pi * 5e-3**3
    x, y = (np.array([[0, -z, 0], [z, 0, 0], [0, 0, 0]]) for z in (arm, -arm))  # omega x (0, 0, z) is [-z e_y, z e_x]
    to = [np.block([[sign * np.eye(3), sign * m.T], [np.zeros((3, 3)), sign * np.eye(3)]]) for sign, m in ((-1, x), (1, y))]
    H = np.hstack(to)
    M = np.diag(2 * (3 * [mass] + 3 * [0.4 * mass * 25e-6]))
    largest = np.linalg.eigvals(np.linalg.solve(M, H.T @ K @ H)).real.max()
    t = result.table()
    short = 1 - t["f_ts[2]"][0] / (2 / largest**0.5)  # of both grains together it is a bound
    assert short > -1e-6, short
    figures.below("limit of a free pair, below 2 over its largest frequency by", short, 0.015)
    assert t["f_ts[1]"][0] == pytest.approx(4e-7 / t["f_ts[2]"][0])
    warned = [line for line in result.output.splitlines() if "check/timestep/mpm" in line and "of grains on their bonds" in line]
    assert len(warned) >= 1, result.output[-2000:]


def test_example(tmp_path, figures):
    """Loose beads around a pair that is lifted, free to fall, in contact: as in short steps."""
    script = (ROOT / "examples" / "two_clocks" / "in.two_clocks").read_text()
    peak, lines = {}, {}
    for word, step in (("auto", "4e-7"), ("no", "5e-8")):
        result = launch(
            script,
            tmp_path,
            name=f"in.{word}",
            arguments=["-var", "side", "4", "-var", "step", step, "-var", "substeps", word, "-var", "time", "4e-5", "-var", "rows", "100"],
        )
        assert result.status == 0 and not result.errors(), result.output[-2000:]
        rows = [line.split(",") for line in (tmp_path / "bond.csv").read_text().splitlines()]
        at = rows[0].index("tension")
        peak[word] = max(float(row[at]) for row in rows[1:])
        lines[word] = [line.split(":")[2].split(",")[0] for line in result.output.splitlines() if ": bond 1 of grains" in line]
    figures.below("peak of the force", abs(peak["auto"] / peak["no"] - 1), 5e-3)
    assert lines["auto"] == lines["no"] and len(lines["no"]) == 1, lines


def test_stability(figures):
    """Of the method itself. Without a contact, and with one at a fifth of the limit, nothing grows; with one at the limit what the page says. Means with weights that
    are found in each step feed no energy into an oscillation, either."""
    sys.path.insert(0, str(ROOT / "tests" / "verification"))
    from subcycle_stability import RATIOS, Scene, growth, swings

    most = swings([Scene(ratio, steps, share) for ratio, steps in ((10, 12), (100, 5), (1000, 17)) for share in (0.9, 0.5)], 10000).max()
    figures.below("speed of grains after 5000 steps over that of the first 1000", most, 1.3)
    steps = np.linspace(1, 40, 40)
    for share in (0, 0.2):
        found = [g for g in (growth(ratio, r, share, "spread") for ratio in RATIOS for r in steps) if g is not None]
        assert len(found) > 70
        figures.below(f"growth a step, contact at {share} of the limit", max(found), 1e-5)
    for how, least, most in (("spread", 0, 2), ("shared", 0, 2), ("grains alone", 1, 15), ("held", 130, 145)):
        found = [g for g in (growth(ratio, r, 0.9, how) for ratio in (10, 100, 1000, 10000) for r in steps) if g is not None]
        figures.note(f"contact at 0.9 of the limit, {how}", f"{sum(g > 1e-5 for g in found)} of {len(found)} grow")
        assert least <= sum(g > 1e-5 for g in found) <= most


BAD = {
    "many": ("subcycle 8", "subcycle 1001", ["fix mpm (id cem)", "'subcycle 1001'", "from 1 to 1000", "'auto'"]),
    "none": ("subcycle 8", "subcycle 0", ["fix mpm (id cem)", "subcycle", "0"]),
    "a word": ("subcycle 8", "subcycle yes", ["fix mpm (id cem)", "subcycle", "yes"]),
    "a long step": ("timestep     1.28e-07", "timestep     1e-06", ["fix mpm (id cem)", "1e-06 exceeds the stable step", "of 8 sub-steps", "use 'timestep"]),
    "a long step, by itself": ("timestep     1.28e-07", "timestep     1e-03", ["fix mpm (id cem)", "'subcycle auto'", "at most 1000", "use 'timestep"]),
    "updated": ("subcycle 8", "subcycle 8 kinematics updated", ["fix mpm (id cem)", "'subcycle 8' does not go with 'kinematics updated'", "'subcycle no'"]),
    "another integrator": (
        "motion grains nve/sphere",
        "motion grains nve/limit radius_ratio 0.1",
        ["fix mpm/couple (id bond)", "nve/limit", "'subcycle'", "nve/sphere"],
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_message(name, tmp_path):
    old, new, needed = BAD[name]
    text = edit(flying(8) + "run 10\n", old, new)
    if "itself" in name:
        text = edit(text, "subcycle 8", "subcycle auto")
    result = launch(text, tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    missing = [word for word in needed if word not in result.errors()[0]]
    assert not missing, result.errors()[0]
