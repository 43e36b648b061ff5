# SPDX-License-Identifier: GPL-2.0-or-later
"""Where a bond lies in the box, how it is rotated, and which of its grains is the first do not matter.

The lattice of the points and the grid are cubic and lie about the middle of the gap, along the line of centres. So a pair that is moved,
rotated onto that line whichever way it points, mirrored at a plane of the grid or rotated by a quarter about an axis of it is the same pair:
forces of it agree to rounding. So do they with the IDs of the grains swapped, but for columns that belong to a grain, which swap. With viscosity this holds through failure;
without it up to the first failure, from where on rounding may grow (test_symmetry.py).
"""
import csv
import re

import numpy as np
import pytest
from scenes import NEIGHBOURS, RADIUS, cement, dump, edit, host, in_cells, pair, point_quantities, pull, run, thermo

SPACING = 1e-4
VISCOUS = "viscosity 1e-6"
FORCES = [f"f_bond[{i}]" for i in range(1, 13)]
SHARES = ["f_bond[23]", "f_bond[24]"]
REST = ["f_cem[1]", "f_cem[2]", "f_cem[4]", "f_cem[6]", "f_bond[22]"]
FLAT = ("flat", "inner 1e-3 outer 1.4e-3", 1e-4)
MENISCUS = ("meniscus", "neck 1.3e-3 inner 8e-4", 0.0)
COATING = ("coating", "thickness 2.5e-4 cap 22 inner 8e-4", 0.0)


def unit(v):
    return np.array(v, float) / np.linalg.norm(v)


def scene(kind, n, along, steps, damage, place=(0, 0, 0), swapped=False, every=50):
    """Two grains about `place`, the one at the end of n pulled along `along`; swapped: it is the first."""
    shape, words, gap = kind
    text = host() + "region box block -0.03 0.03 -0.03 0.03 -0.03 0.03 units box\ncreate_box 2 box\n"
    for side in (1, -1) if swapped else (-1, 1):
        text += "create_atoms 1 single " + " ".join(f"{c:.17g}" for c in np.array(place) + side * (RADIUS + gap / 2) * unit(n)) + " units box\n"
    text += (
        f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n"
        + NEIGHBOURS
        + f"create_cement calcite pair 1 2 shape {shape} {in_cells(words)} spacing {SPACING}\n"
    )
    # Dampers, since rounding feeds the fastest vibration of the links, which nothing else would take.
    fixes = cement(2 * SPACING, 1.2e-8, axis="radial", damage=f"damage tensor B0 9.6e6 cutoff 0.9 {damage} cracks split", couple="kn auto kt auto damping 0.1")
    if swapped:
        fixes = edit(edit(fixes, "first id 1", "first id 2"), "second id 2", "second id 1")
    return text + fixes + pull(12.0, 4e-6, unit(along)) + thermo(every, FORCES + SHARES + REST) + f"run {steps}\n"


def forces(done, swapped=False):
    """Of the held and of the pulled grain: force, moment over radius."""
    t = done.table()
    rows = np.column_stack([t[c] for c in FORCES]).reshape(-1, 4, 3)
    rows[:, 1::2] /= RADIUS
    return rows[:, [2, 3, 0, 1]] if swapped else rows


def moved(rows, R):
    """Forces are vectors, moments change sign under a mirror."""
    return rows @ R.T * np.array([1.0, np.linalg.det(R)] * 2)[:, None]


def mirror(d):
    return np.diag([-1.0 if e == d else 1.0 for e in range(3)])


def quarter_turn(d):
    R = np.zeros((3, 3))
    R[d, d] = R[(d + 2) % 3, (d + 1) % 3] = 1.0
    R[(d + 1) % 3, (d + 2) % 3] = -1.0
    return R


def turn_onto(axis, n):
    """The smallest rotation that takes the one to the other, by Rodrigues' formula."""
    c, v = axis @ n, np.cross(axis, n)
    K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + K + K @ K / (1 + c)


