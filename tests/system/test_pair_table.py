# SPDX-License-Identifier: GPL-2.0-or-later
"""examples/pair_table and its driver: every load against a closed form or another load, resuming, bad arguments."""
import csv
import json
import math
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from scenes import PATIENCE, CALCITE, RADIUS, executable, launch

pytestmark = pytest.mark.usefixtures("as_installed")  # mpirun lets interrupted runs end

ROOT = Path(__file__).parents[2]
PYTHON = "/usr/bin/python3"
SCRIPT = ROOT / "examples" / "pair_table" / "in.pair_table"


def loaded(directory, **variables):
    """A coarse pair; the rows of its table by column, and the RESULT line by word."""
    variables = {"content": 0.01, "spacing": 1.5e-4, "inner": "auto", "frames": 10**8, **variables}
    words = [w for k, v in variables.items() for w in ("-var", k, str(v))]
    result = launch(SCRIPT.read_text(), directory, name="in.pair_table", arguments=words)
    assert result.status == 0 and not result.errors(), result.output[-3000:]
    with open(directory / "load_run.csv") as f:
        rows = list(csv.DictReader(f))
    line = next(w for w in result.output.splitlines() if w.startswith("RESULT ")).split()
    return {c: np.array([float(r[c]) for r in rows]) for c in rows[0]}, dict(zip(line[1::2], line[2::2])), result


def stiffness(table):
    """Load over displacement while the rate is constant and nothing is damaged."""
    late = slice(len(table["way"]) // 2, None)
    return np.polyfit(table["way"][late] / table["way"][-1], table["load"][late], 1)[0] / table["way"][-1]


def ring(integrand):
    """Integral over the ring of integrand(r, height of the gap, its slope), cement between two spheres that touch."""
    inner, outer = math.sqrt(RADIUS**2 - (RADIUS - 1.5e-4) ** 2), 2.37197e-3
    r = np.linspace(inner, outer, 20001)
    root = np.sqrt(RADIUS**2 - r**2)
    y = 2 * math.pi * r * integrand(r, 2 * (RADIUS - root), 2 * r / root)
    return float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(r)))


def test_rotation_loads(tmp_path, figures):
    """omega and the position of the upper bead belong together, and both reach the coupling.

    Torsion of the ring with the axis of elasticity along z lies between two bounds: columns that slide past each
    other freely, G r^2 / H each, and columns sheared evenly, where the slope of the height H adds the work of
    G' = Ep / 2(1 + nu_p). Bending pulls one side and presses the other: its stiffness over that of tension is
    about that of the integrals of r^2 / 2 H and of 1 / H.
    """
    elastic = {"B0": 1e12, "limit": 1200, "speed": 0.01, "axis": "global 0 0 1"}
    k = {load: stiffness(loaded(tmp_path / load, load=load, **elastic)[0]) for load in ("tension", "torsion", "bending")}
    G, across = CALCITE[4], CALCITE[0] / 2 / (1 + CALCITE[2])
    low = ring(lambda r, H, slope: G * r**2 / H)
    high = low + ring(lambda r, H, slope: across * r**2 * slope**2 / 12 / H)
    figures.note("torsion: stiffness between its bounds", f"{low:.4g} {k['torsion']:.4g} {high:.4g} N m/rad")
    figures.below("torsion: lower bound over stiffness, less 1", low / k["torsion"] - 1, 0.015)  # the springs of the links
    figures.below("torsion: stiffness over upper bound, less 1", k["torsion"] / high - 1, 0.0)
    ratio = ring(lambda r, H, slope: r**2 / 2 / H) / ring(lambda r, H, slope: 1 / H)
    figures.below("bending over tension against the thin ring", abs(k["bending"] / k["tension"] / ratio - 1), 0.05)
    back = stiffness(loaded(tmp_path / "back", load="torsion", **{**elastic, "speed": -0.01})[0])
    figures.below("torsion the other way", abs(back / k["torsion"] - 1), 1e-3)


def test_motion_is_smooth(tmp_path, figures):
    """Neither the displacement nor its first two derivatives jump, in any load that is driven."""
    for load in ("tension", "bending", "mixed"):
        table, _, _ = loaded(tmp_path / load, load=load, record=1, chunk=100, limit=700, B0=1e12)
        speed = np.diff(table["way"]) / np.diff(table["time"])
        jump = np.abs(np.diff(speed)).max() / speed.max()
        # the steepest piece of the ramp, a step long
        figures.below(f"{load}: largest change of speed in a step over that of the ramp", jump / (0.5 * math.pi * np.diff(table["time"])[0] / 1e-5), 1.01)
        assert speed[0] < 1e-4 * speed.max()


