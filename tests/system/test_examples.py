# SPDX-License-Identifier: GPL-2.0-or-later
"""The scripts of examples/ run to their end, on a coarse grid, and the plot tool reads them."""
import csv
import shutil
import subprocess
from pathlib import Path

import pytest

from scenes import launch

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.usefixtures("as_installed")


@pytest.mark.parametrize("name", ["table1", "scaled"])
def test_pair_flat(name, tmp_path, figures):
    folder = ROOT / "examples" / "pair_flat"
    for file in folder.iterdir():
        shutil.copy(file, tmp_path)
    # A coarse pair takes a larger step than the paper's.
    pull = tmp_path / "pull.in"
    text = pull.read_text()
    assert text.count("timestep     1e-9") == 1
    pull.write_text(text.replace("timestep     1e-9", "timestep     4e-9"))
    script = (folder / f"in.flat_{name}").read_text()
    result = launch(script, tmp_path, ranks=2, name=f"in.flat_{name}", arguments=["-var", "spacing", "1e-4", "-var", "cell", "2e-4"])
    assert result.status == 0 and not result.errors(), result.output[-3000:]
    with open(tmp_path / f"bond_{name}.csv") as f:
        rows = list(csv.DictReader(f))
    last = rows[-1]
    peak = float(last["peak_tension"])
    figures.note(f"pair_flat {name}, coarse: peak force", f"{peak:.4g} N")
    assert peak > 0 and int(float(last["failed"])) > 100
    assert int(last["step"]) < 30000, "the force did not fall below 1 % of the peak"
    figures.below(f"pair_flat {name}: energy imbalance at the end", abs(float(last["energy_imbalance"])), 0.01)

    plot = subprocess.run(["/usr/bin/python3", ROOT / "tools" / "mpdem_plot.py", tmp_path], capture_output=True, text=True)
    assert plot.returncode == 0, plot.stderr
    assert "peak force" in plot.stdout
    for picture in ("force_displacement.png", "damage_cut.png", "summary.csv"):
        assert (tmp_path / picture).stat().st_size > 100
