#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Stiffness of a thin layer of cement between two equal elastic spheres, by an integral equation.

The cement is a ring, or a disc with inner = 0, along the line of centres.  It is so thin that it deforms by itself at each place: the
tension is p = M (delta - 2 w)/t with the P-wave modulus M of the cement, the thickness t(r) between undeformed spheres, the
displacement delta of one sphere from the other and the displacement w of the surface by the tractions.  In shear the two tractions
across the line of centres are G (delta - 2 u)/t with the shear modulus G.  Displacements of the surface are those of elastic_sphere.py:
relative to the mean over the volume of the sphere.  Tractions are along the axis of the load, per area across the line of centres.

This is the model of contact-cement theory (Dvorkin, see doc/bibliography.md), which has half-spaces for spheres; `halfspace` has them
too, and `formula` is the published fit.  Tractions are sums of Legendre polynomials on panels with Gauss points; the equation holds in the
mean over each polynomial, so the stiffness grows to its limit with the degree.  SI units.

    thin_layer.py --self-check
    thin_layer.py --inner 0.2e-3 --outer 0.5e-3 --cement 60e9 0.25 --grain 70e9 0.22
"""
import argparse
import json
import math
import sys
from pathlib import Path

import numpy as np
from elastic_sphere import compliance
from numpy.polynomial import legendre
from scipy.special import j0

HIGHEST_DEGREE = 3000  # of the harmonics of the sphere
DEGREE = 3  # of the polynomials


def shear_modulus(E, nu):
    return E / (2 * (1 + nu))


def p_wave_modulus(E, nu):
    return E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))


def between_spheres(R, gap=0.0):
    """Thickness as a function of r."""
    return lambda r: gap + 2 * r * r / (R + np.sqrt(R * R - r * r))


def panels(inner, outer):
    """Edges, finer by a factor of two towards each rim, or towards the line of centres."""
    at_rim = 0.5 ** np.arange(1, 7)  # of half of the width
    if inner == 0:
        at_rim = np.append(at_rim, 0.5**7)
    low = np.concatenate([[0.0], 0.5 * at_rim[::-1], [0.5]])
    return inner + (outer - inner) * np.unique(np.concatenate([low, 1 - low]))


def basis(edges, degree, waves_per_length):
    """Gauss points, their weights over r, and (polynomials, points) values; waves_per_length: of the fastest field to be integrated."""
    points, weights, blocks = [], [], []
    for low, high in zip(edges, edges[1:]):
        x, w = legendre.leggauss(degree + 8 + int(4 * waves_per_length * (high - low)))
        points.append(0.5 * (low + high) + 0.5 * (high - low) * x)
        weights.append(0.5 * (high - low) * w)
        blocks.append(legendre.legvander(x, degree).T)
    size = sum(b.shape[1] for b in blocks)
    values = np.zeros((len(blocks) * (degree + 1), size))
    row = column = 0
    for b in blocks:
        values[row : row + b.shape[0], column : column + b.shape[1]] = b
        row, column = row + b.shape[0], column + b.shape[1]
    return np.concatenate(points), np.concatenate(weights), values


def solved(layer, surface, force):
    """Stiffness: force of the tractions by delta = 1, from the compliances of the layer and of one surface."""
    return force @ np.linalg.solve(layer + 2 * surface, force)


def stiffness(load, R, inner, outer, cement, grain, gap=0.0, degree=DEGREE, highest=HIGHEST_DEGREE):
    """load: tension or shear; cement, grain: E and nu; E of the grain may be inf."""
    r, weight, shape = basis(panels(inner, outer), degree, highest / (2 * math.pi * math.sqrt(R * R - outer * outer)))
    theta = np.arcsin(r / R)
    s, c, zero = np.sin(theta), np.cos(theta), np.zeros_like(shape)
    over_theta = weight / c  # of R theta
    of_sphere = shape * c  # per area of the sphere
    t = between_spheres(R, gap)(r)
    dA = 2 * math.pi * r * weight
    if load == "tension":
        layer = np.einsum("iq,jq,q->ij", shape, shape, dA * t / p_wave_modulus(*cement))
        fields = np.stack([of_sphere * c, -of_sphere * s, zero], axis=1)
        return solved(layer, compliance(0, theta, over_theta, fields, R, *grain, highest), shape @ dA)
    # (t_r, t_phi) = (U cos phi, V sin phi): U = -V is a traction across along x, U = V varies with the angle
    half = np.einsum("iq,jq,q->ij", shape, shape, dA * t / shear_modulus(*cement))
    layer = np.kron(np.eye(2), half)
    along = np.stack([of_sphere * s, of_sphere * c, -of_sphere], axis=1)
    across = np.stack([of_sphere * s, of_sphere * c, of_sphere], axis=1)
    surface = compliance(1, theta, over_theta, np.concatenate([along, across]), R, *grain, highest)
    return solved(layer, surface, np.concatenate([shape @ dA, np.zeros(len(shape))]))


def halfspace(thickness, inner, outer, cement, grain, degree=DEGREE, waves=100):
    """Stiffness in tension, with half-spaces for spheres; thickness: a function of r; waves: of the shortest one, across the disc."""
    shortest = 2 * math.pi * waves / outer  # wave number
    r, weight, shape = basis(panels(inner, outer), degree, waves / outer)
    dA = 2 * math.pi * r * weight
    layer = np.einsum("iq,jq,q->ij", shape, shape, dA * thickness(r) / p_wave_modulus(*cement))
    E, nu = grain
    surface = np.zeros_like(layer)
    x, w = legendre.leggauss(16)
    steps = np.linspace(0.0, shortest, 2 * waves + 1)
    for low, high in zip(steps, steps[1:]):  # a surface wave of number k under p has the amplitude (1 - nu)/(G k) p
        k = 0.5 * (low + high) + 0.5 * (high - low) * x
        P = (shape * (weight * r)) @ j0(np.outer(r, k))
        surface += (P * (0.5 * (high - low) * w)) @ P.T
    return solved(layer, 2 * math.pi * (1 - nu) / shear_modulus(E, nu) * surface, shape @ dA)


def formula(R, outer, cement, grain):
    """Stiffness in tension by the published fit, for touching half-spaces with cement to the line of centres.

    2 pi R M S is the force by the displacement of one grain from the middle of the contact, which is half of that of the other grain.
    """
    M = p_wave_modulus(*cement)
    L = M * (1 - grain[1]) / (math.pi * shear_modulus(*grain))
    a = outer / R
    S = -0.024153 * L**-1.3646 * a * a + 0.20405 * L**-0.89008 * a + 0.00024649 * L**-1.9864
    return math.pi * R * M * S


def between_rigid(R, inner, outer, modulus):
    """Integral of 2 pi r modulus/t."""
    low, high = (math.sqrt(R * R - r * r) for r in (inner, outer))
    return math.pi * modulus * (high - low + R * math.log((R - high) / (R - low)))


def self_check():
    good = True

    def check(name, error, limit):
        nonlocal good
        good &= bool(abs(error) < limit)
        print(f"{'ok  ' if abs(error) < limit else 'FAIL'} {name}: {error:+.1e}, limit {limit:.0e}", flush=True)

    R, glass = 5e-3, (70e9, 0.22)
    stiff, soft = (60e9, 0.25), (0.6e9, 0.25)
    for load, modulus in (("tension", p_wave_modulus), ("shear", shear_modulus)):
        found = stiffness(load, R, 0.2e-3, 1e-3, stiff, (math.inf, 0.0), highest=100)
        check(f"rigid spheres, {load}: closed form", found / between_rigid(R, 0.2e-3, 1e-3, modulus(*stiff)) - 1, 1e-6)
    for load in ("tension", "shear"):
        for inner, outer, cement in ((0.2e-3, 0.5e-3, stiff), (0.0, 1.6e-3, soft)):
            found = [stiffness(load, R, inner, outer, cement, glass, degree=d) for d in (1, 3, 5)]
            check(f"polynomials of degree 5 for 3, {load}, radii {inner:g} and {outer:g} m", found[2] / found[1] - 1, 1e-3)
            check(f"degree 3 changes less than 1, {found[1] / found[0] - 1:.0e} before", (found[2] - found[1]) / (found[1] - found[0]), 0.5)
        more = stiffness(load, R, 0.2e-3, 0.5e-3, stiff, glass, highest=2 * HIGHEST_DEGREE)
        check(f"twice the harmonics, {load}", more / stiffness(load, R, 0.2e-3, 0.5e-3, stiff, glass) - 1, 2e-4)
    with open(Path(__file__).parent / "elastic_bonds.json", encoding="utf-8") as f:
        reference = json.load(f)["cases"]["small ring"]["stiffness"]
    for load in ("tension", "shear"):
        found = stiffness(load, R, 0.2e-3, 0.5e-3, stiff, glass)
        check(f"finite elements of the small ring, {load}", found / reference[load]["value"] - 1, 0.025)
    a, E, nu = 1e-3, *glass
    punch = 2 * shear_modulus(E, nu) * a / (1 - nu)
    found = halfspace(lambda r: np.full_like(r, 1e-7), 0.0, a, stiff, glass, waves=300)
    check("half-spaces and a layer of almost no thickness: rigid punch", found / punch - 1, 1e-3)
    for outer in (0.5e-3, 1.6e-3):
        found = halfspace(lambda r: r * r / R, 0.0, outer, stiff, glass)
        check(f"published fit for stiff cement, outer radius {outer:g} m", formula(R, outer, stiff, glass) / found - 1, 0.012)
    # a sphere is stiffer than a half-space by a compliance that hardly depends on the patch, as a term of the order 1/(G R) must be
    c = [1 / halfspace(between_spheres(R), 0.0, r, stiff, glass) - 1 / stiffness("tension", R, 0.0, r, stiff, glass) for r in (0.5e-3, 1e-3)]
    check(f"compliance of half-spaces less that of spheres, {c[0]:.2e} and {c[1]:.2e} m/N", c[1] / c[0] - 1, 0.1)
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inner", type=float, default=0.2e-3, help="[m], default %(default)g")
    parser.add_argument("--outer", type=float, default=0.5e-3, help="[m], default %(default)g")
    parser.add_argument("--radius", type=float, default=5e-3, help="[m] of both spheres, default %(default)g")
    parser.add_argument("--gap", type=float, default=0.0, help="[m], default %(default)g")
    parser.add_argument("--cement", type=float, nargs=2, default=(60e9, 0.25), help="E nu")
    parser.add_argument("--grain", type=float, nargs=2, default=(70e9, 0.22), help="E nu of both")
    parser.add_argument("--self-check", action="store_true")
    args = parser.parse_args()
    if args.self_check:
        return 0 if self_check() else 1
    for load in ("tension", "shear"):
        print(f"{load}: {stiffness(load, args.radius, args.inner, args.outer, args.cement, args.grain, args.gap):.6e} N/m")
    if args.gap == 0:
        of_halfspaces = halfspace(lambda r: r * r / args.radius, args.inner, args.outer, args.cement, args.grain)
        print(
            f"tension with half-spaces: {of_halfspaces:.6e} N/m; published fit to the line of centres: {formula(args.radius, args.outer, args.cement, args.grain):.6e} N/m"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
