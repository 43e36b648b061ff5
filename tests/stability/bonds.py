# SPDX-License-Identifier: GPL-2.0-or-later
"""The small bond that the stress tests use: under a thousand points, so that a million steps take a
minute. A ring of 0.4 to 1 mm thickness between two beads of 10 mm."""
import re

from scenes import cement, edit, pair, run

CELL = 4e-4
SMALL = "inner 1.4e-3 outer 2.2e-3"
LAW = "damage tensor B0 9.6e3 cutoff 0.9"  # onset near 20 MPa
BRITTLE = "damage tensor B0 9.6e6 cutoff 0.9"


def bond(words="", *, timestep="auto 0.9", damage="", cell=CELL, spacing=CELL / 2, **options):
    """Two grains, their cement, and the fixes; `words` are options of fix mpm."""
    couple = options.pop("couple", "kn auto kt auto")
    elastic = {k: options.pop(k) for k in ("elastic", "axis") if k in options}
    text = pair(spacing, cement=options.pop("cement", SMALL), **options)
    text += cement(cell, 1e-9, damage=damage, couple=couple, **{"axis": "radial", **elastic})
    if timestep.startswith("auto"):
        words += f" timestep {timestep}"
    else:
        text = edit(text, "timestep     1e-09", f"timestep {timestep}")
    return edit(text, f"mpm cell {cell:.15g}", f"mpm cell {cell:.15g} {words}")


def stable_step(words, directory, **options):
    """The limit of the time step that fix mpm finds for the scene."""
    out = run(bond(words, timestep="auto 1", **options) + "run 0\n", directory).output
    return float(re.search(r"timestep auto: (\S+),", out).group(1))
