#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Energy of a crack that runs steadily, as the slope of the energy spent over the area of the crack.

A strip of cement hangs between two grains that are flat, as large as they are. It is held by both along its whole length, has a notch of
failed points half-way between them at one end, and is drawn apart and then held so. In front of the crack the strip has the energy
E e^2/2 times its height H per area, behind it none, so the crack runs if that is above G, as fast however far it is (Rivlin and Thomas,
J. Polym. Sci. 10 (1953) 291). The lattice of the points lies along the axes of the box; the strip is turned against it.
"""
import csv
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "system"))
from localisation import band  # noqa: E402
from scenes import edit, host, NEIGHBOURS, run, thermo  # noqa: E402
import scenes  # noqa: E402

E, B0, DCUT, RHO, LENGTH = 40e9, 9.6e3, 0.9, 2710.0, 2e-4
HEIGHT = 28  # lengths
NOTCH, BEHIND, STEADY, AHEAD = 20, 10, 14, 12  # lengths along the strip
HELD = NOTCH + BEHIND + STEADY + AHEAD


def strip(spacing, angle, width):
    """Points of the strip: along it, across and in depth, and their places."""
    reach = math.hypot(HELD, HEIGHT) * LENGTH
    n = math.ceil(reach / spacing)
    x, z = np.meshgrid((np.arange(-n, n) + 0.5) * spacing, (np.arange(-n, n) + 0.5) * spacing, indexing="ij")
    along, up = math.cos(angle) * x - math.sin(angle) * z, math.sin(angle) * x + math.cos(angle) * z
    inside = (abs(along) < 0.5 * HELD * LENGTH - 1e-9 * LENGTH) & (abs(up) < 0.5 * HEIGHT * LENGTH - 1e-9 * LENGTH)
    y = (np.arange(width) - width / 2 + 0.5) * spacing
    rows = [np.column_stack([x[inside], np.full(inside.sum(), b), z[inside], along[inside], up[inside]]) for b in y]
    return np.concatenate(rows)


def crack(directory, per_length, words=None, energy=None, angle=0.0, shift=0.0, over=1.35, cracks="split", damping=0.3, width=2, ramp=6.0, hold=6.0, then=None, basis=""):
    """per_length: cells; over: energy of the strip over that of the crack. Times in those that a wave takes over the height."""
    h = LENGTH / per_length
    s = h / 2
    p = strip(s, angle, width)
    p[:, 4] -= shift * s
    G = energy or math.sqrt(2) * B0 * LENGTH * band(0.0)[1]
    along = p[:, 3] / LENGTH + HELD / 2
    failed = (along < NOTCH) & (abs(p[:, 4]) < (0.51 if cracks == "split" else 1.01) * h)
    # an average over the length is no larger at a notch than the strength of a strip that is near to break: damage leads the crack in
    D = np.where(~failed & (abs(p[:, 4]) < 0.51 * LENGTH) & (along > NOTCH - 1), np.clip(1.6 * (1 - (along - NOTCH) / 7), 0.0, 0.85), 0.0)
    directory.mkdir(parents=True, exist_ok=True)
    np.savetxt(directory / "strip.txt", np.column_stack([p[:, :3], np.full(len(p), s**3), failed, D, D, D, 0 * D, 0 * D, 0 * D]), fmt="%.17g",
               header="x y z volume failed dxx dyy dzz dyz dxz dxy", comments="")
    radius = 500 * HEIGHT * LENGTH
    n = np.array([math.sin(angle), 0.0, math.cos(angle)])
    text = host() + "region box block " + " ".join(f"{-b:g} {b:g}" for b in (2.2 * radius, 1.1 * radius, 2.2 * radius)) + " units box\ncreate_box 2 box\n"
    for side in (-1, 1):
        text += "create_atoms 1 single " + " ".join(f"{c:.15g}" for c in side * (radius + 0.5 * HEIGHT * LENGTH) * n + 0.0) + " units box\n"
    text += f"set type 1 diameter {2 * radius} density 2500\ngroup grains type 1\n" + NEIGHBOURS
    attach = s * (1.0 if angle == 0 else abs(math.cos(angle)) + abs(math.sin(angle))) * 1.001
    text += f"create_cement calcite pair 1 2 file strip.txt spacing {s:.15g} attach {attach:.15g}\n"
    text += scenes.cement(h, 1e-9, damage=f"damage tensor B0 {B0} cutoff {DCUT} regularization {words or f'nonlocal {LENGTH}'} events events.csv check 20 "
                          f"timestep auto 0.8 quasistatic 1 {damping} cracks {cracks} {basis}")
    text = edit(text, "vti 60000000000 40000000000 0.25 0.2 18000000000", f"isotropic {E} 0.0")
    c = math.sqrt(E / RHO)
    unit = HEIGHT * LENGTH / c
    T, u = ramp * unit, math.sqrt(2 * over * G * HEIGHT * LENGTH / E)
    u2, T2 = u * (1.0 if then is None else math.sqrt(then / over)) - u, 2 * unit
    along_ = (f'"(v_t<{T})*{u}*(v_t/{T}-sin(2*PI*v_t/{T})/2/PI)+(v_t>={T})*({u}+(v_t<{T + T2})*{u2}*((v_t-{T})/{T2}-sin(2*PI*(v_t-{T})/{T2})/2/PI)'
              f'+(v_t>={T + T2})*{u2})"')
    speed = f'"(v_t<{T})*{u}/{T}*(1-cos(2*PI*v_t/{T}))+(v_t>={T})*(v_t<{T + T2})*{u2}/{T2}*(1-cos(2*PI*(v_t-{T})/{T2}))"'
    text += scenes._motion(n, along_, speed)
    text += thermo(5, ["v_t", "f_bond", "f_cem[8]", "f_cem[9]", "f_cem[2]", "f_cem[12]", "f_cem[10]"])
    dt = 0.8 * 2 / math.sqrt(6) * h / c
    text += scenes.point_quantities(["damage"]) + "dump d calcite custom 5 damaged.*.txt id x z c_damage\ndump_modify d thresh c_damage >= 0.1\n"
    text += f"dump e calcite custom {int((ramp + hold) * unit / dt)} end.*.txt id x z c_damage\ndump_modify e thresh c_damage >= 0.01\n"
    text += f"run {int((ramp + hold) * unit / dt)}\n"
    done = run(text, directory, minutes=9)
    t = done.table()
    return measure(directory, t, G, angle, width * s, s)


def measure(directory, t, G, angle, width, s):
    """Front: how far the columns of points reach that have one with a damage above one half."""
    at, spent_at = [], []
    steps = sorted(int(f.name.split(".")[1]) for f in directory.glob("damaged.*.txt"))
    for step in steps:
        lines = (directory / f"damaged.{step}.txt").read_text().splitlines()[9:]
        if not lines:
            continue
        x, z, D = np.array([[float(w) for w in line.split()] for line in lines]).T[1:4]
        column = np.floor(((math.cos(angle) * x - math.sin(angle) * z) / LENGTH + HELD / 2) * LENGTH / s + 1e-6).astype(int)
        most = np.zeros(round(HELD * LENGTH / s) + 2)
        np.maximum.at(most, column, D)
        last = np.flatnonzero(most >= 0.5).max(initial=0)
        if last * s / LENGTH > NOTCH + 7 and most[last + 1] < 0.5:
            at.append((last + 0.5 + (most[last] - 0.5) / (most[last] - most[last + 1])) * s / LENGTH)
            spent_at.append(step)
    at, spent_at = np.array(at), np.array(spent_at)
    spent = np.interp(spent_at, t["step"], t["f_cem[8]"] + t["f_cem[9]"])
    steady = (at >= NOTCH + BEHIND) & (at <= NOTCH + BEHIND + STEADY)
    fit = np.polyfit(at[steady], spent[steady], 1)
    half = np.median(at[steady])
    parts = [np.polyfit(at[steady & m], spent[steady & m], 1)[0] / fit[0] for m in (at <= half, at >= half)]
    slope = fit[0] / (LENGTH * width)
    time = np.interp(spent_at, t["step"], t["v_t"])
    speed = np.polyfit(time[steady], at[steady], 1)[0] * LENGTH
    events = np.loadtxt(directory / "events.csv", delimiter=",", skiprows=1, usecols=(5, 6, 7))
    return {"ratio": slope / G, "slope": slope, "G": G, "scatter": float(np.std(spent - np.polyval(fit, at), where=steady) / (G * LENGTH * width)), "first": parts[0], "second": parts[1],
            "speed": speed / math.sqrt(E / RHO), "failed": len(events) * s**3 / (width * LENGTH * (HELD - NOTCH) * LENGTH), "frames": steady.sum(), "end": spent[-1] / (G * LENGTH * width * (HELD - NOTCH)),
            "imbalance": abs(t["f_cem[12]"][-1])}


if __name__ == "__main__":
    import time as clock
    where = Path(sys.argv[1])
    for spec in sys.argv[2:]:
        o = eval(f"dict({spec})")
        began = clock.time()
        try:
          r = crack(where / str(abs(hash(spec))), **o)
        except Exception as e:
          print(spec, "FAILED", e, flush=True)
          continue
        print(spec, {k: round(float(v), 4) for k, v in r.items()}, round(clock.time() - began, 1), "s", flush=True)
