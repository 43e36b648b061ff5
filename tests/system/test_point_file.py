# SPDX-License-Identifier: GPL-2.0-or-later
"""Cement as text: write_cement and create_cement ... file, and constructed cracks with a known mode."""
import re

import numpy as np
import pytest
from scenes import RADIUS, cement, edit, launch, pair, pull, run, shift, thermo

SPACING, CELL = 1e-4, 2e-4
MADE = f"create_cement calcite pair 1 2 shape flat inner 1e-3 outer 2e-3 film grid spacing {SPACING:.15g}\n"
DAMAGE = "damage tensor B0 9.6e6 cutoff 0.9"
PULL = pull(4.0, 2e-6) + thermo(20, ["f_bond", "f_bond[13]", "f_bond[17]", "f_cem[8]"])


def from_file(name="cement.txt", words="", **options):
    return edit(pair(SPACING, **options), MADE, f"create_cement calcite pair 1 2 file {name} spacing {SPACING:.15g} {words}\n")


def read(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    table = np.array([[float(w) for w in line.split()] for line in lines[1:]])
    return dict(zip(lines[0].split(), table.T))


def write(path, columns):
    path.parent.mkdir(exist_ok=True)
    rows = np.column_stack(list(columns.values()))
    path.write_text("# a comment\n\n" + " ".join(columns) + "  # names\n" + "".join(" ".join(f"{v:.17g}" for v in row) + "\n" for row in rows))


def only(columns, *groups):
    return {n: columns[n] for n in " ".join(groups).split()}


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    """The cement of the scene, written before any fix: no axes yet."""
    directory = tmp_path_factory.mktemp("ring")
    run(pair(SPACING) + "write_cement cement.txt\n", directory)
    return read(directory / "cement.txt")


def test_round_trip(tmp_path, figures):
    """What was written, read and written again is the same, and breaks alike on any number of ranks."""
    body = cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + PULL + "run 700\n"
    made = run(pair(SPACING) + "write_cement ../cement.txt\n" + body, tmp_path / "made").table()
    assert made["f_bond[17]"][-1] > 100
    for ranks in (1, 2):
        again = run(from_file("../cement.txt") + f"write_cement again{ranks}.txt\n" + body, tmp_path / f"read{ranks}", ranks).table()
        a, b = read(tmp_path / "cement.txt"), read(tmp_path / f"read{ranks}" / f"again{ranks}.txt")
        assert a.keys() == b.keys()
        worst = max(np.abs(a[n] - b[n]).max() / max(np.abs(a[n]).max(), 1e-300) for n in a)
        figures.below(f"{ranks} ranks: written, read and written again, relative change of any column", worst, 1e-14)
        for name in ("f_bond", "f_cem[8]"):
            error = abs(made[name] - again[name]).max() / abs(made[name]).max()
            figures.below(f"{ranks} ranks: {name} of cement from a file against the made one", error, 2e-9)


def test_round_trip_of_a_skew_bond(tmp_path, figures):
    """The lattice along the axes of the bond is found: damage, axes and foot points are rotated into them and back, and the bond breaks as the one it came from."""
    n, box = (1, 2, 3), 3 * (12.5e-3,)
    made = pair(SPACING, direction=n, half_box=box)
    body = cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + pull(8.0, 2e-6, n) + thermo(10, ["f_bond", "f_cem[8]", "f_bond[17]"])
    kept = made[: made.index("create_cement")] + f"create_cement calcite pair 1 2 file ../whole.txt spacing {SPACING:.15g}\n"
    one = run(made + "write_cement ../whole.txt\n" + body + "run 700\nwrite_cement ../cracked.txt\n", tmp_path / "made").table()
    assert one["f_bond[17]"][-1] > 100
    two = run(kept + body + "run 700\n", tmp_path / "read").table()
    for name in ("f_bond", "f_cem[8]"):
        figures.below(f"skew bond from a file: {name} against the made one", abs(one[name] - two[name]).max() / abs(one[name]).max(), 6e-10)
    # Damage and axes once more, with the grains where they began.
    rest = cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + "fix move grains nve/sphere\nrun 0\n"
    first = run(made + rest + "write_cement ../rest.txt\n", tmp_path / "rest")
    a = read(tmp_path / "rest.txt")
    lines = (tmp_path / "rest.txt").read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("grain_i"))
    columns = lines[head].split()
    for i in range(head + 1, len(lines)):
        words = lines[i].split()
        for c, value in zip(("dxx", "dyy", "dzz", "dyz", "dxz", "dxy"), (0.5, 0.2, 0.3, 0.1, -0.05, 0.07)):
            words[columns.index(c)] = str(value)
        lines[i] = " ".join(words)
    (tmp_path / "damaged.txt").write_text("\n".join(lines) + "\n")
    run(edit(kept, "whole.txt", "damaged.txt") + rest + "write_cement ../again.txt\n", tmp_path / "again")
    b, wanted = read(tmp_path / "again.txt"), read(tmp_path / "damaged.txt")
    assert first.status == 0 and a.keys() == b.keys()
    worst = max(np.abs(wanted[c] - b[c]).max() / max(np.abs(wanted[c]).max(), 1e-300) for c in b)
    figures.below("skew bond with damage: written, read and written again, relative change of any column", worst, 1e-13)
    # Before there is a fix mpm, points have no axes.
    table = only(wanted, "x y z volume dxx dyy dzz dyz dxz dxy")
    write(tmp_path / "bare.txt", table)
    run(edit(kept, "whole.txt", "bare.txt") + "write_cement ../early.txt\n", tmp_path / "early")
    c = read(tmp_path / "early.txt")
    worst = max(np.abs(table[k] - c[k]).max() / max(np.abs(table[k]).max(), 1e-300) for k in table)
    figures.below("skew bond with damage: written before any run, relative change of any column", worst, 1e-14)