PLACES = [(0.01, 0, 0.003), (1.1e-3, -2.3e-3, 5.7e-3), (-7.7e-3, 3.1e-3, 9.1e-3), (-0.00944882, 0.00507026, 0.00076287)]
MOVES = (
    [(f"at {p}", np.eye(3), p) for p in PLACES]
    + [(f"mirrored across {'xyz'[d]}", mirror(d), (0, 0, 0)) for d in range(3)]
    + [(f"turned about {'xyz'[d]}", quarter_turn(d), PLACES[1]) for d in range(3)]
)
# Along (1,0,1) points lie in the very middle, as near to the one grain as to the other.
DIAGONAL, ACROSS = (1, 0, 1), (1, 0.8, 1)


def first_failure(done):
    t = done.table()
    return int(np.argmax(t["f_cem[2]"] > 0)) if t["f_cem[2]"].max() > 0 else len(t["step"])


# The mirror swaps the grains.
def test_points_in_the_middle(tmp_path, figures):
    """A bond with an unbonded gap, which breaks with failed points as near to the one grain as to the other."""
    R, along = mirror(0), np.array([0.54, 0.64, 0.54])
    one, other = (run(scene(MENISCUS, M @ DIAGONAL, M @ along, 750, VISCOUS, every=25), tmp_path) for M in (np.eye(3), R))
    f, apart = moved(forces(one), R), one.table()["f_bond[22]"] > 0
    assert apart.any() and not apart.all()
    worst = abs(forces(other) - f).max(axis=(1, 2)) / np.linalg.norm(f[:, 2], axis=1).max()
    name = "meniscus along (1,0,1) mirrored across x"
    figures.below(f"{name}, through failure and after it: force over the peak", worst.max(), 1e-11)
    for c in SHARES + REST:
        figures.below(f"{name}: {c}", abs(one.table()[c] - other.table()[c]).max() / max(abs(one.table()[c]).max(), 1e-300), 1e-13)


