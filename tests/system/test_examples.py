# SPDX-License-Identifier: GPL-2.0-or-later
"""The scripts of examples/ run to their end, on a coarse grid, and the plot tool reads them."""
import csv
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from scenes import launch

ROOT = Path(__file__).parents[2]
PEAKS = {"scaled": 193.95, "table1": 6041.0}  # of examples/pair_flat as it stands, N

pytestmark = pytest.mark.usefixtures("as_installed")


@pytest.mark.parametrize("name", ["table1", "scaled"])
def test_pair_flat(name, tmp_path, figures):
    folder = ROOT / "examples" / "pair_flat"
    for file in folder.iterdir():
        shutil.copy(file, tmp_path)
    script = (folder / f"in.flat_{name}").read_text()
    result = launch(script, tmp_path, ranks=2, name=f"in.flat_{name}", arguments=["-var", "spacing", "1e-4", "-var", "cell", "2e-4"])
    assert result.status == 0 and not result.errors(), result.output[-3000:]
    with open(tmp_path / f"bond_{name}.csv") as f:
        rows = list(csv.DictReader(f))
    last = rows[-1]
    peak = float(last["peak_tension"])
    figures.note(f"pair_flat {name}, coarse: peak force", f"{peak:.4g} N")
    figures.below(f"pair_flat {name}: peak with twice the cell, off by", abs(peak / PEAKS[name] - 1), 0.03)
    assert int(float(last["failed"])) > 100
    assert int(last["step"]) < 30000, "the force did not fall below 1 % of the peak"
    figures.below(f"pair_flat {name}: energy imbalance at the end", abs(float(last["energy_imbalance"])), 0.01)

    plot = subprocess.run(["/usr/bin/python3", ROOT / "tools" / "mpdem_plot.py", tmp_path], capture_output=True, text=True)
    assert plot.returncode == 0, plot.stderr
    assert "peak force" in plot.stdout
    for picture in ("force_displacement.png", "damage_cut.png", "summary.csv"):
        assert (tmp_path / picture).stat().st_size > 100

    movie = subprocess.run(["/usr/bin/python3", ROOT / "tools" / "mpdem_movie.py", tmp_path, "--frames", "12"], capture_output=True, text=True)
    assert movie.returncode == 0, movie.stderr
    check_movie(tmp_path / "bond_breaks.gif", least=6, most=12)


def check_movie(path, least, most):
    """Frames differ, the last one stays, and the file is small enough for a page."""
    Image = pytest.importorskip("PIL.Image")
    with Image.open(path) as film:
        frames, stays = [], []
        for i in range(film.n_frames):
            film.seek(i)
            frames.append(film.convert("RGB").tobytes())
            stays.append(film.info["duration"])
    assert least <= len(frames) <= most and all(a != b for a, b in zip(frames, frames[1:]))
    assert stays[-1] > 10 * stays[0] and path.stat().st_size < 1.5e6


def test_movie_of_the_readme():
    check_movie(ROOT / "doc" / "data" / "demo_bond_breaks.gif", least=20, most=60)


@pytest.mark.parametrize(
    "words, expected",
    [
        (["--frames", "1"], "--frames must be at least 2"),
        (["--cut", "none.*.txt"], "none.*.txt: no such dumps"),
        (["--bond", "none.csv"], "none.csv: no such file"),
        ([], "cut.0.txt: no column id"),
    ],
)
def test_movie_says_what_is_wrong(words, expected, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    from mpdem import run

    rows = [",".join([str(step)] + ["0"] * (len(run.COLUMNS) - 1) + ["intact"]) for step in (0, 100)]
    (tmp_path / "bond.csv").write_text("\n".join([",".join((*run.COLUMNS, "mode")), *rows, ""]))
    (tmp_path / "cut.0.txt").write_text("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z c_damage c_failed\n0 0 0 0 0\n")
    done = subprocess.run(["/usr/bin/python3", ROOT / "tools" / "mpdem_movie.py", tmp_path, *words], capture_output=True, text=True)
    assert done.returncode != 0 and "Traceback" not in done.stderr
    assert expected in done.stderr
