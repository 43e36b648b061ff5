#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Many equal bonds, each between a pair of grains of its own, that are pulled apart together: the loads at which their first points fail.

    pulled_bonds.py                     500 bonds for moduli of Weibull of 3, 6 and 12, 100 a run; runs that are there are not repeated
    pulled_bonds.py --folder F --bonds N
"""
import argparse
import math
import os
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "system"))
from scenes import NEIGHBOURS, host, run  # noqa: E402

RADIUS, GAP, WIDTH, CELL = 5e-3, 4e-4, 2.5e-4, 2e-4  # width: radius of the cement
APART = 10.8e-3
E, B0 = 3e10, 1e3


def script(words, bonds, steps=2500, every=10):
    """Displacement grows with the square of time, so weak bonds are not pulled faster than strong ones for their strength."""
    columns = math.ceil(math.sqrt(bonds))
    box = 0.5 * APART * (columns + 1)
    text = host() + f"region box block {-box:.9g} {box:.9g} {-box:.9g} {box:.9g} -0.012 0.012 units box\ncreate_box 2 box\n"
    for n in range(bonds):
        x, y = (APART * (k - 0.5 * (columns - 1)) for k in (n % columns, n // columns))
        for side in (-1, 1):
            text += f"create_atoms 1 single {x:.9g} {y:.9g} {side * (RADIUS + GAP / 2):.9g} units box\n"
    strain = 1.19 * math.sqrt(B0 / E)  # at the strength
    timestep = 0.4 * CELL / math.sqrt(E / 2710)
    distance = 9.0 * strain * GAP
    text += f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n{NEIGHBOURS}"
    text += f"create_cement calcite contacts grains gap {1.5 * GAP} shape flat outer {WIDTH} inner 0 film grid spacing {CELL / 2}\n"
    text += f"timestep {timestep:.9g}\nfix cem calcite mpm cell {CELL} elastic isotropic {E:g} 0.2 damage tensor B0 {B0:g} cutoff 0.5 {words}\n"
    text += f"fix bond grains mpm/couple cem damping 0.5 csv {every} bonds.csv\nregion up block INF INF INF INF 0 INF units box\n"
    text += "group type2 type 2\ngroup upper region up\ngroup upper subtract upper type2\ngroup lower subtract grains upper\n"
    t = steps * timestep
    text += f'variable t equal step*dt\nvariable d equal "{distance}*(v_t/{t:.9g})^2"\nvariable v equal "2*{distance}*v_t/{t:.9g}^2"\n'
    text += "fix hold lower move linear 0 0 0\nfix pull upper move variable NULL NULL v_d NULL NULL v_v\n"
    return text + f"thermo {steps}\nrun {steps}\n"


def first_failures(directory, words, bonds, steps=2500):
    """Tension of each bond in the first row of the table with a failed point, N."""
    directory = Path(directory)
    run(script(words, bonds, steps), directory, minutes=20)
    rows = np.genfromtxt(directory / "bonds.csv", delimiter=",", names=True, dtype=None, encoding=None)
    loads = []
    for n in range(1, bonds + 1):
        own = rows[rows["bond"] == n]
        failed = own["failed"] > 0
        loads.append(own["peak_tension"][np.argmax(failed)] if failed.any() else np.nan)
    return np.array(loads)


def modulus_of_weibull(values):
    """Maximum likelihood."""
    logs = np.log(np.asarray(values) / np.mean(values))
    low, high = 0.1, 200.0
    for _ in range(100):
        m = 0.5 * (low + high)
        weights = np.exp(m * logs)
        low, high = (low, m) if (weights @ logs) / weights.sum() - 1 / m > logs.mean() else (m, high)
    return 0.5 * (low + high)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, default=Path("pulled_bonds"), help="of the runs")
    parser.add_argument("--bonds", type=int, default=500, help="for each modulus, 100 a run")
    args = parser.parse_args()
    if not os.environ.get("MPDEM_EXE"):
        parser.error("set MPDEM_EXE to the program")
    for modulus in (3, 6, 12):
        loads = []
        for part in range(math.ceil(args.bonds / 100)):
            folder = args.folder / f"{modulus}.{part}"
            done = folder / "loads.txt"
            if not done.exists():
                folder.mkdir(parents=True, exist_ok=True)
                np.savetxt(done, first_failures(folder, f"scatter strength weibull {modulus} seed {100 * modulus + part}", 100))
            loads.extend(np.loadtxt(done))
        found = modulus_of_weibull(loads)
        print(f"modulus {modulus}: {found:.3f} from {len(loads)} bonds, error {found / modulus - 1:+.3f}, mean load {np.mean(loads):.4g} N")
    return 0


if __name__ == "__main__":
    sys.exit(main())
