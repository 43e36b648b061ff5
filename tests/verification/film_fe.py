#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Stiffness of a film as columns (doc/theory.md, Film) over that of finite elements, for bonds of equal touching spheres.

    film_fe.py [--levels N]

Each line is a bond that is all film with the inner radius of create_cement, 0.2 of the radius. `flat` is a ring of this
content; `meniscus` has the neck of this content, and its columns are those of the flat ring of its volume.
"""
import argparse
import math

from axisymmetric_fe import TransverselyIsotropic, axis_uniform
from bond_fe import LOADS, converged, meniscus_arc, meniscus_filling
from scipy.integrate import quad
from scipy.optimize import brentq

E, NU, DENSITY, CEMENT = 60e9, 0.25, 2500.0, 2710.0
SHEAR = E / (2 * (1 + NU))
C33 = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU))
CONTACT = math.radians(20)


def gap(R, r):
    return 2 * (R - math.sqrt(R * R - r * r))


def volume_of_ring(R, inner, outer):
    return quad(lambda r: 2 * math.pi * r * gap(R, r), inner, outer)[0]


def outer_of_ring(R, inner, volume):
    return brentq(lambda a: volume_of_ring(R, inner, a) - volume, inner * (1 + 1e-6), 0.99 * R)


def volume_of_meniscus(R, inner, neck):
    filling = meniscus_filling(R, 0.0, neck, CONTACT)
    rho, r0 = meniscus_arc(R, 0.0, filling, CONTACT)
    top = R - R * math.cos(filling)
    under_arc = 2 * quad(lambda z: math.pi * (r0 - math.sqrt(max(rho * rho - z * z, 0.0))) ** 2, 0, top)[0]
    caps = 2 * math.pi * top**2 * (R - top / 3)
    return under_arc - caps - volume_of_ring(R, 0.0, inner)


def columns(load, R, inner, outer):
    stiffness = {"tension": lambda r: C33, "torsion": lambda r: SHEAR * r * r, "shear": lambda r: SHEAR, "bending": lambda r: C33 * r * r / 2}[load]
    return quad(lambda r: 2 * math.pi * r * stiffness(r) / gap(R, r), inner, outer)[0]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--levels", type=int, default=3)
    levels = parser.parse_args().levels
    elastic = TransverselyIsotropic(E, E, NU, NU, SHEAR)
    for R, content in ((1.7e-3, 0.003), (1.7e-3, 0.006), (5e-3, 0.01), (5e-3, 0.03)):
        inner = 0.2 * R
        volume = content * 2 * 4 / 3 * math.pi * R**3 * DENSITY / CEMENT
        outer = outer_of_ring(R, inner, volume)
        neck = brentq(lambda a: volume_of_meniscus(R, inner, a) - volume, inner * 1.001, outer)
        for shape, sizes in (("flat", (outer,)), ("meniscus", (neck, CONTACT))):
            ratios = []
            for load in LOADS:
                found = converged(load, shape, (R, 0.0, inner, *sizes), elastic, axis_uniform(0.0, 1.0), levels=levels)[1]
                ratios.append(f"{load} {columns(load, R, inner, outer) / found:.3f}")
            print(f"R {1e3 * R:g} mm, content {content:g}, {shape} {1e3 * inner:.3f} to {1e3 * sizes[0]:.3f} mm: {', '.join(ratios)}", flush=True)


if __name__ == "__main__":
    main()
