# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""The whole pull to failure of a bond between two grains: what breaking costs, and where the time goes.

    fail/flat, fail/meniscus, fail/coating
                    examples/pair_table/in.pair_table in tension as it stands, with cells of 0.2 mm, until the bond is broken: CPU seconds
                    of the run, points a second and shares of the phases in fix mpm
"""
import os
import re
import shutil

from bonds import ROOT, cpu_seconds, failure, told_by_cement
from scenes import launch

# A coating is thinner than the others with the same content.
CONTENT = {"flat": 0.05, "meniscus": 0.05, "coating": 0.15}
NAMES = [f"fail/{shape}" for shape in CONTENT]
SPACING = 1e-4


def measure(names, directory, quick, tell):
    """Rows (dicts) of the chosen names."""
    rows = []
    for name in names:
        shape = name.split("/")[1]
        folder = directory / f"fail_{shape}"
        folder.mkdir(exist_ok=True)
        script = shutil.copy(ROOT / "examples" / "pair_table" / "in.pair_table", folder)
        spacing = SPACING * (1.5 if quick and shape != "coating" else 1)
        before = cpu_seconds()
        with open(script) as f:
            run = launch(f.read(), folder, arguments=["-var", "shape", shape, "-var", "content", str(CONTENT[shape]), "-var", "spacing", f"{spacing:g}"])
        assert not failure(run), failure(run)
        seconds = cpu_seconds() - before
        result = dict(re.findall(r"(broken|mode|peak|steps) (\S+)", re.search(r"^RESULT .*", run.output, re.M)[0]))
        told = told_by_cement(run)
        points = int(re.search(r"(\d+) material points, \d+ bonds", run.output)[1])
        in_cement = sum(t["seconds"] for t in told)
        rows.append(
            {
                "fail": shape,
                "points": points,
                "steps": sum(t["steps"] for t in told),
                "seconds": seconds,
                "points/s": sum(t["steps"] for t in told) / sum(t["steps"] / t["points/s"] for t in told),
                "broken": float(result["broken"]) == 1.0,
                "mode": result["mode"],
                "peak": float(result["peak"]),
                "phases": {p: sum(t["seconds"] * t["phases"][p] for t in told) / in_cement for p in told[0]["phases"]},
                "load": os.getloadavg()[0],
            }
        )
        tell(rows[-1])
    return rows
