# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""From a labelled image of X-ray CT to grains and a point file.

The image is an array of whole numbers: one for each grain, one for the cement, 0 where there is neither. Voxels are cubes. The first index counts
along x, the second along y, the third along z; an image of slices (z, y, x) becomes this by `image.transpose(2, 1, 0)`. Voxel [0, 0, 0] has a
corner at `origin`. Lengths have the unit of `voxel`; take that of the script.

`spheres` makes a sphere of each grain about its centroid, of its volume or as large as it is below the cement. `cement_points` makes points of the cement, whose volumes add up to that of
its voxels. `write_grains` and `write_points` write what `read_data` of LIGGGHTS and `create_cement ... file` read (doc/point_files.md).
"""
from typing import Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from .run import Trouble

Array = npt.NDArray[np.float64]
Image = npt.NDArray[np.integer]

FITS = ("volume", "cement")
MOST_VOLUME = 1.05  # of a point over the cube of the spacing; create_cement warns above it


class Grain(NamedTuple):
    """A sphere in place of a grain."""

    number: int  # ID in LIGGGHTS, from 1 on in the order of the labels
    label: int  # in the image
    centre: Array  # centroid of its voxels
    radius: float  # of the sphere
    volume: float  # of its voxels
    outside: float  # share of its volume that lies outside of the sphere
    longest: float  # longest over shortest axis of the ellipsoid of its moments of inertia
    cut: bool  # it reaches the border of the image, so that a part may be missing


class Bond(NamedTuple):
    """The cement between two grains."""

    first: int  # number of the grain with the smaller ID
    second: int
    gap: float  # between the spheres; below 0 they overlap
    points: Array  # a row of x, y, z, volume for each point
    factor: float  # volumes of the points over those of their voxels


class Cement(NamedTuple):
    """All cement of an image."""

    bonds: List[Bond]
    spacing: float  # of the lattice of the points
    volume: float  # of all voxels of the cement
    loose: float  # volume of cement that does not reach from one grain to another, and is in no bond


def spheres(image: Image, voxel: float, cement: int, origin: Sequence[float] = (0.0, 0.0, 0.0), fit: str = "volume") -> List[Grain]:
    """A sphere for each label but 0 and that of the cement. fit: `volume`, its volume is that of the grain; `cement`, its radius is the mean distance from the
    centroid of the grain to the faces between the grain and cement, so that bonds keep their thickness. A grain without cement has that of its volume.
    Trouble if the image is no array of labels in space."""
    check(image, voxel)
    if fit not in FITS:
        raise Trouble(f"fit '{fit}': must be {' or '.join(FITS)}")
    faces = faces_with_cement(image, cement) if fit == "cement" else {}
    found: List[Grain] = []
    for label, box in enumerate(ndimage.find_objects(image), start=1):
        if box is None or label == cement:
            continue
        inside = np.argwhere(image[box] == label) + np.array([s.start for s in box]) + 0.5  # in voxels
        number = len(inside)
        centre = inside.mean(axis=0)
        from_centre = inside - centre
        radius = (3.0 * number / (4.0 * np.pi)) ** (1.0 / 3.0)
        if label in faces:
            radius = float(np.linalg.norm(faces[label] - centre, axis=1).mean())
        second = from_centre.T @ from_centre / number + np.eye(3) / 12.0  # of cubes, not of their centres
        axes = np.linalg.eigvalsh(second)
        found.append(
            Grain(
                number=len(found) + 1,
                label=label,
                centre=np.asarray(origin, dtype=float) + voxel * centre,
                radius=voxel * radius,
                volume=voxel**3 * number,
                outside=float(((from_centre**2).sum(axis=1) > radius**2).mean()),
                longest=float(np.sqrt(axes[2] / axes[0])),
                cut=any(s.start == 0 or s.stop == n for s, n in zip(box, image.shape)),
            )
        )
    if not found:
        raise Trouble(f"the image has no grain: its labels are {np.unique(image)[:8]}, and that of the cement is {cement}")
    return found


def faces_with_cement(image: Image, cement: int) -> Dict[int, Array]:
    """Middles of the faces between voxels of a grain and of the cement, in voxels, by the label of the grain."""
    labels, middles = [], []
    for axis in range(3):
        low, high = (np.moveaxis(image, axis, 0)[part] for part in (slice(None, -1), slice(1, None)))
        for grain, other in ((low, high), (high, low)):
            at = np.argwhere((grain != 0) & (grain != cement) & (other == cement))
            labels.append(grain[tuple(at.T)])
            middle = at + np.array([1.0, 0.5, 0.5])  # the face is at the end of the lower voxel
            middles.append(np.insert(middle[:, 1:], axis, middle[:, 0], axis=1))
    of, where = np.concatenate(labels), np.concatenate(middles)
    return {int(label): where[of == label] for label in np.unique(of)}


def cement_points(
    image: Image,
    voxel: float,
    cement: int,
    grains: Sequence[Grain],
    coarse: int = 1,
    attach: float = 1.0,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
) -> Cement:
    """Points of the cement on a lattice of `coarse` voxels.

        A cell of the lattice that has cement becomes a point at the centroid of this cement. It belongs to the two grains whose spheres are nearest. Cement
    XX"""
    check(image, voxel)
    if coarse < 1 or attach <= 0.0:
        raise Trouble(f"coarse {coarse}, attach {attach:g}: must be a whole number from 1 on, and a number above 0")
    if len(grains) < 2:
        raise Trouble("cement lies between two grains: the image has one only")
    cells, filled, centroid = lattice(image == cement, coarse)
    if not len(cells):
        raise Trouble(f"no voxel has the label of the cement, {cement}; the image has {np.unique(image)[:8]}")
    spacing = coarse * voxel
    place = np.asarray(origin, dtype=float) + voxel * centroid
    volume = voxel**3 * filled
    first, second, distance = nearest_two(place, grains)
    bonds, loose = [], 0.0
    key = first * (len(grains) + 1) + second
    for one in np.unique(key):
        mine = np.flatnonzero(key == one)
        pair = (grains[first[mine[0]] - 1], grains[second[mine[0]] - 1])
        to = np.column_stack([np.linalg.norm(place[mine] - g.centre, axis=1) - g.radius for g in pair])
        joined = joins_both(cells[mine], to < attach * spacing)
        kept = joined & (distance[mine] > -0.5 * spacing) & (width(place[mine], *pair) > 0.5 * spacing)
        if not (kept.any() and (kept[:, None] & (to < attach * spacing)).any(axis=0).all()):
            joined = kept = np.zeros(len(mine), dtype=bool)
        loose += float(volume[mine][~joined].sum())
        if not kept.any():
            continue
        factor = float(volume[mine][joined].sum() / volume[mine][kept].sum())
        rows = np.column_stack([place[mine][kept], factor * volume[mine][kept]])
        gap = float(np.linalg.norm(pair[0].centre - pair[1].centre) - pair[0].radius - pair[1].radius)
        bonds.append(Bond(pair[0].number, pair[1].number, gap, rows, factor))
    return Cement(bonds, spacing, float(volume.sum()), loose)


def check(image: Image, voxel: float) -> None:
    if image.ndim != 3 or not np.issubdtype(image.dtype, np.integer) or image.size == 0:
        raise Trouble(f"the image has the shape {image.shape} and the type {image.dtype}; it must be an array of whole numbers with three indices")
    if image.min() < 0:
        raise Trouble(f"the image has the label {image.min()}; labels must be from 0 on")
    if not 0.0 < voxel < np.inf:
        raise Trouble(f"voxel {voxel:g}: must be above 0, the edge of a voxel")


def lattice(mask: npt.NDArray[np.bool_], coarse: int) -> Tuple[npt.NDArray[np.intp], Array, Array]:
    """Cells of `coarse` voxels that have some of the mask: their indices, numbers of voxels, and centroids in voxels."""
    voxels = np.argwhere(mask)
    shape = [n // coarse + 1 for n in mask.shape]
    flat, of = np.unique(np.ravel_multi_index(tuple((voxels // coarse).T), shape), return_inverse=True)
    cells = np.column_stack(np.unravel_index(flat, shape))
    filled = np.bincount(of, minlength=len(cells)).astype(float)
    centroid = np.column_stack([np.bincount(of, weights=voxels[:, i] + 0.5, minlength=len(cells)) for i in range(3)])
    return cells, filled, centroid / np.maximum(filled, 1.0)[:, None]


def nearest_two(place: Array, grains: Sequence[Grain]) -> Tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Array]:
    """Numbers of the two grains whose spheres are nearest to each place, the smaller first, and the distance from the nearest; below 0 inside of it."""
    one, two = (np.full(len(place), np.inf) for _ in range(2))
    first, second = (np.zeros(len(place), dtype=np.intp) for _ in range(2))
    for g in grains:
        d = np.linalg.norm(place - g.centre, axis=1) - g.radius
        nearer, next_one = d < one, d < two
        two = np.where(nearer, one, np.where(next_one, d, two))
        second = np.where(nearer, first, np.where(next_one, g.number, second))
        one, first = np.where(nearer, d, one), np.where(nearer, g.number, first)
    return np.minimum(first, second), np.maximum(first, second), one


def width(place: Array, one: Grain, two: Grain) -> Array:
    """Width of the gap between two spheres along the line of centres, at the distance of each place from this line; infinite beside the gap."""
    between = two.centre - one.centre
    long = float(np.linalg.norm(between))
    along = (place - one.centre) @ between / long
    square = ((place - one.centre) ** 2).sum(axis=1) - along**2
    half = [np.sqrt(np.maximum(g.radius**2 - square, 0.0)) for g in (one, two)]
    beside = (square > min(one.radius, two.radius) ** 2) | (along < 0.0) | (along > long)
    return np.where(beside, np.inf, long - half[0] - half[1])


def joins_both(cells: npt.NDArray[np.intp], touches: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Which cells belong to a connected set of cells, by faces, edges or corners, that touches both grains."""
    low = cells.min(axis=0)
    box = np.zeros(cells.max(axis=0) - low + 1, dtype=bool)
    at = tuple((cells - low).T)
    box[at] = True
    sets = ndimage.label(box, structure=np.ones((3, 3, 3)))[0][at]
    both = set(sets[touches[:, 0]]) & set(sets[touches[:, 1]])
    return np.isin(sets, sorted(both))


