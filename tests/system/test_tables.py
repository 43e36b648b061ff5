# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of the bonds and of the events: rows of a run in parts are those of the run left alone, and none is lost in silence."""
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from scenes import cement, edit, executable, launch, pair, restarted, run, thermo

CELL, SPACING = 4e-4, 2e-4
FIXES = cement(CELL, 2e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9 check 20 events events.csv", couple="kn auto kt auto csv 7 bond.csv")
HEAD, MOTION = pair(SPACING, gap=1e-4), "fix motion grains nve/sphere\n"
LEAVING = "velocity second set 0.2 0.4 1.2\nset group second omegaz 300\n"
FIRST = HEAD + FIXES + LEAVING + MOTION
AGAIN = restarted("r") + FIXES + MOTION


def tables(directory):
    return {name: (directory / name).read_bytes() for name in ("bond.csv", "events.csv")}


def same(found, expected):
    """Words, steps and counts are the same. The start of a run finds the forces anew, so other numbers are so to rounding, and the last of ten
    digits may differ where they nearly cancel. The imbalance of the energy is relative already, and next to rounding."""
    for name in expected:
        rows, others = ([line.split(b",") for line in tables[name].splitlines()] for tables in (found, expected))
        if rows[0] != others[0] or len(rows) != len(others):
            return False
        for title, column, other in zip(rows[0], zip(*rows[1:]), zip(*others[1:])):
            try:
                a, b = (np.array(c, dtype=float) for c in (column, other))
            except ValueError:
                a, b = None, None
            if column != other and (a is None or abs(a - b).max() > (1e-13 if title == b"energy_imbalance" else 1e-9 * abs(b).max())):
                return False
    return True


def steps(text):
    return [int(line.split(b",")[0]) for line in text.splitlines()[1:]]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    directory = tmp_path_factory.mktemp("whole")
    run(FIRST + "run 520\n", directory)
    found = tables(directory)
    assert steps(found["bond.csv"]) == list(range(0, 521, 7)) and len(found["events.csv"].splitlines()) > 20
    return found


def test_run_in_parts(tmp_path, whole):
    run(FIRST + "run 300\nrun 0\nrun 150\nrun 70 pre no\n", tmp_path)
    assert same(tables(tmp_path), whole)


def test_first_row_of_steps_that_begin_at_one(tmp_path):
    run(HEAD + "reset_timestep 1\n" + edit(FIXES, "csv 7", "csv 1") + LEAVING + MOTION + "run 5\n", tmp_path)
    assert steps(tables(tmp_path)["bond.csv"]) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("at", [300, 301, 350])
def test_restart(tmp_path, whole, at):
    """The file is of a step with a row, or of one without; steps that the first run made beyond it do not stay."""
    run(FIRST + f"run {at}\nwrite_restart r\nrun 33\n", tmp_path)
    run(AGAIN + f"run {520 - at}\n", tmp_path)
    assert same(tables(tmp_path), whole)


def test_coupling_defined_anew(tmp_path, whole):
    again = next(line for line in FIXES.splitlines(True) if "mpm/couple" in line)
    for at in (300, 350):
        run(FIRST + f"run {at}\nunfix bond\n{again}run {520 - at}\n", tmp_path)
        assert same(tables(tmp_path), whole)


def test_rows_of_another_scene_do_not_stay(tmp_path):
    """Cement that is made late in a run has a table of its own, whatever the file held."""
    late = HEAD.replace("create_cement", "fix hold grains freeze\nrun 100\nunfix hold\ncreate_cement") + FIXES + LEAVING + MOTION
    late = late.replace("group        grains type 1\n", "group        grains type 1\ntimestep 2e-9\n")
    run(late + "run 50\n", tmp_path)
    clean = tables(tmp_path)
    assert steps(clean["bond.csv"]) == [105, 112, 119, 126, 133, 140, 147]
    row = clean["bond.csv"].splitlines(True)[1].replace(b"105,", b"14,", 1)
    (tmp_path / "bond.csv").write_bytes(clean["bond.csv"].splitlines(True)[0] + row)
    run(late + "run 50\n", tmp_path)
    assert tables(tmp_path) == clean


def test_other_columns_are_not_overwritten(tmp_path):
    run(FIRST + "run 14\nwrite_restart r\n", tmp_path)
    (tmp_path / "bond.csv").write_text("my,notes\n")
    result = launch(AGAIN + "run 7\n", tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1
    for word in ("fix mpm/couple (id bond)", "bond.csv", "other columns", "name another"):
        assert word in result.errors()[0]
    assert (tmp_path / "bond.csv").read_text() == "my,notes\n"


# Called by the script: no file of the program that called it grows beyond so many bytes any more. MPI needs larger ones to begin with.
LIMIT = """\
import os, resource, sys
pid = os.getppid()
while os.readlink(f"/proc/{pid}/exe") != sys.argv[1]:
    pid = int(open(f"/proc/{pid}/stat").read().rsplit(")", 1)[1].split()[1])
resource.prlimit(pid, resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.prlimit(pid, resource.RLIMIT_FSIZE)[1]))
"""
ROOM = 12000


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("file", ["bond.csv", "events.csv"])
def test_disk_that_gets_full(tmp_path, whole, file, ranks):
    """The run stops with a message; the file has whole rows up to there."""
    program = tmp_path / "program"
    program.write_text(f"#!/bin/sh\ntrap '' XFSZ\nexec {executable()} \"$@\"\n")  # so that it is told, not killed
    os.chmod(program, 0o755)
    (tmp_path / "limit.py").write_text(LIMIT)
    script = edit(FIRST, "csv 7 bond.csv" if file == "events.csv" else "events events.csv", "")
    result = launch(script + f"shell {sys.executable} limit.py {os.path.realpath(executable())} {ROOM}\nrun 520\n", tmp_path, ranks, program=str(program))
    assert result.status != 0, result.output[-1500:]
    assert len(result.errors()) == 1, result.output[-1500:]
    for word in ("cannot write", file, "File too large", "disk with free space"):
        assert word in result.errors()[0]
    found = (tmp_path / file).read_bytes()
    assert 0.5 * ROOM < len(found) <= ROOM and found.endswith(b"\n")
    if ranks == 1:  # two round sums in another order
        assert whole[file].startswith(found)
    assert len({line.count(b",") for line in found.splitlines()}) == 1


@pytest.mark.parametrize("alias", ["symbolic link", "hard link", "path"])
def test_one_file_by_two_names(tmp_path, alias):
    (tmp_path / "bond.csv").write_text("")
    (tmp_path / "sub").mkdir()
    name = {"path": "sub/../bond.csv"}.get(alias, "other.csv")
    if alias == "symbolic link":
        (tmp_path / name).symlink_to("bond.csv")
    elif alias == "hard link":
        os.link(tmp_path / "bond.csv", tmp_path / name)
    result = launch(edit(FIRST, "events events.csv", f"events {name}") + "run 10\n", tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1
    for word in ("fix mpm (id cem)", name, "'csv' of fix mpm/couple (id bond)", "name another"):
        assert word in result.errors()[0]


def test_devices_take_both(tmp_path, whole):
    """A device that is named twice is written to twice, and stays what it is; the run is that which has files."""
    script = edit(edit(FIRST, "events events.csv", "events /dev/null"), "csv 7 bond.csv", "csv 7 /dev/null")
    table = run(script + thermo(40, ["f_bond[14]", "f_bond[18]"]) + "run 520\n", tmp_path).table()
    assert Path("/dev/null").is_char_device() and not list(tmp_path.glob("*.csv"))
    assert table["step"][-1] == 520 and table["f_bond[18]"][-1] == len(whole["events.csv"].splitlines()) - 1
    names, *rows = [line.split(b",") for line in whole["bond.csv"].splitlines()]
    of_files = {int(r[0]): float(r[names.index(b"tension")]) for r in rows}
    both = [(f, of_files[int(s)]) for s, f in zip(table["step"], table["f_bond[14]"]) if int(s) in of_files]
    assert len(both) > 1 and all(abs(a - b) <= 1e-9 * max(of_files.values()) for a, b in both)


def test_places_and_names(tmp_path):
    """Value n of the vector, value n of the first row of the array and column n of the table are the same, to the last of them."""
    script = pair(1e-4, gap=1e-4) + cement(2e-4, 2e-9, axis="radial", damage="damage tensor B0 9.6e3", couple="csv 250 bond.csv") + LEAVING + MOTION
    names = (run(script + "run 0\n", tmp_path).directory / "bond.csv").read_text().splitlines()[0].split(",")[5:-1]
    places = range(1, len(names) + 1)
    script += thermo(250, [f"f_bond[{n}]" for n in places] + [f"f_bond[1][{n}]" for n in places])
    result = run(script + "run 250\n", tmp_path)
    row = (tmp_path / "bond.csv").read_text().splitlines()[-1].split(",")
    assert row[0] == "250" and int(row[5 + names.index("failed")]) > 0 and len(row) == len(names) + 6
    table = result.table()
    for n, name in zip(places, names):
        for value in (table[f"f_bond[{n}]"][-1], table[f"f_bond[1][{n}]"][-1]):
            assert f"{value:.10g}" == row[4 + n], name
    more = launch(script.replace(f"f_bond[{len(names)}]", f"f_bond[{len(names) + 1}]") + "run 0\n", tmp_path, 1)
    assert more.status != 0


@pytest.mark.parametrize(
    "words, ranks", [("", 1), ("", 2), ("condense yes wake 0.7", 1), ("condense yes wake 0.7", 2), ("subcycle 4", 1), ("condense yes wake 0.7 subcycle 4", 2)]
)
def test_peak_is_that_of_every_step(words, ranks, tmp_path, figures):
    """A bond that swings and then fails: its largest tension is that of every step, however seldom a row asks for it, and over a restart."""
    dt, steps = (8e-9, 300) if "subcycle" in words else (2e-9, 1200)
    scene = pair(SPACING, gap=1e-4, processors="1 1 2" if ranks == 2 else "* * *")
    fixes = cement(CELL, dt, axis="radial", damage=f"damage tensor B0 9.6e3 {words}", couple="kn auto kt auto") + MOTION
    start = scene + fixes + "velocity second set 0.1 0.2 0.6\nset group second omegaz 300\nvariable awake equal f_cem[24]\n"
    each = run(start + thermo(1, ["f_bond[14]", "f_bond[21]", "v_awake"]) + f"run {steps}\n", tmp_path / "each", ranks).table()
    assert "condense" not in words or 0 < each["v_awake"].argmax() < steps / 2, "the bond is to wake on its way"
    tension, half = each["f_bond[14]"][1:], steps // 2
    assert 0 < tension.argmax() < steps - 1
    seldom = run(
        start + f"run {half}\nwrite_restart half.restart\n" + thermo(steps, ["f_bond[21]"]) + f"run {steps - half}\n", tmp_path / "seldom", ranks
    ).table()
    parted = run(restarted("../seldom/half.restart") + fixes + thermo(steps, ["f_bond[21]"]) + f"run {steps - half}\n", tmp_path / "parted", ranks).table()
    most = tension.max()
    for what, found in (("each step", each), ("the end", seldom), ("the end after a restart", parted)):
        figures.below(
            f"{words or 'one clock'}, {ranks} ranks: peak_tension asked for at {what}, off the largest tension, over it",
            abs(found["f_bond[21]"][-1] / most - 1),
            6e-15,
        )
    assert (np.diff(each["f_bond[21]"][1:]) >= 0).all()
