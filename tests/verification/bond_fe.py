#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Finite-element reference for the stiffness of bonds between two equal rigid spheres.

Shapes: flat (a cylinder between the spheres, or a ring), meniscus (circular-arc neck) and
coating (shell up to a polar angle) as src/USER-MPDEM/geometry defines them, perfectly bonded
to the spheres on all of the wetted area, traction free elsewhere.  Loads: relative motion of
the spheres along the line of centres (tension) or across it (shear), relative turn about it
(torsion) or about an axis across it through the middle of the gap (bending).

Small strain, linear; transversely isotropic with its axis in the meridional plane.  In the
angle theta the displacement is u_r = U cos(n theta), u_theta = V sin(n theta), u_z = W cos(n theta),
n = 0 for tension (U, W) and torsion (V for every theta), n = 1 for shear and bending.  With
n = 1 the unknowns are p = (U - V)/2, q = (U + V)/2 and W: a regular field has q = W = 0 on the
axis.  By mirror (anti)symmetry the half z >= 0 suffices, driven by half the motion.  The spheres
lie on the z axis, the middle of the gap is the origin.  SI units throughout.

    bond_fe.py --self-check
    bond_fe.py meniscus --neck 1e-3 --gap 5e-4
    bond_fe.py --references tests/verification/bond_stiffness.json   # writes those of the tests