def test_round_trip_of_a_broken_bond(tmp_path, figures):
    """Damage, axes, failed points and debonded links survive, though a grain has moved."""
    script = (
        pair(SPACING) + cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + PULL + "run 700\n"
        "write_cement cement.txt\n"
        "variable q1 equal x[1]\nvariable q2 equal z[1]\nvariable q3 equal x[2]\nvariable q4 equal z[2]\n"
        'print "GRAINS ${q1} ${q2} ${q3} ${q4}"\n'
    )
    first = run(script, tmp_path / "first")
    a = read(tmp_path / "first" / "cement.txt")
    assert a["failed"].sum() > 100 and (a["area_i"] > 0).sum() > (a["attached_i"] > 0).sum() > 0
    assert 0.01 < abs(a["ax"]).max() and (a["dzz"] > 0.1).any()
    where = [float(w) for w in first.output.split("\nGRAINS ")[1].split("\n")[0].split()]
    assert where[3] > RADIUS + 5e-6
    centres = f"{where[0]:.17g} 0 {where[1]:.17g}", f"{where[2]:.17g} 0 {where[3]:.17g}"
    text = from_file("../first/cement.txt")
    text = edit(edit(text, f"0 0 {-RADIUS:.15g}", centres[0]), f"0 0 {RADIUS:.15g}", centres[1])
    run(text + cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + "fix move grains nve/sphere\nrun 0\nwrite_cement again.txt\n", tmp_path / "second")
    b = read(tmp_path / "second" / "again.txt")
    for n in a:
        scale = np.abs(a[n]).max() if n.startswith("foot") or n in "xyz" else max(np.abs(a[n]).max(), 1e-300)
        figures.below(f"broken bond, column {n}: change", np.abs(a[n] - b[n]).max() / scale if scale else 0.0, 8e-14)


def test_attached_points_are_found(ring, tmp_path, figures):
    """Positions and volumes alone: areas within 2 %, stiffness within 3 % of the cement made by shape."""

    def stiffness(script, directory):
        script += cement(CELL, 1e-8) + shift(1e-8, 8e-6) + "run 800\n" + thermo(4, ["f_bond"]) + "run 400\n"
        done = run(script, directory)
        return done, done.table()["f_bond"].mean()

    write(tmp_path / "file" / "cement.txt", only(ring, "x y z volume"))
    _, exact = stiffness(pair(SPACING), tmp_path / "made")
    done, found = stiffness(from_file(), tmp_path / "file")
    line = next(x for x in done.output.splitlines() if "attached area" in x)
    area = float(line.split("attached area ")[1].split()[0])
    figures.note("signed error of the attached area from positions alone", f"{area / ring['area_i'].sum() - 1:+.4f}")
    figures.note("signed change of the stiffness", f"{found / exact - 1:+.4f}")
    figures.below("error of the attached area from positions alone", abs(area / ring["area_i"].sum() - 1), 0.02)
    figures.below("change of the stiffness", abs(found / exact - 1), 0.03)


