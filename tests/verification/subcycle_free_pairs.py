#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Free pairs in sub-steps, by the program itself: does their energy stay what it was?

    tests/verification/subcycle_free_pairs.py OUT [--steps 100000] [--jobs 2]

A small flat bond between two free grains of 0.1 to 1e4 times its mass. They are thrown at each other and turned, and swing. The sub-step is 0.9 of the limit of
the cement. The steps of LIGGGHTS are spread evenly, by their logarithm, up to 0.9 of the limit of the grains on their bond, or two sub-steps where that is shorter. For each
pair it prints the mean energy of grains and cement over the last tenth of the steps, over that of the first, and the largest of all over the first. Goes on where
it was stopped.
"""
import argparse
import concurrent.futures
import os
import re
import sys
from pathlib import Path

import numpy as np

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "system"))
os.environ.setdefault("MPDEM_EXE", str(ROOT / "build" / "liggghts-mpdem"))
from scenes import cement, edit, pair, run, thermo  # noqa: E402

RATIOS = (0.1, 1, 10, 100, 1000, 10000)  # mass of both grains over that of the cement
VOLUME = 4 / 3 * np.pi * 5e-3**3


def scene(density, subcycle, words=""):
    text = edit(pair(3e-4, gap=6e-4, cement="outer 1.2e-3 inner 0", half_box=(0.1, 0.1, 0.1)), "density 2500", f"density {density:.17g}")
    text += cement(6e-4, 1e-8, axis="bond", damage=f"subcycle {subcycle} {words}")
    text += (
        "velocity first set 0.01 0 0.02\nvelocity second set -0.01 0.004 -0.02\nset atom 1 omegaz 3\nset atom 2 omegay 2\nfix motion grains nve/sphere\n"
        'variable kin atom "0.5*mass*(vx^2+vy^2+vz^2)+0.2*mass*0.005^2*(omegax^2+omegay^2+omegaz^2)"\n'
        "compute k grains reduce sum v_kin\nvariable E equal c_k+f_cem[5]+f_cem[6]+f_cem[7]\n"
    )
    return text


def limits(out, ratio):
    """Density of the grains for this ratio; the stable sub-step; the stable step of grains on their bond."""
    tell = 'variable d equal dt\nrun 0\nprint "dt ${d}"\n'
    volume = float(re.search(r"^  volume (\S+),", run(scene(1000, 2) + "run 0\n", out / "volume").output, re.M)[1])
    density = ratio * 2710 * volume / (2 * VOLUME)
    return (
        density,
        run(scene(density, 2, "timestep auto 1") + tell, out / f"cement_{ratio:g}").value("dt") / 2,
        run(scene(density, "auto", "timestep auto 1") + tell, out / f"grains_{ratio:g}").value("dt"),
    )


def swings(out, density, n, sub, steps):
    out.mkdir(parents=True, exist_ok=True)
    if not (out / "energy.txt").exists():
        text = edit(scene(density, n), "timestep     1e-08", f"timestep     {n * sub:.17g}")
        table = run(text + thermo(max(1, steps // 2000), ["v_E"]) + f"run {steps}\n", out, minutes=120).table()
        np.savetxt(out / "energy.txt", table["v_E"])
    energy = np.loadtxt(out / "energy.txt")
    tenth = len(energy) // 10
    first = energy[:tenth].mean()
    return energy[-tenth:].mean() / first, energy.max() / first


def main():
    p = argparse.ArgumentParser()
    p.add_argument("out", type=Path)
    p.add_argument("--steps", type=int, default=100000)
    p.add_argument("--jobs", type=int, default=2)
    p.add_argument("--each", type=int, default=4, help="steps of LIGGGHTS for each ratio of the masses")
    args = p.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    tasks = []
    for ratio in RATIOS:
        density, sub, step = limits(args.out, ratio)
        most = max(2.0, 0.9 * step / (0.9 * sub))
        for n in sorted({int(round(x)) for x in np.geomspace(2, most, args.each)}):
            tasks.append((ratio, density, n, 0.9 * sub, step))
    print("mass of grains over cement, sub-steps, step over the limit of the grains: mean energy of the last tenth, largest; over that of the first")
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        found = [(t, pool.submit(swings, args.out / f"{t[0]:g}_{t[2]}", t[1], t[2], t[3], args.steps)) for t in tasks]
        for (ratio, _, n, sub, step), f in found:
            last, largest = f.result()
            print(f"{ratio:g}, {n}, {n * sub / step:.3g}: {last:.6f}, {largest:.6f}", flush=True)


if __name__ == "__main__":
    main()
