#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Axisymmetric finite-element reference for a cement ring between two rigid spheres.

The spheres of radius R sit on the z axis, `gap` apart; transversely isotropic
cement fills r_in <= r <= r_out between them, perfectly bonded to both and traction
free on its cylindrical faces.  Small strain, linear.  SI units throughout.
By mirror (anti)symmetry 0 <= z <= height(r) suffices, driven by half the motion.
"""
import argparse
import json
import math
import sys
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu


class TransverselyIsotropic(NamedTuple):
    """nu_zp is -eps_p/eps_z under uniaxial stress along the symmetry axis z."""

    Ep: float
    Ez: float
    nu_p: float
    nu_zp: float
    Gzp: float

    def meridional_stiffness(self):
        """In the order: transverse, along the axis, hoop, engineering shear."""
        p, zp = -self.nu_p / self.Ep, -self.nu_zp / self.Ez
        compliance = np.array([[1 / self.Ep, zp, p, 0], [zp, 1 / self.Ez, zp, 0], [p, zp, 1 / self.Ep, 0], [0, 0, 0, 1 / self.Gzp]])
        if np.linalg.eigvalsh(compliance).min() <= 0:
            raise ValueError(f"elastic constants are not positive definite: {self}")
        return np.linalg.inv(compliance)


def sphere_profile(R, gap):
    # Avoids the cancellation in R + gap/2 - sqrt(R^2 - r^2) close to the contact.
    return lambda r: gap / 2 + r**2 / (R + np.sqrt(R**2 - r**2))


def axis_uniform(a_r, a_z):
    return lambda r, z: (np.full_like(r, a_r), np.full_like(z, a_z))


def axis_radial(R, gap):
    """Direction from the upper grain, which is the nearest one for all z > 0."""

    def direction(r, z):
        dz = z - (R + gap / 2)
        return r / np.hypot(r, dz), dz / np.hypot(r, dz)

    return direction


def graded_nodes(lo, hi, n, grading, grade_lo):
    """Power-law element edges clustered towards hi (and lo), and their midpoints.

    Midpoints are placed after grading: sent through the power law they would leave
    the middle half of their element and fold its Jacobian.
    """
    t = np.linspace(0, 1, n + 1)
    edges = 1 - (1 - t) ** grading
    if grade_lo:
        edges = np.where(t < 0.5, 0.5 * (2 * t) ** grading, 1 - 0.5 * (2 - 2 * t) ** grading)
    nodes = np.empty(2 * n + 1)
    nodes[::2] = lo + (hi - lo) * edges
    nodes[1::2] = 0.5 * (nodes[:-1:2] + nodes[2::2])
    return nodes


def quadratic_shape(x):
    return (np.array([x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2]), np.array([x - 0.5, -2 * x, x + 0.5]))


class Mesh:
    """Structured Q9 mesh, graded to where the bonded and the free surfaces meet."""

    def __init__(self, r_in, r_out, height, nr, nz, grading):
        radii = graded_nodes(r_in, r_out, nr, grading, grade_lo=r_in > 0)
        eta = graded_nodes(0, 1, nz, grading, grade_lo=False)
        tops = height(radii)
        if not (0 <= r_in < r_out and np.all(tops > 0)):  # also catches the NaN of r_out > R
            raise ValueError("need 0 <= r_in < r_out and a positive cement height throughout")
        self.r, self.z = np.repeat(radii, eta.size), np.outer(tops, eta).ravel()
        index = np.arange(self.r.size).reshape(radii.size, eta.size)
        self.midplane, self.top, self.inner, self.outer = *index.T[[0, -1]], *index[[0, -1]]
        self.elements = np.stack([index[i : i + 2 * nr : 2, j : j + 2 * nz : 2].ravel() for i in range(3) for j in range(3)], axis=1)

    def gauss_points(self):
        """Yield r, z, volume weight, N, dN/dr, dN/dz of all elements, point by point."""
        r_nodes, z_nodes = self.r[self.elements], self.z[self.elements]
        rule = list(zip(*np.polynomial.legendre.leggauss(4)))
        for (a, wa), (b, wb) in ((first, second) for first in rule for second in rule):
            (Na, dNa), (Nb, dNb) = quadratic_shape(a), quadratic_shape(b)
            N, N_a, N_b = (np.outer(*f).ravel() for f in ((Na, Nb), (dNa, Nb), (Na, dNb)))
            r_a, r_b, z_a, z_b = r_nodes @ N_a, r_nodes @ N_b, z_nodes @ N_a, z_nodes @ N_b
            det = r_a * z_b - r_b * z_a
            N_r = (np.outer(z_b, N_a) - np.outer(z_a, N_b)) / det[:, None]
            N_z = (np.outer(r_a, N_b) - np.outer(r_b, N_a)) / det[:, None]
            r = r_nodes @ N
            yield r, z_nodes @ N, 2 * math.pi * r * det * wa * wb, N, N_r, N_z


def twice_strain_energy(dofs, element_matrices, prescribed):
    """Equilibrium value of u.K.u under (dof array, value) pairs."""
    size = dofs.shape[1]
    rows, columns = np.repeat(dofs, size, axis=1).ravel(), np.tile(dofs, size).ravel()
    K, u = coo_matrix((element_matrices.ravel(), (rows, columns))).tocsr(), np.zeros(dofs.max() + 1)
    for fixed, value in prescribed:
        u[fixed] = value
    free = np.setdiff1d(np.arange(u.size), np.concatenate([fixed for fixed, _ in prescribed]))
    # A positive definite matrix needs no pivoting, and going without limits the fill.
    factors = splu(K[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    u[free] = factors.solve(-(K @ u)[free])
    return u @ (K @ u)


def axial_stiffness(R, r_in, r_out, gap, elastic, axis, nr, nz, grading, height=None, confined_faces=False, frictionless=False):
    """Axial force per relative axial displacement of the grains.

    axis(r, z) gives the (r, z) components of the symmetry axis for z >= 0.
    height(r) replaces the sphere; it and the flags give cases with closed forms.
    """
    mesh = Mesh(r_in, r_out, height or sphere_profile(R, gap), nr, nz, grading)
    C = elastic.meridional_stiffness()
    Ke = np.zeros((len(mesh.elements), 18, 18))
    for r, z, volume, N, N_r, N_z in mesh.gauss_points():
        B = np.zeros((r.size, 4, 18))  # strain order rr, zz, hoop, rz
        B[:, 0, 0::2] = B[:, 3, 1::2] = N_r
        B[:, 1, 1::2] = B[:, 3, 0::2] = N_z
        B[:, 2, 0::2] = N / r[:, None]
        a_r, a_z = axis(r, z)
        zero, one, rz = np.zeros(r.size), np.ones(r.size), a_r * a_z
        to_material = np.array(
            [[a_z**2, a_r**2, zero, -rz], [a_r**2, a_z**2, zero, rz], [zero, zero, one, zero], [2 * rz, -2 * rz, zero, a_z**2 - a_r**2]]
        )
        B = to_material.transpose(2, 0, 1) @ B
        Ke += volume[:, None, None] * (B.transpose(0, 2, 1) @ (C @ B))
    prescribed = [(2 * mesh.midplane + 1, 0.0), (2 * mesh.top + 1, 0.5)]
    radially_held = ((mesh.top, not frictionless), (mesh.outer, confined_faces), (mesh.inner, confined_faces or r_in == 0))
    prescribed += [(2 * nodes, 0.0) for nodes, held in radially_held if held]
    dofs = (2 * mesh.elements[:, :, None] + np.arange(2)).reshape(-1, 18)
    return 2 * twice_strain_energy(dofs, Ke, prescribed)  # 2: the mirrored lower half


def torsion_stiffness(R, r_in, r_out, gap, elastic, axis, nr, nz, grading, height=None):
    """Torque about z per relative rotation of the grains."""
    mesh = Mesh(r_in, r_out, height or sphere_profile(R, gap), nr, nz, grading)
    Gp = elastic.Ep / (2 * (1 + elastic.nu_p))
    Ke = np.zeros((len(mesh.elements), 9, 9))
    for r, z, volume, N, N_r, N_z in mesh.gauss_points():
        shear_r = N_r - N / r[:, None]
        a_r, a_z = (component[:, None] for component in axis(r, z))
        for G, shear in ((elastic.Gzp, a_r * shear_r + a_z * N_z), (Gp, a_z * shear_r - a_r * N_z)):
            Ke += (G * volume)[:, None, None] * shear[:, :, None] * shear[:, None, :]
    prescribed = [(mesh.midplane, 0.0), (mesh.top, 0.5 * mesh.r[mesh.top])]
    if r_in == 0:
        prescribed.append((mesh.inner, 0.0))
    return 2 * twice_strain_energy(mesh.elements, Ke, prescribed)


class Convergence(NamedTuple):
    table: list  # (nr, nz, stiffness), coarse to fine
    value: float
    uncertainty: float


def converged_stiffness(solver, *problem, nr=8, nz=4, grading=2.5, levels=5, **options):
    if levels < 3 or nr < 2 or nr % 2:
        raise ValueError("need at least 3 levels and a positive even nr")
    meshes = [(nr << level, nz << level) for level in range(levels)]
    table = [(*mesh, solver(*problem, *mesh, grading, **options)) for mesh in meshes]
    a, b, c = (row[2] for row in table[-3:])
    rate = (a - b) / (b - c) if b != c else math.inf
    # Without a credible rate the finest mesh stands, and the last step measures its error.
    value = c + (c - b) / (rate - 1) if rate > 1.5 else c
    return Convergence(table, value, max(abs(value - c), abs(c - b), 1e-9 * abs(c)))


def converged_axial_stiffness(R, r_in, r_out, gap, elastic, axis, **options):
    return converged_stiffness(axial_stiffness, R, r_in, r_out, gap, elastic, axis, **options)


def self_check():
    vti = TransverselyIsotropic(60e9, 40e9, 0.25, 0.2, 18e9)
    no_poisson = vti._replace(nu_p=0.0, nu_zp=0.0)
    isotropic = TransverselyIsotropic(60e9, 60e9, 0.25, 0.25, 24e9)
    C33, Gp = vti.meridional_stiffness()[1, 1], vti.Ep / (2 * (1 + vti.nu_p))
    R, r_in, r_out, length = 5e-3, 1e-3, 2e-3, 0.6e-3
    A_L, J_L = math.pi * (r_out**2 - r_in**2) / length, math.pi / 2 * (r_out**4 - r_in**4) / length
    along_z, across, radial = axis_uniform(0.0, 1.0), axis_uniform(1.0, 0.0), axis_radial(R, 0.0)
    flat = {"height": lambda r: np.full_like(r, length / 2)}

    def on_ring(solver):
        return lambda elastic, axis=along_z, **options: solver(R, r_in, r_out, 0.0, elastic, axis, 8, 4, 2.5, **options)

    axial, torsion = on_ring(axial_stiffness), on_ring(torsion_stiffness)
    checks = {
        "bonded cylinder, nu = 0: Ez A / L": (axial(no_poisson, **flat), vti.Ez * A_L),
        "the same, axis along r: Ep A / L": (axial(no_poisson, across, **flat), vti.Ep * A_L),
        "uniaxial strain: C33 A / L": (axial(vti, confined_faces=True, **flat), C33 * A_L),
        "uniaxial stress: Ez A / L": (axial(vti, frictionless=True, **flat), vti.Ez * A_L),
        "torsion: Gzp J / L": (torsion(vti, **flat), vti.Gzp * J_L),
        "torsion, axis along r: Gp J / L": (torsion(vti, across, **flat), Gp * J_L),
        "isotropic ring is blind to the axis": (axial(isotropic, radial), axial(isotropic)),
        "and so is its torsion": (torsion(isotropic, radial), torsion(isotropic)),
    }
    errors = {name: abs(computed / exact - 1) for name, (computed, exact) in checks.items()}
    for name, error in errors.items():
        print(f"{'ok  ' if error < 1e-9 else 'FAIL'} {name}: relative error {error:.1e}")
    return all(error < 1e-9 for error in errors.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, default in (("radius", 5e-3), ("inner", 1e-3), ("outer", 2e-3), ("gap", 0.0)):
        parser.add_argument(f"--{name}", type=float, default=default, help=f"[m], default {default:g}")
    parser.add_argument("--vti", type=float, nargs=5, metavar=TransverselyIsotropic._fields, default=(60e9, 40e9, 0.25, 0.2, 18e9))
    parser.add_argument("--axis", choices=("z", "radial"), default="z", help="symmetry axis")
    parser.add_argument("--levels", type=int, default=5, help="meshes, each twice as fine")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--self-check", action="store_true")
    args = parser.parse_args()
    if args.self_check:
        return 0 if self_check() else 1
    axis = axis_uniform(0.0, 1.0) if args.axis == "z" else axis_radial(args.radius, args.gap)
    problem = (args.radius, args.inner, args.outer, args.gap, TransverselyIsotropic(*args.vti), axis)
    results = {
        "axial": converged_axial_stiffness(*problem, levels=args.levels),
        "torsion": converged_stiffness(torsion_stiffness, *problem, levels=args.levels),
    }
    if args.json:
        print(json.dumps({name: result._asdict() for name, result in results.items()}))
        return 0
    for (name, (table, value, uncertainty)), unit in zip(results.items(), ("N/m", "N m/rad")):
        print(f"{name} stiffness [{unit}], axis {args.axis}: nr, nz, k, k/k_limit - 1")
        for nr, nz, k in table:
            print(f"{nr:6d} {nz:6d} {k:16.9e} {k / value - 1:12.2e}")
        print(f"k_limit = {value:.8e} +- {uncertainty:.1e} ({uncertainty / value:.1e} relative)\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
