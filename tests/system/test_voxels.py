# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/mpdem/voxels.py: volumes of grains and cement of an image are those of its voxels; the program reads what it writes; bad images."""
import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest

from scenes import CALCITE, edit, host, NEIGHBOURS, pair, run

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
from mpdem import voxels  # noqa: E402
from mpdem.run import Trouble  # noqa: E402

CEMENT = 7


def ball(shape, centre, radius):
    """Voxels whose centres lie in a sphere; lengths in voxels."""
    return ((np.moveaxis(np.indices(shape), 0, -1) + 0.5 - np.array(centre)) ** 2).sum(axis=-1) <= radius**2


def pair_image(n, inner, outer, radius=5e-3):
    """Two grains that touch, n voxels in a radius, and a flat bond between two radii; the edge of a voxel."""
    shape = (2 * n + 4, 2 * n + 4, 4 * n + 4)
    middle = (n + 2, n + 2)
    image = np.zeros(shape, dtype=np.uint16)
    x, y, z = np.indices(shape) + 0.5
    r = np.hypot(x - middle[0], y - middle[1]) * radius / n
    image[(r >= inner) & (r < outer) & (z > n + 2) & (z < 3 * n + 2)] = CEMENT
    image[ball(shape, (*middle, n + 2), n)] = 1
    image[ball(shape, (*middle, 3 * n + 2), n)] = 2
    return image, radius / n


def total(cement):
    return sum(b.points[:, 3].sum() for b in cement.bonds)


def test_spheres_are_found(figures):
    """Centre and radius of spheres of voxels; a coordinate counts from the origin."""
    image = np.zeros((70, 60, 50), dtype=np.int32)
    image[ball(image.shape, (30.3, 29.8, 25.1), 20)] = 3
    (g,) = voxels.spheres(image, 2e-6, CEMENT, origin=(1.0, 2.0, 3.0))
    assert (g.number, g.label, g.cut) == (1, 3, False)
    figures.below("centre against that of the sphere, voxels", abs((g.centre - (1, 2, 3)) / 2e-6 - (30.3, 29.8, 25.1)).max(), 0.02)
    figures.below("radius against that of the sphere", abs(g.radius / 4e-5 - 1), 2e-3)
    figures.below("volume outside of the sphere", g.outside, 0.01)
    figures.below("ratio of axes", g.longest - 1, 2e-3)


def test_error_of_a_box(figures):
    """Volume, ratio of axes and volume outside of the sphere of a cube and a long box have closed forms."""
    image = np.zeros((70, 70, 90), dtype=np.uint8)
    image[5:65, 5:65, 5:65] = 1
    image[10:20, 10:20, 68:88] = 2
    image[0:3, 0:3, 0:3] = 9
    cube, box, corner = voxels.spheres(image, 0.5, CEMENT)
    assert cube.volume == 60**3 / 8 and box.volume == 2000 / 8 and corner.cut and not cube.cut
    assert cube.radius == pytest.approx((3 * cube.volume / (4 * math.pi)) ** (1 / 3), rel=1e-14)
    R, half = cube.radius, 15.0
    caps = 6 * math.pi * (R - half) ** 2 * (3 * R - (R - half)) / 3
    figures.below("volume of a cube outside of its sphere against that of six caps", abs(cube.outside * cube.volume / caps - 1), 0.01)
    assert box.longest == pytest.approx(2.0, rel=1e-12) and cube.longest == pytest.approx(1.0, rel=1e-12)


