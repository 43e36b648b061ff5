# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Packings: seconds a step, bytes, and the share of the phases, of many coarse bonds between free grains.

    packing/total, packing/updated
                    5 x 5 x 5 beads in a cubic packing, cement at their 300 contacts, one or two cells thick, sheared
                    so slowly that none breaks; on one and on two ranks, medians
"""
import os
import re
import statistics

from bonds import failure, grains_at, loop_seconds, told_by_cement
from scenes import CALCITE, RADIUS, cement, edit, launch

NAMES = ["packing/total", "packing/updated"]
BEADS, CELL = 5, 8e-4


def script(kinematics, quick):
    n = 3 if quick else BEADS
    low, high = -1.1 * RADIUS, 2 * RADIUS * (n - 1) + 1.1 * RADIUS
    text = grains_at([[2 * RADIUS * k for k in (i % n, i // n % n, i // n**2)] for i in range(n**3)], (low,) * 3, (high,) * 3)
    text += f"create_cement calcite contacts grains gap 1e-6 shape flat outer 2.5e-3 inner auto spacing {CELL / 2}\n"
    text += edit(cement(CELL, 4e-8, elastic=CALCITE, damage="damage tensor B0 9.6e3"), "elastic vti", f"kinematics {kinematics} elastic vti")
    return (
        text
        + f'variable vx atom "0.01*z/{high}"\nvelocity grains set v_vx 0 0\nfix motion grains nve/sphere\n'
        + "thermo_style custom step f_cem[2] f_cem[12]\nthermo 100\n"
        + f"run {20 if quick else 500}\n"
    )


def measure(names, directory, quick, tell):
    """Rows (dicts) of the chosen names."""
    rows = []
    for name in names:
        kinematics = name.split("/")[1]
        times, said = {1: [], 2: []}, None
        for turn in range(1 if quick else 3):
            for ranks, taken in times.items():
                run = launch(script(kinematics, quick), directory / f"packing_{kinematics}_{ranks}", ranks)
                assert not failure(run), failure(run)
                taken.append(loop_seconds(run))
                if ranks == 1:
                    (said,) = told_by_cement(run)
                    points, bonds = map(int, re.search(r"(\d+) material points, (\d+) bonds", run.output).groups())
        one, two = (statistics.median(t) for t in times.values())
        rows.append(
            {
                "packing": kinematics,
                "bonds": bonds,
                "points": points,
                "points/s": said["points/s"],
                "bytes/point": said["bytes/point"],
                "phases": said["said"],
                "one": one,
                "two": two,
                "speedup": one / two,
                "load": os.getloadavg()[0],
            }
        )
        tell(rows[-1])
    return rows