def test_principal_damage_is_the_tensor(ring, tmp_path):
    """Damage by principal values and directions, with and without axes, is what compute mpm/atom sees."""
    t = np.pi / 6
    n = len(ring["x"])
    column = dict(only(ring, "x y z volume"))
    values = {"d1": 0.5, "d2": 0.2, "d3": 0.1, "v1x": np.cos(t), "v1y": np.sin(t), "v1z": 0, "v2x": -np.sin(t), "v2y": np.cos(t), "v2z": 0}
    for k, v in values.items():
        column[k] = np.full(n, v)
    c, s = np.cos(t), np.sin(t)
    exact = {
        "damage_xx": 0.5 * c * c + 0.2 * s * s,
        "damage_yy": 0.5 * s * s + 0.2 * c * c,
        "damage_zz": 0.1,
        "damage_xy": 0.3 * s * c,
        "damage_yz": 0.0,
        "damage_xz": 0.0,
    }
    for axes in (False, True):
        if axes:
            column.update(ax=np.full(n, 0.6), ay=np.zeros(n), az=np.full(n, 0.8))
        directory = tmp_path / f"axes{axes}"
        write(directory / "cement.txt", column)
        names = list(exact) + ["axis_x"]
        script = from_file() + cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + "fix move grains nve/sphere\n"
        script += "".join(f"compute {q} calcite mpm/atom cem {q}\n" for q in names)
        script += f"dump d calcite custom 1 points.*.txt id {' '.join('c_' + q for q in names)}\nrun 0\n"
        points = run(script, directory).points(0)
        for q, v in exact.items():
            assert points[f"c_{q}"] == pytest.approx(v, abs=2e-6), q
        assert (abs(points["c_axis_x"] - 0.6) < 1e-5).all() == axes


# Cracks cut into the ring beforehand: failed points, the rest whole.  What is left is pulled gently, so nothing else fails.
def beside(ring, side, layers=1.0):
    """Points attached to one grain."""
    return ring[("area_i", "area_j")[side]] > 0


CRACKS = {
    "internal plane": (lambda r: abs(r["z"]) < SPACING, "internal"),
    "debonding at the first grain": (lambda r: beside(r, 0), "debonding"),
    "debonding at the second grain": (lambda r: beside(r, 1), "debonding"),
    "half and half": (lambda r: np.where(r["x"] < 0, beside(r, 1), (abs(r["z"]) < SPACING)) | ((abs(r["x"]) < SPACING) & (r["z"] > -SPACING)), "mixed"),
    "inner half of the ring": (lambda r: (abs(r["z"]) < SPACING) & (np.hypot(r["x"], r["y"]) < 1.5e-3), "intact"),
    "half plane": (lambda r: (abs(r["z"]) < SPACING) & (r["x"] < 0), "intact"),
    "none": (lambda r: np.zeros(len(r["x"]), bool), None),
}


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("unilateral, damage, warned", [("yes", 0.0, True), ("yes", 0.95, False), ("no", 0.0, False)])
def test_failed_points_without_damage(ring, tmp_path, unilateral, damage, warned, ranks):
    """Their cracks have no direction and do not close, which a user has to know."""
    column = dict(ring)
    column["failed"] = (abs(ring["z"]) < SPACING).astype(float)
    column["dzz"] = damage * column["failed"]
    write(tmp_path / "cement.txt", column)
    done = run(
        from_file() + cement(CELL, 5e-9, axis="radial", damage=f"{DAMAGE} unilateral {unilateral}") + shift(1e-9, 1e-6) + "run 1\nrun 1\n", tmp_path, ranks
    )
    told = [line for line in done.output.splitlines() if "never close" in line]
    assert len(told) == warned, done.output[-2000:]
    if warned:
        assert f" {int(column['failed'].sum())} points failed and have no damage" in told[0] and "'d1 d2 d3 v1x" in told[0]


@pytest.mark.parametrize("crack", CRACKS)
def test_mode_of_a_constructed_crack(ring, tmp_path, figures, crack):
    where, mode = CRACKS[crack]
    column = dict(ring)
    column["failed"] = where(ring).astype(float)
    write(tmp_path / "cement.txt", column)
    done = run(from_file() + cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + shift(1e-9, 1e-6) + thermo(1, ["f_cem[2]"]) + "run 200\n", tmp_path)
    lines = [x for x in done.output.splitlines() if "of grains 1 and 2: " in x]
    assert (done.table()["f_cem[2]"] == column["failed"].sum()).all()
    if mode is None:
        assert not lines
        return
    assert f": {mode}," in lines[-1], lines
    if mode != "intact":
        shares = [float(w) for w in re.findall(r"(\S+) % ", lines[-1])]
        figures.note(f"{crack}: per cent at the first grain, the second, inside", shares)
        assert sum(shares) == pytest.approx(100, abs=0.01)
        expected = {
            "internal plane": (0, 0, 100),
            "debonding at the first grain": (100, 0, 0),
            "debonding at the second grain": (0, 100, 0),
            "half and half": (0, 50, 50),
        }[crack]
        assert shares == pytest.approx(expected, abs=10)


