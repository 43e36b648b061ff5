#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Reference for the stiffness of bonds between two elastic spheres.

The cement is solved by the finite elements of bond_fe.py: harmonics 0 and 1 in the angle, small strain, transversely isotropic.
Its surface on a sphere moves as the sphere does there: the rigid mean motion of the sphere plus the displacement by the tractions of
the cement, with the closed-form compliance of elastic_sphere.py.  Both are equal in the mean over each shape function.  The stiffness is
the force on a sphere by its mean motion, while the mean motion of the other sphere is zero.  A sphere with E inf is rigid.

Shapes: meniscus between equal spheres, whose half is solved, and flat (ring or cylinder) between any two spheres.

    elastic_bond.py --self-check
    elastic_bond.py flat --inner 1e-3 --outer 2e-3 --cement 60e9 0.25 --grain 70e9 0.22
    elastic_bond.py --references tests/verification/elastic_bonds.json   # writes those of the tests; takes minutes
"""
import argparse
import json
import math
import sys
from typing import NamedTuple

import numpy as np
from axisymmetric_fe import TransverselyIsotropic, axis_radial, axis_uniform, graded_nodes
from bond_fe import LOADS, Body, element_matrices, element_nodes, flat_body, meniscus_body, stiffness
from elastic_sphere import compliance, isotropic, legendre, spheroidal
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

HIGHEST_DEGREE = 3000  # of the harmonics


class Patch(NamedTuple):
    """Where the cement of a mesh is attached to a sphere with its centre at z; the pole of the patch is towards `pole`."""

    nodes: np.ndarray  # along the meridian
    radius: float
    centre: float
    pole: int  # 1: the sphere is below the cement, -1: above
    E: float
    nu: float
    at_both_poles: bool = False  # the sphere has such a patch at the other pole, too, see elastic_sphere.py


def ring_between(R, gap, inner, outer, ns, nt, grading, edge=None):
    """Flat ring from the surface of the lower sphere, R[0], to that of the upper one; z = 0 is the middle of the gap; edge: a radius with nodes."""
    r = graded_nodes(inner, outer, ns, grading, grade_lo=inner > 0)
    if edge is not None:
        r = np.concatenate([graded_nodes(inner, edge, ns, grading, grade_lo=True)[:-1], graded_nodes(edge, outer, ns, grading, grade_lo=True)])
    r = r[:, None]
    low, high = (gap / 2 + r**2 / (S + np.sqrt(S**2 - r**2)) for S in R)
    eta = graded_nodes(0, 1, nt, grading, grade_lo=True)
    return Body(np.repeat(r, eta.size, axis=1), -low * (1 - eta) + high * eta, 0)


def of_patch(load, patch, r):
    """Mass and compliance matrices of the tractions on a patch, in the unknowns of its nodes; angles of nodes."""
    theta_of_node = np.arcsin(r[patch.nodes] / patch.radius)
    waves = HIGHEST_DEGREE * np.diff(theta_of_node[::2]).max() / (2 * math.pi)  # in the longest element
    x, w = np.polynomial.legendre.leggauss(8 + int(4 * waves))
    N = np.array([x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2])
    n, count = patch.nodes.size, patch.nodes.size // 2
    theta, weight, shape = np.empty(count * x.size), np.empty(count * x.size), np.zeros((n, count * x.size))
    for i in range(count):
        at = slice(i * x.size, (i + 1) * x.size)
        ends = theta_of_node[[2 * i, 2 * i + 1, 2 * i + 2]]
        theta[at] = ends @ N
        slope = ends @ np.array([x - 0.5, -2 * x, x + 0.5])
        weight[at] = patch.radius * slope * w
        shape[2 * i : 2 * i + 3, at] = N
    m = 1 if load in ("shear", "bending") else 0
    zero, c, s = np.zeros_like(shape), np.cos(theta), np.sin(theta)
    U, V = np.stack([shape * s, shape * c, zero], axis=1), np.stack([zero, zero, shape], axis=1)
    W = np.stack([shape * c * patch.pole, -shape * s * patch.pole, zero], axis=1)
    unknowns = {"tension": [U, W], "torsion": [V]}.get(load, [U - V, U + V, W])
    fields = np.stack(unknowns, axis=1).reshape(-1, 3, theta.size)
    around = math.pi if m else 2 * math.pi
    mass = np.einsum("icq,jcq,q->ij", fields, fields, around * weight * patch.radius * s)
    C = compliance(m, theta, weight, fields, patch.radius, patch.E, patch.nu, HIGHEST_DEGREE, patch.at_both_poles)
    return mass, C, theta_of_node, (theta, weight, shape)


def rigid(load, r, z, unit=1.0):
    """Motion of the nodes of a patch by that of its grain, in the unknowns."""
    one, zero = np.full_like(r, unit), np.zeros_like(r)
    return {"tension": [zero, one], "torsion": [unit * r], "shear": [one, zero, zero], "bending": [unit * z, zero, -unit * r]}[load]


class Solution(NamedTuple):
    stiffness: float
    rims: np.ndarray  # mean normal traction by a unit load over the outermost fifth at the inner and the outer rim of the last patch
    traction: tuple  # of the last patch by a unit load: angles, weights for the integral over R theta, values along (r, z) or in the unknowns


def solve(load, body, patches, elastic, axis, mirrored):
    """mirrored: the body is the half z >= 0, with one patch."""
    r, z = body.r.ravel(), body.z.ravel()
    elements = element_nodes(body.r.shape)
    Ke, _, k = element_matrices(load, body, elastic, axis)
    dofs = (k * elements[:, :, None] + np.arange(k)).reshape(len(elements), -1)
    size = k * r.size
    K = coo_matrix((Ke.ravel(), (np.repeat(dofs, dofs.shape[1], axis=1).ravel(), np.tile(dofs, dofs.shape[1]).ravel())), shape=(size, size)).tocsr()
    on_axis = {"tension": (0,), "torsion": (0,)}.get(load, (1, 2))
    held = [k * np.flatnonzero(r == 0) + j for j in on_axis]
    if mirrored:
        plane = np.arange(r.size).reshape(body.r.shape)[: body.middle + 1, 0]
        held += [k * plane + j for j in {"tension": (1,), "torsion": (0,), "shear": (0, 1), "bending": (2,)}[load]]
    held = np.unique(np.concatenate(held))
    of_patches = [(k * p.nodes[:, None] + np.arange(k)).ravel() for p in patches]
    kept = [~np.isin(d, held) for d in of_patches]
    surface = np.concatenate([d[keep] for d, keep in zip(of_patches, kept)])
    inside = np.setdiff1d(np.arange(size), np.concatenate([held, surface]))
    factors = splu(K[inside][:, inside].tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    coupling = K[inside][:, surface].toarray()
    S = K[surface][:, surface].toarray() - coupling.T @ factors.solve(coupling)
    F, motion, masses = np.zeros_like(S), np.zeros(surface.size), []
    start = 0
    for i, (p, keep) in enumerate(zip(patches, kept)):
        mass, C, theta, quadrature = of_patch(load, p, r)
        mass, C = mass[np.ix_(keep, keep)], C[np.ix_(keep, keep)]
        of = slice(start, start + mass.shape[0])
        F[of, of] = np.linalg.solve(mass, np.linalg.solve(mass, C).T)
        moves = 0.5 if mirrored else float(i == len(patches) - 1)
        motion[of] = np.stack(rigid(load, r[p.nodes], z[p.nodes], moves), axis=-1).ravel()[keep]
        masses.append((mass, of, keep, quadrature))
        start += mass.shape[0]
    force = S @ np.linalg.solve(np.eye(start) + F @ S, motion)
    total = motion @ force * (2 if mirrored else 1)
    mass, of, keep, quadrature = masses[-1]
    of_nodes = np.zeros(keep.size)
    of_nodes[keep] = np.linalg.solve(mass, force[of]) / total
    traction = quadrature[0], quadrature[1], of_nodes.reshape(-1, k).T @ quadrature[2]
    return Solution(total, rim_tractions(load, patches[-1], r, k, traction), traction)


def rim_tractions(load, patch, r, k, traction):
    """Mean normal traction on the cement over the outermost fifth of its width at the inner and the outer rim, at phi = 0."""
    if load == "torsion":
        return np.full(2, math.nan)
    theta, weight, t = traction
    t_r = t[0] if k == 2 else t[0] + t[1]
    normal = -t_r * np.sin(theta) - patch.pole * t[-1] * np.cos(theta)
    x, ends = patch.radius * np.sin(theta), r[patch.nodes[[0, -1]]]
    share = [weight * x * np.clip(1 - abs(x - e) / (0.2 * (ends[1] - ends[0])), 0, 1) for e in ends]
    return np.array([normal @ f / f.sum() for f in share])


def between_bonds(case, angle, highest=400, ns=16, nt=6):
    """Stiffness in tension of each of two equal bonds on a sphere, at an angle, that are pulled alike.

    The tractions are those of a single bond.  Their work on the displacement by each other follows from the closed form of the
    sphere.  What they change of each other is left out, a term of the second order.
    """
    alone = solve_case(case, "tension", ns, nt)
    theta, weight, (t_r, t_z) = alone.traction
    R, (E, nu) = case["radius"][1], case["grain"][1]
    mu, s, c = E / (2 * (1 + nu)), np.sin(theta), np.cos(theta)
    # on the sphere, with its pole towards the other one; the patch of the solution has its pole at -z
    normal, south = -(t_r * s - t_z * c), -(t_r * c + t_z * s)
    around = 2 * math.pi * weight * s / R
    phi = 2 * math.pi * (np.arange(64) + 0.5) / 64
    at = np.stack([np.outer(s, np.cos(phi)), np.outer(s, np.sin(phi)), np.outer(c, np.ones(64))])
    e_south = np.stack([np.outer(c, np.cos(phi)), np.outer(c, np.sin(phi)), np.outer(-s, np.ones(64))])
    pole = np.array([math.sin(angle), 0.0, math.cos(angle)])
    cosine = np.tensordot(pole, at, 1)
    other = np.arccos(cosine)  # angle from the pole of the other patch
    e_other = (cosine * at - pole[:, None, None]) / np.sin(other)
    u_n, u_s = np.zeros_like(other), np.zeros_like(other)
    for (l, P, dP), (_, Q, dQ) in zip(legendre(0, theta, highest), legendre(0, other, highest)):
        t = np.array([around @ (normal * P), around @ (south * dP) / (l * (l + 1)) if l else 0.0])
        u = R / mu * spheroidal(l, nu) @ t
        u_n += u[0] * Q
        u_s += u[1] * dQ
    by_normal = u_n * normal[:, None]
    by_south = u_s * np.einsum("kij,kij->ij", e_other, e_south) * south[:, None]
    compliance = R**2 * around / (2 * math.pi) @ (by_normal + by_south) @ np.full(64, 2 * math.pi / 64)
    return alone.stiffness / (1 + alone.stiffness * compliance)


def solve_case(case, load, ns, nt, grading=2.5):
    """case: shape, radius of both spheres, gap, inner, outer or neck and contact, axis (z or radial), elastic, grain: E, nu of both.

    attached_from: a flat ring is attached to the second sphere from this radius on.
    chain: the second sphere is the middle one of three that are pulled apart, or twisted; the stiffness is that of one of the two bonds.
    """
    R, gap, inner = case["radius"], case["gap"], case["inner"]
    elastic = TransverselyIsotropic(*case["elastic"])
    edge = case.get("attached_from")
    chain = case.get("chain", False)
    mirrored = not chain and edge is None and R[0] == R[1] and tuple(case["grain"][0]) == tuple(case["grain"][1])
    if not mirrored and (case["shape"] != "flat" or case["axis"] != "z"):
        raise ValueError("the meniscus and the radial axis are for equal spheres")
    axis = axis_radial(R[0], gap) if case["axis"] == "radial" else axis_uniform(0.0, 1.0)
    if case["shape"] == "meniscus":
        body = meniscus_body(R[0], gap, inner, case["neck"], math.radians(case["contact"]), ns, nt, grading)
    elif mirrored:
        body = flat_body(R[0], gap, inner, case["outer"], ns, nt, grading)
    else:
        body = ring_between(R, gap, inner, case["outer"], ns, 2 * nt, grading, edge)
    index = np.arange(body.r.size).reshape(body.r.shape)
    attached = slice(0 if edge is None else 2 * ns, None)
    above = Patch(index[attached, -1], R[1], gap / 2 + R[1], -1, *case["grain"][1], chain)
    patches = [above] if mirrored else [Patch(index[:, 0], R[0], -gap / 2 - R[0], 1, *case["grain"][0]), above]
    return solve(load, body, patches, elastic, axis, mirrored)


def converged(case, load, levels=3, ns=8, nt=3):
    """Stiffness, its change from the mesh before, and tractions at the rims, by the finest mesh."""
    found = [solve_case(case, load, ns << i, nt << i) for i in range(levels)]
    return found[-1].stiffness, abs(found[-1].stiffness / found[-2].stiffness - 1), found[-1].rims


def write_references(file, resume):
    with open(file) as f:
        table = json.load(f)
    for name, case in {**table["cases"], **table["chains"]}.items():
        for load in LOADS[:2] if case.get("chain") else LOADS:
            if load in case["stiffness"] and resume:
                continue
            value, change, rims = converged(case, load)
            rigid, _, _ = converged({**case, "grain": [[math.inf, 0.0]] * 2}, load)
            case["stiffness"][load] = {"rigid": float(f"{rigid:.6g}"), "value": float(f"{value:.6g}"), "relative_change": float(f"{change:.1e}")}
            if load == "tension":
                case["rims"] = [float(f"{t:.6g}") for t in rims]
            print(f"{name} {load}: {value:.6e}, {change:.1e}", flush=True)
        with open(file, "w") as f:
            f.write(json.dumps(table, indent=2) + "\n")


def self_check():
    good = True

    def check(name, error, limit):
        nonlocal good
        good &= bool(error < limit)
        print(f"{'ok  ' if error < limit else 'FAIL'} {name}: {error:.1e}, limit {limit:.0e}", flush=True)

    cement = isotropic(60e9, 0.25)
    ring = {"shape": "flat", "radius": [5e-3, 5e-3], "gap": 0.0, "inner": 1e-3, "outer": 2e-3, "axis": "z"}
    ring.update(elastic=cement, grain=[[70e9, 0.22]] * 2)
    for load, given in zip(LOADS, (1.8387e8, 284.63, 8.945e7, 281.43)):
        found = solve_case(ring, load, 16, 6)
        check(f"ring, {load}: {found.stiffness:.5e}, an independent solution", abs(found.stiffness / given - 1), 5e-4)
    rigid_body = flat_body(5e-3, 0.0, 1e-3, 2e-3, 8, 3, 2.5)
    for load in LOADS:
        found = solve_case({**ring, "grain": [[math.inf, 0.0]] * 2}, load, 8, 3).stiffness
        check(f"rigid, {load}: bond_fe.py", abs(found / stiffness(load, rigid_body, cement, axis_uniform(0.0, 1.0)) - 1), 1e-7)
        whole = solve_case({**ring, "grain": [[70e9, 0.22], [70e9 * (1 + 1e-12), 0.22]]}, load, 12, 4).stiffness
        check(f"whole and half, {load}", abs(whole / solve_case(ring, load, 12, 4).stiffness - 1), 1e-5)
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("shape", nargs="?", choices=("flat", "meniscus"))
    for name, default in (("--gap", 0.0), ("--inner", 1e-3), ("--outer", 2e-3), ("--neck", 2e-3)):
        parser.add_argument(name, type=float, default=default, help=f"[m], default {default:g}")
    parser.add_argument("--contact", type=float, default=0.0, help="[degrees]")
    parser.add_argument("--radius", type=float, nargs=2, default=(5e-3, 5e-3), help="[m] of both spheres")
    parser.add_argument("--cement", type=float, nargs="+", default=(60e9, 0.25), help="E nu, or the five constants of fix mpm")
    parser.add_argument("--grain", type=float, nargs="+", default=(70e9, 0.22), help="E nu of both, or of each")
    parser.add_argument("--axis", choices=("z", "radial"), default="z", help="symmetry axis")
    parser.add_argument("--levels", type=int, default=3, help="meshes, each twice as fine")
    parser.add_argument("--references", metavar="FILE", help="solve the cases of this file and write their stiffness into it")
    parser.add_argument("--resume", action="store_true", help="keep the values that the file has")
    parser.add_argument("--self-check", action="store_true")
    args = parser.parse_args()
    if args.self_check:
        return 0 if self_check() else 1
    if args.references:
        return write_references(args.references, args.resume)
    if not args.shape:
        parser.error("give a shape, --references or --self-check")
    case = {**vars(args), "elastic": isotropic(*args.cement) if len(args.cement) == 2 else args.cement}
    case["grain"] = [list(args.grain[:2]), list(args.grain[-2:])]
    for load in LOADS:
        value, change, rims = converged(case, load, args.levels)
        unit = "N/m" if load in ("tension", "shear") else "N m/rad"
        print(f"{load}: {value:.6e} {unit}, changed by {change:.1e}; normal traction at the rims by a unit load: {rims}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
