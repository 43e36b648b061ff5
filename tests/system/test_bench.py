# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmarks in their short form: they run, and the default has its order."""
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from scenes import PATIENCE

ROOT = Path(__file__).parents[2]
BUILD = Path(os.environ.get("MPDEM_EXE", "build/liggghts-mpdem")).resolve().parent

pytestmark = pytest.mark.skipif(not (BUILD / "bench" / "accuracy").exists(), reason="benchmarks not built (cmake -DMPDEM_BENCH=ON)")


def report(*arguments):
    return subprocess.run(
        [sys.executable, str(ROOT / "tools" / "bench_report.py"), "--build", str(BUILD), *arguments], capture_output=True, text=True, timeout=300 * PATIENCE
    )


def test_short_run(tmp_path, figures):
    done = report("--quick", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / "results.json").read_text())
    for problem in ("bar", "cube", "vortex"):
        order = result["orders"][f"{problem}/total/quadratic/none"]
        figures.note(f"{problem}: order of total/quadratic/none", f"{order:.2f}")
        assert order >= 1.9
        assert (tmp_path / f"{problem}.png").stat().st_size > 5000
    # Phase after one period of 4: lumped mass and consistent stiffness of linear hat functions against the central difference.
    linear = [r for r in result["accuracy"] if (r["problem"], r["method"]) == ("bar", "total/linear/none")]
    assert [r["cells"] for r in linear] == [4, 6, 12, 24]
    for r in linear:
        h, dt = 1 / r["cells"], 4 / r["steps"]
        late = 2 * math.pi * (math.pi / 2 * h) ** 2 / 24 * (1 - (dt / h) ** 2)
        figures.below(f"bar, linear, {r['cells']:g} cells: error against the closed form, less 1", abs(r["error"] / late - 1), 0.01)
    lumped, second = ([r["error"] for r in result["accuracy"] if (r["problem"], r["method"]) == ("bar", f"total/quadratic/{m}")] for m in ("none", "order2"))
    assert len(lumped) == 4
    figures.below("bar: error with mass_order 2 over that with the lumped mass", max(b / a for a, b in zip(lumped[1:], second[1:])), 0.1)
    assert result["orders"]["vortex/updated/quadratic/apic"] > 1.0
    law = {r["step"]: r for r in result["law"] if r["law"] == "law/turning/crackband"}
    order = math.log(law[0.025]["D"] / law[0.01]["D"]) / math.log(2.5)
    figures.note("order of the step of the damage", f"{order:.2f}")
    assert order >= 1.6 and law[0.01]["evaluations"] < 7
    steps = {r["name"]: r for r in result["rates"]}
    assert steps["step/total/quadratic/none/elastic"]["bytes/point"] < 400
    # a tenth damages, in every step
    assert 0.09 < steps["step/total/quadratic/none/damaging"]["growing"] < 0.11
    assert {r["packing"]: r["bonds"] for r in result["packings"]} == {"total": 54, "updated": 54}
    for r in result["failures"]:
        assert r["broken"] and r["peak"] > 50 and abs(sum(r["phases"].values()) - 100) < 1, r
    assert [r["fail"] for r in result["failures"]] == ["flat", "meniscus", "coating"]
    assert [r["skip"] for r in result["skips"]] == ["undamaged", "failed", "resting", "resting"]
    assert 0.008 < steps["step/updated/quadratic/apic/elastic"]["crossing"] < 0.012


@pytest.mark.parametrize("name", ["stepp", "bar/total/quintic", "step/total/quadratic/none/elastic/x"])
def test_unknown_name(name):
    done = report(name)
    assert done.returncode != 0
    assert f"'{name}'" in done.stderr and "bar/total/quadratic/none" in done.stderr
