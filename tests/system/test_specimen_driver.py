# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/specimen.py: a tiny specimen is poured, cemented and broken; the driver resumes; bad arguments."""
import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import PATIENCE, edit, executable, launch

ROOT = Path(__file__).parents[2]
DRIVER = ROOT / "tools" / "specimen.py"
TINY = [
    "--beads",
    "12",
    "--contents",
    "0.012",
    "--pressures",
    "5e3,2e5",
    "--jobs",
    "1",
    "--set",
    "settle=0.04",
    "--set",
    "press=0.01",
    "--set",
    "speed=0.2",
    "--set",
    "pull=0.05",
    "--set",
    "ramp=2e-5",
    "--set",
    "confine=6e-5",
    "--set",
    "record=20",
    "--set",
    "frames=5",
    "--set",
    "strain=0.004",
    "--set",
    "beyond=1.3",
]


def drive(out, *words):
    return subprocess.run(["/usr/bin/python3", DRIVER, out, "--exe", executable(), *words], capture_output=True, text=True, timeout=300 * PATIENCE)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    out = tmp_path_factory.mktemp("specimen")
    done = drive(out, *TINY)
    assert done.returncode == 0, done.stdout + done.stderr
    return out, done.stdout


def rows(out):
    with open(out / "specimen.csv", newline="") as f:
        return {r["label"]: r for r in csv.DictReader(f)}


def curve(out, label):
    with open(out / label / "curve.csv", newline="") as f:
        table = list(csv.DictReader(f))
    return {k: np.array([float(r[k]) for r in table]) for k in table[0]}


def test_strengths(driven, figures):
    out, said = driven
    table = rows(out)
    assert list(table) == ["compression_0.012", "tension_0.012", "compression_0.012_0.005MPa", "compression_0.012_0.2MPa"]
    assert said.count("broken, ") >= 3 and "left" in said and ("cohesion" in said or "beyond its cap" in said)
    for label, r in table.items():
        assert float(r["strength"]) > 0 and float(r["stiffness_of_ends"]) > 0
        assert int(r["broken"]) == sum(int(r[m]) for m in ("debonding", "internal", "mixed")) <= int(r["bonds"]), label
        figures.below(f"{label}: energy imbalance of the cement", r["imbalance"], 1e-2)
    assert sum(int(r["broken"]) for r in table.values()) > 3
    assert said.count("pressure of the sides off by at most ") == 2 and (out / "pressure.png").stat().st_size > 5000
    for label, r in table.items():
        assert (
            (float(r["pressure_off_to_peak"]) >= 0) == ("MPa" in label)
            and 0 < float(r["kinetic_share_at_first_failure"]) <= 1
            and float(r["unbalanced_at_first_failure"]) > 0
        )
    for picture in ("curves.png", "awake.png", "strength.png", "rose.png", *(f"{kind}_{label}.png" for kind in ("energy", "bonds") for label in table)):
        assert (out / picture).stat().st_size > 5000, picture


def test_curve(driven, figures):
    """Stress, work and energy of the driver against the table of the run and that of the bonds."""
    out, _ = driven
    r, c = rows(out)["tension_0.012"], curve(out, "tension_0.012")
    poured = json.loads((out / "poured" / "done.json").read_text())["results"]
    assert float(r["strength"]) == pytest.approx(c["force"].max() / poured["side"] ** 2, rel=1e-5)
    with open(out / "tension_0.012" / "bond.csv", newline="") as f:
        bonds = list(csv.DictReader(f))
    last = [b for b in bonds if b["step"] == bonds[-1]["step"]]
    assert len(last) == int(r["bonds"])
    at = int(np.flatnonzero(c["step"] == float(last[0]["step"]))[0])
    assert c["broken"][at] == sum(float(b["separated"]) for b in last) and c["failed"][at] == sum(float(b["failed"]) for b in last)
    # nothing but grips and contacts works on beads and cement: until it breaks, what the grips do is in beads and cement but for the contacts
    work = np.cumsum(c["force"][1:] * np.diff(c["way"]))
    peak = int(np.argmax(c["force"])) - 1
    figures.below(
        "tension: work of the grip against that in beads and cement, at the peak", abs((c["work"] + c["kinetic_beads"])[peak + 1] / work[peak] - 1), 0.05
    )


@pytest.mark.parametrize("pressure", [5e3, 2e5])
def test_confined(driven, figures, pressure):
    """The side walls come to their pressure before the plate moves, and small pressures do not lose them."""
    out, _ = driven
    c = curve(out, f"compression_0.012_{1e-6 * pressure:g}MPa")
    poured = json.loads((out / "poured" / "done.json").read_text())["results"]
    before = int(np.flatnonzero(c["stage"] == 0)[-1])
    figures.below(
        f"pressure of the sides at the end of their stage, {1e-6 * pressure:g} MPa",
        abs(c["sideways"][before] / (pressure * poured["side"] * poured["height"]) - 1),
        0.1,
    )
    figures.below(f"strain of the sides until then, {1e-6 * pressure:g} MPa", abs(c["lateral"][: before + 1]).max(), 2e-3)
    assert c["stage"][-1] == 1


