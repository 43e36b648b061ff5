# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""What it costs when a bond separates, in scenes of few and of many bonds.

    separation/N    N coarse bonds between pairs of grains, of which 24 are pulled apart at speeds of their own and the others
                    are held still. CPU time of the step in which one gets the layout of its two pieces, above the median of the ten steps before;
                    median over the separations. The same run twice: told of separations, told of times, which bench/cpu_clock.cpp
                    makes those of the CPU.
"""
import os
import statistics
from pathlib import Path

from bonds import failure, grains_at
from scenes import CALCITE, RADIUS, cement, launch, thermo

NAMES = ["separation/30", "separation/600", "separation/2700"]
PULLED, CELL, STEP = 24, 4e-4, 2e-8


def script(bonds, columns, every, steps):
    across, deep, apart = 60, -(-bonds // 60), 2.2 * RADIUS
    text = grains_at(
        [(n % across * apart, n // across * apart, z) for n in range(bonds) for z in (-RADIUS, RADIUS)],
        (-RADIUS, -RADIUS, -4 * RADIUS),
        (across * apart, deep * apart, 4 * RADIUS),
    )
    text += f"create_cement calcite contacts grains gap 1e-6 shape flat inner 5e-4 outer 2e-3 film grid spacing {CELL / 2}\n"
    text += cement(CELL, STEP, elastic=CALCITE, damage="damage tensor B0 9.6e3")
    text = text.replace("damage tensor B0 9.6e3", "damage tensor B0 9.6e3 check 100000")
    names = []
    for n in range(PULLED):
        text += f"group pulled{n} id {2 * n + 2}\nfix pull{n} pulled{n} move linear 0 0 {60.0 / (20 + 7 * n):g}\n"
        names.append(f"pulled{n}")
    text += f"group all_pulled union {' '.join(names)}\ngroup others subtract grains all_pulled\nfix hold others move linear 0 0 0\n"
    return text + thermo(every, columns) + f"run {steps}\n"


def measure(names, directory, quick, tell):
    """Rows (dicts) of the chosen names."""
    rows = []
    for name in names:
        bonds = int(name.split("/")[1])
        steps = 30 if quick else 130
        # a bond is checked in the step after one that five divides
        told = launch(script(bonds, ["f_cem[19]"], 5, steps), directory / f"separation_{bonds}")
        assert not failure(told), failure(told)
        os.environ["LD_PRELOAD"] = str(Path(os.environ["MPDEM_EXE"]).resolve().parent / "bench" / "libcpu_clock.so")
        try:
            timed = launch(script(bonds, ["cpu"], 1, steps), directory / f"separation_{bonds}_timed", minutes=15)
        finally:
            del os.environ["LD_PRELOAD"]
        assert not failure(timed), failure(timed)
        separated, cpu = told.table()["f_cem[19]"], timed.table()["cpu"]
        above = []
        for m in range(3, len(separated)):
            if separated[m] <= separated[m - 1]:
                continue
            n = 5 * (m - 1) + 1
            usual = statistics.median(cpu[k] - cpu[k - 1] for k in range(n - 10, n))
            above.append((cpu[n] - cpu[n - 1] - usual) / (separated[m] - separated[m - 1]))
        rows.append(
            {
                "bonds": bonds,
                "separations": int(separated[-1]),
                "seconds": statistics.median(above) if above else None,
                "step": statistics.median(cpu[k] - cpu[k - 1] for k in range(1, len(cpu))),
                "load": os.getloadavg()[0],
            }
        )
        tell(rows[-1])
    return rows
