# SPDX-License-Identifier: GPL-2.0-or-later
"""Bonds whose shapes overlap: create_cement ... contacts with `overlap error`, `skip` and `trim`.

Three grains touch each other.  The union of their menisci and coatings is integrated here, from the definitions in
doc/create_cement.md, and compared with what the command says that it has made.
"""
import re

import numpy as np
import pytest
from scenes import NEIGHBOURS, host, launch, run

R, INNER, SPACING = 1e-3, 2e-4, 5e-5
FILLING, SHELL, CAP = 50.0, 1e-4, 40.0
SHAPES = {"meniscus": f"shape meniscus filling {FILLING:g}", "coating": f"shape coating thickness {SHELL} cap {CAP:g}"}
SHAPES["both"] = SHAPES["coating"] + " " + SHAPES["meniscus"]


def triangle(turned):
    """Centres of three grains that touch each other, in the plane z = 0 or in one that no axis lies in."""
    x = 2 * R / np.sqrt(3) * np.array([[np.cos(a), np.sin(a), 0] for a in np.radians([90, 210, 330])])
    a, b = np.array([1, 2, 3]) / np.sqrt(14), 1.0
    across = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return x @ (np.eye(3) + np.sin(b) * across + (1 - np.cos(b)) * across @ across) if turned else x


def scene(centres, words, ranks=1, half=2.6e-3, boundary="f f f"):
    atoms = "".join("create_atoms 1 single " + " ".join(f"{c:.17g}" for c in x) + " units box\n" for x in centres)
    return (
        host(boundary=boundary, processors=f"{ranks} 1 1")
        + f"region box block {-half} {half} {-half} {half} {-half} {half} units box\ncreate_box 2 box\n{atoms}"
        f"set type 1 diameter {2 * R} density 2500\ngroup grains type 1\n"
        + NEIGHBOURS
        + f"create_cement calcite contacts grains gap 1e-6 {words} inner {INNER} film grid spacing {SPACING}\n"
    )


def inside(kind, x, c0, c1):
    """Whether x (rows) lies in the cement of the grains at c0 and c1."""
    n = (c1 - c0) / np.linalg.norm(c1 - c0)
    from0, from1 = np.linalg.norm(x - c0, axis=1), np.linalg.norm(x - c1, axis=1)
    z = (x - 0.5 * (c0 + c1)) @ n
    r = np.sqrt(np.maximum(((x - 0.5 * (c0 + c1)) ** 2).sum(axis=1) - z**2, 0))
    found = np.zeros(len(x), bool)
    if kind in ("meniscus", "both"):
        # a circle that touches both spheres where the angle from the line of centres is FILLING
        beta = np.radians(FILLING)
        arc = R * (1 / np.cos(beta) - 1)
        found |= (abs(z) < R * (1 - np.cos(beta))) & (r < R * np.tan(beta) - np.sqrt(np.maximum(arc**2 - z**2, 0)))
    if kind in ("coating", "both"):
        for far, ahead in ((from0, (x - c0) @ n), (from1, (c1 - x) @ n)):
            found |= (far < R + SHELL) & (ahead > np.cos(np.radians(CAP)) * far)
    return found & (from0 > R) & (from1 > R) & ~((r < INNER) & (abs(z) < R))