def test_ramp(driven, figures):
    """The speed of the plate rises along half a wave of a cosine."""
    out, _ = driven
    c = curve(out, "compression_0.012")
    ramp, speed = 2e-5, 0.2
    u = np.minimum(c["time"], ramp)
    wanted = 0.5 * speed * (u - ramp / np.pi * np.sin(np.pi * u / ramp)) + speed * (c["time"] - u)
    assert (c["time"] < ramp).sum() > 10
    within = c["time"] < 2 * ramp
    figures.below("way of the plate against that of the ramp, over that of twice its time", abs(c["way"] - wanted)[within].max() / wanted[within].max(), 1e-2)


def test_energy_of_the_contacts(driven, figures):
    """Without friction and dashpots, what the plate did is in cement, motion, and the springs of the contacts: nothing is left over."""
    out, _ = driven
    sys.path.insert(0, str(ROOT / "tools"))
    from mpdem import specimen

    folder = out / "without_friction"
    folder.mkdir()
    scripts = ROOT / "examples" / "specimen"
    words = {
        "here": scripts,
        "poured": "../poured",
        "cemented": "../cemented_0.012",
        "rub": 0,
        "bounce": 0.9999,
        "speed": 0.05,
        "ramp": 2e-5,
        "record": 20,
        "frames": 1,
        "strain": 0.002,
        "beyond": 1.1,
    }
    with open(folder / "out.txt", "w") as said:
        done = subprocess.run(
            [executable(), "-in", scripts / "in.load", *(str(w) for k, v in words.items() for w in ("-var", k, v))],
            cwd=folder,
            stdout=said,
            timeout=300 * PATIENCE,
        )
    assert done.returncode == 0, (folder / "out.txt").read_text()[-2000:]
    c = specimen.Curve(str(folder), "compression", 0.0)
    fails = int(np.argmax(c.table["failed"] > 0)) - 1
    assert 0.1 < (c.springs[fails] - c.springs[0]) / c.work[fails] < 0.95
    figures.below("work of the plate less energy of cement, beads and springs when the first point fails, over it", abs(c.rubbed[fails] / c.work[fails]), 1e-2)


def test_goes_on(driven):
    """Finished runs are kept; one whose file is lost is run again, and those that need it are not, as it is the same."""
    out, _ = driven
    before = (out / "specimen.csv").read_text()
    again = drive(out, *TINY)
    assert again.returncode == 0 and "6 runs, 6 finished before, 0 to do" in again.stdout, again.stdout + again.stderr
    assert (out / "specimen.csv").read_text() == before
    other = drive(out, *TINY[:-2], "--set", "beyond=1.2", "--redraw")
    assert other.returncode != 0 and "no load of this plan is finished" in other.stderr, "runs of other variables are not those"
    assert (out / "specimen.csv").read_text() == before
    drive(out, *TINY, "--redraw")
    assert (out / "specimen.csv").read_text() == before


BAD = {
    "no variable": (["--set", "sped=1"], ["--set sped=1", "speed"]),
    "no number": (["--contents", "0.01,x"], ["--contents", "0.01,x", "positive numbers"]),
    "below zero": (["--pressures", "-1e5"], ["--pressures", "positive numbers"]),
    "a test": (["--tests", "torsion"], ["--tests torsion", "compression or tension"]),
    "executable": (["--exe", "/nowhere"], ["/nowhere", "--exe"]),
    "a small seed": (["--set", "seed=101"], ["--set seed=101", "prime above 10000", "49979687"]),
    "a seed that is no prime": (["--set", "seed=10001"], ["--set seed=10001", "prime above 10000"]),
    "a seed that the script has": (["--set", "seed=15485867"], ["--set seed=15485867", "not 15485863, 15485867 or 32452843"]),
}


@pytest.mark.parametrize("name", BAD)
def test_message(name, tmp_path):
    words, needed = BAD[name]
    done = subprocess.run(
        ["/usr/bin/python3", DRIVER, tmp_path / "out", *(w.replace("-1e5", "=-1e5") if w == "-1e5" else w for w in words)],
        capture_output=True,
        text=True,
        env={**os.environ},
    )
    assert done.returncode != 0
    missing = [w for w in needed if w not in done.stderr]
    assert not missing, done.stderr
    assert "Traceback" not in done.stderr


def test_nothing_to_draw(tmp_path):
    done = drive(tmp_path / "out", *TINY, "--redraw")
    assert done.returncode == 1 and len(done.stderr.splitlines()) == 1 and "no load of this plan is finished there; give the folder" in done.stderr, done.stderr
    assert not (tmp_path / "out" / "specimen.csv").exists()


def test_a_failing_run_is_told(tmp_path):
    """A spacing of nothing: the message of the program, and that others needed it."""
    done = drive(tmp_path / "out", *TINY, "--set", "spacing=0")
    assert done.returncode != 0 and "FAILED cemented_0.012: ERROR: create_cement" in done.stdout and "needs a run that failed" in done.stderr, (
        done.stdout + done.stderr
    )


