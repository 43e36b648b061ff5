# SPDX-License-Identifier: GPL-2.0-or-later
"""A run continued from a restart file is the run that was not interrupted."""
import shutil

import pytest
from scenes import cement, dump, edit, hosted, launch, pair, point_quantities, restarted, run, thermo

BEFORE, AFTER = 550, 100  # steps; damage and failure have begun at the restart
VECTORS = [[f"{v}{c}" for c in "xyz"] for v in ("", "v", "omega", "f")]
QUANTITIES = ["damage", "failed", "attached", "stress_zz", "stress_xy", "strain_yy", "axis_x"]
COLUMNS = sum(VECTORS, []) + [f"c_{q}" for q in QUANTITIES]
SCALARS = ["f_bond", "f_bond[4]", "f_bond[6]", "f_bond[17]", "f_cem[6]", "f_cem[8]", "f_cem[11]", "f_cem[12]"]
# Grain 2 moves away and rotates, which its cement only knows from its orientation.
LEAVING = "velocity second set 0.05 0.1 0.3\nset group second omegaz 300\n"
FIXES = cement(2e-4, 2e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9", couple="kn 2e12 kt 3e11")
MOVING = "fix motion grains nve/sphere\n"
OUTPUT = point_quantities(QUANTITIES) + thermo(10, SCALARS)
FIRST = pair(1e-4, gap=2e-4) + FIXES + LEAVING + MOVING + OUTPUT


def dumped(every, file):
    return dump(every, COLUMNS, f"{file}.*.txt", "all")


CONTINUED = restarted("middle.restart") + FIXES + MOVING + OUTPUT + dumped(50, "continued") + f"run {AFTER}\n"


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The uninterrupted run on a number of ranks; it leaves middle.restart."""
    results = {}

    def get(ranks):
        if ranks not in results:
            script = FIRST + f"run {BEFORE}\nwrite_restart middle.restart\n" + dumped(50, "points") + f"run {AFTER}\n"
            results[ranks] = run(script, tmp_path_factory.mktemp("first"), ranks)
            middle = results[ranks].points(BEFORE)
            assert middle["c_failed"].sum() > 10 and (middle["c_damage"] > 0).sum() > 100
        return results[ranks]

    return get


def continue_in(directory, first_run, ranks):
    shutil.copy(first_run.directory / "middle.restart", directory)
    return run(CONTINUED, directory, ranks)


@pytest.mark.parametrize("ranks", [1, 2])
def test_bitwise_identical(tmp_path, first, figures, ranks):
    a, b = first(ranks), continue_in(tmp_path, first(ranks), ranks)
    for step in (BEFORE, BEFORE + AFTER):
        p, q = a.points(step), b.points(step, "continued")
        different = [c for c in p if (p[c] != q[c]).any()]
        assert not different, f"step {step}: {different}"
    rows = AFTER // 10 + 1
    for name, column in b.table().items():
        # What accumulates is summed over the ranks by the file, in another order than before. The imbalance of the energy is a
        # difference over the energies already, so its rounding is that of 1.
        scale = 1.0 if name == "f_cem[12]" else abs(column).max()
        allowed = 0.0 if ranks == 1 else 1e-11 * scale
        assert abs(a.table()[name][-rows:] - column).max() <= allowed, name
    figures.note(f"restart, {ranks} rank(s)", f"{len(COLUMNS)} columns bitwise equal")


def test_on_more_ranks(tmp_path, first, figures):
    a, b = first(1), continue_in(tmp_path, first(1), 2)
    p, q = a.points(BEFORE + AFTER), b.points(BEFORE + AFTER, "continued")
    assert (p["id"] == q["id"]).all() and (p["c_failed"] == q["c_failed"]).all()
    for names in VECTORS + [[f"c_{q}"] for q in QUANTITIES]:
        scale = max(abs(p[n]).max() for n in names)
        worst = max(abs(p[n] - q[n]).max() for n in names)
        figures.below(f"restart, 1 -> 2 ranks, {' '.join(names)}: difference over the largest", worst / scale, 3e-13)


def test_written_during_a_run(tmp_path, figures):
    """`restart N a b` while points fail; the run goes on from the file of either name."""
    whole = run(FIRST + "restart 50 a.restart b.restart\nrun 530\n", tmp_path, 2)
    peak = whole.table()["f_bond"].max()
    for file, step in (("a.restart", 450), ("b.restart", 500)):
        again = edit(CONTINUED, "middle.restart", file)
        again = edit(again, f"run {AFTER}\n", "run 30\n")
        tail = run(again, tmp_path, 2, name=f"in.{file}").table()
        assert tail["step"][0] == step
        force = whole.table()["f_bond"][step // 10 :][: len(tail["f_bond"])]
        figures.below(
            f"restart written at step {step} of a run: bond force of the next 30 steps, over the peak", abs(force - tail["f_bond"]).max() / peak, 2e-15
        )


def test_events_before_the_file_are_in_the_log(tmp_path):
    """A run that dies between two checks, after it wrote a restart file, leaves the log complete up to that file."""

    def go_on(death):
        fixes = edit(FIXES, "cutoff 0.9", "cutoff 0.9 check 100000 events events.csv")
        return (
            pair(1e-4, gap=2e-4)
            + fixes
            + LEAVING
            + MOVING
            + f"variable trap equal 1/({death}-step)\n"
            + thermo(5, ["v_trap"])
            + "restart 575 r.*.bin\nrun 650\n"
        )

    whole = run(go_on(1000), tmp_path / "whole")
    rows = [line for line in (whole.directory / "events.csv").read_text().splitlines()[1:] if int(line.split(",")[0]) <= 575]
    dead = launch(go_on(600), tmp_path / "dead")
    assert dead.status != 0 and "Divide by 0" in dead.errors()[0] and (dead.directory / "r.575.bin").exists()
    found = (dead.directory / "events.csv").read_text().splitlines()[1:]
    assert len(rows) > 100 and found == rows


@pytest.mark.parametrize("ranks", [1, 2])
def test_table_goes_on_bitwise(tmp_path, ranks):
    """Of free grains, whose velocities at the step of the file differ from those of the run that wrote it: the table is that of
    a run that went on, with a fix after fix mpm too."""
    scene = FIXES + "fix g grains nve/sphere\n"
    push = "fix push second addforce 0 0 -5\n"
    whole = run(
        pair(1e-4, gap=2e-4)
        + edit(scene, "couple cem", "couple cem csv 10 bond.csv")
        + "velocity second set 0.03 0.02 1\n"
        + push
        + "run 100\nwrite_restart r.bin\nrun 100\n",
        tmp_path / "whole",
        ranks,
    )
    expected = (whole.directory / "bond.csv").read_text()
    first = "".join(line for line in expected.splitlines(True) if not line[0].isdigit() or int(line.split(",")[0]) <= 100)
    (tmp_path / "part").mkdir()
    (tmp_path / "part" / "bond.csv").write_text(first)
    part = run(restarted("../whole/r.bin") + edit(scene, "couple cem", "couple cem csv 10 bond.csv") + push + "run 100\n", tmp_path / "part", ranks)

    def cut(text):  # the imbalance, in which sums of ranks come in another order
        rows = [line.split(",") for line in text.splitlines()]
        at = rows[0].index("energy_imbalance")
        return [row.pop(at) for row in rows][1:], rows

    (imbalance, rows), (of_part, rows_of_part) = cut(expected), cut((part.directory / "bond.csv").read_text())
    assert rows_of_part == rows and len(rows) == 22
    assert max(abs(float(a) - float(b)) for a, b in zip(imbalance, of_part)) < 1e-14


def test_peak_goes_on_whoever_asks(tmp_path):
    """The largest tension of a bond, in the file and when a script reads it before the run goes on."""
    look = 'variable peak equal f_bond[21]\nprint "peak ${peak}"\n'
    turn = "run 200\nunfix pull\nfix pull second move linear 0 0 -20\nrun 100\n"
    first = run(
        pair(1e-4)
        + cement(2e-4, 1e-8)
        + "fix hold first move linear 0 0 0\nfix pull second move linear 0 0 0.02\n"
        + thermo(100, ["f_bond[14]", "f_bond[21]"])
        + turn
        + "write_restart r.bin\n"
        + look,
        tmp_path,
    )
    t = first.table()
    assert t["f_bond[14]"][-1] < 0.5 * first.value("peak")
    again = run(
        restarted("r.bin")
        + cement(2e-4, 1e-8)
        + "fix hold first move linear 0 0 0\nfix pull second move linear 0 0 -20\n"
        + look
        + thermo(1, ["f_bond[14]", "f_bond[21]"])
        + "run 1\n",
        tmp_path,
    )
    assert again.value("peak") == first.value("peak")
    assert (again.table()["f_bond[21]"] == t["f_bond[21]"][-1]).all()


@pytest.mark.parametrize(
    "changes, needed",
    [
        ([("cell 0.0002", "cell 0.00025")], ["fix mpm (id cem)", "cell 0.00025", "0.0002", "use"]),
        ([("cell 0.0002", "cell 0.0002 basis cubic")], ["fix mpm (id cem)", "basis cubic", "basis quadratic"]),
        ([("cell 0.0002", "cell 0.0002 kinematics updated")], ["fix mpm (id cem)", "kinematics updated", "kinematics total"]),
        ([("cell 0.0002", "cell 0.0002 edge free")], ["fix mpm (id cem)", "'edge free'", "restart file was written with 'edge tied'"]),
        ([("axis radial", "axis bond")], ["fix mpm (id cem)", "'axis bond'", "by 'axis radial'"]),
        ([("fix          cem", "fix          glue"), ("couple cem", "couple glue")], ["fix mpm (id glue)", "in motion", "ID"]),
    ],
    ids=["other cell", "other basis", "other kinematics", "other edge", "other axis", "other ID"],
)
def test_wrong_fix(tmp_path, first, changes, needed):
    shutil.copy(first(1).directory / "middle.restart", tmp_path)
    script = restarted("middle.restart") + FIXES + MOVING + "run 10\n"
    for old, new in changes:
        script = edit(script, old, new)
    result = launch(script, tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1000:]
    for word in needed:
        assert word in result.errors()[0]


BYTES_OF_SEAL = 40


@pytest.fixture
def whole(first):
    """Bytes of a restart file with its seal."""
    data = (first(1).directory / "middle.restart").read_bytes()
    if data[-BYTES_OF_SEAL : -BYTES_OF_SEAL + 8] != b"MPDEMend":
        pytest.skip("a LIGGGHTS with the package compiled in writes no seal")
    return data


def read_in(directory, data, ranks=1, name="middle.restart"):
    (directory / name).write_bytes(data)
    return launch(restarted("middle.restart") + FIXES + MOVING + "run 1\n", directory, ranks)


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("kept", [0, 3, 100, 300, 500, 5000, 0.5, -8, -BYTES_OF_SEAL, -1])
def test_truncated(tmp_path, whole, kept, ranks):
    """All of a file but its end, which `kept` says in bytes from the front or the back, or as a share."""
    result = read_in(tmp_path, whole[: int(kept * len(whole)) if isinstance(kept, float) else kept], ranks)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1000:]
    for word in ("read_restart", "middle.restart", "truncated"):
        assert word in result.errors()[0]
    assert result.errors()[0] in (tmp_path / "log.liggghts").read_text()


def test_every_changed_byte_shows(tmp_path, whole, figures):
    """One bit changed, anywhere in the file and its seal, or bytes lost or put in."""
    places = [0, 1, 40, 200, 400, len(whole) // 3, len(whole) - BYTES_OF_SEAL - 1] + list(range(len(whole) - BYTES_OF_SEAL, len(whole), 3))
    changed = [whole[:at] + bytes([whole[at] ^ 1 << at % 8]) + whole[at + 1 :] for at in places]
    changed += [whole[:1000] + whole[1001:], whole[:1000] + b"x" + whole[1000:], whole + b"x"]
    for number, data in enumerate(changed):
        result = read_in(tmp_path, data)
        assert result.status != 0 and len(result.errors()) == 1, (number, result.output[-1000:])
        assert "read_restart" in result.errors()[0] and ("damaged" in result.errors()[0] or "truncated" in result.errors()[0])
    figures.note("restart files with one bit or byte changed", f"{len(changed)} of {len(changed)} refused")


def test_version_and_programs_without_seal(tmp_path, whole):
    """A file of another version says so; one without seal whose writer makes none is read."""
    at = whole.index(b"MPDEMrst") + 8
    bare = whole[:-BYTES_OF_SEAL]
    for version in (2, 29, 31):
        result = read_in(tmp_path, bare[:at] + version.to_bytes(4, "little") + bare[at + 4 :])
        assert result.status != 0 and len(result.errors()) == 1
        for words in (f"version {version}, this program reads version 30", "go on with the USER-MPDEM that wrote the file", "write_cement"):
            assert words in result.errors()[0]
    result = read_in(tmp_path, bare[: at + 16] + bytes(4) + bare[at + 20 :])
    assert result.status == 0, result.output[-1000:]
    for bonds in ((1 << 20) + 1, (1 << 31) - 1):  # more than the file has
        result = read_in(tmp_path, bare[: at + 8] + bonds.to_bytes(4, "little") + bare[at + 12 : at + 16] + bytes(4) + bare[at + 20 :])
        assert result.status != 0 and "truncated" in result.errors()[0]


def test_split_over_ranks(tmp_path, whole):
    """A file a rank ('%' in the name); those of two writings do not mix."""
    script = FIRST + f"run {BEFORE}\nwrite_restart middle.%\nrun 1\nwrite_restart later.%\n"
    run(script, tmp_path, 2)
    again = edit(CONTINUED, "middle.restart", "middle.%")
    for ranks in (1, 2):
        run(edit(again, f"run {AFTER}\n", "run 1\n"), tmp_path, ranks)
    shutil.copy(tmp_path / "later.1", tmp_path / "middle.1")
    for ranks in (1, 2):
        result = launch(again, tmp_path, ranks)
        assert result.status != 0 and f"'middle.1' is not of step {BEFORE}" in result.errors()[0]
    data = (tmp_path / "later.0").read_bytes()
    (tmp_path / "later.0").write_bytes(data[:-100] + bytes([data[-100] ^ 2]) + data[-99:])
    result = launch(edit(again, "middle.%", "later.%"), tmp_path, 2)
    assert result.status != 0 and "'later.0' is damaged" in result.errors()[0]


def test_cannot_be_written(tmp_path, whole):
    result = launch(FIRST + "run 1\nwrite_restart /dev/full\n", tmp_path)
    assert result.status != 0 and "write_restart: '/dev/full' is not a regular file" in result.errors()[0]


def test_other_atom_styles_have_no_seal(tmp_path):
    """The file of atom_style sphere is that of `liggghts`, byte by byte."""
    program = shutil.which("liggghts")
    if program is None:
        pytest.skip("the stock program liggghts is not installed")
    if not hosted():
        pytest.skip("the head of the file names the build of the program")
    script = (
        "units si\natom_style sphere\nboundary f f f\nnewton off\nregion b block -1 1 -1 1 -1 1 units box\ncreate_box 1 b\n"
        "create_atoms 1 single 0 0 0 units box\nset type 1 diameter 0.1 density 2500\nneighbor 0.01 bin\n"
    )
    run(script + "write_restart ours.restart\n", tmp_path)
    assert launch(script + "write_restart theirs.restart\n", tmp_path, program=program).status == 0
    assert (tmp_path / "ours.restart").read_bytes() == (tmp_path / "theirs.restart").read_bytes()
    assert launch("read_restart theirs.restart\n", tmp_path).status == 0


def test_written_again_without_a_run(tmp_path, first):
    """The motion of nodes that no run has read would be lost."""
    shutil.copy(first(1).directory / "middle.restart", tmp_path)
    done = launch(edit(CONTINUED, f"run {AFTER}\n", "write_restart other.restart\n"), tmp_path)
    assert done.status != 0 and "use 'run 0' before write_restart" in done.errors()[0], done.output[-1000:]
    again = edit(CONTINUED, f"run {AFTER}\n", "run 0\nwrite_restart other.restart\n")
    run(again, tmp_path, name="in.again")
    one, other = continue_in(tmp_path, first(1), 1).table(), run(edit(CONTINUED, "middle", "other"), tmp_path, name="in.other").table()
    assert all((one[name] == other[name]).all() for name in SCALARS)


def test_cement_made_after_bond_stiffness(tmp_path, first):
    """A command that lays out the bonds of the file comes before a bond that the file does not have."""
    shutil.copy(first(1).directory / "middle.restart", tmp_path)
    more = (
        "create_atoms 1 single 0 0 -0.0122 units box\nset atom {id} diameter 0.004 density 2500\ngroup grains id {id}\n"
        "{look}create_cement calcite pair 1 {id} shape flat inner 0.3e-3 outer 0.9e-3 film grid spacing 1e-4\n"
    )
    tables = []
    for look in ("", "bond_stiffness k.csv\n"):
        script = edit(CONTINUED, f"run {AFTER}\n", more.format(id=first(1).points(BEFORE)["id"].max().astype(int) + 1, look=look) + f"run {AFTER}\n")
        tables.append(run(script, tmp_path, name=f"in.{len(look)}").table())
    assert all((tables[0][name] == tables[1][name]).all() for name in SCALARS)


def test_grains_on_a_side_of_a_subdomain(tmp_path):
    """LIGGGHTS exchanges atoms before it writes, and forces do not go along: grains that have crossed a side of a subdomain since have any force."""
    columns = thermo(1, ["f_cem[5]", "f_cem[6]", "f_bond[7]", "f_bond[10]"])

    def table(ranks, processors, write):
        script = edit(pair(1e-4, gap=2e-4, processors=processors), "create_cement", "displace_atoms grains move 1e-8 1e-8 0 units box\ncreate_cement")
        return run(
            script + FIXES + f"fix motion grains move linear -0.05 -0.05 0\nrun 300\n{write}{columns}run 5\n", tmp_path / f"{ranks}{len(write)}", ranks
        ).table()

    whole, crossed = table(1, "* * *", ""), table(4, "2 2 1", "write_restart crossed.restart\n")
    again = run(
        restarted("../430/crossed.restart", processors="2 2 1") + FIXES + "fix motion grains move linear -0.05 -0.05 0\n" + columns + "run 5\n",
        tmp_path / "again",
        4,
    ).table()
    for name in whole:
        assert abs(whole[name]).max() > 0, name
        for other in (crossed, again):
            assert abs(whole[name] - other[name]).max() <= 1e-9 * abs(whole[name]).max(), name


@pytest.mark.parametrize("divided", [80, 170])
def test_damped_pieces_in_parts(tmp_path, divided):
    """What is damped against which grain is found when the bond is examined, so a run that is divided later is the run as a whole."""
    script = pair(2e-4, gap=4e-4, cement="outer 1.5e-3 inner 0") + cement(
        4e-4, 1.6e-8, axis="radial", damage="damage tensor B0 9.6e3 quasistatic 2 0.05 check 50"
    )
    script += "velocity second set 0.2 0 2.0\n" + MOVING + thermo(10, ["f_bond[22]", "f_cem[2]", "f_cem[5]", "f_cem[8]", "f_cem[10]"])
    whole = run(script + "run 600\n", tmp_path / "whole").table()
    parts = run(script + f"run {divided}\nrun {600 - divided}\n", tmp_path / "parts").table()
    apart = 10 * int((whole["f_bond[22]"] > 0).argmax())
    assert 0 < apart < divided, apart
    for name in whole:
        a, b = whole[name], parts[name]
        b = [b[i] for i in range(len(b)) if i != divided // 10 + 1]
        assert abs(a - b).max() <= 1e-9 * abs(a).max(), name