def test_radius_below_the_cement(tmp_path, figures):
    """With `fit cement` a flat ellipsoid gets the radius that it has below its cement, and keeps its mass; a sphere stays as it is."""
    shape, c = (84, 84, 130), 28.0
    image = np.zeros(shape, dtype=np.uint8)
    x, y, z = np.indices(shape) + 0.5
    image[(np.hypot(x - 42, y - 42) < 8) & (z > 40) & (z < 96)] = CEMENT
    image[ball(shape, (42, 42, 42), 32)] = 1
    image[((x - 42) / 36) ** 2 + ((y - 42) / 36) ** 2 + ((z - 103) / c) ** 2 <= 1] = 2
    grains, before = (voxels.spheres(image, 1e-5, CEMENT, fit=fit) for fit in ("cement", "volume"))
    r = np.sqrt((np.arange(1000) + 0.5) / 1000) * 8  # points of the attached disc, of equal areas
    there = np.hypot(r, c * np.sqrt(1 - (r / 36) ** 2)).mean()
    figures.below("radius of the sphere", abs(grains[0].radius / 32e-5 - 1), 0.003)
    figures.below("radius of the ellipsoid below its cement", abs(grains[1].radius / (there * 1e-5) - 1), 0.01)
    assert before[1].radius > 1.1 * grains[1].radius and grains[1].volume == before[1].volume
    after, overlapping = (voxels.cement_points(image, 1e-5, CEMENT, g) for g in (grains, before))
    assert after.bonds[0].factor < 1.02 and (not overlapping.bonds or overlapping.bonds[0].factor > 1.5)
    voxels.write_grains(str(tmp_path / "grains.data"), grains, 2650)
    rows = [[float(w) for w in line.split()] for line in (tmp_path / "grains.data").read_text().splitlines()[-2:]]
    for g, (_, _, diameter, density, *_) in zip(grains, rows):
        assert density * math.pi / 6 * diameter**3 == pytest.approx(2650 * g.volume, rel=1e-9)
    with pytest.raises(Trouble, match="fit 'mean': must be volume or cement"):
        voxels.spheres(image, 1e-5, CEMENT, fit="mean")


@pytest.mark.parametrize("coarse", [1, 2, 3])
def test_volumes_add_up(coarse, figures):
    """Points of a bond have the volume of its voxels, and what is left out is what reaches one grain only. Each point is the centroid of its voxels."""
    image, voxel = pair_image(24, 1.5e-3, 2.5e-3)
    lone = (image == 0) & ball(image.shape, (26, 45, 26), 7)
    alone = int(lone.sum())
    bonded = int((image == CEMENT).sum())
    image[lone] = CEMENT
    grains = voxels.spheres(image, voxel, CEMENT, origin=(1e-3, 0, 0))
    cement = voxels.cement_points(image, voxel, CEMENT, grains, coarse=coarse, origin=(1e-3, 0, 0))
    (bond,) = cement.bonds
    assert (bond.first, bond.second, cement.spacing) == (1, 2, coarse * voxel) and alone > 80
    figures.below("volume of all points against that of the voxels", abs(total(cement) / (bonded * voxel**3) - 1), 5e-15)
    figures.below("volume left out against that of the voxels", abs(cement.loose / (alone * voxel**3) - 1), 5e-15)
    figures.below("sum against all voxels of the cement", abs((total(cement) + cement.loose) / cement.volume - 1), 5e-15)
    if bond.factor == 1.0:
        mass = bond.points[:, 3] @ bond.points[:, :3] / total(cement)
        where = (np.argwhere((image == CEMENT) & ~lone) + 0.5).mean(axis=0) * voxel + (1e-3, 0, 0)
        assert abs(mass - where).max() < 1e-12
    cells = np.floor((bond.points[:, :3] - (1e-3, 0, 0)) / cement.spacing + 1e-9)
    assert len(np.unique(cells, axis=0)) == len(cells), "one point in a cell of the lattice"


def test_spheres_that_overlap():
    """Points inside a sphere, and where the gap is too narrow, are left out; the others get their volume."""
    image, voxel = pair_image(24, 0.0, 2.5e-3)
    grains = voxels.spheres(image, voxel, CEMENT)
    grains[1] = grains[1]._replace(radius=1.03 * grains[1].radius)
    cement = voxels.cement_points(image, voxel, CEMENT, grains, attach=1.5)
    (bond,) = cement.bonds
    assert bond.factor > 1.01 and bond.gap < 0 and cement.loose < 0.02 * cement.volume
    assert abs(total(cement) + cement.loose - cement.volume) < 1e-12 * cement.volume
    for g in grains:
        assert (np.linalg.norm(bond.points[:, :3] - g.centre, axis=1) > g.radius - 0.5 * voxel).all()
    assert "above 1.05 spacing^3" in voxels.report(grains, cement)


