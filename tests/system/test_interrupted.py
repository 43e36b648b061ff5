# SPDX-License-Identifier: GPL-2.0-or-later
"""A run that is stopped by a signal, or killed, and continued from its last restart file ends like the
run that was left alone: its tables and its event log are those of one run."""
import re
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest
from scenes import PATIENCE, cement, edit, launch, pair, pull, restarted, run, start

pytestmark = pytest.mark.usefixtures("as_installed")  # mpirun lets interrupted ranks write their restart files

STEPS = 1500
DAMAGE = "damage tensor B0 9.6e6 cutoff 0.9 events events.csv check 20"
FIXES = cement(2e-4, 3e-9, axis="radial", damage=DAMAGE, couple="kn auto kt auto csv 10 bond.csv")
MOVING = pull(4.0, 4e-6)
BEGIN = pair(1e-4) + FIXES + MOVING + "thermo 50\nthermo_modify flush yes\n"
WHOLE = BEGIN + f"run {STEPS} upto\n"
# The same, not done before a signal has come through mpirun.
SLOWED = edit(WHOLE, "thermo 50\n", "dump slow all custom 4 /dev/null id type mass x y z vx vy vz fx fy fz\nthermo 50\n")


def continued(file, **options):
    return restarted(file, **options) + FIXES + MOVING + f"thermo 50\nrun {STEPS} upto\n"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    result = run(WHOLE, tmp_path_factory.mktemp("whole"), 2)
    assert len((result.directory / "events.csv").read_text().splitlines()) > 200
    return result.directory


def begin(script, directory, ranks, step):
    """The run, as soon as its thermo output has reached `step`, and the file of its output."""
    process, output = start(script, directory, ranks, name="in.first"), directory / "in.first.out"
    log, deadline = directory / "log.liggghts", time.monotonic() + 60 * PATIENCE
    while not (log.exists() and re.search(rf"^ +{step} ", log.read_text(), re.MULTILINE)):
        assert time.monotonic() < deadline and process.poll() is None, output.read_text()[-2000:]
        time.sleep(0.02)
    return process, output


def columns(file):
    lines = [line.split(",") for line in file.read_text().splitlines()]
    return {name: [row[i] for row in lines[1:]] for i, name in enumerate(lines[0])}


def same_tables(whole, directory, figures, what):
    a, b = columns(whole / "events.csv"), columns(directory / "events.csv")
    for exact in ("step", "time", "point", "bond", "grain", "mode"):
        assert a[exact] == b[exact], exact
    a, b = columns(whole / "bond.csv"), columns(directory / "bond.csv")
    assert a["step"] == b["step"] and a["time"] == b["time"] and a["mode"] == b["mode"]
    for column in ("tension", "peak_tension"):  # ten digits
        p, q = (np.array(t[column], dtype=float) for t in (a, b))
        figures.below(f"{what}: {column} at any step against the run left alone, over the peak", abs(p - q).max() / p.max(), 1e-9)


@pytest.mark.parametrize("ranks, sent", [(1, signal.SIGTERM), (1, signal.SIGINT), (2, signal.SIGTERM), (2, signal.SIGINT)])
def test_asked_to_end(ranks, sent, whole, tmp_path, figures):
    """SIGTERM and SIGINT: a restart file at the same step on all ranks, and the end, with nothing in the script for it."""
    process, output = begin(SLOWED, tmp_path, ranks, 700)
    process.send_signal(sent)
    process.wait(60 * PATIENCE)
    files = list(tmp_path.glob("restart_forced_liggghts_*.data"))
    assert len(files) == 1, output.read_text()[-2000:]
    step = int(re.search(r"(\d+)\.data", files[0].name).group(1))
    assert 700 < step < STEPS
    run(continued(files[0].name), tmp_path, ranks)
    same_tables(whole, tmp_path, figures, f"{sent.name} on {ranks} rank(s) at step {step}")


def test_asked_for_a_restart_file(whole, tmp_path, figures):
    """SIGUSR1: a restart file, and on."""
    process, output = begin(SLOWED, tmp_path, 2, 700)
    process.send_signal(signal.SIGUSR1)
    assert process.wait(120 * PATIENCE) == 0, output.read_text()[-2000:]
    assert len(list(tmp_path.glob("restart_forced_liggghts_*.data"))) == 1
    # LIGGGHTS itself stops its output then, if there is no `restart` command
    shown = re.findall(r"^ +(\d+) ", output.read_text().split("Loop time")[0], re.MULTILINE)
    assert shown[-3:] == [str(STEPS - 100), str(STEPS - 50), str(STEPS)]
    same_tables(whole, tmp_path, figures, "SIGUSR1 on 2 ranks")


@pytest.mark.parametrize("ranks", [1, 2])
def test_killed(ranks, whole, tmp_path, figures):
    """kill -9 at any time. Killed while it writes one of its two restart files, that one is refused, and the run goes on from the other."""
    script = edit(WHOLE, "thermo 50\n", "thermo 50\nrestart 200 a.restart b.restart\n")
    process, output = begin(script, tmp_path, ranks, 900)
    subprocess.run(["pkill", "-9", "-s", str(process.pid)], check=True)
    process.wait(60 * PATIENCE)
    assert "Total wall time" not in output.read_text()
    rows = len((tmp_path / "bond.csv").read_text().splitlines())
    earlier, latest = sorted((tmp_path / f for f in ("a.restart", "b.restart")), key=lambda f: f.stat().st_mtime)
    shutil.copy(latest, tmp_path / "latest.restart")
    done = launch(continued("latest.restart"), tmp_path, ranks)
    if "'latest.restart' is truncated" in done.output:
        shutil.copy(earlier, tmp_path / "latest.restart")
        done = launch(continued("latest.restart"), tmp_path, ranks)
    assert done.status == 0 and not done.errors(), done.output[-3000:]
    assert len((tmp_path / "bond.csv").read_text().splitlines()) > rows
    same_tables(whole, tmp_path, figures, f"kill -9 on {ranks} rank(s)")
