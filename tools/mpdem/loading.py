# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""What a loaded pair did: the table load_NAME.csv of examples/pair_table and the table of its bond.

`way` is the way (m) or angle (rad) of the upper grain, `load` the force (N) or moment (N m) on the
bond that does work on it, whichever load it is.
"""
import os
import re

import numpy as np

from . import tables
from .tables import Trouble

FAILED_BELOW = 0.01  # of the peak
STIFFNESS = (0.10, 0.40)  # of the peak


def read_table(path):
    """Columns by name; a last line that is still being written is left out."""
    table = tables.read(path)
    if table.empty:
        raise Trouble(f"{path}: no rows; let the run get past its setup")
    return {name: table[name].tolist() if name == "mode" else table[name].to_numpy() for name in table}


def measure(time, way, load, window):
    """Peak, stiffness, work and the displacement at which the load has fallen for good. `window` in s."""
    nan = float("nan")
    top = int(np.argmax(np.abs(load)))
    peak = abs(load[top])
    r = dict(
        peak=peak, way_at_peak=way[top], stiffness=nan, broken=False, way_at_failure=nan, energy=float(np.sum(0.5 * (load[1:] + load[:-1]) * np.diff(way)))
    )
    if not peak > 0.0:
        return r
    rising = np.abs(load[: top + 1])
    above = np.flatnonzero(rising > STIFFNESS[1] * peak)
    end = int(above[0]) + 1 if above.size else top + 1
    low = np.flatnonzero(rising[:end] < STIFFNESS[0] * peak)
    start = int(low[-1]) + 1 if low.size else 0
    if end - start >= 3 and np.ptp(way[start:end]) > 0.0:
        scale = np.ptp(way[start:end])
        r["stiffness"] = float(np.polyfit((way[start:end] - way[start]) / scale, load[start:end], 1)[0] / scale)
    # means over windows that end at each row, of whole windows after the peak
    total = np.concatenate(([0.0], np.cumsum(load)))
    first = np.searchsorted(time, time - window, side="right")
    rows = np.arange(1, len(load) + 1)
    mean = (total[rows] - total[first]) / (rows - first)
    gone = np.flatnonzero((time >= time[top] + window) & (np.abs(mean) < FAILED_BELOW * peak))
    if gone.size:
        r["broken"], r["way_at_failure"] = True, float(way[first[gone[0]]])
    return r


def dimension(log):
    """What the log says of the cement: (dimension that the content fixes, inner radius, volume, points)."""
    found = re.search(r"^Cement between grains .*?: (.*)\n\s*volume ([^,]+),.* (\d+) points", log, re.M)
    if not found:
        raise Trouble("the log lacks the line of create_cement; run the pair again")
    size = {name: float(value) for name, value in re.findall(r"(outer radius|neck radius|ring radius) ([0-9.e+-]+)", found[1])}
    inner = re.search(r"inner radius ([0-9.e+-]+)", found[1])
    largest = max(size.values()) if size else float("nan")
    return largest, float(inner[1]) if inner else 0.0, float(found[2]), int(found[3])


def ahead(log):
    """Of a bond that is intact at the end: share of its weakest section that is left, and the mode of a crack through that."""
    last = re.findall(r"^fix mpm .*: bond 1 of grains 1 and 2: intact, .*", log, re.M)[-1:]
    found = re.search(r"; (\S+) % of its weakest section is intact .*, and a crack through this ligament would be (\w+)", last[0]) if last else None
    return (0.01 * float(found[1]), found[2]) if found else ("", "")


def results(folder, radius=0.005, name="run", window=2e-6):
    """One row of the table of runs, SI units."""
    table = read_table(os.path.join(folder, f"load_{name}.csv"))
    bond = read_table(os.path.join(folder, f"bond_{name}.csv"))
    with open(os.path.join(folder, "log.liggghts"), errors="replace") as f:
        log = f.read()
    size, inner, volume, points = dimension(log)
    r = measure(table["time"], table["way"], table["load"], window)
    section = np.pi * (size**2 - inner**2)
    left, mode_ahead = ahead(log) if bond["mode"][-1] == "intact" else ("", "")
    r.update(
        dimension=size,
        inner=inner,
        volume=volume,
        points=points,
        section=section,
        stress_section=r["peak"] / section,
        stress_grain=r["peak"] / (np.pi * radius**2),
        mode=bond["mode"][-1],
        left=left,
        mode_ahead=mode_ahead,
        share_grain1=bond["share_grain1"][-1],
        share_grain2=bond["share_grain2"][-1],
        share_inside=1.0 - bond["share_grain1"][-1] - bond["share_grain2"][-1] if bond["mode"][-1] != "intact" else 0.0,
        failed=int(bond["failed"][-1]),
        links_debonded=int(bond["debonded"][-1]),
        attached=int(bond["attached"][-1]),
        dissipated=bond["dissipated_energy"][-1],
        imbalance=bond["energy_imbalance"][-1],
        steps=int(table["step"][-1]),
        duration=table["time"][-1],
    )
    return r
