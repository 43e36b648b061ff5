# SPDX-License-Identifier: GPL-2.0-or-later
"""LIGGGHTS' own public tutorials give the same thermo output with liggghts-mpdem as with liggghts, to the last digit.

They come from the source of LIGGGHTS, which `make` fetches (tools/fetch_liggghts.sh). Runs are shortened, thermo
output is made denser and printed in full; nothing else of a script is changed.
"""
import os
import re
import shutil
import signal
import subprocess
import tarfile
from pathlib import Path

import pytest
from scenes import PATIENCE, executable, hosted, start

TARBALL = "liggghts_3.8.0+repack1.orig.tar.xz"
FOLDER = "LIGGGHTS-PUBLIC-3.8.0/examples/LIGGGHTS/Tutorials_public/"

# The longest that a `run` takes: long enough for contacts, and for every phase of a script.
STEPS = {
    "ParScale/fluidizedBedTempParScale/in.liggghts_init": 10000,
    "chute_wear/in.chute_wear": 15000,
    "cohesion/in.cohesion": 7000,
    "cohesion/in.noCohesion": 7000,
    "contactModels/in.newModels": 3000,
    "conveyor/in.conveyor": 30000,
    "heatTransfer_1/in.heatGran": 4000,
    "heatTransfer_2/in.heatGran": 3000,
    "hydrogel_multicontact/in.hydrogel_default": 1000,
    "hydrogel_multicontact/in.hydrogel_multicontact": 40,
    "hysteresis/in.hysteresis": 7000,
    "hysteresis/in.noHysteresis": 7000,
    "insert_stream/in.insert_stream": 20000,
    "insert_stream/in.insert_stream_reset_timestep": 20000,
    "meshGran/in.meshGran": 10000,
    "mesh_tet/in.mesh_tet": 300,
    "movingMeshGran/in.movingMeshGran": 3000,
    "multisphere_stone_restitution/in.multisphere": 15000,
    "packing/in.packing": 10000,
    "sph_1/in.sph_1": 300,
    "sph_2/in.sph_2": 1500,
}

# Those that Debian's liggghts does not run, and the error it stops with.
FAILING = {
    # radii of ParScale's own LIGGGHTS; the next one needs the ParScale library
    "ParScale/heatTransferBed_paScal/in.liggghts": "invalid radius random style",
    "ParScale/fluidizedBedTempParScale/in.liggghts_run": 'Invalid fix style: "couple/pascal"',
    "contactModels/in.oldModels": "Invalid pair style",  # syntax of LIGGGHTS 2
    "superquadric/in.particle_particle": "Invalid atom style",  # built without superquadrics
}

# Not scripts of LIGGGHTS: variables that another includes, and input of ParScale.
OTHER = {
    "ParScale/fluidizedBedTempParScale/in.DEM",
    "ParScale/fluidizedBedTempParScale/pascal/in.pascal",
    "ParScale/heatTransferBed_paScal/pascal/in.pascal",
}

# What has to run before in the same folder, for its restart file.
BEFORE = {
    "insert_stream/in.insert_stream_reset_timestep": "insert_stream/in.insert_stream",
    "ParScale/fluidizedBedTempParScale/in.liggghts_run": "ParScale/fluidizedBedTempParScale/in.liggghts_init",
}
# Not on both 1 and 2 ranks.
RANKS = {
    # on two, both programs end with MPI_ERR_TRUNCATE in the communication of fix multicontact/halfspace
    "hydrogel_multicontact/in.hydrogel_multicontact": [1],
    # the `processors` command fits one number of ranks only
    "multisphere_stone_restitution/in.multisphere": [1],
    "ParScale/fluidizedBedTempParScale/in.liggghts_run": [2],
}


@pytest.fixture(autouse=True)
def fresh_memory_is_zero(monkeypatch):
    """What a tutorial computes from memory that LIGGGHTS never wrote to (doc/reliability.md) is no difference of programs."""
    monkeypatch.setenv("ASAN_OPTIONS", os.environ.get("ASAN_OPTIONS", "") + ":max_malloc_fill_size=0")


@pytest.fixture(scope="module")
def stock():
    program = shutil.which("liggghts", path="/usr/bin:/usr/local/bin")
    if not program:
        pytest.skip("the stock program liggghts is not installed")
    if not hosted():
        pytest.skip("a LIGGGHTS compiled anew rounds otherwise than Debian's, and may lack its VTK dumps")
    return program