def test_beads_that_do_not_fit_the_step_are_told(tmp_path):
    done = drive(tmp_path / "out", *TINY, "--set", "large=2e-4", "--set", "small=1.7e-4")
    assert done.returncode != 0 and "FAILED poured: ERROR: Unknown command: -var small: dt is above half of the Rayleigh time" in done.stdout, done.stdout


def test_lost_beads_stop_the_script(tmp_path):
    script = edit((ROOT / "examples" / "specimen" / "in.pour").read_text(), "> 4.7e-4", "> 1")
    words = {"here": ROOT / "examples" / "specimen", "beads": 40, "large": 2e-4, "small": 1.7e-4, "settle": 0.02, "press": 0.005}
    result = launch(script, tmp_path, name="in.pour", arguments=[str(w) for k, v in words.items() for w in ("-var", k, v)])
    assert result.status != 0 and "of 40 beads left the box" in result.output and "beads left the box" in result.errors()[0]
    assert not (tmp_path / "poured.restart").exists()


def test_whole_message():
    """An error of LIGGGHTS that has several lines is told to its end."""
    sys.path.insert(0, str(ROOT / "tools"))
    from mpdem import runner

    text = "x\nERROR on proc 0: It is required that\nThe random seed used was 101\n  Hint 2: these:\n       15485863 (./src/random.cpp:93)\n------\nMPI_ABORT\n"
    assert runner.error_of(text) == "ERROR on proc 0: It is required that The random seed used was 101 Hint 2: these: 15485863 (./src/random.cpp:93)"
    assert runner.error_of("ERROR: one line (fix mpm:0)\nERROR: another (./src/a.cpp:1)\n") == "ERROR: one line (fix mpm:0)"
    assert runner.error_of("ERROR: without a place\nmore\n") == "ERROR: without a place" and runner.error_of("RESULT\n") == ""


def test_early_failure(driven, tmp_path):
    """If points fail early, stiffness and kinetic share are of the load before, and the words say so; if at once, there are none."""
    out, _ = driven
    sys.path.insert(0, str(ROOT / "tools"))
    from mpdem import specimen

    words = dict(w.split("=") for w in TINY if "=" in w)
    load = specimen.Load("compression", 0.012, 0.0, specimen.Cement(0.012, specimen.Pour(12, words), words), words)
    for name in ("poured", "cemented_0.012", "compression_0.012"):
        shutil.copytree(out / name, tmp_path / name)
    folder = tmp_path / "compression_0.012"
    as_it_is = load.results(str(folder))
    c = specimen.Curve(str(folder), "compression", 0.0)
    text = (folder / "curve.csv").read_text().splitlines()
    at = text[0].split(",").index("failed")
    for share in (0.4, 0.0):
        first = int(np.argmax(c.stress > share * c.stress[c.peak])) if share else 0
        moved = [line.split(",") for line in text[1:]]
        start = len(moved) - len(c.stress)
        for n, row in enumerate(moved):
            row[at] = "1" if n >= start + first else "0"
        (folder / "curve.csv").write_text("\n".join([text[0], *(",".join(row) for row in moved)]) + "\n")
        r = load.results(str(folder))
        assert r["strength"] == as_it_is["strength"]
        if share:
            top = c.stress[:first].max() / c.stress[c.peak]
            assert r["load_at_first_failure"] == pytest.approx(top) and f"GPa before the first failure at {100 * top:.0f} % of the peak" in load.told(r)
            assert r["kinetic_at_half"] == c.kinetic_share[first - 1] and np.isfinite(r["stiffness_of_ends"])
        else:
            assert "stiffness n/a, before the first failure at 0 % of the peak" in load.told(r) and np.isnan(r["kinetic_at_half"])


def test_mohr_coulomb():
    """Of a material that has them."""
    sys.path.insert(0, str(ROOT / "tools"))
    from mpdem import specimen

    cohesion, angle = 3e5, np.radians(35.0)
    q = (1 + np.sin(angle)) / (1 - np.sin(angle))
    rows = [{"pressure": p, "strength": 2 * cohesion * np.sqrt(q) + q * p} for p in (0.0, 1e5, 4e5)]
    line = specimen.mohr_coulomb(rows)
    fit = line["fit"]
    assert line["beyond"] == [] and line["fitted"] == 3
    assert fit["cohesion"] == pytest.approx(cohesion) and fit["angle"] == pytest.approx(35.0) and fit["off"] < 1e-12
    # strengths that rise by less than the pressure are left out, in whatever order they come
    cap = [{"pressure": p, "strength": rows[-1]["strength"] + 0.4 * (p - 4e5)} for p in (8e5, 6e5)]
    line = specimen.mohr_coulomb([cap[0], *rows, cap[1]])
    assert line["beyond"] == [6e5, 8e5] and line["fit"] == fit
    line = specimen.mohr_coulomb([{"pressure": p, "strength": 1e6 + 0.5 * p} for p in (0.0, 1e5, 2e5)])
    assert line["beyond"] == [1e5, 2e5] and line["fit"] is None
    assert specimen.mohr_coulomb(rows[:1]) is None