"""
import argparse
import json
import math
import sys
from typing import NamedTuple

import numpy as np
from axisymmetric_fe import (
    TransverselyIsotropic,
    axial_stiffness,
    axis_radial,
    axis_uniform,
    converged_stiffness,
    graded_nodes,
    quadratic_shape,
    sphere_profile,
    torsion_stiffness,
    twice_strain_energy,
)

LOADS = ("tension", "torsion", "shear", "bending")


class Body(NamedTuple):
    """Nodes of a logically rectangular Q9 mesh of the half z >= 0; j = -1 lies on the sphere.

    r, z: (2 ns + 1, 2 nt + 1) coordinates; the nodes i <= middle of j = 0 lie in the plane z = 0.
    """

    r: np.ndarray
    z: np.ndarray
    middle: int


def coons(along, bottom, top, left, right):
    """Transfinite interpolation of four sides given as (n, 2) or (m, 2) points; s, t: their parameters."""
    s, t = along
    s, t = s[:, None, None], t[None, :, None]
    corners = (1 - s) * (1 - t) * bottom[0] + s * (1 - t) * bottom[-1] + (1 - s) * t * top[0] + s * t * top[-1]
    return ((1 - t) * bottom[:, None] + t * top[:, None] + (1 - s) * left[None] + s * right[None]) - corners


def on_sphere(R, gap, angle):
    """Point of the upper sphere at this polar angle, seen from its centre, from the contact."""
    return np.stack([R * np.sin(angle), gap / 2 + 2 * R * np.sin(angle / 2) ** 2], axis=-1)


def straight(a, b, t):
    return np.asarray(a) + np.asarray(t)[:, None] * (np.asarray(b) - np.asarray(a))


def flat_body(R, gap, inner, outer, ns, nt, grading):
    radii = graded_nodes(inner, outer, ns, grading, grade_lo=inner > 0)
    tops = sphere_profile(R, gap)(radii)
    eta = graded_nodes(0, 1, nt, grading, grade_lo=False)
    return Body(np.repeat(radii[:, None], eta.size, axis=1), np.outer(tops, eta), 2 * ns)


def meniscus_arc(R, gap, filling, contact):
    """Radius of the arc and r of its centre, which by symmetry lies in the plane z = 0."""
    rho = (R + gap / 2 - R * math.cos(filling)) / math.cos(filling + contact)
    return rho, R * math.sin(filling) + rho * math.sin(filling + contact)


def meniscus_filling(R, gap, neck, contact):
    """Filling angle of a neck of this radius."""
    lo, hi = 0.0, math.pi / 2 - contact
    for _ in range(200):
        mid = 0.5 * (lo + hi)
        rho, r0 = meniscus_arc(R, gap, mid, contact)
        lo, hi = (mid, hi) if r0 - rho < neck else (lo, mid)
    return 0.5 * (lo + hi)


def meniscus_body(R, gap, inner, neck, contact, ns, nt, grading):
    b = meniscus_filling(R, gap, neck, contact)
    rho, r0 = meniscus_arc(R, gap, b, contact)
    s = graded_nodes(0, 1, ns, grading, grade_lo=inner > 0)
    t = graded_nodes(0, 1, nt, grading, grade_lo=False)
    top = on_sphere(R, gap, math.asin(inner / R) + s * (b - math.asin(inner / R)))
    bottom = straight((inner, 0.0), (neck, 0.0), s)
    turn = t * (math.pi / 2 - b - contact)  # along the arc from the neck
    right = np.stack([r0 - rho * np.cos(turn), rho * np.sin(turn)], axis=-1)
    left = straight(bottom[0], top[0], t)
    x = coons((s, t), bottom, top, left, right)
    return Body(x[..., 0], x[..., 1], 2 * ns)


def coating_body(R, gap, inner, thickness, cap, ns, nt, grading):
    """The merged shells up to the ring in which they meet, then the shell up to the angle `cap`."""
    c, S = R + gap / 2, R + thickness
    meet = math.acos(c / S)
    n_bond = ns - ns // 3  # elements along the bond; the rest are along the shell
    t = graded_nodes(0, 1, nt, grading, grade_lo=True)  # the ring is a notch
    s = graded_nodes(0, 1, n_bond, grading, grade_lo=True)
    start = math.asin(inner / R)
    top = on_sphere(R, gap, start + s * (meet - start))
    ring = math.sqrt(S**2 - c**2)
    bottom = straight((inner, 0.0), (ring, 0.0), s)
    x = coons((s, t), bottom, top, straight(bottom[0], top[0], t), straight(bottom[-1], top[-1], t))
    angles = graded_nodes(meet, cap, ns // 3, grading, grade_lo=True)[1:, None]
    radius = S - t * thickness
    shell = np.stack([radius * np.sin(angles), c - radius * np.cos(angles)], axis=-1)
    x = np.concatenate([x, shell])
    return Body(x[..., 0], x[..., 1], 2 * n_bond)


BODIES = {"flat": flat_body, "meniscus": meniscus_body, "coating": coating_body}


def element_nodes(shape):
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    return np.stack([index[i : i + shape[0] - 2 : 2, j : j + shape[1] - 2 : 2].ravel() for i in range(3) for j in range(3)], axis=1)


def strain_rows(load, r, N, N_r, N_z):
    """B of rr, zz, hoop, rz and of r theta, z theta: (elements, rows, 9 nodes x unknowns) each."""
    n = 1 if load in ("shear", "bending") else 0
    cosine, sine = np.zeros((r.size, 4, 9, 3)), np.zeros((r.size, 2, 9, 3))
    Nr = N / r[:, None]
    cosine[:, 0, :, 0] = cosine[:, 3, :, 2] = N_r
    cosine[:, 1, :, 2] = cosine[:, 3, :, 0] = N_z
    cosine[:, 2, :, 0], cosine[:, 2, :, 1] = Nr, n * Nr
    sine[:, 0, :, 0], sine[:, 0, :, 1] = -n * Nr, N_r - Nr
    sine[:, 1, :, 1], sine[:, 1, :, 2] = N_z, -n * Nr
    if n == 1:  # U = q + p, V = q - p
        for B in (cosine, sine):
            U, V = B[..., 0].copy(), B[..., 1].copy()
            B[..., 0], B[..., 1] = U - V, U + V
    use = {"tension": [0, 2], "torsion": [1]}.get(load, [0, 1, 2])
    return tuple(B[..., use].reshape(r.size, B.shape[1], -1) for B in (cosine, sine)), len(use)


def element_matrices(load, body, elastic, axis, density=0.0, other=None):
    """Stiffness and mass of each element, and the number of unknowns of a node.

    other: a second material and a function of r, z that tells where it is, at the points of integration.
    """
    r_all, z_all = body.r.ravel(), body.z.ravel()
    elements = element_nodes(body.r.shape)
    C = elastic.meridional_stiffness()
    Gp = elastic.Ep / (2 * (1 + elastic.nu_p))
    around = math.pi if load in ("shear", "bending") else 2 * math.pi  # integral of cos^2 (n theta)
    rule = list(zip(*np.polynomial.legendre.leggauss(4)))
    Ke, Me, smallest = 0.0, 0.0, math.inf
    for (a, wa), (b, wb) in ((first, second) for first in rule for second in rule):
        (Na, dNa), (Nb, dNb) = quadratic_shape(a), quadratic_shape(b)
        N, N_a, N_b = (np.outer(*f).ravel() for f in ((Na, Nb), (dNa, Nb), (Na, dNb)))
        r_a, r_b, z_a, z_b = (x[elements] @ d for x in (r_all, z_all) for d in (N_a, N_b))
        det = r_a * z_b - r_b * z_a
        smallest = min(smallest, det.min())
        N_r = (np.outer(z_b, N_a) - np.outer(z_a, N_b)) / det[:, None]
        N_z = (np.outer(r_a, N_b) - np.outer(r_b, N_a)) / det[:, None]
        r, z = r_all[elements] @ N, z_all[elements] @ N
        (B, shear), unknowns = strain_rows(load, r, N, N_r, N_z)
        a_r, a_z = axis(r, z)
        zero, one, rz = np.zeros(r.size), np.ones(r.size), a_r * a_z
        to_material = np.array(
            [[a_z**2, a_r**2, zero, -rz], [a_r**2, a_z**2, zero, rz], [zero, zero, one, zero], [2 * rz, -2 * rz, zero, a_z**2 - a_r**2]]
        )
        B = to_material.transpose(2, 0, 1) @ B
        along = np.array([[a_r, a_z], [a_z, -a_r]]).transpose(2, 0, 1) @ shear  # shear along and across the axis
        moduli, shear_moduli = C, np.diag([elastic.Gzp, Gp])
        if other:
            there = other[1](r, z)[:, None, None]
            second = other[0]
            moduli = np.where(there, second.meridional_stiffness(), C)
            shear_moduli = np.where(there, np.diag([second.Gzp, second.Ep / (2 * (1 + second.nu_p))]), shear_moduli)
        K = B.transpose(0, 2, 1) @ (moduli @ B) + along.transpose(0, 2, 1) @ (shear_moduli @ along)
        volume = around * r * det * wa * wb
        Ke = Ke + volume[:, None, None] * K
        if density:
            per_unknown = [2.0, 2.0, 1.0] if unknowns == 3 else [1.0] * unknowns  # U^2 + V^2 = 2 (p^2 + q^2)
            Me = Me + density * volume[:, None, None] * np.kron(np.outer(N, N), np.diag(per_unknown))
    if not smallest > 0:
        raise ValueError("the mesh folds; the shape is too far from a quadrilateral")
    return Ke, Me, unknowns


def stiffness(load, body, elastic, axis, other=None):
    """Force or moment per relative motion of the spheres: N/m for tension and shear, else N m/rad. other: see element_matrices()."""
    r_all, z_all = body.r.ravel(), body.z.ravel()
    elements = element_nodes(body.r.shape)
    Ke, _, unknowns = element_matrices(load, body, elastic, axis, other=other)
    index = np.arange(r_all.size).reshape(body.r.shape)
    grain, plane, centre = index[:, -1], index[: body.middle + 1, 0], np.flatnonzero(r_all == 0)
    r, z = r_all[grain], z_all[grain]
    # unknowns by node: value on the grain, zero in the plane of symmetry, zero on the axis
    on_grain, in_plane, on_axis = {
        "tension": ((0.0, 0.5), (1,), (0,)),
        "torsion": ((r / 2,), (0,), (0,)),
        "shear": ((0.5, 0.0, 0.0), (0, 1), (1, 2)),
        "bending": ((z / 2, 0.0, -r / 2), (2,), (1, 2)),
    }[load]
    prescribed = [(unknowns * plane + k, 0.0) for k in in_plane] + [(unknowns * centre + k, 0.0) for k in on_axis]
    prescribed += [(unknowns * grain + k, value) for k, value in enumerate(on_grain)]
    dofs = (unknowns * elements[:, :, None] + np.arange(unknowns)).reshape(len(elements), -1)
    return 2 * twice_strain_energy(dofs, Ke, prescribed)  # 2: the mirrored lower half


def converged(load, shape, dimensions, elastic, axis, ns=12, nt=4, grading=2.5, levels=5):
    """Richardson limit over meshes, each twice as fine; dimensions: all of the shape's but the mesh."""
    return converged_stiffness(
        lambda ns, nt, grading: stiffness(load, BODIES[shape](*dimensions, ns, nt, grading), elastic, axis), nr=ns, nz=nt, grading=grading, levels=levels
    )