@pytest.fixture(scope="module")
def tutorials(tmp_path_factory):
    folder = tmp_path_factory.mktemp("source")
    beside = Path(executable()).parent / TARBALL  # where `make` puts it
    if not beside.exists():
        tool = Path(__file__).parents[2] / "tools" / "fetch_liggghts.sh"
        try:
            complaint = subprocess.run([tool, folder], capture_output=True, text=True, timeout=200 * PATIENCE).stderr
        except subprocess.TimeoutExpired:
            complaint = "no answer"
        beside = folder / TARBALL
        if not beside.exists():
            pytest.skip(f"no tutorials: {TARBALL} is not beside the executable, and Debian's archive is out of reach: " + complaint[-500:])
    with tarfile.open(beside) as source:
        source.extractall(folder, [m for m in source if m.name.startswith(FOLDER)])
    return folder / FOLDER


def shortened(text, steps):
    runs = re.findall(r"^\s*run\s", text, re.M)
    text, changed = re.subn(
        r"^(\s*run\s+)(\d+|\$\{\w+\})( +upto\b)?", lambda m: f"{m[1]}{min(int(m[2]), steps) if m[2].isdigit() else steps}", text, flags=re.M
    )
    assert changed == len(runs), "a run command of an unknown form"
    # The limit that check/timestep/gran reports is known at its own steps only.
    every = r"\2" if "check/timestep/gran" in text else "100"
    text, changed = re.subn(r"^(\s*thermo\s+)(\S+)$", rf"\g<1>{every}\nthermo_modify format float %.17g", text, flags=re.M)
    assert changed <= 1
    return text


def table(output):
    """Names and rows of the thermo output without the columns that depend on the clock, and what ends a run."""
    found, names = [], None
    for line in output.splitlines():
        words = line.split()
        if words[:1] == ["Step"]:
            names = words
            found.append([n for n in names if n != "CPU"])
        elif line.startswith("Loop time"):
            names = None
        elif names and len(words) == len(names) and words[0].isdigit():
            found.append([w for n, w in zip(names, words) if n != "CPU"])
        elif re.match(r"Total #|Neighbor list builds|Dangerous", line):
            found.append(words)
    return found


def run_both(programs, tutorials, directory, name, ranks, steps):
    """Exit status and output with each program, both at the same time."""
    folder, script = Path(name).parent, Path(name).name
    processes = []
    for label, program in programs.items():
        at = directory / label
        if not at.exists():
            shutil.copytree(tutorials / folder, at)
        text = (tutorials / name).read_text()
        processes.append(start(shortened(text, steps), at, ranks, program=program, name=script))
    try:
        for p in processes:
            p.wait(200 * PATIENCE)
    finally:
        for p in processes:
            if p.poll() is None:
                os.killpg(p.pid, signal.SIGKILL)
                p.wait()
    return [(p.returncode, (directory / label / f"{script}.out").read_text(errors="replace")) for p, label in zip(processes, programs)]


def cases(table):
    return [pytest.param(name, ranks, id=f"{name}-{ranks}") for name in table for ranks in RANKS.get(name, [1, 2])]


def test_none_is_left_out(tutorials):
    scripts = {str(f.relative_to(tutorials)) for f in tutorials.rglob("in.*")}
    assert scripts == set(STEPS) | set(FAILING) | OTHER


@pytest.mark.parametrize("name, ranks", cases(STEPS))
def test_same_output(name, ranks, stock, tutorials, tmp_path, figures):
    # Two ranks change nothing but the order of sums and the communication, and take their time.
    divisor = ranks**2
    programs = {"liggghts": stock, "liggghts-mpdem": executable()}
    for script in [BEFORE[name]] if name in BEFORE else []:
        run_both(programs, tutorials, tmp_path, script, ranks, STEPS[script] // divisor)
    (status, theirs), (ours_status, ours) = run_both(programs, tutorials, tmp_path, name, ranks, STEPS[name] // divisor)
    assert status == 0, f"{name} fails with {stock}:\n{theirs[-2000:]}"
    assert ours_status == 0, ours[-2000:]
    rows = table(theirs)
    assert len(rows) > 8 and table(ours) == rows
    figures.note(f"tutorial {name}, {ranks} rank(s)", f"{len(rows)} lines equal to those of {Path(stock).name}")


@pytest.mark.parametrize("name, ranks", [c for c in cases(FAILING) if c.values[1] == RANKS.get(c.values[0], [1])[0]])
def test_same_error(name, ranks, stock, tutorials, tmp_path, figures):
    programs = {"liggghts": stock, "liggghts-mpdem": executable()}
    for script in [BEFORE[name]] if name in BEFORE else []:
        run_both(programs, tutorials, tmp_path, script, ranks, 100)
    (status, _), (ours_status, ours) = run_both(programs, tutorials, tmp_path, name, ranks, 100)
    assert status != 0 and ours_status != 0
    assert FAILING[name] in ours, ours[-2000:]
    figures.note(f"tutorial {name}", f"stops with both: {FAILING[name]}")