@pytest.mark.parametrize("ranks", [1, 2])
def test_stiffness(ranks, tmp_path, figures):
    """The bond of an image has volume, attached area and stiffness of the flat bond that the image shows."""
    n, inner, outer = 50, 1.5e-3, 2.5e-3
    image, voxel = pair_image(n, inner, outer)
    origin = (-(n + 2) * voxel,) * 2 + (-(2 * n + 2) * voxel,)
    grains = voxels.spheres(image, voxel, CEMENT, origin)
    cement = voxels.cement_points(image, voxel, CEMENT, grains, origin=origin)
    voxels.write_grains(str(tmp_path / "grains.data"), grains, 2500)
    voxels.write_points(str(tmp_path / "cement.txt"), cement)
    (tmp_path / "cement.in").write_text(voxels.commands(cement, "cement.txt"))
    law = f"timestep 1e-9\nfix cem calcite mpm cell {2 * voxel} elastic vti {' '.join(map(str, CALCITE))}\nfix bond grains mpm/couple cem\n"
    read = host() + "read_data grains.data\ngroup grains type 1\n" + NEIGHBOURS + "include cement.in\n" + law + "bond_stiffness image.csv\n"
    out = run(read, tmp_path, ranks, name="in.image").output
    assert float(re.search(r"^  volume (\S+), content", out, re.M)[1]) == pytest.approx(total(cement), rel=1e-5)
    made = pair(1e-4, cement=f"inner {inner} outer {outer} film grid")
    shape = run(made + edit(law, f"cell {2 * voxel}", "cell 2e-4") + "bond_stiffness shape.csv\n", tmp_path, ranks, name="in.shape").output
    size = [np.array([float(v) for v in re.search(r"^  volume (\S+), content .*attached area (\S+) \+ (\S+),", o, re.M).groups()]) for o in (out, shape)]
    figures.below("volume of the bond against that of the shape", abs(size[0][0] / size[1][0] - 1), 0.02)
    figures.below("attached areas against those of the shape", abs(size[0][1:] / size[1][1:] - 1).max(), 0.03)
    rows = [np.genfromtxt(tmp_path / f"{name}.csv", delimiter=",", names=True) for name in ("image", "shape")]
    for load in ("tension", "shear_min", "torsion", "bending_min"):
        figures.below(f"{load} stiffness against that of the shape", abs(rows[0][load] / rows[1][load] - 1), 0.02)


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda i: i[0], "three indices"),
        (lambda i: i.astype(float), "whole numbers"),
        (lambda i: i.astype(int) - 1, "from 0 on"),
        (lambda i: np.where(i == CEMENT, 0, i), "no voxel has the label of the cement, 7"),
        (lambda i: np.where(i == CEMENT, i, 0), "the image has no grain"),
        (lambda i: np.where(i == 2, 0, i), "has one only"),
    ],
)
def test_bad_images(change, words):
    image = change(pair_image(8, 0.0, 2.5e-3)[0])
    with pytest.raises(Trouble, match=words):
        voxels.cement_points(image, 1e-4, CEMENT, voxels.spheres(image, 1e-4, CEMENT))


def test_bad_numbers(tmp_path):
    image, voxel = pair_image(8, 0.0, 2.5e-3)
    grains = voxels.spheres(image, voxel, CEMENT)
    with pytest.raises(Trouble, match="must be above 0"):
        voxels.spheres(image, 0.0, CEMENT)
    with pytest.raises(Trouble, match="coarse 0, attach 1"):
        voxels.cement_points(image, voxel, CEMENT, grains, coarse=0)
    with pytest.raises(Trouble, match="name a file in a folder"):
        voxels.write_grains(str(tmp_path / "no" / "grains.data"), grains, 2500)
