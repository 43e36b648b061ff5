# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Speeds of the shear and the compression wave of a specimen, from what examples/specimen/in.wave left."""
import os
from typing import Dict, List, Tuple

import numpy as np

from .run import Trouble

SLABS = 8  # of the specimen, from the floor to the plate
FRONT = 0.5  # share of the first crest at which a wave arrives
CREST = 0.3  # a crest is at least this share of the largest velocity of its slab


def frames(path: str, column: int, rate: float) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (s) since the start, heights of the beads (m), and their velocities (times, beads), of a dump of in.wave."""
    times, heights, speeds = [], np.empty(0), []
    with open(path) as f:
        while line := f.readline():
            if line.startswith("ITEM: TIMESTEP"):
                times.append(int(f.readline()))
            elif line.startswith("ITEM: NUMBER"):
                count = int(f.readline())
            elif line.startswith("ITEM: ATOMS"):
                rows = np.array([f.readline().split() for _ in range(count)], dtype=float)
                heights = rows[:, 1] if not heights.size else heights
                speeds.append(rows[:, column])
    return rate * (np.array(times, dtype=float) - times[0]), heights, np.array(speeds)


def arrivals(t: np.ndarray, z: np.ndarray, v: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Mean heights of the slabs of beads, and the times at which the wave has FRONT of its first crest in each; nan: it does not come."""
    edges = np.linspace(0.0, z.max() + z.min(), SLABS + 1)  # beads of both ends are as far from the plates
    middle, come = [], []
    for low, high in zip(edges, edges[1:]):
        inside = (z >= low) & (z < high)
        if not inside.any():
            continue
        mean = v[:, inside].mean(axis=1)
        crests = np.flatnonzero((mean[1:-1] > mean[:-2]) & (mean[1:-1] >= mean[2:]) & (mean[1:-1] > CREST * np.abs(mean).max())) + 1
        middle.append(z[inside].mean())
        if not crests.size:
            come.append(np.nan)
            continue
        n = int(np.argmax(mean >= FRONT * mean[crests[0]]))
        step = (FRONT * mean[crests[0]] - mean[n - 1]) / (mean[n] - mean[n - 1]) if n else 0.0
        come.append(t[n - 1] + step * (t[n] - t[n - 1]) if n else 0.0)
    return np.array(middle), np.array(come)


def speed(middle: np.ndarray, come: np.ndarray) -> Tuple[float, float]:
    """Speed, m/s, of the line through the arrivals in all slabs but that of the kick and that of the plate; the largest distance from it over the height."""
    middle, come = middle[1:-1], come[1:-1]
    there = np.isfinite(come)
    if there.sum() < 3:
        return float("nan"), float("nan")
    slope, start = np.polyfit(middle[there], come[there], 1)
    return 1.0 / slope, float(np.abs(middle[there] - (come[there] - start) / slope).max() / np.ptp(middle))


def results(folder: str, rate: float) -> Dict[str, float]:
    """Shear and compression wave speeds, m/s, and how far the arrivals are from a line; rate: the time step, s."""
    found: Dict[str, float] = {}
    for name, column, runs in (("shear", 2, (2, 1)), ("compression", 3, (4, 3))):
        parts: List[np.ndarray] = []
        for n in runs:
            path = os.path.join(folder, f"wave_{n}.txt")
            if not os.path.exists(path):
                raise Trouble(f"{path}: no such file; run in.wave to its end")
            t, z, v = frames(path, column, rate)
            parts.append(v)
        rows = min(len(p) for p in parts)
        found[name], found[f"{name}_off"] = speed(*arrivals(t[:rows], z, 0.5 * (parts[0][:rows] - parts[1][:rows])))
    return found