def union(kind, centres):
    """Volume of the union of the cement of all pairs: those of single pairs, bodies of revolution, less what is in several
    of them, which is sampled in the cells of a lattice, anywhere in each."""
    parts, random = 1500, np.random.default_rng(5)
    z, r = np.meshgrid((np.arange(parts) + 0.5) / parts * 2 * R, (np.arange(parts) + 0.5) / parts * 1.2 * R, indexing="ij")
    x = np.column_stack([r.ravel(), 0 * r.ravel(), z.ravel()])
    half = inside(kind, x, np.array([0, 0, -R]), np.array([0, 0, R]))
    alone = 2 * (2 * np.pi * r.ravel() * half).sum() * 2.4 * R**2 / parts**2

    cells = 130
    low, high = centres.min(axis=0) - 0.8 * R, centres.max(axis=0) + 0.8 * R
    size = (high - low) / cells
    twice = 0
    for i in range(cells):
        j, k = np.meshgrid(np.arange(cells), np.arange(cells), indexing="ij")
        at = np.column_stack([np.full(j.size, i), j.ravel(), k.ravel()])
        x = low + size * (at + random.random(at.shape))
        count = np.sum([inside(kind, x, centres[a], centres[b]) for a, b in ((0, 1), (0, 2), (1, 2))], axis=0)
        twice += np.maximum(count - 1, 0).sum()
    return 3 * alone - twice * size.prod()


def attached(kind, centres):
    """Area of all grains that the cement of some pair covers: sampled at the same number of points on each."""
    number = 400000
    cosine = 1 - (2 * np.arange(number) + 1) / number
    angle = np.pi * (1 + np.sqrt(5)) * np.arange(number)  # Fibonacci's lattice on a sphere
    n = np.column_stack([np.sqrt(1 - cosine**2) * np.cos(angle), np.sqrt(1 - cosine**2) * np.sin(angle), cosine])
    largest = np.radians(max([FILLING] * (kind != "coating") + [CAP] * (kind != "meniscus")))
    total = 0
    for g in range(3):
        covered = np.zeros(number, bool)
        for other in range(3):
            if other != g:
                towards = n @ (centres[other] - centres[g]) / (2 * R)
                covered |= (towards > np.cos(largest)) & (towards < np.sqrt(1 - (INNER / R) ** 2))
        total += covered.mean() * 4 * np.pi * R**2
    return total


def made(output):
    """Volume, and the two attached areas, of each bond; the sums of the last line."""
    bonds = [[float(v) for v in m] for m in re.findall(r"^  volume (\S+), content .*, attached area (\S+) \+ (\S+), (\d+) points", output, re.M)]
    sums = re.findall(
        r"^  in all (\d+) points, volume (\S+), mass (\S+), content \(mass over that of the (\d+) grains of group 'grains', (\S+)\) (\S+)$", output, re.M
    )
    assert len(sums) == 1, output[-2000:]
    return np.array(bonds), [float(v) for v in sums[0]]


@pytest.mark.parametrize("kind, turned", [("meniscus", True), ("coating", False), ("both", True)])
def test_trim(tmp_path, figures, kind, turned):
    centres = triangle(turned)
    fixes = (
        "timestep 1e-9\nfix cem calcite mpm cell 1e-4 elastic isotropic 1e9 0.25\nfix bond grains mpm/couple cem\n"
        "fix motion grains nve/sphere\nvelocity grains set 0.1 0.2 0.3\nrun 5\n"
    )
    outputs = [run(scene(centres, SHAPES[kind] + " overlap trim", ranks) + fixes, tmp_path, ranks).output for ranks in (1, 2)]
    bonds, sums = made(outputs[0])
    again, again_sums = made(outputs[1])
    assert (bonds == again).all() and sums == again_sums and len(bonds) == 3
    alone = re.findall(r"trimmed from a volume of (\S+)", outputs[0])
    assert len(alone) == 3
    volume, area = union(kind, centres), attached(kind, centres)
    lost = 1 - sums[1] / sum(float(v) for v in alone)
    figures.note(f"three grains, {kind}: share of the cement that overlaps", f"{lost:.3g}")
    assert lost > 0.01
    figures.below(f"three grains, {kind}, trimmed: volume against the union, relative", abs(sums[1] / volume - 1), 5e-4)
    figures.below(f"three grains, {kind}, trimmed: attached area against the union, relative", abs(bonds[:, 1:3].sum() / area - 1), 5e-4)
    figures.below(f"three grains, {kind}, trimmed: volumes of the bonds, equal by symmetry, relative", np.ptp(bonds[:, 0]) / bonds[:, 0].mean(), 5e-4)
    grains = 3 * 4 / 3 * np.pi * R**3 * 2500
    assert sums[0] == bonds[:, 3].sum() and abs(sums[1] / bonds[:, 0].sum() - 1) < 1e-5
    assert abs(sums[2] / (2710 * sums[1]) - 1) < 1e-5 and sums[3] == 3 and abs(sums[4] / grains - 1) < 1e-5
    assert abs(sums[5] / (sums[2] / sums[4]) - 1) < 1e-5