# Dimensions of a case by shape, as create_cement names them; angles in degrees.
WORDS = {"flat": ("outer",), "meniscus": ("neck", "contact"), "coating": ("thickness", "cap")}


def solve_case(case, loads, levels=5):
    """Limit and uncertainty by load of a case: shape, its words, radius, gap, inner, axis (z or radial), elastic."""
    sizes = [math.radians(case[w]) if w in ("contact", "cap") else case[w] for w in WORDS[case["shape"]]]
    axis = axis_uniform(0.0, 1.0) if case["axis"] == "z" else axis_radial(case["radius"], case["gap"])
    dimensions = (case["radius"], case["gap"], case["inner"], *sizes)
    elastic = TransverselyIsotropic(*case["elastic"])
    return {load: converged(load, case["shape"], dimensions, elastic, axis, levels=levels) for load in loads}


def write_references(file):
    """Solves the cases that the file lists, for the loads it lists, and puts the stiffness into it."""
    with open(file) as f:
        table = json.load(f)
    for name, case in table["cases"].items():
        for load, (_, value, uncertainty) in solve_case(case, case["stiffness"]).items():
            case["stiffness"][load] = {"value": float(f"{value:.8g}"), "relative_uncertainty": float(f"{uncertainty / value:.1e}")}
            print(f"{name} {load}: {value:.6e} +- {uncertainty / value:.1e}")
    with open(file, "w") as f:
        f.write(json.dumps(table, indent=2) + "\n")


