# SPDX-License-Identifier: GPL-2.0-or-later
"""Failure mode and shares of the fracture surface for cracks cut into the cement beforehand, where they are known.

test_point_file.py has the plain cracks of the ring; here are several at once, stepped ones, other shapes, and ranks.
Intact bonds: how much of their weakest section is left, and the crack that would be there.
"""
import csv
import re

import numpy as np
import pytest
from scenes import cement, edit, launch, in_cells, pair, restarted, run, shift, thermo
from test_pair_table import SCRIPT
from test_point_file import CELL, DAMAGE, SPACING, read, write

SHAPES = {
    "flat": ("flat", "inner 1e-3 outer 2e-3"),
    "meniscus": ("meniscus", "neck 1.6e-3 inner 8e-4"),
    "coating": ("coating", "thickness 4e-4 cap 30 inner 8e-4"),
    "wide": ("meniscus", "neck 1e-3"),
}
GAP = {"wide": 1e-3}
MEET = np.sqrt(5.4e-3**2 - 5e-3**2)  # ring in which the shells of the coating meet
# As far out cells of both shells share faces, though there is a gap thinner than two spacings between them.
TOUCH = np.sqrt(5.4e-3**2 - (5e-3 - SPACING) ** 2)
MODES = [f"f_cem[{i}]" for i in (19, 20, 21, 22)]  # bonds that are separated; by debonding, internal, mixed
STEP, FEW = 1.5e-3, np.deg2rad(18)


