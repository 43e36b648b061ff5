# SPDX-License-Identifier: GPL-2.0-or-later
"""examples/specimen past the peak: checkpoints, constant volume, cycles, speeds of plate and waves, and what tools/mpdem makes of the tables."""
import csv
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scenes import PATIENCE, executable, launch

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "specimen"
sys.path.insert(0, str(ROOT / "tools"))
from mpdem import response, tables, waves

BEADS = 24
CALCITE = 0.02
FAST = {"speed": 0.2, "ramp": 2e-5, "confine": 6e-5, "record": 20, "frames": 5, "ends": "strain", "pressure": 5e4}


def words(variables):
    return [w for k, v in {"here": FOLDER, **variables}.items() for w in ("-var", k, *map(str, v if isinstance(v, list) else [v]))]


def go(name, directory, ranks=1, status=0, **variables):
    directory.mkdir(exist_ok=True)
    result = launch((FOLDER / name).read_text(), directory, ranks, name=name, arguments=words(variables))
    assert bool(result.status) == bool(status), result.output[-3000:]
    return result.output


@pytest.fixture(scope="module")
def cemented(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cemented")
    go("in.pour", folder, beads=BEADS, settle=0.06, press=0.01)
    go("in.cement", folder, calcite=CALCITE)
    return folder


def of(folder, **variables):
    return {"poured": folder, "cemented": folder, **FAST, **variables}


@pytest.fixture(scope="module")
def drained(cemented, tmp_path_factory):
    """To 1 %, in pieces, with marks."""
    folder = tmp_path_factory.mktemp("drained")
    go("in.load", folder, **of(cemented, strain=0.01, save=10000, frames=2, marks=[0, 0.004]))
    return folder


def test_content_of_all_beads(cemented, figures):
    """in.cement reaches the content that a laboratory gives, as create_cement counts it."""
    text = go("in.cement", cemented, calcite=CALCITE)
    (made,) = [line.split()[-1] for line in text.splitlines() if line.startswith("  in all")][-1:]
    figures.below("calcite over all beads that create_cement made, off what was asked for, over it", abs(float(made) / CALCITE - 1), 1e-3)


def test_stopped_and_not(cemented, tmp_path):
    """A loading that is killed three times and started by the same command ends with the same restart file as one that is not, bitwise."""
    loading = of(cemented, strain=0.004, save=3000, resume="yes", marks=[0.001])
    go("in.load", tmp_path / "whole", **loading)
    cut = tmp_path / "cut"
    cut.mkdir()
    for _ in range(3):
        before = (cut / "loaded.in").read_text() if (cut / "loaded.in").exists() else ""
        with open(cut / "out.txt", "w") as out:
            process = subprocess.Popen([executable(), "-in", FOLDER / "in.load", *words(loading)], cwd=cut, stdout=out)
            end = time.time() + 100 * PATIENCE
            while process.poll() is None and time.time() < end:
                now = (cut / "loaded.in").read_text() if (cut / "loaded.in").exists() else ""
                if now != before:
                    break
                time.sleep(0.02)
            time.sleep(0.3)  # into the next piece
            process.send_signal(signal.SIGKILL)
            assert process.wait() == -signal.SIGKILL, (cut / "out.txt").read_text()[-2000:]
    go("in.load", cut, **loading)
    one, two = (tmp_path / name for name in ("whole", "cut"))
    assert (one / "loaded.in").read_text() == (two / "loaded.in").read_text()
    (end,) = [p.name for p in one.glob("loaded_*.restart")]
    assert [p.name for p in two.glob("loaded_*.restart")] == [end] and (one / end).read_bytes() == (two / end).read_bytes()
    a, b = response.whole(str(one), "curve"), response.whole(str(two), "curve")
    assert all((a[k] == b[k]).all() for k in a), "rows that a killed run wrote after its checkpoint are left out"
    assert len(list(one.glob("curve_from_*.csv"))) >= 3 and (np.diff(a["step"]) > 0).all() and np.diff(a["step"]).max() <= 2 * FAST["record"]


def test_stress_and_strain(drained, figures):
    """Stress of the walls against the forces between beads inside, volume strain against the beads themselves, and counts of bonds and contacts."""
    r, f = response.write(str(drained))
    there = f["axial_strain"] > 0
    walls = np.interp(f["step"], r["step"], r["axial_stress"])
    figures.below(
        "stress by forces inside against that of the plate, mean of the frames, over it", abs(f["stress_inside"][there].mean() / walls[there].mean() - 1), 0.05
    )
    beads = response.dumps(str(drained), "beads")
    steps = [s for s in beads if r["step"][0] <= s <= r["step"][-1]]
    volume = np.array([np.prod((b[:, 1:4] + b[:, 4:5]).max(axis=0) - (b[:, 1:4] - b[:, 4:5]).min(axis=0)) for b in (beads[s] for s in steps)])
    of_walls = np.interp(steps, r["step"], r["volume_strain"])
    assert abs(of_walls).max() > 0.002
    off = abs(volume / volume[0] - 1 - of_walls)
    figures.below(
        "volume strain of the walls against that of the box around the beads, mean of the frames, over the largest", off.mean() / abs(of_walls).max(), 0.1
    )
    assert (f["contacts"] == f["old_contacts"] + f["new_contacts"]).all() and f["new_contacts"][0] == 0 and f["lost_contacts"][-1] > 0
    assert (f["bonds"][0] - f["bonds"] == np.interp(f["step"], r["step"], r["broken"])).all() and f["bonds"][-1] < f["bonds"][0]
    assert np.allclose(f["coordination"], 2 * f["contacts"] / BEADS) and (f["coordination_with_bonds"] >= f["coordination"]).all()
    with open(drained / "fragments.csv", newline="") as file:
        sizes = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    for step, pieces, single in zip(f["step"], f["pieces"], f["single"]):
        at = [s for s in sizes if s["step"] == step]
        assert sum(s["grains"] * s["pieces"] for s in at) == BEADS and sum(s["pieces"] for s in at) == pieces + single
    read = response.read(str(drained))
    assert np.allclose(read[0]["q"], r["q"], rtol=1e-5, atol=1) and np.allclose(read[1]["contacts"], f["contacts"])


def test_energies_go_on(drained, figures):
    """Sums of the cement (work, dissipation, failed points) do not jump where a loading went on."""
    c = response.whole(str(drained), "curve")
    begins = [b for b, _ in tables.pieces(str(drained), "curve") if b]
    assert len(begins) > 1 and abs(c["imbalance"][1:]).max() < 1e-3
    for name in ("work", "dissipated", "failed", "broken"):
        steps = np.searchsorted(c["step"], begins)
        jump = max(abs(c[name][n] - c[name][n - 1]) for n in steps if 0 < n < len(c["step"]))
        most = max(abs(np.diff(c[name])).max(), 1e-12)
        figures.below(f"largest change of {name} over a checkpoint, over the largest between rows", jump / most, 2.0)


@pytest.mark.parametrize("start", ["cemented", "poured"])
def test_constant_volume(start, cemented, tmp_path, figures):
    """With `sides volume` the walls keep the volume, and their stress changes instead."""
    go("in.load", tmp_path, **of(cemented, start=start, sides="volume", strain=0.004, save=8000, record=20 if start == "cemented" else 10))
    r = response.response(response.whole(str(tmp_path), "curve"))
    figures.below(f"volume strain of an undrained test, {start}", abs(r["volume_strain"]).max(), 5e-5)
    assert r["axial_strain"][-1] > 0.004 and np.ptp(r["side_stress"]) > 5e3 and np.ptp(r["section"]) > 0.003 * r["section"][0]


@pytest.mark.parametrize("by, lower, upper", [("strain", 0, 2e-4), ("stress", 5e4, 2e5)])
def test_cycles(by, lower, upper, cemented, tmp_path, figures):
    """The plate turns at both ends of each cycle, by strain and by stress, across a checkpoint."""
    output = go("in.load", tmp_path, **of(cemented, test="cyclic", by=by, lower=lower, upper=upper, cycles=2, strain=0.02, save=1000))
    assert "RESULT test cyclic" in output
    r = response.response(response.whole(str(tmp_path), "curve"))
    down = r["speed"] > 0
    turns = np.flatnonzero(np.diff(r["speed"]) != 0)[1:]  # the first is the start
    assert len(turns) >= 3 and down[turns[0]] and not down[turns[1]]
    assert by == "stress" or list(tmp_path.glob("curve_from_*.csv"))
    gauge = r["axial_strain"] if by == "strain" else r["q"]
    parts = [gauge[a : b + 1] for a, b in zip([0, *turns], turns)]  # a row has the new speed once it is reached
    assert min(part.max() for part in parts[::2]) > 0.9 * upper and max(part.min() for part in parts[1::2]) < lower + 0.1 * (upper - lower)
    # it goes on while it brakes, in `ramp`
    if by == "strain":
        height = r["height"][0]
        figures.below(
            "strain beyond its limits in a cyclic test, over the way in which the plate turns",
            max(gauge.max() - upper, lower - gauge.min()) * height / (FAST["speed"] * FAST["ramp"]),
            2.0,
        )


def test_speed_follows_the_kinetic_share(cemented, tmp_path):
    """The plate gets faster once the load has fallen and motion is small, up to `fast`, and not where motion is large."""
    slow = of(cemented, strain=0.0025, save=1e6, speed=0.05)
    go("in.load", tmp_path / "calm", **{**slow, "fast": 0.1, "calm": 1e9})
    go("in.load", tmp_path / "loud", **{**slow, "fast": 0.1, "calm": 1e-9})
    calm, loud = (response.response(response.whole(str(tmp_path / name), "curve")) for name in ("calm", "loud"))
    assert set(loud["speed"]) == {0, 0.05}
    first = int(np.argmax(calm["speed"] > 0.05 + 1e-9))
    top = int(np.argmax(calm["axial_stress"][:first]))
    assert first and calm["axial_stress"][first] < 0.9 * calm["axial_stress"][top] and calm["failed"][first] > 0
    assert calm["speed"].max() == 0.1
    rate = -np.diff(calm["height"]) / np.diff(calm["time"])
    assert np.median(rate[-20:]) == pytest.approx(0.1, rel=1e-2) and np.median(rate[top - 20 : top]) == pytest.approx(0.05, rel=1e-2)
    go("in.load", tmp_path / "beads", **of(cemented, start="poured", strain=0.01, fast=0.4, calm=1e9))
    assert response.whole(str(tmp_path / "beads"), "curve")["speed"].max() == pytest.approx(0.4, rel=0.25)


def test_friction_is_passed_on(cemented, tmp_path):
    go("in.cement", tmp_path, poured=cemented, calcite=CALCITE, inner="auto", spacing=2.5e-4)
    go("in.load", tmp_path, **of(cemented, cemented=tmp_path, strain=1e-5, cell=5e-4, condense="no", friction=0.3))
    assert re.search(r"mpm/couple cem csv 100 bond.csv friction 0.3 interface penalty grains rigid$", (tmp_path / "log.liggghts").read_text(), re.M)


# ------------------------------------------------------------------------ waves


@pytest.fixture(scope="module")
def speeds(drained, cemented, tmp_path_factory):
    def at(mark, **variables):
        folder = tmp_path_factory.mktemp("waves")
        output = go("in.wave", folder, poured=cemented, loaded=drained, after=mark, **variables)
        rate = float([line for line in output.splitlines() if line.startswith("WAVE 4")][0].split()[-1])
        return folder, rate, output

    return at


def test_waves(speeds, figures):
    """Both waves cross the specimen at a mark; a kick a tenth as large gives the same speeds, as the wave is linear; the compression wave is faster."""
    folder, rate, output = speeds("mark_0")
    found = waves.results(str(folder), rate)
    other = waves.results(*(str(v) if n == 0 else v for n, v in enumerate(speeds("mark_0", kick=1e-9)[:2])))
    assert 500 < found["shear"] < found["compression"] < 7000 and "RESULT waves" in output
    for name in ("shear", "compression"):
        figures.below(f"speed of the {name} wave by a kick a tenth as large, off, over it", abs(other[name] / found[name] - 1), 1e-3)
    for n, column in ((1, 2), (3, 3)):
        t, _, v = waves.frames(str(folder / f"wave_{n}.txt"), column, rate)
        assert t[-1] > 9.9e-5 and abs(v[t > 0]).max() > 1e-3


@pytest.mark.parametrize("speed", [300.0, 1500.0])
def test_arrivals(speed, figures):
    """Speed of a pulse that travels through beads at a known one."""
    random = np.random.default_rng(1)
    z = random.uniform(2e-3, 18e-3, 300)
    t = np.linspace(0, 6 * 0.02 / speed, 400)
    period = 0.02 / speed / 2
    phase = (t[:, None] - z[None, :] / speed) / period
    v = np.where((phase > 0) & (phase < 1), np.sin(2 * np.pi * phase), 0.0) * 1e-3
    found, off = waves.speed(*waves.arrivals(t, z, v))
    figures.below(f"speed of a pulse of {speed:g} m/s, off, over it", abs(found / speed - 1), 0.02)
    assert off < 0.03
    assert all(np.isnan(waves.speed(*waves.arrivals(t, z, 0 * v))))


def test_fragments():
    """Pieces of grains by their joints, largest first."""
    ids = np.arange(1, 9)
    assert list(response.fragments(ids, np.array([[1, 2], [2, 3], [7, 8], [3, 1]]))) == [3, 2, 1, 1, 1]
    assert list(response.fragments(ids, np.zeros((0, 2)))) == [1] * 8


def test_force_inside():
    """A column of three beads under 2 N, one contact and one bond: that is the force through each section."""
    z = {1: 0.0, 2: 1.0, 3: 2.0}
    pairs, bonds = np.array([[2, 1, 2.0]]), np.array([[2, 3, -2.0, 2.0]])
    for low, high in ((0.0, 2.0), (0.5, 1.5), (1.2, 1.9)):
        assert response.force_inside(low, high, z, pairs, bonds) == pytest.approx(2.0)


BAD = {
    "a test": ({"test": "torsion"}, "-var test: must be compression, tension or cyclic"),
    "sides": ({"sides": "soft"}, "-var sides: must be pressure or volume"),
    "ends": ({"ends": "never"}, "-var ends: must be peak or strain"),
    "by": ({"by": "force"}, "-var by: must be strain or stress"),
    "fast": ({"fast": 0.1}, "-var fast: must be at least speed"),
    "calm": ({"calm": 0}, "-var calm: must be above 0"),
    "cycles": ({"cycles": 0}, "-var cycles: must be at least 1"),
    "lower": ({"lower": 1, "upper": 1}, "-var lower: must be below upper"),
    "save": ({"save": 0}, "-var save: must be at least 1"),
    "volume without a pressure": ({"sides": "volume", "pressure": 0}, "-var sides volume: needs a pressure"),
}


@pytest.mark.parametrize("name", BAD)
def test_message(name, cemented, tmp_path):
    variables, message = BAD[name]
    assert message in go("in.load", tmp_path, status=1, **of(cemented, **variables))


def test_messages_of_the_others(cemented, drained, tmp_path):
    assert "-var calcite: must be from 0, below 1" in go("in.cement", tmp_path, status=1, poured=cemented, calcite=2)
    assert "-var kick, period and last: must be above 0" in go("in.wave", tmp_path, status=1, poured=cemented, loaded=drained, after="mark_0", kick=0)


# ------------------------------------------------------------------------ the command

DRIVER = ROOT / "tools" / "specimen.py"
SMALL = "--beads 16 --calcite 0.02 --tests= --pressures 5e4 --strain 0.006 --waves 0,0.003 --jobs 1 --set settle=0.04 --set press=0.01 --set speed=0.2".split()
SMALL += "--set ramp=2e-5 --set confine=6e-5 --set record=20 --set frames=5 --set save=5000".split()


def drive(out, *more):
    return ["/usr/bin/python3", str(DRIVER), str(out), "--exe", executable(), *SMALL, *more]


def test_command(tmp_path):
    """One command: drained, undrained, cyclic and uncemented, with wave speeds; stopped in a loading, it goes on from the checkpoint."""
    more = ["--confined", "drained,undrained,cyclic,uncemented"]
    load = tmp_path / "compression_0.02_0.05MPa"
    with open(tmp_path / "said.txt", "w") as said:
        process = subprocess.Popen(drive(tmp_path, *more), stdout=said, stderr=said)
        end = time.time() + 120 * PATIENCE
        while process.poll() is None and time.time() < end and not list(load.glob("curve_from_*.csv")):
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        process.wait()
    assert "the same command goes on from here" in (tmp_path / "said.txt").read_text()
    first = os.stat(load / "curve.csv").st_mtime_ns
    done = subprocess.run(drive(tmp_path, *more), capture_output=True, text=True, timeout=300 * PATIENCE)
    assert done.returncode == 0, done.stdout + done.stderr
    assert os.stat(load / "curve.csv").st_mtime_ns == first, "the loading began anew"
    with open(tmp_path / "specimen.csv", newline="") as f:
        table = {r["kind"]: r for r in csv.DictReader(f)}
    assert set(table) == {"drained", "undrained", "cyclic", "uncemented"}
    assert float(table["drained"]["content_of_all"]) == pytest.approx(0.02, rel=1e-3) and float(table["uncemented"]["content_of_all"]) == 0
    assert float(table["drained"]["q_peak"]) > 3 * float(table["uncemented"]["q_at_end"]) and abs(float(table["undrained"]["volume_strain_at_end"])) < 1e-4
    assert int(table["drained"]["broken"]) == sum(int(table["drained"][m]) for m in ("debonding", "internal", "mixed"))
    with open(tmp_path / "waves.csv", newline="") as f:
        rows = list(csv.DictReader(f))
    assert [float(r["strain"]) for r in rows] == [0, 0.003] and all(float(r["shear"]) > 0 for r in rows)
    assert "calcite 2 %" in (tmp_path / "said.txt").read_text()
    for name in ("response_compression_0.02_0.05MPa", "response_undrained_0.02_0.05MPa", "response_cyclic_0.02_0.05MPa"):
        assert (tmp_path / f"{name}.png").stat().st_size > 20000, name
    again = subprocess.run(drive(tmp_path, *more, "--redraw"), capture_output=True, text=True, timeout=100 * PATIENCE)
    assert again.returncode == 0 and again.stdout.count("q ") >= 4


WRONG = {
    "both contents": (["--contents", "0.01"], "not allowed with argument"),
    "a kind": (["--confined", "wet"], "--confined wet: must be drained, undrained, cyclic or uncemented"),
    "a strain": (["--strain", "2"], "must be a number above 0, below 0.5"),
    "waves beyond the end": (["--waves", "0.01"], "--waves: needs --strain"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_arguments(name, tmp_path):
    more, message = WRONG[name]
    done = subprocess.run(drive(tmp_path / "out", *more), capture_output=True, text=True)
    assert done.returncode != 0 and message in done.stderr and "Traceback" not in done.stderr, done.stderr