@pytest.mark.parametrize("shape", ["flat", "meniscus", "coating+meniscus"])
def test_each_shape_breaks(shape, tmp_path):
    spacing = {"flat": 2e-4, "meniscus": 2e-4, "coating+meniscus": 7e-5}[shape]
    content = 0.1 if shape == "coating+meniscus" else 0.01
    _, result, _ = loaded(tmp_path, shape=shape, content=content, spacing=spacing, share=0.9, speed=0.1, chunk=50)
    assert float(result["peak"]) > 0 and float(result["broken"]) == 1
    assert result["mode"] in ("internal", "debonding", "mixed")


def test_force_and_displacement(tmp_path, figures):
    """A bead pulled by a growing force breaks at the force at which one that is moved does; compression of the
    symmetric law is tension with the other sign."""
    peak = {}
    for load in ("tension", "force", "compression"):
        table, result, done = loaded(tmp_path / load, load=load, speed=0.02, ramp=2e-5, rate=5e6)
        peak[load] = table["load"].max()
        assert float(result["broken"]) == 1
        most, mean = (float(v) for v in re.search(r"^PEAK of all steps (\S+), of the mean of 100 steps (\S+)$", done.output, re.M).groups())
        assert mean == float(result["peak"]) < most and peak[load] <= most * (1 + 1e-9) < 1.01 * peak[load]
    figures.below("peak under force control against motion", abs(peak["force"] / peak["tension"] - 1), 0.06)
    figures.below("compression against tension", abs(peak["compression"] / peak["tension"] - 1), 0.02)


@pytest.mark.parametrize(
    "word, value, expected",
    [
        ("shape", "flt", "-var shape: must be flat, meniscus"),
        ("load", "tensoin", "-var load: must be tension"),
        ("content", "-1", "-var content: must lie in"),
        ("speed", "0", "-var speed: must not be 0"),
        ("diameter", "1", "-var diameter: must lie in"),
        ("limit", "3", "-var limit: must be at least"),
        ("regularization", "crackbnd", "must be one of none, crackband"),
    ],
)
def test_variables_of_the_script(word, value, expected, tmp_path):
    result = launch(SCRIPT.read_text(), tmp_path, name="in.pair_table", arguments=["-var", word, value])
    assert result.status != 0 and len(result.errors()) == 1
    assert expected in result.errors()[0]
    assert value in result.output


def table_command(out, *more):
    return [
        PYTHON,
        str(ROOT / "tools" / "pair_table.py"),
        str(out),
        "--exe",
        executable(),
        "--set",
        "coarse=2.5e-4",
        "--shapes",
        "flat,meniscus",
        "--loads",
        "tension,torsion",
        "--contents",
        "0.01",
        "--jobs",
        "1",
        *more,
    ]


