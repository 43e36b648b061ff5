# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/mpdem_plot.py says of each bond what the table of fix mpm/couple says: state, mode, sign of load and displacement."""
import csv
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import launch

ROOT = Path(__file__).parents[2]
PLOT = ["/usr/bin/python3", ROOT / "tools" / "mpdem_plot.py"]
HEADER = (
    "step,time,bond,grain1,grain2,fx1,fy1,fz1,mx1,my1,mz1,fx2,fy2,fz2,mx2,my2,mz2,gap,tension,points,attached,debonded,"
    "failed,largest_damage,mean_damage,peak_tension,separated,share_grain1,share_grain2,elastic_energy,kinetic_energy,"
    "coupling_energy,dissipated_energy,released_energy,damped_energy,external_work,energy_imbalance,mode"
).split(",")
N, EVERY = 41, 100
# The last 500 steps, over which the plot tool averages, carry nothing where `end` is 0.
BONDS = {
    1: dict(what="carries nothing, holds", sign=1, end=0.0, way=1e-6, separated=None, mode="intact", shares=(0, 0)),
    2: dict(what="separated under load", sign=1, end=0.5, way=1e-6, separated=30, mode="mixed", shares=(0.25, 0.5)),
    3: dict(what="crushed", sign=-1, end=0.2, way=-7e-9, separated=25, mode="debonding", shares=(1, 0)),
    4: dict(what="pressed, holds", sign=-1, end=1.0, way=-2e-6, separated=None, mode="intact", shares=(0, 0)),
    5: dict(what="never loaded", sign=0, end=0.0, way=0.0, separated=None, mode="intact", shares=(0, 0)),
}
PEAK = 20.0


