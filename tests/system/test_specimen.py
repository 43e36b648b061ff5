# SPDX-License-Identifier: GPL-2.0-or-later
"""The specimen of 150 beads of examples/specimen150 in short form: poured, settled, cemented after a restart, seated by a
servo, compressed past its peak. Its dumps are those that doc/howto_pictures.md shows."""
import csv
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from scenes import launch

FOLDER = Path(__file__).parents[2] / "examples" / "specimen150"
COARSE = {"spacing": 2.3e-4, "cell": 4.6e-4, "inner": 6e-4}


def go(name, directory, ranks, **variables):
    words = [w for k, v in variables.items() for w in ("-var", k, str(v))]
    result = launch((FOLDER / name).read_text(), directory, ranks, name=name, arguments=words)
    assert result.status == 0 and not result.errors(), result.output[-3000:]
    return result


def tables(result):
    """Thermo output of each `run`, by head."""
    found = []
    for text in re.findall(r"^ +Step .*\n(?: *[-\d].*\n)+", result.output, re.M):
        head, *rows = (line.split() for line in text.splitlines())
        found.append(dict(zip(head, np.array(rows, dtype=float).T)))
    return found


@pytest.fixture(scope="module")
def poured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("poured")
    shutil.copy(FOLDER / "plate.stl", folder)
    _, settled, levelled = tables(go("in.pour", folder, 1, settle=175000, level=75000))
    assert (np.concatenate([settled["Atoms"], levelled["Atoms"]]) == 150).all()
    # they fell with half a metre per second and more
    assert levelled["KinEng"][-2] < 1e-3 * settled["KinEng"].max()
    return folder


def prepared(poured, directory):
    directory.mkdir(exist_ok=True)
    for name in ("poured.restart", "plate.in", "plate.stl"):
        shutil.copy(poured / name, directory)
    return directory


def last_rows(directory):
    with open(directory / "bond.csv") as f:
        return {int(r["bond"]): r for r in csv.DictReader(f)}.values()


def test_specimen(poured, tmp_path, figures):
    """150 beads, poured and settled, read from a restart file, cemented, pressed on with 50 N, compressed past the peak."""
    result = go("in.compress", prepared(poured, tmp_path), 2, **COARSE, seat=599, press=1000, record=50, frames=1000)  # ends with a row
    seat, press = tables(result)
    last = last_rows(tmp_path)
    points = sum(int(float(r["points"])) for r in last)
    assert 200 < len(last) < 350
    for table in (seat, press):
        assert (table["Atoms"] == 150 + points).all(), "atoms are lost"
    assert seat["failed"].max() == 0
    figures.below("specimen: force of the servo against 50 N, last 100 steps", abs(seat["force_N"][-3:] / 50 - 1).max(), 0.05)
    row = int(press["force_N"].argmax())
    peak = press["force_N"][row]
    figures.note("specimen: peak force", f"{peak:.4g} N at {press['way_um'][row]:.3g} um")
    figures.below("specimen: force at the end over the peak", press["force_N"][-1] / peak, 0.8)
    assert peak > 2 * 50 and 2 <= row < len(press["force_N"]) - 2
    # the first row of a run, that of its setup, is left out
    figures.below("specimen: energy imbalance", max(abs(t["e_error"][1:]).max() for t in (seat, press)), 0.015)

    apart = [r["mode"] for r in last if float(r["separated"]) > 0]
    told, = re.findall(r"^fix mpm \(id cem\): of (\d+) bonds points failed in \d+, .*: (.*)$", result.output, re.M)
    modes = {mode: int(n) for n, mode in re.findall(r"(\d+) (\w+)", told[1])}
    assert int(told[0]) == len(last)
    assert sum(n for mode, n in modes.items() if mode != "intact") == len(apart) > 5
    assert all(apart.count(mode) == n for mode, n in modes.items() if mode != "intact")
    with open(tmp_path / "events.csv") as f:
        events = list(csv.DictReader(f))
    assert max(r["step"] for r in last) == str(int(press["Step"][-1]))
    assert len(events) == press["failed"][-1] == sum(float(r["failed"]) for r in last)
    check_pictures(tmp_path, press, points)


def check_pictures(folder, press, points):
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
    assert step > press["Step"][0]
    for name, number, columns in (("beads", 150, {"id", "radius", "v"}),
                                  ("cement", points, {"id", "radius", "c_damage", "c_failed", "c_bond", "c_stress"})):
        place, arrays = of(folder / f"{name}_{step}.vtk")
        assert set(arrays) == columns and len(place) == number
        with open(folder / f"{name}.{step}.txt") as f:
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
    height = float(re.search(r"equal (\S+)", (folder / "plate.in").read_text())[1])
    way = np.interp(step, press["Step"][1:], press["way_um"][1:]) * 1e-6
    assert len(plate) == 3 and abs(plate[:, 2] - (height - way)).max() < 6e-8  # six digits


def test_first_failures_on_one_rank_and_two(poured, tmp_path, figures):
    """The same points fail in the same order while only a few bonds have failed points."""
    failures = []
    for ranks in (1, 2):
        directory = prepared(poured, tmp_path / str(ranks))
        go("in.compress", directory, ranks, **COARSE, seat=1, press=200, speed=1, record=200, frames=100000)
        with open(directory / "events.csv") as f:
            failures.append([[int(r[c]) for c in ("step", "point", "bond", "grain")] for r in csv.DictReader(f)])
    one, two = failures
    assert len(one) > 30 and len({bond for _, _, bond, _ in one}) >= 2
    same = next((i for i, (a, b) in enumerate(zip(one, two)) if a != b), min(len(one), len(two)))
    figures.note("specimen: first failures that are the same on one rank and two", f"{same} of {len(one)}")
    assert same >= 30
