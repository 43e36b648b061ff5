# SPDX-License-Identifier: GPL-2.0-or-later
"""`shape hourglass`: a pair pulled apart breaks through the waist, at less than the straight bond of the same attached area."""
import re

import numpy as np
from scenes import cement, edit, pair, pull, run, thermo

CELL, GAP, OUTER, WAIST = 3e-4, 1.2e-3, 1.6e-3, 0.6
DAMAGE = "damage tensor B0 9.6e3"


def pulled(shape, words, directory, ranks=1):
    script = pair(CELL / 2, gap=GAP, shape=shape, cement=words)
    script += cement(CELL, 1.5e-8, damage=DAMAGE) + pull(2.0, 4e-6)
    script += thermo(20, ["f_bond", "f_bond[16]", "f_cem[2]", "f_cem[12]", "f_cem[19]", "f_cem[21]"]) + "run 1200\n"
    script += "compute bad calcite mpm/atom cem failed\ndump d calcite custom 1 points.txt id x y z c_bad\nrun 0\n"
    return run(script, directory, ranks)


def failed_heights(directory):
    rows = np.loadtxt((directory / "points.txt").read_text().split("ITEM: ATOMS")[-1].splitlines()[1:])
    return rows[rows[:, 4] > 0, 3]


def test_pulled_apart(tmp_path, figures):
    words = f"outer {OUTER} waist {WAIST}"
    one, two = (pulled("hourglass", words, tmp_path / str(n), n) for n in (1, 2))
    straight = pulled("flat", f"outer {OUTER}", tmp_path / "flat")
    # made as said: volume of the solid under the hyperbola less the caps of both grains
    R, length = 5e-3, GAP + 2 * (5e-3 - np.sqrt(25e-6 - OUTER**2))
    cap = R - np.sqrt(R**2 - OUTER**2)
    V = np.pi * length * OUTER**2 * (2 * WAIST**2 + 1) / 3 - 2 * np.pi * cap**2 * (R - cap / 3)
    said = re.search(
        r"^Cement between grains 1 and 2: hourglass, inner radius 0, neck radius (\S+), outer radius (\S+), gap .*\n  volume (\S+),", one.output, re.M
    )
    assert float(said[1]) == WAIST * OUTER and float(said[2]) == OUTER and abs(float(said[3]) / V - 1) < 1e-5
    a, b, flat = (r.table() for r in (one, two, straight))
    for table in (a, b):
        assert table["f_cem[19]"][-1] == 1 and table["f_cem[21]"][-1] == 1, "one bond is separated, through its inside"
        figures.below("hourglass pulled apart: energy imbalance", abs(table["f_cem[12]"]).max(), 0.01)
    intact = a["f_cem[2]"] == 0
    peak = a["f_bond"].max()
    figures.below("hourglass, two ranks against one: force while intact, over the peak", abs(a["f_bond"] - b["f_bond"])[intact].max() / peak, 1e-13)
    # the crack is in the waist, not at a grain
    heights = failed_heights(tmp_path / "1")
    assert len(heights) > 20
    figures.below("hourglass: mean distance of failed points from the plane of the waist, over half of the length", abs(heights).mean() / (length / 2), 0.35)
    ratio = peak / flat["f_bond"].max()
    figures.note("hourglass: peak over that of the cylinder", f"{ratio:.3f}")
    assert WAIST**2 * 0.8 < ratio < 0.8


def test_neck_or_content(tmp_path):
    """`neck` and `content` give the same bond as `outer`."""
    volumes, output = [], ""
    made = pair(CELL / 2, gap=GAP, shape="hourglass", cement=f"outer {OUTER} waist {WAIST}")
    for words in (f"outer {OUTER} waist {WAIST}", f"neck {OUTER * WAIST:.17g} waist {WAIST}", "content"):
        if words == "content":
            content = re.search(r"content \(mass over mass of the grains\) (\S+),", output)[1]
            words = f"content {content} waist {WAIST}"
        output = run(edit(made, f"outer {OUTER} waist {WAIST}", words), tmp_path).output
        volumes.append(float(re.search(r"^  volume (\S+),", output, re.M)[1]))
    assert volumes[0] == volumes[1] and abs(volumes[2] / volumes[0] - 1) < 1e-5