def load(bond, row):
    """Up to the peak in the middle, then to `end` within five rows."""
    rising = row / (N // 2)
    return bond["sign"] * PEAK * (rising if rising <= 1 else max(bond["end"], 1 - (row - N // 2) / 5))


@pytest.fixture
def table(tmp_path):
    with open(tmp_path / "bond.csv", "w", newline="") as f:
        out = csv.DictWriter(f, HEADER, restval=0)
        out.writeheader()
        for row in range(N):
            for number, b in BONDS.items():
                apart = b["separated"] is not None and row >= b["separated"]
                out.writerow(
                    {
                        "step": EVERY * row,
                        "time": 1e-8 * EVERY * row,
                        "bond": number,
                        "grain1": number,
                        "grain2": number + 1,
                        "gap": 1e-5 + b["way"] * row / (N - 1),
                        "tension": load(b, row),
                        "fz1": load(b, row),
                        "points": 100,
                        "attached": 50,
                        "peak_tension": max(0, *(load(b, r) for r in range(row + 1))) if row else 0,
                        "separated": int(apart),
                        "share_grain1": b["shares"][0] * apart,
                        "share_grain2": b["shares"][1] * apart,
                        "mode": b["mode"] if apart else "intact",
                    }
                )
    return tmp_path


def plot(folder, *words):
    done = subprocess.run([*PLOT, folder, "--points", "none", *map(str, words)], capture_output=True, text=True)
    with open(folder / "summary.csv") as f:
        return done, {int(r["bond"]): r for r in csv.DictReader(f)}


def test_state_is_that_of_the_table(table):
    """A bond is separated where the table says so, whatever it carries, by the mode of the table."""
    done, summary = plot(table)
    assert done.returncode == 0, done.stderr
    assert "all bonds                    2 of 5 separated (1 debonding, 0 internal, 1 mixed)" in done.stdout
    for number, b in BONDS.items():
        row = summary[number]
        assert (row["separated"], row["mode"]) == ("no" if b["separated"] is None else "yes", b["mode"]), b["what"]
        assert row["step_of_separation"] == ("" if b["separated"] is None else str(EVERY * b["separated"])), b["what"]
        assert float(row["peak_force_N"]) == pytest.approx(PEAK * abs(b["sign"])), b["what"]
        assert row["sense"] == ("compression" if b["sign"] < 0 else "tension"), b["what"]
        if b["separated"] is not None:
            assert float(row["opening_at_separation_m"]) == pytest.approx(b["way"] * b["separated"] / (N - 1))


@pytest.mark.parametrize(
    "which, lines",
    [
        (1, ["state                        not separated", "load left                    0 % of the peak (lowest mean tension of 500 steps"]),
        (
            2,
            [
                "state                        separated, mixed: 25 % at the first grain, 50 % at the second, 25 % inside",
                "displacement at failure      gap opened by 0.75 um (step 3000, the first row in which the bond is separated)",
            ],
        ),
        (
            3,
            [
                "peak force                   20 N (compression)",
                "stiffness                    5.714e+09 N/m",
                "displacement at failure      gap closed by 0.004375 um (step 2500",
            ],
        ),
        (4, ["displacement at peak         gap closed by 1 um", "load left                    100 % of the peak (lowest mean compression"]),
    ],
)
def test_words(table, which, lines):
    """Signs are told in words: a gap opens or closes, a load is tension or compression."""
    done, _ = plot(table, "--which", which)
    assert done.returncode == 0, done.stderr
    for line in lines:
        assert "  " + line in done.stdout, done.stdout
    assert not re.search(r"-\d", done.stdout.split("state")[0].split("\n", 1)[1])
    assert (table / "force_displacement.png").stat().st_size > 1000


def test_never_loaded(table):
    done, _ = plot(table, "--which", 5)
    assert done.returncode != 0 and "bond 5 was never loaded, nothing to draw" in done.stderr


def test_bad_mode(table):
    text = (table / "bond.csv").read_text()
    (table / "bond.csv").write_text(text.replace("debonding", "debond"))
    done = subprocess.run([*PLOT, table], capture_output=True, text=True)
    assert done.returncode != 0 and "mode 'debond' is none of debonding, internal, mixed, intact" in done.stderr


@pytest.mark.parametrize("which", [1, 2, 3, 4])
def test_curve_is_drawn_whole(table, which, monkeypatch):
    """No row of the table is outside of the axes, in compression as in tension."""
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    from mpdem import figures, run, summary

    bond = run.choose(run.read_bonds(str(table / "bond.csv")), which)
    fig = figures.force_displacement(bond, summary.measure(bond, 500), [])
    ax = fig.axes[0]
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    x, y = ax.get_lines()[0].get_data()
    assert len(x) == N and left <= x.min() and x.max() <= right and low < y.min() and y.max() < high
    star = next(line for line in ax.get_lines() if line.get_marker() == "*")
    assert star.get_ydata()[0] == pytest.approx(BONDS[which]["sign"] * PEAK)
    figures.plt.close(fig)


def test_packing(tmp_path, as_installed):
    """The packing of the example in short form, upper layer drawn off or pushed on: summary and table agree bond by bond."""
    script = (ROOT / "examples" / "packing" / "in.packing").read_text()
    for name, speed in (("pulled", "6"), ("pressed", "-6")):
        result = launch(
            script, tmp_path / name, name="in.packing", arguments=["-var", "side", "2", "-var", "steps", "700", "-var", "record", "20", "-var", "speed", speed]
        )
        assert result.status == 0 and not result.errors(), result.output[-3000:]
        with open(tmp_path / name / "bond.csv") as f:
            rows = list(csv.DictReader(f))
        last = {int(r["bond"]): r for r in rows}
        separated = {n for n, r in last.items() if float(r["separated"]) > 0}
        assert 0 < len(separated) < len(last) == 12
        done, summary = plot(tmp_path / name, "--which", min(separated))
        assert done.returncode == 0, done.stderr
        assert {n for n, r in summary.items() if r["separated"] == "yes"} == separated
        assert all(summary[n]["mode"] == last[n]["mode"] for n in last)
        # the end of the run says the same
        told = dict(re.findall(r"^fix mpm \(id cem\): bond (\d+) of grains \d+ and \d+: (\w+),", result.output, re.M))
        assert {int(n): mode for n, mode in told.items() if mode != "intact"} == {n: last[n]["mode"] for n in separated}
        for n in separated:
            largest = max((float(r["tension"]) for r in rows if int(r["bond"]) == n), key=abs)
            assert summary[n]["sense"] == ("tension" if speed == "6" else "compression") == ("tension" if largest > 0 else "compression")
            assert float(summary[n]["peak_force_N"]) >= abs(largest) * (1 - 1e-7)
            assert (float(summary[n]["opening_at_separation_m"]) > 0) == (speed == "6")


def test_figure_of_a_table(monkeypatch):
    """Legends are words with units, whatever is varied, and the measured strengths are drawn where they belong."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    from mpdem import table, table_figure

    of_output = {"record", "chunk", "limit", "frames"}
    assert set(table.VARIABLES) | set(table.OWN) == set(table_figure.WORDS) | of_output
    told = table_figure.text_of(
        table.Run(
            "flat",
            "mixed",
            0.05,
            {"gap": "1e-4", "regularization": "crackband 4", "speed": "0.04", "rate": "1e7", "ramp": "1e-5", "B0": "9.6e3", "inner": "auto"},
        )
    )
    assert told == "crack energy 4 J/m², threshold 9.6 kPa, beads 0.1 mm apart, 40 mm/s, speed reached in 10 µs, 10 N/µs"
    for name in ("study_strength.csv", "study_checks.csv"):
        rows = table_figure.read(ROOT / "doc" / "data" / name)
        fig = table_figure.draw(rows)
        words = [t.get_text() for legend in fig.legends for t in legend.get_texts()]
        assert words and not any("=" in w or "_" in w or "crackband" in w for w in words), words
        for ax in fig.axes:
            measured = [line.get_ydata()[0] for line in ax.get_lines() if line.get_color() == table_figure.HAM_COLOUR]
            assert measured == list(table_figure.HAM.get(ax.get_title(loc="left"), [])), ax.get_title(loc="left")
        if name == "study_strength.csv":
            assert table_figure.HAM == {"tension": (35, 8), "shear": (13, 7)}
            assert len(fig.axes) == 2 and len(rows) == 48
        table_figure.plt.close(fig)


def test_map_of_modes(tmp_path):
    """One mark a run at its content and strength of the interface; runs without a cohesive interface are left out."""
    sys.path.insert(0, str(ROOT / "tools"))
    from mpdem import mode_map, table_figure

    law = "bonding=cohesive:tn:{0:g}:tt:{0:g}:Gn:{1:g}:Gt:{1:g}"
    strengths, contents = (1e6, 4e6, 1e7), (0.01, 0.17, 0.25)
    lines = ["shape,load,content,stress_grain,mode,share_grain1,share_grain2,parameters", "flat,tension,0.01,2e5,mixed,0.5,0,"]
    lines += [
        f"flat,{load},{c},1e5,{mode},{share},0.1,{law.format(t, G)}"
        for load in ("tension", "shear")
        for c in contents
        for t, mode, share in zip(strengths, ("debonding", "mixed", "intact"), (0.9, 0.4, 0.0))
        for G in (10, 1)
    ]
    (tmp_path / "table.csv").write_text("\n".join(lines) + "\n")
    rows = table_figure.read(tmp_path / "table.csv")
    assert mode_map.wanted(rows) and not mode_map.wanted(rows[:2])
    assert abs(mode_map.cement_strength(9.6e3) / 19.77e6 - 1) < 1e-3
    fig = mode_map.figure(rows)
    try:
        for ax in fig.axes[:2]:
            assert ax.get_title(loc="left") in ("flat ring, tension", "flat ring, shear")
            filled = np.concatenate([c.get_offsets() for c in ax.collections if len(c.get_offsets())])
            crosses = np.concatenate([line.get_xydata() for line in ax.get_lines() if line.get_marker() == "x"])
            expected = {(round(i + d, 6), round(t / mode_map.cement_strength(9.6e3), 6)) for i in range(3) for d in (-0.14, 0.14) for t in strengths}
            assert {(round(x, 6), round(y, 6)) for x, y in [*filled, *crosses]} == expected
            assert len(crosses) == 6 and len(filled) == 12
            shares = np.sort(np.concatenate([c.get_array() for c in ax.collections if len(c.get_offsets())]))
            assert np.allclose(shares, [0.5] * 6 + [1.0] * 6)
            seen = [t.get_text() for t in ax.texts]
            assert seen == ["debonding", "debonding,\nmixed", "internal,\nmixed"]
    finally:
        mode_map.plt.close(fig)


@pytest.mark.parametrize(
    "text",
    [
        "shape,load\nflat,tension\n",
        "",
        "a,b\n",
        "a,b\n1,2\n",
        "shape,load,content,parameters,stress_grain,mode,share_grain1,share_grain2\n",
        "shape,load,content,parameters,stress_grain,mode,share_grain1,share_grain2\nflat,tension\n",
    ],
)
def test_redraw_bad_table(tmp_path, text):
    (tmp_path / "table.csv").write_text(text)
    done = subprocess.run(["/usr/bin/python3", ROOT / "tools" / "pair_table.py", tmp_path, "--redraw", tmp_path / "table.csv"], capture_output=True, text=True)
    assert done.returncode == 1 and "not a table.csv of pair_table.py" in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr


def test_residue():
    """Failed points that are still bonded to a grain are its residue; those inside, or debonded, are not."""
    sys.path.insert(0, str(ROOT / "tools"))
    from mpdem.interface import residue

    first = {"id": np.array([1, 2, 3, 4]), "c_attached": np.array([1, 1, 1, 0]), "c_grain": np.array([7, 7, 8, 0])}
    events = {"point": np.array([1, 2, 3, 4]), "grain": np.array([0, 7, 0, 0])}
    assert residue(events, first, 7).tolist() == [True, False, False, False]
    assert residue(events, first, 8).tolist() == [False, False, True, False]
