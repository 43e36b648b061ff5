#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""A block of cement without damage, pulled off a flat grain whose links have a strength and an energy.

The block hangs between two grains that are flat, as large as they are: by all of its face on grain 2, by a part of it on grain 1, so
that grain 2 carries less and all of grain 1 debonds. The part is one end of the block, whose edge is a crack that runs, or every other
point of the face: then all links of grain 1 go the same way. With nu = 0 and kt/kn = 1/2, which is G/E, block and links fail
alike, and each link opens along the direction of the pull: with the angle a of it against the normal, of the energy the share of shear

  B = (kt/kn) sin^2 a/(cos^2 a + (kt/kn) sin^2 a),   and 1/G = (1 - B)/Gn + B/Gt.
"""
import math

import numpy as np
import scenes
from scenes import NEIGHBOURS, edit, host, run, thermo

E, RHO, LONG, HIGH, SHEAR = 40e9, 2710.0, 2e-3, 5e-4, 0.5  # SHEAR: kt/kn


def envelope(angle, Gn, Gt):
    B = SHEAR * math.sin(angle) ** 2 / (math.cos(angle) ** 2 + SHEAR * math.sin(angle) ** 2)
    return 1 / ((1 - B) / Gn + B / Gt)


def block(cells, layers):
    """Points, 4 across; `layers` more of them than `cells` twice."""
    s = HIGH / cells / 2
    n = (round(LONG / s), 4, 2 * cells + layers)
    i = np.stack(np.meshgrid(*(np.arange(k) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    return i, (i - np.array(n) / 2 + 0.5) * s, s


def pulled_off(directory, cells, angle=0.0, Gn=4.0, Gt=4.0, strength=10e6, held="end", layers=0, speed=0.05, far=2.5):
    """Energies per area that was held by grain 1. angle: of the pull, against the normal; far: of the pull, over the end of the law."""
    i, X, s = block(cells, layers)
    high, h = s * (2 * cells + layers), 2 * s
    first, last = i[:, 2] == 0, i[:, 2] == i[:, 2].max()
    part = first & (X[:, 0] > 0 if held == "end" else (i[:, 0] + i[:, 1]) % 2 == 0)
    directory.mkdir(parents=True, exist_ok=True)
    np.savetxt(
        directory / "block.txt",
        np.column_stack([X, np.full(len(X), s**3), first * s**2, last * s**2, part, last]),
        fmt="%.17g",
        header="x y z volume area_i area_j attached_i attached_j",
        comments="",
    )
    radius = 500 * LONG
    text = (
        host() + f"region box block {-1.1 * radius} {1.1 * radius} {-1.1 * radius} {1.1 * radius} {-2.2 * radius} {2.2 * radius} units box\ncreate_box 2 box\n"
    )
    for side in (-1, 1):
        text += f"create_atoms 1 single 0 0 {side * (radius + high / 2):.15g} units box\n"
    text += f"set type 1 diameter {2 * radius} density 2500\ngroup grains type 1\n" + NEIGHBOURS
    text += f"create_cement calcite pair 1 2 file block.txt spacing {s:.15g}\n"
    text += scenes.cement(
        h,
        1e-9,
        damage="timestep auto 0.8 quasistatic 1 0.3 events events.csv check 20",
        couple=f"kn {200 * E} kt {200 * SHEAR * E} interface cohesive tn {strength} tt {strength} Gn {Gn} Gt {Gt}",
    )
    text = edit(text, "vti 60000000000 40000000000 0.25 0.2 18000000000", f"isotropic {E} 0.0")
    c = math.sqrt(E / RHO)
    dt = 0.8 * 2 / math.sqrt(6) * h / c
    way = 2 * far * max(Gn, Gt) / strength + 2 * high * strength / E
    duration = way / (speed * c * strength / E)
    n = (math.sin(angle), 0.0, math.cos(angle))
    text += scenes._motion(n, f'"{way}*(v_t/{duration}-sin(2*PI*v_t/{duration})/2/PI)"', f'"{way}/{duration}*(1-cos(2*PI*v_t/{duration}))"')
    text += thermo(20, ["f_bond[17]", "f_cem[8]", "f_cem[11]", "f_cem[12]"]) + f"run {int(duration / dt)}\n"
    done = run(text, directory)
    t = done.table()
    debonded = [line.split(",")[4] for line in (directory / "events.csv").read_text().splitlines()[1:]]
    area = part.sum() * s**2
    return {
        "energy": t["f_cem[8]"][-1] / area,
        "of_first": debonded.count("1") / part.sum(),
        "of_second": debonded.count("2"),
        "imbalance": abs(t["f_cem[12]"][len(t["step"]) // 4 :]).max(),
        "output": done.output,
    }