# name: (columns and rows, words of the message).  Grains of radius 5 mm at z = -5 and 5 mm.
HEAD, ROW = "x y z volume", "0.001 0 0.00005 1e-12"
BAD = {
    "short line": (f"{HEAD}\n{ROW}\n0 0 0\n", ["line 3", "3 numbers", "4 columns"]),
    "not a number": (f"{HEAD}\n0.0015 0 1e-4mm 1e-12\n", ["line 2", "1e-4mm", "'z'", "not a number"]),
    "nan": (f"# here\n{HEAD}\n0.0015 0 nan 1e-12\n", ["line 3", "nan", "'z'", "finite"]),
    "infinite": (f"{HEAD}\n0.0015 0 0 1e999\n", ["line 2", "1e999", "'volume'", "finite"]),
    "volume zero": (f"{HEAD}\n0.0015 0 0 0\n", ["line 2", "volume 0", "greater than 0"]),
    "inside a grain": (f"{HEAD}\n{ROW}\n0 0 0.002 1e-12\n", ["line 3", "inside grain 2", "units"]),
    "zero axis": (f"{HEAD} ax ay az\n{ROW} 0 0 0\n", ["line 2", "axis 0 0 0", "direction"]),
    "damage at 1": (f"{HEAD} dxx dyy dzz dyz dxz dxy\n{ROW} 0 0 1 0 0 0\n", ["line 2", "eigenvalues", "[0, 1)"]),
    "negative damage": (f"{HEAD} dxx dyy dzz dyz dxz dxy\n{ROW} 0.1 0.1 0.1 0.2 0 0\n", ["line 2", "eigenvalues", "-0.1"]),
    "skew directions": (f"{HEAD} d1 d2 d3 v1x v1y v1z v2x v2y v2z\n{ROW} 0.1 0 0 1 0 0 1 1 0\n", ["line 2", "right angles"]),
    "no points": (f"{HEAD}\n", ["no points"]),
    "empty": ("# nothing\n", ["empty", "names of the columns"]),
    "no such pair": (f"{HEAD} grain_i grain_j\n{ROW} 2 3\n", ["no points of grains 1 and 2"]),
    "repeated": (f"{HEAD}\n{ROW}\n0.0011 0 0.00005 1e-12\n{ROW}\n0.001 0 -0.00005 1e-12\n", ["line 4", "repeats", "line 2"]),
    "not on a lattice": (f"{HEAD}\n{ROW}\n0.00102 0.00001 0.00006 1e-12\n0.001 0 -0.00005 1e-12\n", ["line 3", "shares a cell", "line 2", "spacing"]),
    "unknown column": (f"{HEAD} mass\n{ROW} 1\n", ["line 1", "mass", "known are", "volume"]),
    "commas": ("x,y,z,volume\n0,0,0,1\n", ["line 1", "'x,y,z,volume' has commas", "blanks"]),
    "a mark of the order of bytes": (f"\ufeff{HEAD} mass\n{ROW} 1\n", ["line 1", "unknown column 'mass'"]),
    "areas that are all zero": (
        f"{HEAD} area_i area_j\n{ROW} 0 1e-8\n",
        ["nothing is attached to grain 1", "column 'area_i' is 0 in all lines", "leave 'area_i area_j' out"],
    ),
    "column twice": (f"{HEAD} x\n{ROW} 1\n", ["line 1", "'x'", "twice"]),
    "column missing": ("x y volume\n0 0 1\n", ["line 1", "'z'", "missing"]),
    "half an axis": (f"{HEAD} ax ay\n{ROW} 1 0\n", ["line 1", "'az'", "missing"]),
    "one grain only": (f"{HEAD}\n0.0025 0 -0.0006 1e-12\n", ["nothing is attached to grain 2", "attach"]),
    "failed": (f"{HEAD} failed\n{ROW} 2\n", ["line 2", "'failed'", "0 or 1"]),
    **{f"grain {g}": (f"{HEAD} grain_i grain_j\n{ROW} 1 2\n{ROW} {g} 2\n", ["line 3", "'grain_i' is", f"{g}", "whole number"]) for g in ("1.5", "-1", "0")},
    "both grains one": (f"{HEAD} grain_i grain_j\n{ROW} 1 2\n{ROW} 2 2\n", ["line 3", "both 2", "different"]),
    "grain that does not exist": (
        f"{HEAD} area_i area_j grain_i grain_j\n{ROW} 1e-8 1e-8 1 2\n{ROW} 1e-8 1e-8 7 2\n{ROW} 1e-8 1e-8 2 7\n",
        ["line 3", "grain 7 does not exist", "leave its lines out"],
    ),
    "area far too large": (f"{HEAD} area_i area_j\n{ROW} 9.9 1e-8\n", ["line 2", "area 9.9 at grain 1", "units"]),
    "more than the surface": (
        f"{HEAD} area_i area_j\n" + "".join(f"{1e-4 * i:.6g} {1e-4 * j:.6g} -0.00005 1e-12 6e-7 1e-8\n" for i in range(-12, 13) for j in range(-12, 13)),
        ["attached area at grain 1", "0.000375", "more than its surface", "0.000314", "units"],
    ),
    "volume far too large": (f"{HEAD}\n{ROW}\n0.0011 0 0.00005 1e-3\n", ["line 3", "volume 0.001", "1000000000 times a cell", "units"]),
    "foot off the grain": (
        f"{HEAD} area_i area_j foot_ix foot_iy foot_iz foot_jx foot_jy foot_jz\n{ROW} 1e-8 1e-8 0.001 0 0 0.001 0 0\n",
        ["line 2", "foot point", "off the surface", "grain 1"],
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_file(tmp_path, name):
    text, words = BAD[name]
    (tmp_path / "cement.txt").write_text(text)
    for ranks in (1, 2):
        result = launch(from_file(), tmp_path, ranks)
        errors = result.errors()
        assert result.status != 0 and len(errors) == 1, result.output[-2000:]
        for word in ["create_cement", "cement.txt"] + words:
            assert word in errors[0], (word, errors[0])


WORDS = {
    "unreadable": (from_file("nowhere/cement.txt"), ["create_cement", "nowhere/cement.txt", "cannot be read", "No such file"]),
    "a folder": (from_file("."), ["create_cement", "'.'", "cannot be read"]),
    "file and shape": (from_file(words="shape flat outer 2e-3"), ["create_cement", "file cement.txt", "shape", "one of them"]),
    "file and inner": (from_file(words="inner 1e-3"), ["create_cement", "file cement.txt", "inner", "one of them"]),
    "attach and shape": (edit(pair(SPACING), MADE, MADE[:-1] + " attach 1e-4\n"), ["create_cement", "attach 0.0001", "belongs to 'file'"]),
    "write: no cement": (edit(pair(SPACING), MADE, "write_cement cement.txt\n"), ["write_cement", "no cement", "create_cement"]),
    "write: no such pair": (pair(SPACING) + "write_cement c.txt pair 1 3\n", ["write_cement", "1 and 3", "no cement"]),
    "write: no such folder": (pair(SPACING) + "write_cement nowhere/c.txt\n", ["write_cement", "nowhere/c.txt", "No such file"]),
    "write: keyword": (pair(SPACING) + "write_cement c.txt bond 1\n", ["write_cement", "'bond'", "pair"]),
    "write: no name": (pair(SPACING) + "write_cement\n", ["write_cement", "file name"]),
}


@pytest.mark.parametrize("name", WORDS)
def test_bad_options(tmp_path, name):
    script, words = WORDS[name]
    result = launch(script, tmp_path, 2)
    errors = result.errors()
    assert result.status != 0 and len(errors) == 1, result.output[-2000:]
    for word in words:
        assert word in errors[0], (word, errors[0])


def test_attach_beyond_the_cement(ring, tmp_path):
    """Every point would be bonded to both grains."""
    write(tmp_path / "cement.txt", {k: ring[k] for k in ("x", "y", "z", "volume")})
    errors = launch(from_file(words="attach 1"), tmp_path, 2).errors()
    assert len(errors) == 1 and "'attach 1': must be at most 4 spacings" in errors[0] and "area_i area_j" in errors[0], errors


def test_initial_damage_against_the_cutoff(ring, tmp_path):
    column = dict(ring)
    column["dzz"] = np.full(len(ring["x"]), 0.8)
    write(tmp_path / "cement.txt", column)
    for damage, words in (("damage tensor B0 9.6e6 cutoff 0.7", ["0.8", "cut-off 0.7", "raise 'cutoff'"]), ("", ["0.8", "damage tensor"])):
        result = launch(from_file() + cement(CELL, 5e-9, damage=damage) + "fix move grains nve/sphere\nrun 0\n", tmp_path)
        assert result.status != 0 and len(result.errors()) == 1
        for word in ["fix mpm (id cem)", "material point"] + words:
            assert word in result.errors()[0], result.errors()[0]


@pytest.mark.parametrize("second", ["shape coating thickness 4e-4 cap 60", "shape flat inner 1e-3 outer 2e-3"])
def test_overlapping_cement(tmp_path, second):
    """Shells of two bonds of one grain, which leave the third grain free, overlap; flat bonds do not."""
    text = pair(SPACING, half_box=(16e-3, 6e-3, 16e-3))
    text = edit(text, "set          type 1", f"create_atoms 1 single {1.9696 * RADIUS:.15g} 0 {1.3473 * RADIUS:.15g} units box\nset          type 1")
    coat = "shape coating thickness 4e-4 cap 60" if "coating" in second else "shape flat inner 1e-3 outer 2e-3"
    text = edit(
        text,
        MADE,
        f"create_cement calcite pair 1 2 {coat} spacing 2e-4\ncreate_cement calcite pair 2 3 {second} spacing 2e-4\n"
        if "coating" in second
        else MADE + f"create_cement calcite pair 2 3 {coat} spacing 1e-4\n",
    )
    for ranks in (1, 2):
        result = launch(text, tmp_path, ranks)
        if "coating" in second:
            assert result.status != 0 and len(result.errors()) == 1, result.output[-2000:]
            for word in ("create_cement", "2 and 3", "1 and 2", "overlaps", "cap"):
                assert word in result.errors()[0]
        else:
            assert result.status == 0 and not result.errors(), result.output[-2000:]


def test_points_on_the_faces_of_cells(ring, tmp_path):
    """Rounding puts points on a face to either side of it: the cells are laid beside them, and each has its own."""
    columns = only(ring, "x y z volume")
    off = np.random.default_rng(1).uniform(-1e-9, 1e-9, (3, len(columns["x"]))) * SPACING
    for i, c in enumerate("xyz"):
        columns[c] = columns[c] + off[i] + (0.5 * SPACING if c != "z" else 0.0)
    write(tmp_path / "cement.txt", columns)
    out = run(from_file() + cement(CELL, 5e-9) + "fix hold grains freeze\nrun 2\n", tmp_path).output
    assert f"{len(columns['x'])} material points" in out
    assert "WARNING" not in out, out


def test_report(ring, tmp_path, figures):
    """Volume, content and attached area of cement from a file are those of the cement that was written, and so is the mass
    that its links add where a grain is free."""
    body = cement(CELL, 2e-8) + "fix motion grains nve/sphere\nrun 0\n"
    made = run(pair(SPACING) + body, tmp_path / "made").output
    write(tmp_path / "file" / "cement.txt", {k: v for k, v in ring.items() if not k.startswith("grain_")})
    again = run(from_file() + body, tmp_path / "file").output
    for what in (r"volume ([-0-9.e]+)", r"mass of the grains\) ([-0-9.e]+)", r"attached area ([-0-9.e]+)", r"added mass ([-0-9.e]+)"):
        a, b = (float(re.search(what, out)[1]) for out in (made, again))
        assert a > 0
        figures.below(f"cement from a file, '{what.split(' (')[0]}': change", abs(b / a - 1), 1e-5)


@pytest.mark.parametrize("damage", ["", DAMAGE])
def test_links_debonded_before_carry_nothing(ring, tmp_path, damage):
    """The file has no link to the second grain: the bond is separated from the start, also with a law that cannot break, and damping does not hold that grain."""
    columns = dict(ring)
    columns["attached_j"] = 0.0 * columns["attached_j"]
    write(tmp_path / "cement.txt", columns)
    script = from_file() + cement(CELL, 5e-9, damage=f"{damage} quasistatic 1 0.5") + pull(1.0, 2e-6) + thermo(20, ["f_bond", "f_bond[17]", "f_bond[22]"])
    t = run(script + "run 400\n", tmp_path).table()
    assert (t["f_bond[22]"] == 1).all() and abs(t["f_bond"]).max() == 0.0, t