# --------------------------------------------------------------------------------------------------- files and report


def write_grains(path: str, grains: Sequence[Grain], density: float, margin: Optional[float] = None) -> None:
    """The grains as a data file of LIGGGHTS for `read_data`: type 1, and a second type for the cement. Spheres have the masses that grains of `density` have.
    The box is larger than the spheres by `margin`, their largest radius without it."""
    room = max(g.radius for g in grains) if margin is None else margin
    low = np.min([g.centre - g.radius for g in grains], axis=0) - room
    high = np.max([g.centre + g.radius for g in grains], axis=0) + room
    lines = ["Grains of a CT image: ID, type, diameter, density, x, y, z", "", f"{len(grains)} atoms", "2 atom types", ""]
    lines += [f"{a:.9g} {b:.9g} {c}lo {c}hi" for a, b, c in zip(low, high, "xyz")]
    lines += ["", "Atoms", ""]
    for g in grains:
        own = density * g.volume / (4.0 / 3.0 * np.pi * g.radius**3)
        lines.append(f"{g.number} 1 {2.0 * g.radius:.12g} {own:.12g} " + " ".join(f"{x:.12g}" for x in g.centre))
    write(path, lines)


def write_points(path: str, cement: Cement) -> None:
    """The cement as a point file, of all bonds."""
    lines = [f"# cement of a CT image: {len(cement.bonds)} bonds, spacing {cement.spacing:.9g}", "grain_i grain_j x y z volume"]
    lines += [f"{b.first} {b.second} " + " ".join(f"{v:.12g}" for v in row) for b in cement.bonds for row in b.points]
    write(path, lines)


