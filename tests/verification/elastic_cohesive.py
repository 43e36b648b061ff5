#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Reference for a flat bond between two elastic spheres whose interfaces soften: force over displacement in tension.

Cement and spheres are those of elastic_bond.py.  Cohesive springs of the law of doc/interface_cohesive.md join them, one at each node
of the interface.  Both interfaces soften alike, so half of the bond is solved.  The analysis is sequentially linear (Rots, Engineering
Fracture Mechanics 75 (2008) 590): the load is such that one spring reaches its strength, whose damage is then raised a little.  So the
path is followed where displacement and force go back, too.

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

LEVELS = 60  # of the damage of a spring


def flexibility(R, inner, outer, cement, grain, ns, nt):
    """Flexibility of the upper interface in (r, z) of its nodes, lumped areas, directions of the normal, and the motion of the sphere."""
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
    of_cement = splu(K[free][:, free].tocsc()).solve(unit[free])
    whole = np.zeros_like(unit)
    whole[free] = of_cement
    mass, C, _, _ = of_patch("tension", patch, r)
    of_sphere = np.linalg.solve(mass, np.linalg.solve(mass, C).T)
    area = mass.sum(axis=1)
    motion = np.stack(rigid("tension", r[patch.nodes], z[patch.nodes], 0.5), axis=-1).ravel()
    normal = np.stack([-r[patch.nodes], R - z[patch.nodes]], axis=-1) / R  # out of the sphere, into the cement: minus this
    return whole[surface] + of_sphere, area, normal, motion


def path(R=5e-3, inner=1e-3, outer=2e-3, cement=None, grain=(70e9, 0.22), tn=20e6, Gn=10.6, kn=1.44e17, kt=None, ns=24, nt=8):
    """Rows of displacement, force and largest damage; tn and Gn in both modes."""
    cement = isotropic(60e9, 0.25) if cement is None else cement
    kt = kn / 3 if kt is None else kt
    C, area, normal, motion = flexibility(R, inner, outer, cement, grain, ns, nt)
    n = normal.shape[0]
    along = np.stack([normal[:, 1], -normal[:, 0]], axis=-1)
    area_of = area[1::2]
    nn, tt = (np.einsum("ij,ik->ijk", v, v) / area_of[:, None, None] for v in (normal, along))
    at = np.arange(n)
    onset = tn / kn
    d = np.zeros(n)
    rows = [(0.0, 0.0, 0.0)]
    while True:
        soft = d < 1.0
        left = np.where(soft, 1.0 - d, 1e-9)
        springs = (nn / kn + tt / kt) / left[:, None, None]
        A = C.copy().reshape(n, 2, n, 2)
        A[at, :, at, :] += springs
        f = np.linalg.solve(A.reshape(2 * n, 2 * n), motion).reshape(n, 2)
        total = 2 * motion @ f.ravel()
        t_n, t_t = np.einsum("ij,ij->i", f, normal) / area_of, np.einsum("ij,ij->i", f, along) / area_of
        opening, slip = np.maximum(t_n, 0) / (kn * left), t_t / (kt * left)
        ratio = kt / kn
        size = np.sqrt(opening**2 + ratio * slip**2)
        B = np.where(size > 0, ratio * slip**2 / np.maximum(size, 1e-300) ** 2, 0.0)
        first = 1.0 / (kn * np.sqrt((1 - B) / tn**2 + ratio * B / tn**2))
        end = 2 * Gn / (kn * first)
        now = first * end / (end - d * (end - first))  # opening at which the damage grows
        scale = np.where(soft & (size > 0), now / np.maximum(size, 1e-300), math.inf)
        i = int(np.argmin(scale))
        if not math.isfinite(scale[i]) or total * scale[i] < 0.02 * max(row[1] for row in rows) and len(rows) > 10:
            return np.array(rows)
        rows.append((scale[i], total * scale[i], d.max()))
        # equal steps of the traction that a spring carries at its onset of growth
        carried = now[i] * (1 - d[i]) / onset
        target = carried - 1.0 / LEVELS * (first[i] / onset)
        if target <= 0:
            d[i] = 1.0
        else:
            x = end[i] - target * onset * (end[i] - first[i]) / first[i]
            d[i] = max(d[i], 1 - target * onset / x)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rigid", action="store_true", help="between rigid spheres")
    parser.add_argument("--strength", type=float, default=20e6, help="[Pa], default %(default)g")
    parser.add_argument("--energy", type=float, default=10.6, help="[J/m2], default %(default)g")
    parser.add_argument("--elements", type=int, default=24, help="across the width, default %(default)s")
    args = parser.parse_args()
    rows = path(grain=(math.inf, 0.0) if args.rigid else (70e9, 0.22), tn=args.strength, Gn=args.energy, ns=args.elements, nt=max(3, args.elements // 3))
    peak = int(np.argmax(rows[:, 1]))
    print(f"largest force {rows[peak, 1]:.5g} N at {rows[peak, 0]:.5g} m, largest displacement {rows[:, 0].max():.5g} m; after it at {rows[-1, 0]:.5g} m")
    print("first spring at %.5g N, %.5g m" % (rows[1, 1], rows[1, 0]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
