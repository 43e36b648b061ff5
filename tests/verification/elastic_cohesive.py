#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Reference for a flat bond between two elastic spheres whose interfaces soften: force over displacement in tension.

Cement and spheres are those of elastic_bond.py.  Cohesive springs of the law of doc/interface_cohesive.md join them, one at each node
of the interface, with the area of its shape function.  Both interfaces soften alike, so half of the bond is solved.  The displacement
of the spheres rises in steps; in each of them the damage of the springs is found by iteration of their secants.

    elastic_cohesive.py                 the ring of doc/study_elastic_grains.md, 20 MPa and 10.6 J/m2
    elastic_cohesive.py --rigid         between rigid spheres
"""
import argparse
import math
import sys

import numpy as np
from axisymmetric_fe import TransverselyIsotropic, axis_uniform
from bond_fe import element_matrices, element_nodes, flat_body
from elastic_bond import Patch, of_patch, rigid
from elastic_sphere import isotropic
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu


def flexibility(R, inner, outer, cement, grain, ns, nt):
    """Flexibility of the upper interface in (r, z) of its nodes, their areas, normals of the sphere outwards, motion of the sphere by a unit of both."""
    body = flat_body(R, 0.0, inner, outer, ns, nt, 2.5)
    r, z = body.r.ravel(), body.z.ravel()
    elements = element_nodes(body.r.shape)
    Ke, _, k = element_matrices("tension", body, TransverselyIsotropic(*cement), axis_uniform(0.0, 1.0))
    dofs = (k * elements[:, :, None] + np.arange(k)).reshape(len(elements), -1)
    rows, columns = np.repeat(dofs, dofs.shape[1], axis=1).ravel(), np.tile(dofs, dofs.shape[1]).ravel()
    K = coo_matrix((Ke.ravel(), (rows, columns)), shape=(k * r.size,) * 2).tocsr()
    index = np.arange(body.r.size).reshape(body.r.shape)
    patch = Patch(index[:, -1], R, R, -1, *grain)
    held = k * index[: body.middle + 1, 0] + 1
    surface = (k * patch.nodes[:, None] + np.arange(k)).ravel()
    free = np.setdiff1d(np.arange(k * r.size), held)
    unit = np.zeros((k * r.size, surface.size))
    unit[surface, np.arange(surface.size)] = 1.0
    of_cement = np.zeros_like(unit)
    of_cement[free] = splu(K[free][:, free].tocsc()).solve(unit[free])
    mass, C, _, _ = of_patch("tension", patch, r)
    of_sphere = np.linalg.solve(mass, np.linalg.solve(mass, C).T)
    motion = np.stack(rigid("tension", r[patch.nodes], z[patch.nodes], 0.5), axis=-1).ravel()
    normal = np.stack([-r[patch.nodes], R - z[patch.nodes]], axis=-1) / R
    return of_cement[surface] + of_sphere, mass.sum(axis=1)[1::2], normal, motion


def softening(distances, R=5e-3, inner=1e-3, outer=2e-3, cement=None, grain=(70e9, 0.22), strength=20e6, energy=10.6, kn=7.2e16, ns=12):
    """Force for each of the rising displacements; strength and energy are those of both modes."""
    kt = kn / 3
    C, area, normal, motion = flexibility(R, inner, outer, isotropic(60e9, 0.25) if cement is None else cement, grain, ns, max(3, ns // 3))
    n = len(normal)
    along = np.stack([normal[:, 1], -normal[:, 0]], axis=-1)
    nn, tt = (np.einsum("ij,ik->ijk", v, v) / area[:, None, None] for v in (normal, along))
    at, d, forces = np.arange(n), np.zeros(n), []
    for distance in distances:
        for _ in range(1000):
            left = np.where(d < 1, 1 - d, 1e-9)
            A = C.copy().reshape(n, 2, n, 2)
            A[at, :, at, :] += (nn / kn + tt / kt) / left[:, None, None]
            f = np.linalg.solve(A.reshape(2 * n, 2 * n), motion * distance).reshape(n, 2)
            opening = np.maximum(np.einsum("ij,ij->i", f, normal), 0) / (area * kn * left)
            shear = kt / kn * (np.einsum("ij,ij->i", f, along) / (area * kt * left)) ** 2
            size = np.sqrt(opening**2 + shear)
            share = np.where(size > 0, shear / np.maximum(size, 1e-300) ** 2, 0.0)
            onset = strength / (kn * np.sqrt(1 - share + share * kt / kn))
            end = 2 * energy / (kn * onset)
            grown = np.where(size > onset, end * (size - onset) / (np.maximum(size, 1e-300) * (end - onset)), 0.0)
            grown = np.clip(grown, d, 1.0)
            change, d = abs(grown - d).max(), grown
            if change < 1e-7:
                break
        forces.append(2 * motion @ f.ravel())
    return np.array(forces)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rigid", action="store_true", help="between rigid spheres")
    parser.add_argument("--strength", type=float, default=20e6, help="[Pa], default %(default)g")
    parser.add_argument("--energy", type=float, default=10.6, help="[J/m2], default %(default)g")
    parser.add_argument("--elements", type=int, default=12, help="across the width, default %(default)s")
    parser.add_argument("--end", type=float, default=1.6e-6, help="displacement at the end [m], default %(default)g")
    args = parser.parse_args()
    distances = np.linspace(0, args.end, 81)[1:]
    grain = (math.inf, 0.0) if args.rigid else (70e9, 0.22)
    forces = softening(distances, grain=grain, strength=args.strength, energy=args.energy, ns=args.elements)
    peak = int(np.argmax(forces))
    print(f"largest force {forces[peak]:.5g} N at {distances[peak]:.4g} m, at the end {forces[-1]:.5g} N")
    return 0


if __name__ == "__main__":
    sys.exit(main())