def commands(cement: Cement, points: str, group: str = "calcite", attach: float = 1.0) -> str:
    """Lines of a script: a create_cement for each bond, from the point file `points`. attach: as of `cement_points`."""
    words = f"file {points} spacing {cement.spacing:.9g} attach {attach * cement.spacing:.9g}"
    return "".join(f"create_cement {group} pair {b.first} {b.second} {words}\n" for b in cement.bonds)


def write(path: str, lines: Iterable[str]) -> None:
    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
    except OSError as e:
        raise Trouble(f"{path}: {e.strerror}; name a file in a folder that can be written") from None


def report(grains: Sequence[Grain], cement: Cement) -> str:
    """What became of the image, as a text: a line for each grain, and for each bond."""
    lines = [f"{'grain':>6}{'label':>7}{'radius':>12}{'sphere over its volume':>25}{'outside of its sphere':>24}{'longest over shortest axis':>29}"]
    for g in grains:
        larger = 4.0 / 3.0 * np.pi * g.radius**3 / g.volume
        lines.append(
            f"{g.number:6d}{g.label:7d}{g.radius:12.5g}{larger:25.4f}{100 * g.outside:22.2f} %{g.longest:29.3f}" + ("   cut by the border" if g.cut else "")
        )
    lines.append(f"{'bond of grains':>15}{'gap':>13}{'points':>9}{'volume':>13}{'volume over that of its voxels':>33}")
    for b in cement.bonds:
        warning = "   points above 1.05 spacing^3" if b.points[:, 3].max() > MOST_VOLUME * cement.spacing**3 else ""
        lines.append(f"{b.first:7d} {b.second:7d}{b.gap:13.4g}{len(b.points):9d}{b.points[:, 3].sum():13.5g}{b.factor:33.4f}{warning}")
    volume = sum(float(b.points[:, 3].sum()) for b in cement.bonds)
    lines.append(f"cement: {cement.volume:.6g} in all voxels = {volume:.6g} in bonds + {cement.loose:.6g} loose")
    return "\n".join(lines)