def self_check():
    vti = TransverselyIsotropic(60e9, 40e9, 0.25, 0.2, 18e9)
    no_poisson = vti._replace(nu_p=0.0, nu_zp=0.0)
    isotropic = TransverselyIsotropic(60e9, 60e9, 0.25, 0.25, 24e9)
    R, along_z, across = 5e-3, axis_uniform(0.0, 1.0), axis_uniform(1.0, 0.0)
    # ends of a cylinder between spheres of this radius are plane to 1e-9 of its length
    huge, length, a = 1e5, 2.5e-3, 5e-4
    cylinder, ring = flat_body(huge, length, 0.0, a, 8, 4, 1.0), flat_body(R, 0.0, 1e-3, 2e-3, 8, 4, 2.5)
    A, I = math.pi * a**2, math.pi / 4 * a**4
    meniscus = meniscus_body(R, 5e-4, 0.0, 1e-3, 0.3, 16, 8, 2.5)
    coating = coating_body(R, 0.0, 8e-4, 4e-4, 0.6, 24, 8, 2.5)
    of_ring = (R, 1e-3, 2e-3, 0.0, vti)
    checks = {
        "cylinder in tension, nu = 0: Ez A / L": (stiffness("tension", cylinder, no_poisson, along_z), vti.Ez * A / length),
        "the same, axis along r: Ep A / L": (stiffness("tension", cylinder, no_poisson, across), vti.Ep * A / length),
        "torsion: Gzp J / L": (stiffness("torsion", cylinder, vti, along_z), 2 * vti.Gzp * I / length),
        "bending, nu = 0: Ez I / L": (stiffness("bending", cylinder, no_poisson, along_z), vti.Ez * I / length),
    }
    for axis, name in ((along_z, "axis along z"), (axis_radial(R, 0.0), "radial axis")):
        for load, solver in (("tension", axial_stiffness), ("torsion", torsion_stiffness)):
            checks[f"ring, {load}, {name}: axisymmetric_fe.py"] = (stiffness(load, ring, vti, axis), solver(*of_ring, axis, 8, 4, 2.5))
    for name, body in (("meniscus", meniscus), ("coating", coating)):
        for load in LOADS:
            checks[f"isotropic {name} in {load} is blind to the axis"] = (
                stiffness(load, body, isotropic, axis_radial(R, 0.0)),
                stiffness(load, body, isotropic, along_z),
            )
    errors = {name: abs(computed / exact - 1) for name, (computed, exact) in checks.items()}
    for name, error in errors.items():
        print(f"{'ok  ' if error < 1e-8 else 'FAIL'} {name}: relative error {error:.1e}")
    slender = flat_body(huge, 20 * a, 0.0, a, 16, 32, 1.0)
    EI, kGA = no_poisson.Ez * I, 6 / 7 * no_poisson.Gzp * A  # Cowper's coefficient without Poisson's effect
    beam = 1 / ((20 * a) ** 3 / (12 * EI) + 20 * a / kGA)
    error = abs(stiffness("shear", slender, no_poisson, along_z) / beam - 1)
    print(f"{'ok  ' if error < 1e-3 else 'FAIL'} shear of a slender cylinder: Timoshenko's beam: relative error {error:.1e}")
    return all(error < 1e-8 for error in errors.values()) and error < 1e-3 and check_volumes(R)