@pytest.mark.parametrize("words, limit", [("basis linear", 7e-9), ("basis linear condense yes", 5e-9), ("timestep auto 0.3", 2.5e-9)])
def test_axes_of_the_box(words, limit, tmp_path, figures):
    """Along another axis of the box the nodes have another order. Added mass and 'timestep auto' depend on an eigenvalue that does not change with it."""
    along = {}
    for d in range(3):
        n = np.eye(3)[d]
        text = pair(SPACING, gap=2e-4, cement="outer 1.5e-3 inner 0.3e-3", direction=n, half_box=3 * (12.5e-3,))
        text += cement(2 * SPACING, 4e-9, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 check 10 {words}") + pull(0.5, 8e-6, n)
        done = run(text + thermo(20, FORCES) + "run 800\n", tmp_path / "xyz"[d])
        along[d] = forces(done)[:, 2] @ n
    for d in range(2):
        figures.below(f"flat, {words}, along {'xyz'[d]} against along z: force over the peak", abs(along[d] - along[2]).max() / abs(along[2]).max(), limit)


# The axis of the box nearest to each, of equally near ones the first: that of the pair which is the same.
@pytest.mark.parametrize(
    "n, nearest",
    [
        pytest.param((1, 2, 3), (0, 0, 1), marks=pytest.mark.long),
        ((1, 1, 1), (1, 0, 0)),
        ((-3, 1, 2), (-1, 0, 0)),
        pytest.param((0.3, -1, 0), (0, -1, 0), marks=pytest.mark.long),
    ],
    ids=["123", "111", "-312", "in a plane"],
)
def test_any_direction(n, nearest, tmp_path, figures):
    """Forces, shares and sums of a skew pair, with gravity across it, are those of one along an axis, rotated."""
    R, along, g = turn_onto(np.array(nearest, float), unit(n)), np.array([0.4, 0.8, 0.9]), np.array([3e4, -2e4, 1e4])

    def loaded(axis, turn):
        weight = "fix weight all gravity {:.17g} vector {:.17g} {:.17g} {:.17g}\n".format(np.linalg.norm(g), *(turn @ unit(g)))
        text = scene(MENISCUS, axis, turn @ along, 700, VISCOUS, PLACES[1])
        return run(text.replace("run 700", weight + "run 700"), tmp_path)

    one, other = loaded(nearest, np.eye(3)), loaded(n, R)
    f, g2 = forces(one), forces(other)
    name = "meniscus along (" + ",".join(f"{c:g}" for c in n) + ") against one along an axis"
    peak = np.linalg.norm(f[:, 2], axis=1).max()
    assert one.table()["f_cem[2]"][-1] > 100 and one.table()["f_cem[2]"][-1] == other.table()["f_cem[2]"][-1]
    figures.below(f"{name}, with gravity, through failure: force over the peak", abs(g2 - moved(f, R)).max() / peak, 1e-9)
    for c in SHARES + REST:
        figures.below(f"{name}: {c}", abs(one.table()[c] - other.table()[c]).max() / max(abs(one.table()[c]).max(), 1e-300), 1e-11)


TENSORS = ["damage", "stress", "strain"]
PARTS = ["xx", "yy", "zz", "yz", "xz", "xy"]


def test_points_of_a_skew_pair(tmp_path, figures):
    """Whatever is told of points and events is in the axes of the box."""
    n = (1, 2, 3)
    R, along = turn_onto(np.array((0.0, 0, 1)), unit(n)), np.array([0.4, 0.8, 0.9])
    quantities = [f"{t}_{c}" for t in TENSORS for c in PARTS] + ["axis_x", "axis_y", "axis_z", "pressure", "stress_max", "failed"]
    columns = ["x", "y", "z", "vx", "vy", "vz"] + [f"c_{q}" for q in quantities]

    def seen_along(axis, turn):
        text = scene(MENISCUS, axis, turn @ along, 560, VISCOUS + " events events.csv")
        done = run(text.replace("run 560", point_quantities(quantities) + dump(560, columns) + "run 560"), tmp_path / "".join(map(str, axis)))
        with open(done.directory / "events.csv") as f:
            return done.points(560), list(csv.DictReader(f))

    (a, first), (b, second) = seen_along((0, 0, 1), np.eye(3)), seen_along(n, R)
    assert (a["c_failed"] == b["c_failed"]).all() and 50 < a["c_failed"].sum() < len(a["x"])

    def tensors(p, name):
        v = np.array([p[f"c_{name}_{c}"] for c in PARTS])
        return v[[0, 5, 4, 5, 1, 3, 4, 3, 2]].reshape(3, 3, -1)

    worst = {}
    for name in ("x y z", "vx vy vz", "c_axis_x c_axis_y c_axis_z"):
        u, w = (np.array([p[c] for c in name.split()]) for p in (a, b))
        worst[name] = abs(R @ u - w).max() / abs(w).max()
    for name in TENSORS:
        u, w = tensors(a, name), tensors(b, name)
        worst[name] = abs(np.einsum("ij,jkp,lk->ilp", R, u, R) - w).max() / abs(w).max()
    for name in ("c_pressure", "c_stress_max"):
        worst[name] = abs(a[name] - b[name]).max() / abs(a[name]).max()
    assert [e["point"] for e in first] == [e["point"] for e in second] and len(first) > 50
    for name in ("r", "z", "damage1"):
        worst["events, " + name] = max(abs(float(e[name]) - float(f[name])) / max(abs(float(f[name])), 1e-4) for e, f in zip(first, second))
    u, w = (np.array([[float(e[f"direction_{c}"]) for c in "xyz"] for e in events]) for events in (first, second))
    worst["events, direction"] = (1.0 - abs(np.einsum("ei,ei->e", u @ R.T, w))).max()
    # the angle, from the axis of the box most across the line of centres
    e1 = unit(np.array((1.0, 0, 0)) - unit(n)[0] * unit(n))
    e2 = np.cross(unit(n), e1)
    X = np.array([[float(e["r"]) * f(float(e["theta"])) for f in (np.cos, np.sin)] + [float(e["z"])] for e in first]) @ R.T
    turned = np.arctan2(X @ e2, X @ e1)
    worst["events, theta"] = abs(np.exp(1j * turned) - np.exp(1j * np.array([float(e["theta"]) for e in second]))).max()
    limit = {"events, direction": 1e-5, "events, theta": 1e-7, "events, r": 1e-7, "events, z": 1e-7}
    for name, value in worst.items():
        figures.below(f"points of a skew pair, {name}: against a pair along z, turned", value, limit.get(name, 1e-9))


@pytest.mark.parametrize("damage", [VISCOUS, ""], ids=["viscous", "not"])
def test_moved_mirrored_and_turned(damage, tmp_path, figures, long):
    steps = 700 if damage else 250
    done = run(scene(FLAT, DIAGONAL, ACROSS, steps, damage), tmp_path)
    f = forces(done)
    rows = slice(None) if damage else slice(first_failure(done))
    assert done.table()["f_cem[2]"][-1] > 100
    peak = np.linalg.norm(f[:, 2], axis=1).max()
    if damage:
        assert np.linalg.norm(f[-1, 2]) < 0.1 * peak, "the bond is not broken"
    for what, R, place in MOVES if long or not damage else MOVES[::2]:
        other = run(scene(FLAT, R @ DIAGONAL, R @ ACROSS, steps, damage, place), tmp_path)
        worst = abs(forces(other) - moved(f, R))[rows].max() / peak
        figures.below(f"pair along (1,0,1) {what}, {'through failure' if damage else 'to the first failure'}: force over the peak", worst, 1e-9)
        assert other.table()["f_cem[2]"][-1] == done.table()["f_cem[2]"][-1] or not damage


def opens_and_slides(R):
    """A bead of 4 mm is pulled off one of 10 mm, pushed back, and shaken across, in the axes that R rotates."""
    to = [int(np.argmax(abs(R @ e))) for e in np.eye(3)]
    assert (R @ np.eye(3) >= -1e-12).all(), "a permutation of the axes"

    def along(line, across, *, nothing="NULL"):
        words = [nothing] * 3
        words[to[2]], words[to[0]] = line, across
        return words

    text = host() + "region box block -0.013 0.013 -0.013 0.013 -0.013 0.013 units box\ncreate_box 2 box\n"
    for place in ("-0.00505", "0.00205"):
        text += "create_atoms 1 single " + " ".join(along(place, "0", nothing="0")) + " units box\n"
    text += (
        "group grains type 1\ngroup small id 2\nset type 1 diameter 0.01 density 2500\nset group small diameter 0.004\n"
        + NEIGHBOURS
        + "create_cement calcite pair 1 2 shape flat outer 1.2e-3 inner auto spacing 1.25e-4\n"
        + cement(2.5e-4, 6e-9, axis="radial", damage="damage tensor B0 2e3", couple="friction 0")
    )
    way, period, opens, every = 1e-6, 1.2e-5, 6e-7, 8e-6
    text += (
        f"variable t equal step*dt\nvariable x equal {way}*(1-cos(2*PI*v_t/{period}))\nvariable u equal {way}*2*PI/{period}*sin(2*PI*v_t/{period})\n"
        f"variable z equal {opens}*sin(2*PI*v_t/{every})^3\nvariable w equal {opens}*6*PI/{every}*sin(2*PI*v_t/{every})^2*cos(2*PI*v_t/{every})\n"
        "fix hold first move linear 0 0 0\nfix go second move variable " + " ".join(along("v_z", "v_x") + along("v_w", "v_u")) + "\n"
    )
    return text + thermo(25, FORCES + REST) + "run 600\n"


def test_friction(tmp_path, figures):
    """Contact points are remapped to other material points, of which several are equally near. None of them comes first."""

    def forces_of(R):
        done = run(opens_and_slides(R), tmp_path)
        return forces(done), done.table()["f_cem[2]"]

    f, failed = forces_of(np.eye(3))
    assert failed[-1] > 500
    peak = np.linalg.norm(f[:, 2], axis=1).max()
    figures.below("friction: force across the mirror plane over the peak", abs(f[:, [0, 2], 1]).max() / peak, 1e-10)
    for what, to in (("turned onto x", [1, 2, 0]), ("turned onto y", [2, 0, 1]), ("shaken across the other axis", [1, 0, 2])):
        R = np.eye(3)[:, np.argsort(to)].T
        other, failed_there = forces_of(R)
        figures.below(f"friction, {what}: force over the peak", abs(other - moved(f, R)).max() / peak, 1e-9)
        assert failed_there[-1] == failed[-1]


def tetrahedron(place):
    """Four grains as they touch in fcc, three held and one pulled; the box is periodic."""
    half = 0.0125
    box = " ".join(3 * [f"{-half} {half}"])
    text = host(boundary="p p p") + f"region box block {box} units box\ncreate_box 2 box\n"
    for corner in ((0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)):
        x = np.mod(np.array(place) + RADIUS * np.sqrt(2) * np.array(corner) + half, 2 * half) - half
        text += "create_atoms 1 single " + " ".join(f"{c:.17g}" for c in x) + " units box\n"
    text += f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n" + NEIGHBOURS
    text += f"create_cement calcite contacts grains gap 1e-5 shape {FLAT[0]} {in_cells(FLAT[1])} spacing {SPACING}\n"
    fixes = edit(
        cement(2 * SPACING, 1.2e-8, axis="radial", damage=f"damage tensor B0 9.6e6 cutoff 0.9 {VISCOUS}", couple="kn auto kt auto damping 0.1"),
        "second id 2",
        "second id 4",
    )
    columns = [f"f_bond[{b}][{c}]" for b in range(1, 7) for c in range(1, 13)]
    return text + edit(fixes, "first id 1", "first id 1:3") + pull(12.0, 4e-6, unit((1, 2, 3))) + thermo(50, ["f_cem[2]"] + columns) + "run 650\n"


def test_across_a_periodic_boundary(tmp_path, figures):
    rows = []
    for place in ((-0.003, -0.0041, -0.0033), (0.0092, 0.0071, 0.0083)):
        t = run(tetrahedron(place), tmp_path).table()
        rows.append(np.column_stack([t[f"f_bond[{b}][{c}]"] for b in range(1, 7) for c in (1, 2, 3, 7, 8, 9)]))
        assert t["f_cem[2]"][-1] > 100
    figures.below("six bonds of fcc, within the box and across its boundaries: force over the peak", abs(rows[0] - rows[1]).max() / abs(rows[0]).max(), 1e-9)


# Shape, line of centres, direction of the pull, steps. All separate within them.
SWAPPED = {
    "flat": (FLAT, (0, 0, 1), (0, 0, 1), 450, ""),
    "flat along (1,0,1)": (FLAT, DIAGONAL, DIAGONAL, 450, ""),
    "meniscus": (MENISCUS, (0, 0, 1), (0.64, 0, 0.77), 750, VISCOUS),
    "coating": (COATING, (0, 0, 1), (0, 0, 1), 400, ""),
}


def report(output):
    return [float(v) for v in re.findall(r"bond 1 of grains 1 and 2:.* surface (\S+) % at the first grain, (\S+) % at the second, (\S+) %", output)[-1]]


@pytest.mark.parametrize("name", SWAPPED)
def test_which_grain_is_the_first(name, tmp_path, figures):
    kind, n, along, steps, damage = SWAPPED[name]
    one, other = (run(scene(kind, n, along, steps, damage, swapped=s), tmp_path) for s in (False, True))
    t, u = one.table(), other.table()
    f, g = forces(one), forces(other, True)
    peak = np.linalg.norm(f[:, 2], axis=1).max()
    assert t["f_bond[22]"][-1] == 1.0, "the bond is not separated"
    figures.below(f"{name}, IDs swapped, through failure and after it: force over the peak", abs(f - g).max() / peak, 3e-10)
    for c in REST:
        figures.below(f"{name}, IDs swapped: {c}", abs(t[c] - u[c]).max() / max(abs(t[c]).max(), 1e-300), 2e-11)
    for a, b in zip(SHARES, reversed(SHARES)):
        figures.below(f"{name}, IDs swapped: share {a} against {b}", abs(t[a] - u[b]).max(), 1e-12)
    first, second, inside = report(one.output)
    assert report(other.output) == [second, first, inside]


# The same loads, ended while the bond holds.
HOLDING = {"meniscus": 560, "meniscus, nearly apart": 620, "coating": 220, "coating, nearly apart": 250}


def ahead(output):
    """Share and points of the weakest section that is left, of how many, mode of a crack through it, its shares."""
    found = re.findall(
        r"bond 1 of grains 1 and 2: intact, .*; (\S+) % of its weakest section is intact \((\d+) of (\d+) points\), and a crack "
        r"through this ligament would be (\w+); of the fracture surface (\S+) % at the first grain, (\S+) % at the second, (\S+) %",
        output,
    )
    return list(found[-1])


@pytest.mark.parametrize("name", HOLDING)
def test_what_is_left_of_a_bond_that_holds(name, tmp_path):
    kind, n, along, _, damage = SWAPPED[name.split(",")[0]]
    one, other = (ahead(run(scene(kind, n, along, HOLDING[name], damage, swapped=s), tmp_path).output) for s in (False, True))
    first, second = one[4:6]
    assert other == [*one[:4], second, first, one[6]]
    assert int(one[1]) < int(one[2])
