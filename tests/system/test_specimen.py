# SPDX-License-Identifier: GPL-2.0-or-later
"""examples/specimen in short form: beads poured, cemented after a restart, and loaded past the peak; without cement; in parts. Its pictures are
those that doc/howto_pictures.md shows."""
import csv
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import launch

FOLDER = Path(__file__).parents[2] / "examples" / "specimen"
BEADS = 40
FAST = {"cell": 5e-4, "speed": 0.2, "pull": 0.05, "ramp": 2e-5, "confine": 6e-5, "record": 20, "frames": 5}
HARMLESS = "Restart file used different # of processors"
TOO_FAST = "('kinetic_share')"  # in the warning of a load that is not quasi-static, which FAST is


def go(name, directory, ranks=1, **variables):
    words = [w for k, v in {"here": FOLDER, **variables}.items() for w in ("-var", k, str(v))]
    result = launch((FOLDER / name).read_text(), directory, ranks, name=name, arguments=words)
    assert result.status == 0 and not result.errors(), result.output[-3000:]
    warnings = [line for line in result.output.splitlines() if "WARNING" in line and HARMLESS not in line and TOO_FAST not in line]
    assert not warnings and result.output.count(TOO_FAST) < 2, warnings
    return result


def rows(directory, name="curve.csv"):
    with open(directory / name, newline="") as f:
        table = list(csv.DictReader(f))
    return {k: np.array([float(r[k]) for r in table]) for k in table[0]}


def last_rows(directory):
    with open(directory / "bond.csv", newline="") as f:
        return {int(r["bond"]): r for r in csv.DictReader(f)}.values()


@pytest.fixture(scope="module")
def poured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("poured")
    output = go("in.pour", folder, beads=BEADS, settle=0.08, press=0.03).output
    table = np.array([line.split()[:4] for line in output.splitlines() if re.fullmatch(r" +\d+( +[-+.e\d]+){4,5} *", line)], dtype=float)
    assert (table[2:, 2] == BEADS).all() and table[-1, 3] < 1e-2 * table[:, 3].max(), "all fell, and are at rest"
    return folder


@pytest.fixture(scope="module")
def cemented(poured):
    made = re.search(r"Cement at (\d+) contacts", go("in.cement", poured, spacing=2.5e-4).output)
    assert 40 < int(made[1]) < 90
    return poured


def load(cemented, directory, ranks=1, **variables):
    return go("in.load", directory, ranks, **{"poured": cemented, "cemented": cemented, **FAST, **variables})


def test_specimen(cemented, tmp_path, figures):
    """Compressed past the peak, on two ranks, with pictures."""
    result = load(cemented, tmp_path, 2, strain=0.003, beyond=1.5, pictures=25)
    assert TOO_FAST in result.output
    curve, last = rows(tmp_path), last_rows(tmp_path)
    points = sum(int(float(r["points"])) for r in last)
    told = float(re.search(r"^RESULT .* peak (\S+) ", result.output, re.M)[1])
    moves = curve["stage"] == 1
    figures.below("specimen: peak that is told against the largest row of curve.csv, over it, less 1", abs(told / curve["force"][moves].max() - 1), 1e-14)
    row = int(curve["force"].argmax())
    figures.note("specimen: peak force", f"{told:.4g} N at {1e6 * curve['way'][row]:.3g} um")
    assert told > 20 and 25 < row < len(curve["force"]) - 25 and curve["force"][-25:].mean() < 0.8 * told
    strains = [float(s) for s in re.findall(r"^PROGRESS strain (\S+)", result.output, re.M)]
    at = curve["way"][row] / curve["way"][-1] * strains[-1]
    assert len(strains) > 2 and (strains[-1] > 1.5 * at or curve["force"][-25:].mean() < 0.25 * told or strains[-1] > 0.003), "none of the ends was reached"
    figures.below("specimen: energy imbalance", abs(curve["imbalance"][1:]).max(), 0.015)

    apart = [r["mode"] for r in last if float(r["separated"]) > 0]
    (told,) = re.findall(r"^fix mpm \(id cem\): \d+ of (\d+) bonds have points that failed, .*: (.*)$", result.output, re.M)[-1:]
    modes = {mode: int(n) for n, mode in re.findall(r"(\d+) (\w+)", told[1])}
    assert int(told[0]) == len(last)
    # one more check follows the last row, at the end of a run
    assert 3 < curve["broken"][-1] <= sum(n for mode, n in modes.items() if mode != "intact") < 1.5 * curve["broken"][-1]
    assert len(apart) > 3 and set(apart) <= set(modes)
    with open(tmp_path / "events.csv") as f:
        assert curve["failed"][-1] <= len(list(csv.DictReader(f)))
    height = float(re.search(r"height index (\S+)", (cemented / "poured.in").read_text())[1])
    check_pictures(tmp_path, height, curve, points)