def running_in(folder):
    """Processes whose working directory is in the folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*/cwd"):
        try:
            if str(folder) in os.readlink(process):
                found.append(process.parent.name)
        except (FileNotFoundError, PermissionError):
            pass
    return found


def test_table_is_resumed(tmp_path):
    """Stopped in the middle, the driver leaves nothing running, keeps what was finished and does the rest."""
    out = tmp_path / "out"
    first = subprocess.Popen(table_command(out), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.time() + 120 * PATIENCE
    while not list(out.glob("*/done.json")) and time.time() < deadline:
        time.sleep(0.05)
    os.kill(first.pid, signal.SIGTERM)
    _, error = first.communicate(timeout=60 * PATIENCE)
    assert first.returncode != 0 and "goes on from here" in error
    done = {p: p.stat().st_mtime_ns for p in out.glob("*/done.json")}
    assert 1 <= len(done) < 4
    deadline = time.time() + 20 * PATIENCE  # Open MPI's daemon of a run follows it in its own time
    while running_in(out) and time.time() < deadline:
        time.sleep(0.1)
    assert not running_in(out)

    second = subprocess.run(table_command(out), capture_output=True, text=True, timeout=280 * PATIENCE)
    assert second.returncode == 0, second.stderr
    assert f"{len(done)} finished before, {4 - len(done)} to do" in second.stdout
    assert all(p.stat().st_mtime_ns == t for p, t in done.items())
    with open(out / "table.csv") as f:
        rows = list(csv.DictReader(f))
    assert len(rows) == 4 and {(r["shape"], r["load"]) for r in rows} == {(s, l) for s in ("flat", "meniscus") for l in ("tension", "torsion")}
    for row in rows:
        peak, energy = float(row["peak"]), float(row["energy"])
        assert peak > (10 if row["load"] == "tension" else 0.1) and energy > 0 and row["mode"] in ("internal", "debonding", "mixed")
        assert row["left"] == row["mode_ahead"] == ""
        # the work done on the bond is what damage and failure took, the rest is in the pieces
        assert 0.3 * energy < float(row["dissipated"]) < energy
    assert (out / "table.png").stat().st_size > 1000

    third = subprocess.run(table_command(out), capture_output=True, text=True, timeout=100 * PATIENCE)
    assert "4 finished before, 0 to do" in third.stdout


@pytest.mark.parametrize(
    "words, expected",
    [
        (["--shapes", "flt"], "shape flt: must be one of flat"),
        (["--loads", "pull"], "load pull: must be one of tension"),
        (["--contents", "0.1,x"], "--contents 0.1,x: must be numbers"),
        (["--contents", "7"], "content 7: must lie in"),
        (["--set", "spede=1"], "spede: no variable of the table"),
        (["--set", "speed"], "--set speed: must be NAME=VALUE"),
        (["--vary", "refine=0"], "refine 0: must be a positive number"),
        (["--table", "none.json"], "none.json: No such file"),
        (["--exe", "/nowhere/x"], "/nowhere/x: no such executable"),
    ],
)
def test_arguments_of_the_driver(words, expected, tmp_path):
    result = subprocess.run(
        [PYTHON, ROOT / "tools" / "pair_table.py", tmp_path / "out", "--exe", executable(), *words], capture_output=True, text=True, timeout=60 * PATIENCE
    )
    assert result.returncode != 0 and expected in result.stderr and len(result.stderr.strip().splitlines()) == 1
    assert not list((tmp_path).glob("out/*"))


def test_a_run_that_fails_is_named(tmp_path):
    """Too much cement for the shape: the message of create_cement comes through, other runs go on."""
    command = [
        PYTHON,
        ROOT / "tools" / "pair_table.py",
        tmp_path,
        "--exe",
        executable(),
        "--shapes",
        "flat",
        "--loads",
        "tension",
        "--contents",
        "0.01,0.5",
        "--set",
        "coarse=2.5e-4",
    ]
    result = subprocess.run(command, capture_output=True, text=True, timeout=200 * PATIENCE)
    assert result.returncode != 0 and "1 of 2 runs failed" in result.stderr and "does not fit" in result.stderr
    done = [json.loads(p.read_text()) for p in tmp_path.glob("*/done.json")]
    assert len(done) == 1 and done[0]["results"]["broken"]


def test_figures_of_a_load(tmp_path):
    """The plot tool follows the load, draws geometry and interface."""
    loaded(tmp_path, load="torsion", frames=200, spacing=2e-4)
    plot = subprocess.run([PYTHON, ROOT / "tools" / "mpdem_plot.py", tmp_path], capture_output=True, text=True)
    assert plot.returncode == 0, plot.stderr
    assert "peak moment" in plot.stdout and "N m/rad" in plot.stdout
    for picture in ("force_displacement.png", "damage_cut.png", "geometry.png", "interface.png"):
        assert (tmp_path / picture).stat().st_size > 1000


def test_points_of_a_file(tmp_path):
    """Shape file takes the points of another program: those of the shape itself break alike; a table of them needs the variable `points`."""
    script = ROOT / "examples" / "flawed_pair" / "in.solid"
    made = launch(script.read_text(), tmp_path, name="in.solid", arguments=["-var", "content", "0.01", "-var", "spacing", "2e-4"])
    assert made.status == 0 and (tmp_path / "solid.txt").exists()
    words = dict(inner=1e-3, film="grid", spacing=2e-4, limit=2000)
    shape, result, _ = loaded(tmp_path / "shape", **words)
    file, of_file, _ = loaded(tmp_path / "file", shape="file", points=tmp_path / "solid.txt", **words)
    peak = shape["load"].max()
    assert peak > 10 and float(of_file["broken"]) == float(result["broken"]) == 1 and of_file["mode"] == result["mode"]
    assert abs(file["load"].max() - peak) < 1e-6 * peak
    table = subprocess.run(
        [PYTHON, ROOT / "tools" / "pair_table.py", tmp_path / "out", "--exe", executable(), "--shapes", "file", "--loads", "tension"],
        capture_output=True,
        text=True,
        timeout=60 * PATIENCE,
    )
    assert table.returncode != 0 and "points FILE is for shape file" in table.stderr
    done = subprocess.run(
        [
            PYTHON,
            ROOT / "tools" / "pair_table.py",
            tmp_path / "out",
            "--exe",
            executable(),
            "--shapes",
            "file",
            "--loads",
            "tension",
            "--contents",
            "0.01",
            "--set",
            f"points={tmp_path / 'solid.txt'}",
            "--set",
            "coarse=2e-4",
        ],
        capture_output=True,
        text=True,
        timeout=60 * PATIENCE,
    )
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "out" / "table.csv") as f:
        rows = list(csv.DictReader(f))
    assert len(rows) == 1 and abs(float(rows[0]["peak"]) - peak) < 0.01 * peak and (tmp_path / "out" / "table.png").stat().st_size > 1000
