#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Displacement of the surface of an elastic sphere under tractions on it, in vector spherical harmonics.

The load is balanced by the body force of free acceleration, and the displacement is relative to the mean motion of the sphere:
the mean displacement and the mean rotation over the volume are zero (inertia relief).  With Y a spherical harmonic of degree l
that is orthonormal on the unit sphere, traction and displacement are sums of

  t = t_r Y n + t_s grad Y + t_t n x grad Y,   u = u_r Y n + u_s grad Y + u_t n x grad Y,   grad: on the unit sphere.

The pole of the harmonics is the contact.  Fields go as cos(m phi) or sin(m phi), m = 0 or 1.  The formulas follow from the regular solutions of the sphere (Love 1927, see doc/bibliography.md), and are
checked below.  SI units.

    elastic_sphere.py --self-check
"""
import argparse
import math
import sys

import numpy as np
from axisymmetric_fe import TransverselyIsotropic, axis_uniform, graded_nodes
from bond_fe import Body, element_matrices, element_nodes
from scipy.sparse import bmat, coo_matrix, csr_matrix
from scipy.sparse.linalg import splu


def isotropic(E, nu):
    return TransverselyIsotropic(E, E, nu, nu, E / (2 * (1 + nu)))


def spheroidal(degree, nu):
    """Matrix from (t_r, t_s) to (u_r, u_s), over R/mu; degree: an integer of 0 or more."""
    l = float(degree)
    if degree == 0:
        return np.array([[(1 - 2 * nu) / (2 * (1 + nu)), 0.0], [0.0, 0.0]])
    if degree == 1:  # the body force is -3 (t_r + 2 t_s)/R times grad (r Y)
        N, t_s = np.array([1.0, 2.0]), np.array([0.0, 1.0])
        c, U = (t_s - N * (1 - 2 * nu) / (6 - 4 * nu)) / (4 * (1 + nu)), N * (1 - 2 * nu) / (2 * (3 - 2 * nu))
        return np.array([c * (8 * nu - 4) + 4 * U / 5, c * (4 - 4 * nu) - U / 5])
    f = 1 / (2 * (l - 1) * (l * l + l + 1 + nu * (2 * l + 1)))
    cross = (1 - 2 * nu) * l - 2 + nu
    return f * np.array([[2 * (1 - nu) * l * l + nu * l + 2 * nu - 1, -l * (l + 1) * cross], [-cross, 2 * (1 - nu) * l * l - (1 - 3 * nu) * l + 1 + nu]])


def toroidal(degree):
    """u_t over t_t R/mu, for a degree of 1 or more."""
    return 1 / 7 if degree == 1 else 1 / (degree - 1)


def legendre(m, theta, highest):
    """Yields l, P and dP/dtheta for l from m on: P cos(m phi) is orthonormal on the unit sphere; m: 0 or 1."""
    x, s = np.cos(theta), np.sin(theta)
    P = s * math.sqrt(3 / (4 * math.pi)) if m else np.full_like(theta, math.sqrt(1 / (4 * math.pi)))
    before = np.zeros_like(theta)
    for l in range(m, highest + 1):
        if l > m:
            a = math.sqrt((4 * l * l - 1) / (l * l - m * m))
            b = math.sqrt(((l - 1) ** 2 - m * m) / (4 * (l - 1) ** 2 - 1)) if l > 1 else 0.0
            P, before = a * (x * P - b * before), P
        yield l, P, (l * x * P - math.sqrt((2 * l + 1) / (2 * l - 1) * (l * l - m * m)) * before) / s if l else np.zeros_like(theta)


def compliance(m, theta, weight, fields, R, E, nu, highest, at_both_poles=False):
    """Matrix of the work of each traction field on the displacement by each other one.

    at_both_poles: the same tractions act at the other pole, as in a chain in tension or torsion (m = 0); degrees of one parity cancel.

    fields: (fields, 3, points): t_n along the outward normal, t_theta from the pole on, both times cos(m phi), and t_phi times
    sin(m phi), or 1 for m = 0; weight: of the points for the integral over R theta, without the circumference.
    """
    if math.isinf(E):
        return np.zeros((len(fields), len(fields)))
    around = math.pi if m else 2 * math.pi
    s = np.sin(theta)
    w = around * weight * s / R
    mu = E / (2 * (1 + nu))
    C = np.zeros((len(fields), len(fields)))
    pending = []
    normal, meridian, across = (csr_matrix(fields[:, k]) for k in range(3))  # a shape function is zero at most points
    for l, P, dP in legendre(m, theta, highest):
        if at_both_poles and l % 2 and l < highest:
            continue
        radial = normal @ (w * P)
        A = spheroidal(l, nu)
        if l == 0:
            pending.append((A[0, 0], radial, radial))
            continue
        degree = l * (l + 1)
        gradient = (meridian @ (w * dP) - m * across @ (w * P / s)) / degree
        curl = (across @ (w * dP) - m * meridian @ (w * P / s)) / degree
        pending += [(1.0, radial, A[0, 0] * radial + A[0, 1] * gradient), (degree, gradient, A[1, 0] * radial + A[1, 1] * gradient)]
        pending.append((degree * toroidal(l), curl, curl))
        if len(pending) > 600 or l == highest:
            k, t, u = (np.array(x) for x in zip(*pending))
            C += (k[:, None] * t).T @ u
            pending = []
    return R**3 / mu * (1.0 if at_both_poles else 0.5) * (C + C.T)


def rigid_fields(load, r, z):
    """Rigid motions in this harmonic: (motions, unknowns, nodes), in the unknowns of bond_fe.py."""
    one, zero = np.ones_like(r), np.zeros_like(r)
    if load == "tension":
        return [[zero, one]]
    if load == "torsion":
        return [[r]]
    return [[one, zero, zero], [z, zero, -r]]  # p = (U - V)/2 with U = -V


def work_by_fe(load, R, E, nu, traction, n):
    """Work of a traction t(theta) = (t_n, t_theta, t_phi) on its displacement, by finite elements; traction: smooth."""
    angle, radius = graded_nodes(0, math.pi, 2 * n, 1.0, False)[::-1], graded_nodes(0, R, n, 1.0, False)  # the contact is at z = -R
    body = Body(np.outer(np.sin(angle), radius), -np.outer(np.cos(angle), radius), 0)
    body.r[[0, -1]] = 0.0
    Ke, Me, unknowns = element_matrices(load, body, isotropic(E, nu), axis_uniform(0.0, 1.0), density=1.0)
    shape = body.r.shape
    number = np.arange(body.r.size).reshape(shape)
    number[:, 0] = number[0, 0]  # the centre is one node
    nodes = number.ravel()[element_nodes(shape)]
    dofs = (unknowns * nodes[:, :, None] + np.arange(unknowns)).reshape(len(nodes), -1)
    size = unknowns * body.r.size
    rows, columns = np.repeat(dofs, dofs.shape[1], axis=1).ravel(), np.tile(dofs, dofs.shape[1]).ravel()
    K, M = (coo_matrix((X.ravel(), (rows, columns)), shape=(size, size)).tocsr() for X in (Ke, Me))
    force = np.zeros(size)
    around = math.pi if unknowns == 3 else 2 * math.pi
    surface = number[:, -1]
    x, w = np.polynomial.legendre.leggauss(6)
    for i in range(0, shape[0] - 2, 2):
        ends = angle[[i, i + 2]]
        theta = 0.5 * (ends[0] + ends[1]) + 0.5 * (ends[1] - ends[0]) * x
        N = np.array([x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2])
        t_n, t_theta, t_phi = traction(theta)
        t_r, t_z = t_n * np.sin(theta) + t_theta * np.cos(theta), -t_n * np.cos(theta) + t_theta * np.sin(theta)
        dA = around * R * np.sin(theta) * R * abs(ends[1] - ends[0]) / 2 * w
        per_unknown = {1: [t_phi], 2: [t_r, t_z], 3: [t_r - t_phi, t_r + t_phi, t_z]}[unknowns]
        for k, t in enumerate(per_unknown):
            np.add.at(force, unknowns * surface[i : i + 3] + k, N @ (dA * t))
    on_axis = {"tension": (0,), "torsion": (0,)}.get(load, (1, 2))
    centre = np.unique(number.ravel()[np.flatnonzero(body.r.ravel() == 0)])
    held = np.concatenate([unknowns * centre + k for k in on_axis])
    free = np.setdiff1d(np.unique(dofs), held)
    modes = np.array([np.stack(u, axis=-1).ravel() for u in rigid_fields(load, body.r.ravel(), body.z.ravel())]).T
    MR = (M @ modes)[free]
    A = bmat([[K[free][:, free] / E, MR], [MR.T, None]]).tocsc()
    u = splu(A).solve(np.concatenate([force[free], np.zeros(MR.shape[1])]))[: free.size] / E
    return force[free] @ u


def solutions_inside(l, nu, R=1.0, mu=1.0):
    """Columns (u_r, u_s, t_r, t_s) at the surface of both regular solutions without body force, from the definitions.

    With h = r^l Y these are grad h, and r^2 grad h + a x h with the a that makes it an equilibrium.
    """
    lam = 2 * mu * nu / (1 - 2 * nu)
    a = -2 * (l * lam + (3 * l + 1) * mu) / ((l + 3) * lam + (l + 5) * mu)
    columns = []
    # u = U(r) Y n + V(r) grad Y, both powers of r
    for U, V, power in ((l, 1.0, l - 1), (l + a, 1.0, l + 1)):
        dU, dV = power * U / R, power * V / R
        divergence = dU + 2 * U / R - l * (l + 1) * V / R
        columns.append([U, V, lam * divergence + 2 * mu * dU, mu * (dV - V / R + U / R)])
    return np.array(columns).T


def self_check():
    good = True

    def check(name, error, limit):
        nonlocal good
        good &= bool(error < limit)
        print(f"{'ok  ' if error < limit else 'FAIL'} {name}: {error:.1e}, limit {limit:.0e}")

    worst = 0.0
    for nu in (0.0, 0.22, 0.49):
        for l in (2, 3, 7, 40, 400):
            s = solutions_inside(l, nu)
            found = s[:2] @ np.linalg.inv(s[2:])
            worst = max(worst, abs(found - spheroidal(l, nu)).max() / abs(found).max())
    check("closed form and 2 by 2 systems, l from 2 to 400", worst, 1e-10)
    for nu in (0.0, 0.22, 0.45):
        A = spheroidal(1, nu)
        check(f"degree 1 is symmetric, nu {nu}", abs(2 * A[1, 0] - A[0, 1]), 1e-14)
    R, E, nu = 5e-3, 70e9, 0.22
    for load, m, traction in (
        ("tension", 0, lambda t: (np.exp(3 * np.cos(t) - 3), 0.7 * np.sin(t) * np.exp(2 * np.cos(t) - 2), 0 * t)),
        ("torsion", 0, lambda t: (0 * t, 0 * t, np.sin(t) * np.exp(3 * np.cos(t) - 3))),
        ("shear", 1, lambda t: (np.sin(t) * np.exp(2 * np.cos(t) - 2), np.cos(t) * np.exp(3 * np.cos(t) - 3), -np.exp(3 * np.cos(t) - 3))),
        ("shear", 1, lambda t: (np.sin(t), np.cos(t), 0.2 * np.sin(t) ** 2 - 1)),
    ):
        x, w = np.polynomial.legendre.leggauss(400)
        theta = math.pi / 2 * (1 + x)
        closed = compliance(m, theta, math.pi / 2 * R * w, np.array([traction(theta)]), R, E, nu, 60)[0, 0]
        errors = [abs(work_by_fe(load, R, E, nu, traction, n) / closed - 1) for n in (6, 12)]
        check(f"{load}, m = {m}: finite elements, 16 times as near on half the mesh ({errors[0] / errors[1]:.1f})", errors[1], 1e-5)
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--self-check", action="store_true", required=True)
    parser.parse_args()
    return 0 if self_check() else 1


if __name__ == "__main__":
    sys.exit(main())
