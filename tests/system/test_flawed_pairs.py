# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/flawed_pairs.py: flaws are where and as many as asked for, bonds with them are weaker, the driver resumes; bad arguments."""
import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import PATIENCE, executable

ROOT = Path(__file__).parents[2]
DRIVER = ROOT / "tools" / "flawed_pairs.py"
SIZE = 6e-4
TINY = ["--content", "0.02", "--coarse", "2.5e-4", "--size", f"{SIZE:g}", "--seeds", "1", "--pores", "0.3", "--softness", "0.6", "--contact", "0.25"]


def drive(out, *words):
    return subprocess.run(["/usr/bin/python3", DRIVER, out, "--exe", executable(), *words], capture_output=True, text=True, timeout=400 * PATIENCE)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    out = tmp_path_factory.mktemp("flawed")
    done = drive(out, *TINY)
    assert done.returncode == 0, done.stdout + done.stderr
    return out


def points(out, name):
    with open(next((out / "points").glob(f"{name}_*.txt"))) as f:
        lines = [line.split() for line in f if not line.startswith("#")]
    return dict(zip(lines[0], np.array(lines[1:], dtype=float).T))


def place(of):
    return np.column_stack([of[c] for c in "xyz"])


def test_pores(driven, figures):
    """What is gone lies in spheres of the size asked for, and all that lay in them is gone."""
    solid, porous = points(driven, "solid"), points(driven, "pores")
    left = {tuple(x) for x in place(porous)}
    gone = np.array([tuple(x) not in left for x in place(solid)])
    assert len(left) + gone.sum() == len(gone)
    figures.below(
        "pores: share of the volume less that asked for, over that of a sphere",
        abs(solid["volume"][gone].sum() / solid["volume"].sum() - 0.3) * solid["volume"].sum() / (4 / 3 * np.pi * SIZE**3),
        1.0,
    )
    # a point that is gone has one that is gone too as the middle of a pore without any that is left
    x, kept = place(solid)[gone], place(porous)
    empty = [i for i in range(len(x)) if ((kept - x[i]) ** 2).sum(axis=1).min() >= SIZE**2]
    assert empty and all(((x[empty] - p) ** 2).sum(axis=1).min() < SIZE**2 for p in x)


def test_softness(driven, figures):
    solid, soft = points(driven, "solid"), points(driven, "softness")
    assert (place(solid) == place(soft)).all() and (solid["volume"] == soft["volume"]).all()
    d = soft["dxx"]
    assert (d == soft["dyy"]).all() and (d == soft["dzz"]).all() and not soft["dyz"].any()
    assert 0.0 <= d.min() and d.max() < 0.6
    grains = np.unique(d).size
    figures.note("softness: grains, and volume over that of a grain", f"{grains} {solid['volume'].sum() / (4 / 3 * np.pi * SIZE**3):.1f}")
    assert abs(grains - solid["volume"].sum() / (4 / 3 * np.pi * SIZE**3)) <= 0.5
    # a grain is connected: no point of it is further off than the nearest points of it are apart, times a few
    mean = np.average(d, weights=solid["volume"])
    figures.below("softness: mean damage less half of the largest, over three deviations of a mean", abs(mean - 0.3) / (3 * 0.6 / np.sqrt(12 * grains)), 1.0)


def test_contact(driven, figures):
    solid, patched = points(driven, "solid"), points(driven, "contact")
    assert (place(solid) == place(patched)).all()
    assert (solid["attached_i"] == patched["attached_i"]).all()
    holds = patched["attached_j"] == 1
    area = solid["area_j"]
    share = area[holds].sum() / area.sum()
    figures.below("contact: attached share less that asked for, over that of a patch", abs(share - 0.25) * area.sum() / (np.pi * SIZE**2), 1.0)


def test_strengths(driven, figures):
    with open(driven / "flaws.csv", newline="") as f:
        rows = list(csv.DictReader(f))
    assert {r["flaw"] for r in rows} == {"pores", "softness", "contact"} and all(r["broken"] == "yes" for r in rows)
    force = {(r["flaw"], float(r["amount"]), r["load"]): float(r["peak"]) for r in rows}
    for load in ("tension", "shear"):
        for flaw, amount, whole in (("pores", 0.3, 0.0), ("softness", 0.6, 0.0), ("contact", 0.25, 1.0)):
            ratio = force[flaw, amount, load] / force[flaw, whole, load]
            figures.note(f"{flaw} {amount}, {load}: largest force over that without flaws", f"{ratio:.3f}")
            # no more than the share that is left, and not almost nothing
            left = {"pores": 0.7, "softness": 1.0, "contact": 0.4}[flaw]
            assert 0.2 * left < ratio < 1.2 * left, (flaw, load)
    assert (driven / "flaws.png").stat().st_size > 5000
    for r in rows:
        figures.below(f"{r['flaw']} {r['amount']} {r['load']}: energy imbalance", abs(float(r["imbalance"])), 0.01)


def test_resumes_and_draws_again(driven, tmp_path):
    done = drive(driven, *TINY)
    assert done.returncode == 0 and "10 runs, 10 finished before, 0 to do" in done.stdout, done.stdout
    done = drive(tmp_path, "--redraw", driven / "flaws.csv")
    assert done.returncode == 0 and (tmp_path / "flaws.png").stat().st_size > 5000


@pytest.mark.parametrize(
    "words, expected",
    [
        (["--pores", "1.2"], "1.2: must be numbers between 0 and 1"),
        (["--contact", "x"], "x: must be numbers between 0 and 1"),
        (["--size", "0"], "0: must be a positive number"),
        (["--exe", "/nowhere/x"], "/nowhere/x: no such executable"),
        (["--content", "0.5", "--coarse", "5e-4"], "does not fit"),
        (["--softness", "0.95"], "softness 0.95: must be below 0.9"),
        (["--redraw", str(ROOT / "doc" / "data" / "study_map.csv")], "not a flaws.csv of flawed_pairs.py"),
    ],
)
def test_bad_arguments(words, expected, tmp_path):
    done = drive(tmp_path / "out", *words)
    assert done.returncode != 0 and expected in done.stderr, done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("text", ["", "a,b\n", "a,b\n1,2\n", "flaw,amount,seed,load,peak\n", "flaw,amount,seed,load,peak\npores,0.1\n"])
def test_a_table_that_cannot_be_drawn(text, tmp_path):
    (tmp_path / "odd.csv").write_text(text)
    done = drive(tmp_path / "out", "--redraw", tmp_path / "odd.csv")
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1 and "odd.csv: not a flaws.csv" in done.stderr, done.stderr


def test_a_file_that_is_none_of_points(tmp_path):
    sys.path.insert(0, str(ROOT / "tools"))
    from mpdem import flaws, run

    (tmp_path / "a").write_text("x y z volume\n0 0 0 1\n")
    with pytest.raises(run.Trouble, match="no column dxx"):
        flaws.make("pores", 0.1, 1.0, 1, tmp_path / "a", tmp_path / "b")
