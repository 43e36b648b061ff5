# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""What each kind of `skip` of fix mpm saves: CPU seconds of the same run with it and without, in turns, medians.

    skip/undamaged  the ring of tests/system/scenes.py, pulled, too strong to be damaged
    skip/failed     the same pulled through failure
    skip/resting    24 such bonds, coarse, in a row; one is pulled, the others are held still
    skip/loaded     `skip resting` again, where all bonds carry load: the packing of packings.py, whose free grains all move
"""
import statistics

import packings
from bonds import cpu_seconds, failure, grains_at
from scenes import CALCITE, RADIUS, RING, cement, edit, launch, pair

SCENES = {
    "undamaged": ("undamaged", lambda quick: pulled(quick, 9.6e12)),
    "failed": ("failed", lambda quick: pulled(quick, 9.6e3)),
    "resting": ("resting", lambda quick: row_of_bonds(quick)),
    "loaded": ("resting", lambda quick: packings.script("total", quick)),
}
NAMES = [f"skip/{scene}" for scene in SCENES]
CELL = 2e-4
BONDS = 24


def pulled(quick, B0):
    """A pair; with the B0 of calcite until long after its bond has failed."""
    return (
        pair(CELL / 2)
        + cement(CELL, 1e-8, elastic=CALCITE, damage=f"damage tensor B0 {B0}")
        + "fix hold first move linear 0 0 0\nfix pull second move linear 0 0 2\n"
        + f"run {40 if quick else 4000}\n"
    )


def row_of_bonds(quick):
    cell, apart = 2 * CELL, 2.2 * RADIUS
    text = grains_at([(n * apart, 0, z) for n in range(BONDS) for z in (-RADIUS, RADIUS)], (-RADIUS, -RADIUS, -3 * RADIUS), (BONDS * apart, RADIUS, 3 * RADIUS))
    for n in range(BONDS):
        text += f"create_cement calcite pair {2 * n + 1} {2 * n + 2} shape flat {RING} film grid spacing {cell / 2}\n"
    return (
        text
        + cement(cell, 2e-8, elastic=CALCITE, damage="damage tensor B0 9.6e3")
        + "group others subtract grains second\nfix hold others move linear 0 0 0\nfix pull second move linear 0 0 2\n"
        + f"run {20 if quick else 1000}\n"
    )


def measure(names, directory, quick, tell):
    """Rows (dicts) of the chosen names."""
    rows = []
    for name in names:
        scene = name.split("/")[1]
        word, script = SCENES[scene][0], SCENES[scene][1](quick)
        times = {"yes": [], "no": []}
        for turn in range(1 if quick else 3):
            for on, taken in times.items():
                before = cpu_seconds()
                run = launch(edit(script, "elastic vti", f"skip {word} {on} elastic vti"), directory / f"skip_{scene}_{on}")
                assert not failure(run), failure(run)
                taken.append(cpu_seconds() - before)
        yes, no = (statistics.median(t) for t in times.values())
        rows.append({"skip": word, "scene": scene, "seconds": yes, "without": no, "all": times})
        tell(rows[-1])
    return rows