def check_pictures(folder, height, curve, points):
    """VTK reads what ParaView would, and finds in it what the text dumps for OVITO have."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOLegacy import vtkDataSetReader

    def of(file):
        reader = vtkDataSetReader()
        reader.SetFileName(str(file))
        reader.ReadAllScalarsOn()
        reader.ReadAllFieldsOn()
        reader.Update()
        data = reader.GetOutput()
        arrays = data.GetPointData()
        named = {arrays.GetArrayName(i): vtk_to_numpy(arrays.GetArray(i)) for i in range(arrays.GetNumberOfArrays())}
        return vtk_to_numpy(data.GetPoints().GetData()), named

    step = max(int(p.stem.split("_")[1]) for p in folder.glob("cement_[0-9]*.vtk"))
    assert step > curve["step"][0]
    for name, number, columns in (("beads", BEADS, {"id", "radius", "v"}), ("cement", points, {"id", "radius", "c_damage", "c_failed", "c_bond", "c_stress"})):
        place, arrays = of(folder / f"{name}_{step}.vtk")
        assert set(arrays) == columns and len(place) == number
        with open(folder / f"{name}_at.{step}.txt") as f:
            head = [next(f) for _ in range(9)]
            text = dict(zip(head[8].split()[2:], np.loadtxt(f).T))
        assert int(head[1]) == step and int(head[3]) == number
        here, there = np.argsort(arrays["id"]), np.argsort(text["id"])
        assert (arrays["id"][here] == text["id"][there]).all()
        # either has six digits, a unit of the last of which is 1e-7 m from 0.01 m on
        assert abs(place[here] - np.column_stack([text[c] for c in "xyz"])[there]).max() < 1.1e-7
        for column in columns & set(text) - {"id"}:
            assert np.allclose(arrays[column][here], text[column][there], rtol=1e-4, atol=1e-9), column
    assert arrays["c_failed"].sum() > 100 and 0 < arrays["c_damage"].max() <= 1
    plate, _ = of(folder / f"plate_{step}.vtk")
    way = np.interp(step, curve["step"], curve["way"])
    assert len(plate) == 3 and abs(plate[:, 2] - (height - way)).max() < 6e-8  # six digits


def test_first_failures_on_one_rank_and_two(cemented, tmp_path, figures):
    """The same points fail in the same order while only a few bonds have failed points."""
    failures = []
    for ranks in (1, 2):
        load(cemented, tmp_path / str(ranks), ranks, strain=5e-4)
        with open(tmp_path / str(ranks) / "events.csv") as f:
            failures.append([[int(r[c]) for c in ("step", "point", "bond", "grain")] for r in csv.DictReader(f)])
    one, two = failures
    assert len(one) >= 15 and len({bond for _, _, bond, _ in one}) >= 2
    same = next((i for i, (a, b) in enumerate(zip(one, two)) if a != b), min(len(one), len(two)))
    figures.note("specimen: first failures that are the same on one rank and two", f"{same} of {len(one)}")
    assert same >= 15


SLOW = {"speed": 0.007, "ramp": 2e-4, "record": 100, "strain": 6e-4}  # as the script has it


@pytest.mark.parametrize("inertia", [1, 30])
def test_warning_of_scaled_inertia(inertia, cemented, tmp_path, figures):
    """The load of the script is quasi-static. With inertia 30 times as large it is not, and a warning says so once."""
    result = load(cemented, tmp_path, **SLOW, inertia=inertia)
    curve = rows(tmp_path)
    before = int(np.argmax(curve["failed"] > 0)) - 1
    assert before > 5 and curve["kinetic_share"][before:].max() > 3e-3, "bursts are faster than the limit"
    share, unbalanced = (np.median(curve[name][before - 2 : before + 1]) for name in ("kinetic_share", "unbalanced"))
    assert result.output.count(TOO_FAST) == (inertia > 1)
    if inertia == 1:
        figures.below("specimen: kinetic share before a point fails, over the limit of the warning", share / 3e-3, 1.0)
        figures.below("specimen: unbalanced force then", unbalanced, 2e-2)
    else:
        figures.below("specimen, inertia times 30: limit of the warning over the kinetic share", 3e-3 / share, 0.7)


@pytest.mark.parametrize("wall", [1, 375])
def test_pressure_holds(wall, cemented, tmp_path, figures):
    """The servos keep the pressure of the sides in each row, up to the peak and in the bursts after it, while the plate moves at 0.1 m/s. Heavy walls do not."""
    load(
        cemented, tmp_path, **{**FAST, "speed": 0.1, "ramp": 2e-4, "confine": 3e-4, "record": 100}, pressure=5e4, wall=wall, strain=0.002, beyond=1e9, fallen=-1
    )
    curve = rows(tmp_path)
    moves = np.flatnonzero(curve["stage"] == 1)
    shape = {k: float(v) for k, v in re.findall(r"(height|side) +index (\S+)", (cemented / "poured.in").read_text())}
    off = abs(curve["sideways"] / (5e4 * shape["side"] * shape["height"]) - 1)
    peak = moves[curve["force"][moves].argmax()]
    to_peak, after = off[moves[0] : peak + 1].max(), off[peak + 1 :].max()
    assert peak > moves[0] + 10 and len(curve["force"]) > peak + 50 and curve["broken"][-1] > 20
    if wall == 1:
        figures.below("pressure of the sides in rows, off up to the peak, over it", to_peak, 0.02)
        figures.below("pressure of the sides in rows, off after the peak, over it", after, 0.05)
    else:
        figures.note("pressure of the sides in rows with walls 375 times as heavy, off up to the peak and after it, over it", f"{to_peak:.3g}, {after:.3g}")
        assert to_peak > 0.04 and after > 0.1


def test_without_cement(poured, tmp_path, figures):
    """The beads alone, with a pressure on all sides, carry little more than that, and no column is of cement."""
    result = load(poured, tmp_path, start="poured", pressure=5e4, record=50, strain=0.02)
    curve = rows(tmp_path)
    assert not any(curve[c].any() for c in ("failed", "awake", "broken", "elastic", "work"))
    pressed = 5e4 * float(re.search(r"side +index (\S+)", (poured / "poured.in").read_text())[1]) ** 2
    assert "RESULT" in result.output and 0.5 * pressed < curve["force"][-100:].mean() < 5 * pressed


@pytest.mark.parametrize("ranks, words", [(1, {"pressure": 5e4}), (2, {"test": "tension"})])
def test_goes_on(ranks, words, cemented, tmp_path, figures):
    """A loading that ends early goes on from its own restart file as it would have gone on by itself."""
    words = {**words, "record": 5, "frames": 20, "wake": 1, "speed": 0.05, "ramp": 1e-5}
    load(cemented, tmp_path / "whole", ranks, **words, strain=1e-4)
    load(cemented, tmp_path / "first", ranks, **words, strain=1e-5)
    again = {k: v for k, v in words.items() if k not in ("pressure", "test")}  # these are known
    load(cemented, tmp_path / "second", ranks, **again, start="loaded", loaded=tmp_path / "first", strain=1e-4)
    (file,) = (tmp_path / "second").glob("curve_from_*.csv")
    whole, second = rows(tmp_path / "whole"), rows(tmp_path / "second", file.name)
    begin = int(file.stem.split("_")[-1])
    assert begin > whole["step"][0] and abs(second["step"][0] - begin) <= 5
    second = {k: v[1:] for k, v in second.items()}  # the first row has part of its steps
    for column in ("way", "force", "time", "elastic"):
        there = np.interp(second["step"], whole["step"], whole[column])
        within = second["step"] <= whole["step"][-1]
        assert within.sum() > 20
        figures.below(
            f"{words.get('test', 'compression')}: {column} of a loading in parts against that of the whole, over the largest",
            abs(second[column] - there)[within].max() / abs(whole[column]).max(),
            3e-2,
        )


def test_half_of_the_calcite_coats(poured, tmp_path, figures):
    """Contents scatter and half of the calcite coats the beads: bonds and coats have what was asked for, beads that rest stay at rest, and a
    picture shows the contents."""
    output = go("in.cement", tmp_path, poured=poured, calcite=0.02, coating=0.5, scatter=0.5, draw=3, spacing=2.5e-4).output
    for pattern in ("contact", "coating"):
        reached = float(re.search(rf"^    {pattern}: asked 0.01, reached (\S+), share", output, re.M)[1])
        figures.below(f"specimen, half of the calcite as coats: {pattern} off what was asked", abs(reached / 0.01 - 1), 1e-4)
    load(tmp_path, tmp_path / "load", poured=poured, strain=2e-5, pictures=25)
    curve = rows(tmp_path / "load")
    plain = go("in.cement", tmp_path / "plain", poured=poured, calcite=0.01, spacing=2.5e-4) and tmp_path / "plain"
    load(plain, plain / "load", poured=poured, strain=2e-5)
    ratio = curve["kinetic_beads"][0] / rows(plain / "load")["kinetic_beads"][0]
    figures.below("specimen, half of the calcite as coats: kinetic energy of the beads at the start over that without coats", ratio, 1.5)
    step = sorted((tmp_path / "load").glob("beads_at.*.txt"))[0].name.split(".")[1]
    words = [sys.executable, FOLDER.parents[1] / "tools" / "content_picture.py", f"beads_at.{step}.txt", f"cement_at.{step}.txt", "contents.png"]
    told = subprocess.run(words, cwd=tmp_path / "load", capture_output=True, text=True, check=True).stdout
    bonds = re.search(r"^(\d+) bonds, content (\S+) to (\S+) %", told)
    assert int(bonds[1]) == int(re.search(r"Cement at (\d+) contacts", output)[1]) and float(bonds[3]) > 3 * float(bonds[2])
    assert (tmp_path / "load" / "contents.png").stat().st_size > 20000


def test_other_box(tmp_path):
    output = go("in.pour", tmp_path, beads=10, out=0.05, settle=1e-3, press=1e-4).output
    assert re.search(r"box = \(-0.05 -0.05 .* to \(0.05 0.05 ", output)
