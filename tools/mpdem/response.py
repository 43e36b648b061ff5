# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Stress, strain, contacts and fragments of a specimen that examples/specimen/in.load loaded, by its present section and height.

Compression is positive in stresses and in the axial strain, dilation in the volume strain."""
import csv
import glob
import os
import re
from typing import Any, Dict, List, Set, Tuple

import numpy as np

from . import tables
from .loading import read_table
from .tables import Trouble

Table = Dict[str, Any]


def whole(folder: str, name: str) -> Table:
    """All rows of a table of a loading that may have gone on from checkpoints, by column."""
    table = tables.whole(folder, name)
    if table.empty:
        raise Trouble(f"{os.path.join(folder, name)}.csv: no rows; let the run get past its setup")
    return {c: table[c].to_numpy() for c in table}


def response(curve: Table) -> Table:
    """Of the rows from where the upper end moves: strains since then, stresses (Pa) over the present section and sides."""
    moves = np.flatnonzero(curve["stage"] == 1)
    if not moves.size:
        raise Trouble("curve.csv has no row of loading yet; let the run get further")
    first = max(int(moves[0]) - 1, 0)
    t = {k: v[first:] for k, v in curve.items()}
    section, volume = t["wide_x"] * t["wide_y"], t["wide_x"] * t["wide_y"] * t["height"]
    axial = t["force"] / section
    side = t["sideways"] * 2.0 / ((t["wide_x"] + t["wide_y"]) * t["height"])
    return {
        "step": t["step"],
        "time": t["time"],
        "axial_strain": 1.0 - t["height"] / t["height"][0],
        "volume_strain": volume / volume[0] - 1.0,
        "height": t["height"],
        "section": section,
        "axial_stress": axial,
        "side_stress": side,
        "q": axial - side,
        "p": (axial + 2.0 * side) / 3.0,
        **{k: t[k] for k in ("broken", "debonding", "internal", "mixed", "failed", "awake", "kinetic_share", "unbalanced", "speed")},
    }


def dumps(folder: str, name: str) -> Dict[int, np.ndarray]:
    """Rows of the dumps NAME.STEP.txt by step; one that is cut short is left out."""
    found = {}
    for path in tables.dump_paths(folder).get(name, {}).values():
        try:
            step, table = tables.read_dump(path)
        except Trouble:
            continue
        found[step] = table.to_numpy()
    return found


def fragment_numbers(ids: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """Number of the piece of each grain, 0 for the largest one. joined: pairs of IDs of grains that cement holds together."""
    root = {int(i): int(i) for i in ids}

    def find(i: int) -> int:
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i

    for a, b in joined.astype(int):
        root[find(a)] = find(b)
    _, first, number, count = np.unique([find(i) for i in root], return_index=True, return_inverse=True, return_counts=True)
    rank = np.empty(len(count), dtype=int)
    rank[np.lexsort((first, -count))] = np.arange(len(count))
    return rank[number]


def fragments(ids: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """Numbers of grains of the pieces that are left, largest first."""
    return np.bincount(fragment_numbers(ids, joined))


def force_inside(low: float, high: float, z: Dict[int, float], pairs: np.ndarray, bonds: np.ndarray) -> float:
    """Compressive force through horizontal sections, mean over those between two heights: of contacts and of bonds.

    pairs: ID, ID, and the vertical force on the first one; bonds: ID, ID, and the vertical force of the cement on either one."""
    total = 0.0
    for a, b, fa, fb in np.vstack((np.column_stack((pairs, -pairs[:, 2])), bonds)):
        (bottom, at_bottom), (top, at_top) = sorted(((z[int(a)], fa), (z[int(b)], fb)))
        cut = min(top, high) - max(bottom, low)
        if cut > 0.0:
            total += 0.5 * (at_top - at_bottom) * cut
    return total / (high - low)


def fabric(folder: str, r: Table) -> Tuple[List[Table], List[Table]]:
    """A row for each frame with contacts, coordination numbers and pieces; and one for each size of piece of each frame."""
    bonds = whole(folder, "bond") if os.path.exists(os.path.join(folder, "bond.csv")) else {}
    beads, pairs = dumps(folder, "beads"), dumps(folder, "pairs")
    first = next((s for s in pairs if s >= r["step"][0]), None)
    rows, sizes = [], []
    start: Set[Tuple[int, int]] = set()
    for step, touching in pairs.items():
        if first is None or step < first or step not in beads or step > r["step"][-1]:
            continue
        now = {(min(a, b), max(a, b)) for a, b in touching[:, :2].astype(int)}
        start = now if step == first else start
        at = bonds["step"] == step if bonds else np.zeros(0, dtype=bool)
        holds = at & (bonds["separated"] == 0) if bonds else at
        joined = np.column_stack((bonds["grain1"][holds], bonds["grain2"][holds])) if bonds else np.zeros((0, 2))
        bead = beads[step]
        count = len(bead)
        left = fragments(bead[:, 0], joined)
        n = int(np.argmin(np.abs(r["step"] - step)))
        low, high = 0.25 * r["height"][n], 0.75 * r["height"][n]
        z = dict(zip(bead[:, 0].astype(int), bead[:, 3]))
        cement = np.column_stack([bonds[k][at] for k in ("grain1", "grain2", "fz1", "fz2")]) if bonds else np.zeros((0, 4))
        together = len(now | {(int(min(p)), int(max(p))) for p in joined})
        inside = force_inside(low, high, z, touching[:, [0, 1, 8]], cement) if touching.shape[1] > 8 else float("nan")
        rows.append(
            {
                "step": step,
                "axial_strain": r["axial_strain"][n],
                "volume_strain": r["volume_strain"][n],
                "beads": count,
                "contacts": len(now),
                "old_contacts": len(now & start),
                "new_contacts": len(now - start),
                "lost_contacts": len(start - now),
                "coordination": 2 * len(now) / count,
                "bonds": len(joined),
                "coordination_with_bonds": 2 * together / count,
                "pieces": int((left > 1).sum()),
                "single": int((left == 1).sum()),
                "largest": int(left[0]),
                "mean_size": float((left.astype(float) ** 2).sum() / left.sum()),
                "stress_inside": inside / r["section"][n],
            }
        )
        for size, number in zip(*np.unique(left, return_counts=True)):
            sizes.append({"step": step, "axial_strain": r["axial_strain"][n], "grains": int(size), "pieces": int(number)})
    return rows, sizes


def write_rows(path: str, rows: List[Table]) -> None:
    if not rows:
        return
    with open(path + ".tmp", "w", newline="") as f:
        w = csv.writer(f, lineterminator="\n")
        w.writerow(rows[0])
        for row in rows:
            w.writerow([f"{v:.7g}" if isinstance(v, float) else v for v in row.values()])
    os.replace(path + ".tmp", path)


def write(folder: str) -> Tuple[Table, Table]:
    """Writes response.csv, fabric.csv and fragments.csv of a loading; returns response and fabric by column."""
    r = response(whole(folder, "curve"))
    rows, sizes = fabric(folder, r)
    write_rows(os.path.join(folder, "response.csv"), [{k: (float(v[i]) if k != "step" else int(v[i])) for k, v in r.items()} for i in range(len(r["step"]))])
    write_rows(os.path.join(folder, "fabric.csv"), rows)
    write_rows(os.path.join(folder, "fragments.csv"), sizes)
    return r, {k: np.array([row[k] for row in rows], dtype=float) for k in (rows[0] if rows else ())}


def at_strains(r: Table, strains: List[float], half: float = 1e-3) -> List[Table]:
    """Means of q, p and the volume strain within `half` of each axial strain that was reached."""
    found = []
    for e in strains:
        near = np.abs(r["axial_strain"] - e) <= half
        if near.any() and r["axial_strain"].max() >= e:
            found.append({"axial_strain": e, **{k: float(r[k][near].mean()) for k in ("q", "p", "volume_strain")}})
    return found


def marks(folder: str) -> Dict[str, str]:
    """Names of the marks that a loading left, by the strains that were asked for."""
    return {m[1]: os.path.basename(p)[:-3] for p in sorted(glob.glob(os.path.join(folder, "mark_*.in"))) if (m := re.search(r"mark_(.*)\.in$", p))}


def read(folder: str) -> Tuple[Table, Table]:
    """What `write` left."""
    return read_table(os.path.join(folder, "response.csv")), read_table(os.path.join(folder, "fabric.csv"))
