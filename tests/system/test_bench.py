# SPDX-License-Identifier: GPL-2.0-or-later
"""The report of the benchmarks, in its quick form, where the benchmarks are built."""
import csv
import subprocess
import sys
from pathlib import Path

import pytest
from scenes import executable

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def build():
    directory = Path(executable()).parent
    if not (directory / "bench/accuracy").exists():
        pytest.skip("benchmarks are not built (MPDEM_BENCH)")
    return directory


def report(build, *words):
    return subprocess.run(["/usr/bin/python3", "-B", ROOT / "tools/bench_report.py", build, *words], capture_output=True, text=True,
                          timeout=280)


def test_orders(build):
    done = report(build, "--quick", "accuracy")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(open(build / "bench/report/accuracy.csv")))
    fine = {r["problem"]: float(r["order"]) for r in rows if r["method"] == "total quadratic none" and r["order"] != "nan"}
    assert fine["bar"] > 1.9 and fine["cube"] > 1.9, fine


@pytest.mark.parametrize("words, text", [(("speed",), "'speed' is no benchmark; known are rates"), (("rates", "--loud"), "--loud")])
def test_unknown_names(build, words, text):
    done = report(build, *words)
    assert done.returncode != 0 and text in done.stderr


def test_accuracy_knows_its_problems(build):
    done = subprocess.run([build / "bench/accuracy", "rod"], capture_output=True, text=True)
    assert done.returncode != 0 and "'rod'" in done.stderr and "bar, cube" in done.stderr