def test_trim_across_a_periodic_boundary(tmp_path):
    """The same points whichever part of the cluster lies beyond the boundary."""
    centres = triangle(False)
    results = []
    for way in ([0, 0, 0], [2.3e-3, 2.1e-3, 2.5e-3]):
        x = (centres + way + 2.6e-3) % 5.2e-3 - 2.6e-3
        results.append(made(run(scene(x, SHAPES["meniscus"] + " overlap trim", boundary="p p p"), tmp_path).output))
    assert (results[0][0] == results[1][0]).all() and results[0][1] == results[1][1]


@pytest.mark.parametrize("ranks", [1, 2])
def test_skip(tmp_path, ranks):
    """Bonds are made in the order of the IDs, and left out where they overlap."""
    result = run(
        scene(triangle(False), SHAPES["meniscus"] + " overlap skip", ranks)
        + f"create_cement calcite pair 2 3 {SHAPES['meniscus']} overlap skip inner {INNER} film grid spacing {SPACING}\n",
        tmp_path,
        ranks,
    )
    bonds, sums = made(result.output)
    assert len(bonds) == 1 and sums[0] == bonds[0, 3] and sums[1] == bonds[0, 0]
    assert "Cement at 1 contacts of group 'grains'" in result.output
    assert "2 bonds left out whose cement would overlap that of others, between grains 1-3 2-3\n" in result.output
    assert "1 bonds left out whose cement would overlap that of others, between grains 2-3\n" in result.output
    assert result.output.count("2 of 3 bonds were left out; 'content' is the mass of a bond") == 1


@pytest.mark.parametrize(
    "words, needed",
    [
        ("", ["1 and 3", "overlaps that of grains 1 and 2", "'overlap skip'", "'overlap trim'"]),
        (" overlap error", ["'overlap trim'"]),
        (" overlap cut", ["overlap cut", "error", "skip", "trim"]),
    ],
)
def test_error(tmp_path, words, needed):
    for ranks in (1, 2):
        result = launch(scene(triangle(False), SHAPES["meniscus"] + words, ranks), tmp_path, ranks)
        assert result.status != 0 and len(result.errors()) == 1, result.output[-2000:]
        for word in ["create_cement"] + needed:
            assert word in result.errors()[0], result.errors()[0]


def test_trim_has_its_limits(tmp_path):
    """What an earlier command made is not cut, nor are a pair alone and points of a file."""
    centres = triangle(False)
    first = scene(centres, SHAPES["meniscus"]).replace("contacts grains gap 1e-6", "pair 1 2")
    more = f"create_cement calcite contacts grains gap 1e-6 {SHAPES['meniscus']} overlap trim inner {INNER} film grid spacing {SPACING}\n"
    for script, needed in (
        (first + more, ["1 and 3", "earlier command", "overlap skip"]),
        (first.replace("spacing", "overlap trim spacing"), ["pair 1 2", "'contacts'"]),
        (
            first
            + "write_cement c.txt\n"
            + scene(centres, "").split("create_cement")[0].replace("units        si", "clear\nunits si")
            + f"create_cement calcite contacts grains gap 1e-6 file c.txt overlap trim spacing {SPACING}\n",
            ["file", "overlap skip"],
        ),
    ):
        result = launch(script, tmp_path)
        assert result.status != 0 and len(result.errors()) == 1, result.output[-2000:]
        for word in needed:
            assert word in result.errors()[0], result.errors()[0]