def volume(body):
    """Of the whole body, by the mesh."""
    r_all, z_all, elements = body.r.ravel(), body.z.ravel(), element_nodes(body.r.shape)
    total, rule = 0.0, list(zip(*np.polynomial.legendre.leggauss(4)))
    for (a, wa), (b, wb) in ((first, second) for first in rule for second in rule):
        (Na, dNa), (Nb, dNb) = quadratic_shape(a), quadratic_shape(b)
        N, N_a, N_b = (np.outer(*f).ravel() for f in ((Na, Nb), (dNa, Nb), (Na, dNb)))
        r_a, r_b, z_a, z_b = (x[elements] @ d for x in (r_all, z_all) for d in (N_a, N_b))
        total += np.sum(2 * math.pi * (r_all[elements] @ N) * (r_a * z_b - r_b * z_a)) * wa * wb
    return 2 * total


def check_volumes(R):
    """Meshes against the volumes in closed form of theory and create_cement."""
    gap, neck, t, cap = 5e-4, 1e-3, 4e-4, 0.6
    c, b = R + gap / 2, meniscus_filling(R, gap, neck, 0.0)
    rho = c / math.cos(b) - R
    z, r0 = rho * math.cos(b), (R + rho) * math.sin(b)  # from the middle: the arc's centre is at z = 0
    height = c - R * math.cos(b)
    under_arc = (r0**2 + rho**2) * height - height**3 / 3 - r0 * (height * math.sqrt(rho**2 - height**2) + rho**2 * math.asin(height / rho))
    assert abs(z / height - 1) < 1e-9  # no contact angle: the sphere's normal points to the centre of the arc
    exact = {"meniscus": 2 * math.pi * under_arc - 2 * math.pi / 3 * R**3 * (1 - math.cos(b)) ** 2 * (2 + math.cos(b))}

    def lens(S):
        return math.pi * (2 * S - 2 * R) ** 2 * (4 * R**2 + 8 * R * S) / (24 * R)

    exact["coating"] = 4 * math.pi / 3 * (1 - math.cos(cap)) * ((R + t) ** 3 - R**3) - lens(R + t)
    inner = 1e-6  # of the touching pair: what is inside has a volume of 1e-26
    mesh = {"meniscus": volume(meniscus_body(R, gap, 0.0, neck, 0.0, 32, 16, 2.5)), "coating": volume(coating_body(R, 0.0, inner, t, cap, 48, 16, 2.5))}
    good = True
    for name in exact:
        error = abs(mesh[name] / exact[name] - 1)
        good &= error < 1e-6  # of the sides, which are parabolas
        print(f"{'ok  ' if error < 1e-6 else 'FAIL'} volume of the {name}: relative error {error:.1e}")
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("shape", nargs="?", choices=sorted(BODIES))
    for name, default in (
        ("radius", 5e-3),
        ("gap", 0.0),
        ("inner", 1e-3),
        ("outer", 2e-3),
        ("neck", 2e-3),
        ("contact", 0.0),
        ("thickness", 4e-4),
        ("cap", 35.0),
    ):
        unit = "degrees" if name in ("contact", "cap") else "m"
        parser.add_argument(f"--{name}", type=float, default=default, help=f"[{unit}], default {default:g}")
    parser.add_argument("--vti", type=float, nargs=5, metavar=TransverselyIsotropic._fields, default=(60e9, 40e9, 0.25, 0.2, 18e9))
    parser.add_argument("--axis", choices=("z", "radial"), default="z", help="symmetry axis")
    parser.add_argument("--levels", type=int, default=5, help="meshes, each twice as fine")
    parser.add_argument("--references", metavar="FILE", help="solve the cases of this file and write their stiffness into it")
    parser.add_argument("--self-check", action="store_true")
    args = parser.parse_args()
    if args.self_check:
        return 0 if self_check() else 1
    if args.references:
        return write_references(args.references)
    if not args.shape:
        parser.error("give a shape, --references or --self-check")
    case = {**vars(args), "elastic": args.vti}
    for load, (table, value, uncertainty) in solve_case(case, LOADS, args.levels).items():
        print(f"{load} stiffness [{'N/m' if load in ('tension', 'shear') else 'N m/rad'}]: ns, nt, k, k/k_limit - 1")
        for ns, nt, k in table:
            print(f"{ns:6d} {nt:6d} {k:16.9e} {k / value - 1:12.2e}")
        print(f"k_limit = {value:.8e} +- {uncertainty:.1e} ({uncertainty / value:.1e} relative)\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