def scene(shape, file=None):
    style, words = SHAPES[shape]
    text = pair(SPACING, shape=style, cement=words, gap=GAP.get(shape, 0.0))
    if file is None:
        return text
    return edit(text, f"shape {style} {in_cells(words)}", f"file {file}")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Points of each shape, as write_cement has them."""
    points = {}
    for shape in SHAPES:
        directory = tmp_path_factory.mktemp(shape)
        run(scene(shape) + "write_cement cement.txt\n", directory)
        points[shape] = read(directory / "cement.txt")
    return points


class Cement:
    def __init__(self, columns):
        self.x, self.y, self.z = (columns[c] for c in "xyz")
        self.r, self.angle = np.hypot(self.x, self.y), np.arctan2(self.y, self.x)
        self.at = (columns["area_i"] > 0, columns["area_j"] > 0)
        self.plane = abs(self.z) < SPACING


def stepped(c, side):
    """Debonded from a grain within r = STEP, through the middle outside it."""
    wall = (abs(c.r - STEP) < SPACING) & ((c.z < SPACING) if side == 0 else (c.z > -SPACING))
    return np.where(c.r < STEP, c.at[side], c.plane) | wall


def sector(c, few, rest):
    """One crack in a sector of a twentieth of the circle, from the angle 0, another in the rest; both reach its walls."""
    within = (c.angle > 0) & (c.angle < FEW)
    far = c.x > 0
    wall = far & ((abs(c.y) < SPACING) | (abs(c.y * np.cos(FEW) - c.x * np.sin(FEW)) < SPACING)) & (c.z > -SPACING)
    return np.where(within, few, rest) | wall


# Shares of a crack that steps at r = STEP are known as well as where in the wall, two points wide, they separate.
WALL = 100 * 2 * STEP * SPACING / (2e-3**2 - 1e-3**2) + 2
# shape, failed points, mode, shares in per cent (first grain, second, inside) or None, uncertainty if not 2
CASES = {
    "both grains debonded": ("flat", lambda c: c.at[0] | c.at[1], "debonding", (50, 50, 0)),
    "first grain and middle": ("flat", lambda c: c.at[0] | c.plane, "debonding", (100, 0, 0)),
    "middle and second grain": ("flat", lambda c: c.plane | c.at[1], "debonding", (0, 100, 0)),
    "two cracks inside": ("wide", lambda c: abs(abs(c.z) - 2.5 * SPACING) < 0.2 * SPACING, "internal", (0, 0, 100)),
    "stepped, first grain": ("flat", lambda c: stepped(c, 0), "mixed", (42, 0, 58), WALL),
    "stepped, second grain": ("flat", lambda c: stepped(c, 1), "mixed", (0, 42, 58), WALL),
    "a twentieth at the second grain": ("flat", lambda c: sector(c, c.at[1], c.plane), "internal", (0, 5, 95)),
    "a twentieth inside": ("flat", lambda c: sector(c, c.plane, c.at[1]), "debonding", (0, 95, 5)),
    "notch around the ring": ("flat", lambda c: c.plane & (c.r > STEP), "intact", None),
    "both grains half debonded": ("flat", lambda c: np.where(c.x < 0, c.at[0], c.at[1]), "intact", None),
    "meniscus, middle": ("meniscus", lambda c: c.plane, "internal", (0, 0, 100)),
    "meniscus, first grain": ("meniscus", lambda c: c.at[0], "debonding", (100, 0, 0)),
    "coating, shell of the first grain": ("coating", lambda c: c.at[0], "debonding", (100, 0, 0)),
    "coating, shell of the second grain": ("coating", lambda c: c.at[1], "debonding", (0, 100, 0)),
    "coating, where shells meet": ("coating", lambda c: c.plane & (c.r < TOUCH + SPACING), "internal", (0, 0, 100)),
    "coating, debonded within the ring": ("coating", lambda c: c.at[0] & (c.r < MEET - 2 * SPACING), "intact", None),
}


@pytest.mark.parametrize("case", CASES)
def test_constructed_crack(case, made, tmp_path, figures):
    shape, crack, mode, shares, *wall = CASES[case]
    columns = dict(made[shape])
    columns["failed"] = crack(Cement(columns)).astype(float)
    assert 0 < columns["failed"].sum() < len(columns["x"])
    lines = []
    for ranks in (1, 4):
        directory = tmp_path / str(ranks)
        write(directory / "cement.txt", columns)
        done = run(
            scene(shape, "cement.txt")
            + cement(CELL, 5e-9, axis="radial", damage=DAMAGE)
            + shift(1e-9, 1e-6)
            + thermo(1, ["f_cem[2]", "f_bond[22]", "f_bond[23]", "f_bond[24]", *MODES])
            + "run 200\n",
            directory,
            ranks,
        )
        lines.append([x for x in done.output.splitlines() if "of grains 1 and 2: " in x][-1])
        t = done.table()
        assert (t["f_cem[2]"] == columns["failed"].sum()).all(), "the pull itself broke points"
    assert lines[0] == lines[1]
    assert f": {mode}" in lines[0], lines[0]
    assert t["f_bond[22]"][-1] == (mode != "intact")
    assert [t[m][-1] for m in MODES] == [mode != "intact"] + [mode == m for m in ("debonding", "internal", "mixed")]
    if shares:
        found = [float(w) for w in re.findall(r"(\S+) % ", lines[0])]
        figures.note(f"{case}: per cent at the first grain, the second, inside", found)
        assert found == pytest.approx(shares, abs=wall[0] if wall else 2)
        assert [100 * t[f"f_bond[{i}]"][-1] for i in (23, 24)] == pytest.approx(found[:2], abs=0.1)


@pytest.mark.parametrize("ranks", [1, 3])
def test_bonds_by_mode(made, tmp_path, ranks):
    """Four bonds of one scene, three of which separate, each by another mode: their numbers in the vector of fix mpm, also after a restart."""
    bonds = [("meniscus", lambda c: c.at[0]), ("meniscus", lambda c: c.plane), ("flat", lambda c: stepped(c, 0)), ("meniscus", lambda c: 0 * c.x)]
    grains = [[f"create_atoms 1 single {11e-3 * n:.15g} 0 {z} units box" for z in (-0.005, 0.005)] for n in range(len(bonds))]
    files = []
    for n, (shape, crack) in enumerate(bonds):
        columns = dict(made[shape])
        columns["failed"] = crack(Cement(columns)).astype(float)
        for x in ("x", "foot_ix", "foot_jx"):
            columns[x] = np.where(columns["area_" + x[5]] > 0, columns[x] + 11e-3 * n, 0) if len(x) > 1 else columns[x] + 11e-3 * n
        columns["grain_i"], columns["grain_j"] = (np.full(len(columns["x"]), 2 * n + i) for i in (1, 2))
        write(tmp_path / f"{n}.txt", columns)
        files.append(f"create_cement calcite pair {2 * n + 1} {2 * n + 2} file {n}.txt spacing {SPACING}\n")
    text = pair(SPACING, half_box=(40e-3, 6e-3, 12.5e-3))
    text = edit(text, "\n".join(grains[0]), "\n".join(sum(grains, [])))
    text = edit(text, next(line for line in text.splitlines(True) if line.startswith("create_cement")), "".join(files))
    fixes = cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + "fix hold grains move linear 0 0 0\n"
    look = thermo(10, MODES)
    t = run(text + fixes + look + "run 10\nwrite_restart r\n", tmp_path, ranks).table()
    again = run(restarted("r") + fixes + look + "run 10\n", tmp_path, ranks).table()
    for table in (t, again):
        assert [table[m][-1] for m in MODES] == [3, 1, 1, 1]
    assert [again[m][0] for m in MODES] == [3, 1, 1, 1]


def lines_of_modes(output):
    return [x for x in output.splitlines() if "of grains 1 and 2: " in x]


AHEAD = re.compile(
    r"; (\S+) % of its weakest section is intact \((\d+) of (\d+) points\), and a crack through this ligament would be (\w+); of the "
    r"fracture surface (\S+) % at the first grain, (\S+) % at the second, (\S+) % inside$"
)
SECTOR = np.deg2rad(12)


def rest(c):
    return abs(c.angle) < SECTOR


def columns_of(c, points):
    cells = np.floor(np.column_stack((c.x, c.y))[points] / SPACING)
    return len(np.unique(cells, axis=0))


# failed points, those of the section that is left, mode and shares of a crack there
HOLD = {
    "sector left at the first grain": (lambda c: c.at[0] & ~rest(c), lambda c: c.at[0] & rest(c), "debonding", (100, 0, 0)),
    "sector left at the second grain": (lambda c: c.at[1] & ~rest(c), lambda c: c.at[1] & rest(c), "debonding", (0, 100, 0)),
    "sector left in the middle": (lambda c: c.plane & ~rest(c), lambda c: c.plane & (c.z > 0) & rest(c), "internal", (0, 0, 100)),
    "more left in the middle than at the second grain": (
        lambda c: np.where(c.angle > 0, c.at[1] & ~rest(c), c.at[1]) | c.plane & (c.angle > 2),
        lambda c: c.at[1] & rest(c) & (c.angle > 0),
        "debonding",
        (0, 100, 0),
    ),
}


@pytest.mark.parametrize("case", HOLD)
def test_section_left_of_an_intact_bond(case, made, tmp_path, figures):
    failed, left, mode, shares = HOLD[case]
    columns = dict(made["flat"])
    c = Cement(columns)
    columns["failed"] = failed(c).astype(float)
    for d in ("dxx", "dyy", "dzz"):  # the section left is the most damaged of those with as many points
        columns[d] = 0.5 * (left(c) | c.plane & rest(c))
    lines = []
    for ranks in (1, 4):
        directory = tmp_path / str(ranks)
        write(directory / "cement.txt", columns)
        done = run(
            scene("flat", "cement.txt") + cement(CELL, 5e-9, axis="radial", damage=DAMAGE) + shift(1e-9, 1e-6) + thermo(1, ["f_cem[2]"]) + "run 20\n",
            directory,
            ranks,
        )
        lines.append(lines_of_modes(done.output)[-1])
        assert done.output.count("with 'cracks split' of fix mpm they do not") == 1, "the cure is told once"
    assert lines[0] == lines[1] and ": intact, " in lines[0]
    found = AHEAD.search(lines[0])
    assert found, lines[0]
    figures.note(f"{case}: per cent left, points, of", [float(f) for f in found.groups()[:3]])
    # points of a stepped surface stand above one another, and one of each column is enough
    assert (int(found[2]), int(found[3])) == (columns_of(c, left(c)), columns_of(c, c.at[0]))
    assert float(found[1]) == pytest.approx(100 * int(found[2]) / int(found[3]), rel=1e-5)
    assert found[4] == mode
    assert [float(f) for f in found.groups()[4:]] == pytest.approx(shares, abs=8)


def test_sheared_bond_with_almost_no_force(tmp_path, figures):
    """Past the peak the bond is intact by the rule for long; what is left of its weakest section is about what is left of its
    force, and when it separates, at the end, it does so where the crack through that section was expected."""
    words = {"load": "shear", "content": 0.01, "inner": "auto", "spacing": 2e-4, "frames": 10**8, "limit": 3300}
    arguments = [w for k, v in words.items() for w in ("-var", k, str(v))]
    lines = []
    for ranks in (1, 2):
        done = launch(SCRIPT.read_text(), tmp_path / str(ranks), ranks, name="in.pair_table", arguments=arguments)
        assert done.status == 0 and not done.errors(), done.output[-3000:]
        lines.append(lines_of_modes(done.output))
    assert lines[0] == lines[1]
    intact = [line for line in lines[0] if ": intact, " in line]
    assert len(intact) > 10 and intact == lines[0][: len(intact)]
    found = [AHEAD.search(line) for line in intact]
    assert all(found)
    for line in lines[0][len(intact) :]:
        assert f": {found[-1][4]}, " in line and line.split("surface ")[1] == intact[-1].split("surface ")[1]
    left = [float(f[1]) for f in found]
    assert left == sorted(left, reverse=True), "failed points do not heal, so the section never grows"
    with open(tmp_path / "1" / "load_run.csv") as f:
        load = np.array([float(r["load"]) for r in csv.DictReader(f)])
    load = load[: len(load) * len(intact) // len(lines[0])]
    force = load[-len(load) // 20 :].mean() / load.max()
    figures.note("sheared bond: per cent of the section left at the ends of the runs, first, least", [left[0], left[-1]])
    figures.below("sheared bond: mean force of the last twentieth of the time before, over the peak", force, 0.1)
    # Not of the last points: two more or less are half of them, and a run more or less half of their force.
    parts = np.array_split(load, len(left))
    shares = [part.mean() / load.max() / (share / 100) for part, share in zip(parts, left) if 5 < share < 40]
    figures.note("sheared bond: force over peak, over the section left, with 5 to 40 % left: least, largest", [min(shares), max(shares)])
    assert len(shares) > 3 and 0.5 < min(shares) and max(shares) < 4.0
    assert left[0] > 50 and left[-1] < 5 and found[-1][4] == "mixed"
