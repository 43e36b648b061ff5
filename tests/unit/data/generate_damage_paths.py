#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Writes damage_paths.csv: strain-driven paths of the transversely isotropic
elastic law with second-order-tensor damage, for the unit tests of the
constitutive code.  Needs numpy only.

    generate_damage_paths.py [output.csv]      (default: beside this script)

Law (SI units, co-rotated material frame, axis of the material = local 3)
  a = I - D, phi = a^-1
  M^-1:X   = solution Z of  phi Z + Z phi = 2 X
  eps_e    = M^-1:eps,  sigma_e = C0:eps_e,  sigma = M^-1:sigma_e
  psi      = 1/2 eps_e:C0:eps_e
  Y        = -dpsi/dD at fixed eps = phi sym(sigma eps_e) phi
  drive    = <Y>_+ (evolution monotone) or Y (evolution full)
  Yeq      = sqrt(drive:drive / 2)
  B(D)     = B0 / s * (1 - maxeig D)^(-m)
  s        = r + (1 - r) zeta^2, r = sum <sigma_e,i> / sum |sigma_e,i| at
             (eps_{n+1}, D_n), constant during the step
Step: D_{n+1} = D_n + Delta N, Delta = first root of Yeq - B at eps_{n+1}.
  - no damage if Yeq(eps_{n+1}, D_n) <= B(D_n) (1 + 1e-14)
  - Dmax: largest Delta with maxeig(D_n + Delta N) <= Dcut
  - the root is bracketed at Dmax 10^(-6 + 6 k/16), k = 0..16, then bisected to
    a relative width of 1e-15; the end with Yeq <= B is taken
  - no sign change up to Dmax: the point fails, with D = D_n + Dmax N
  With evolution monotone and Yeq < 1.2 B at the trial state:
  - N is the direction of the drive at the middle of the step: strain
    (eps_n + eps_{n+1})/2, damage D_n + Delta_t N_t/2 with N_t the direction at
    (eps_{n+1}, D_n) and Delta_t where the tangent of Yeq - B along it there
    comes down to zero, no further than the cut-off (and there if the tangent
    does not fall). If N and N_t differ by more than 60 degrees, N = N_t
  - the root is bracketed at Dmax k/400
  Otherwise:
  - N is evaluated at the trial state first, then at the new D, until it moves
    by no more than 1e-10 in the Frobenius norm, with at most 3 root searches

Columns
  path, step            numbers from 0 and from 1; D = 0 before step 1
  Ep,Ez,nup,nuzp,Gzp    elastic constants; nuzp = -eps_p/eps_z under sigma_z
  B0,Dcut,m,zeta        as above
  evolution             monotone | full
  e??, D??, s??         strain, damage and stress at the end of the step, order
                        xx,yy,zz,yz,xz,xy, tensor components (no factor 2)
  Yeq_over_B0           Yeq of the drive at the end of the step, over B0 (neither
                        s nor (1 - maxeig D)^(-m) is applied; it is also given,
                        from D, on the failing row)
  failed                1 on the row where the point fails: stress zero, last row
  dissipation           psi(eps_{n+1}, D_n) - psi(eps_{n+1}, D_{n+1}), J/m3; on a
                        failing row the rest psi(eps_{n+1}, D_{n+1}) is not in it
  sensitive             1 if a relative change of 1e-15 of the strains of the path
                        moves any component of D by more than 1e-12 or changes
                        `failed`: such a row is no reference to round-off
"""
import os
import sys

import numpy as np

SEED = 20240611
INDEX = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
NAMES = ("xx", "yy", "zz", "yz", "xz", "xy")
NEAR = 1.2
MAX_DIRECTIONS = 3
DIRECTION_TOL = 1e-10
LARGEST_TURN = 0.5  # cosine
MARCH = 16
MARCH_DECADES = 6.0
ROOT_TOL = 1e-15
ONSET_SLACK = 1e-14
EYE = np.eye(3)


def tensor(six):
    xx, yy, zz, yz, xz, xy = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def six(t):
    return np.array([t[i, j] for i, j in INDEX])


def symmetric(t):
    return 0.5 * (t + t.T)


class Material:
    def __init__(self, Ep, Ez, nup, nuzp, Gzp, B0, Dcut=0.9, m=0.0, zeta=1.0, evolution="monotone"):
        self.parameters = (Ep, Ez, nup, nuzp, Gzp, B0, Dcut, m, zeta, evolution)
        self.B0, self.Dcut, self.m, self.zeta = B0, Dcut, m, zeta
        self.monotone = evolution == "monotone"
        q = nuzp * nuzp * Ep / Ez
        delta = (1.0 - nup) - 2.0 * q
        if not (Ep > 0 and Ez > 0 and Gzp > 0 and abs(nup) < 1 and delta > 0):
            raise ValueError("elastic constants are not positive definite")
        self.C11 = Ep * (1.0 - q) / ((1.0 + nup) * delta)
        self.C12 = Ep * (nup + q) / ((1.0 + nup) * delta)
        self.C13 = nuzp * Ep / delta
        self.C33 = Ez * (1.0 - nup) / delta
        self.C44 = Gzp
        self.C66 = 0.5 * Ep / (1.0 + nup)

    def elastic(self, e):
        """C0:e"""
        sxx = self.C11 * e[0, 0] + self.C12 * e[1, 1] + self.C13 * e[2, 2]
        syy = self.C12 * e[0, 0] + self.C11 * e[1, 1] + self.C13 * e[2, 2]
        szz = self.C13 * (e[0, 0] + e[1, 1]) + self.C33 * e[2, 2]
        return tensor((sxx, syy, szz, 2.0 * self.C44 * e[1, 2], 2.0 * self.C44 * e[0, 2], 2.0 * self.C66 * e[0, 1]))

    @staticmethod
    def reduction(D):
        """Principal axes of D and the factors of M^-1 in them"""
        d, axes = np.linalg.eigh(D)
        a = 1.0 - d
        return a, axes, 2.0 * np.outer(a, a) / np.add.outer(a, a)

    def state(self, eps, D):
        """eps_e, sigma_e, sigma, psi, Y, in the material frame"""
        a, axes, h = self.reduction(D)
        effective_strain = symmetric(axes @ (h * (axes.T @ eps @ axes)) @ axes.T)
        effective_stress = self.elastic(effective_strain)
        # sigma and Y in the principal axes of D
        s = h * (axes.T @ effective_stress @ axes)
        e = axes.T @ effective_strain @ axes
        y = symmetric(s @ e) / np.outer(a, a)
        psi = 0.5 * np.sum(effective_strain * effective_stress)
        return (effective_strain, effective_stress, symmetric(axes @ s @ axes.T), psi, symmetric(axes @ y @ axes.T))

    def drive(self, eps, D):
        Y = self.state(eps, D)[4]
        if not self.monotone:
            return Y
        w, v = np.linalg.eigh(Y)
        return symmetric((v * np.maximum(w, 0.0)) @ v.T)

    def weight(self, eps, D):
        if self.zeta == 1.0:
            return 1.0
        w = np.linalg.eigvalsh(self.state(eps, D)[1])
        total = np.abs(w).sum()
        r = np.maximum(w, 0.0).sum() / total if total > 0.0 else 1.0
        return r + (1.0 - r) * self.zeta**2

    def threshold(self, D, s):
        B = self.B0 / s
        if self.m != 0.0:
            B *= (1.0 - np.linalg.eigvalsh(D)[-1]) ** (-self.m)
        return B

    def largest_step(self, D, N):
        def beyond(x):
            return np.linalg.eigvalsh(D + x * N)[-1] >= self.Dcut

        high = 1e-3
        while not beyond(high) and high < 10.0:
            high *= 2.0
        low = 0.0
        while True:
            middle = 0.5 * (low + high)
            if middle <= low or middle >= high or high < 1e-16:
                return low
            if beyond(middle):
                high = middle
            else:
                low = middle

    def update(self, eps_start, eps, Dn):
        """D_{n+1}, failed"""
        s = self.weight(eps, Dn)
        drive = self.drive(eps, Dn)
        if yeq(drive) <= self.threshold(Dn, s) * (1.0 + ONSET_SLACK):
            return Dn.copy(), False
        decades = 10.0 ** (MARCH_DECADES * (np.arange(MARCH + 1) / MARCH - 1.0))
        if self.monotone and yeq(drive) < NEAR * self.threshold(Dn, s):
            N = self.direction(eps_start, eps, Dn, drive, s)
            return self.along(eps, Dn, N, s, np.arange(1, 401) / 400.0)
        N = drive / np.linalg.norm(drive)
        for _ in range(MAX_DIRECTIONS):
            D, failed = self.along(eps, Dn, N, s, decades)
            if failed:
                return D, True
            drive = self.drive(eps, D)
            previous, N = N, drive / np.linalg.norm(drive)
            if np.linalg.norm(N - previous) <= DIRECTION_TOL:
                break
        return D, False

    def along(self, eps, Dn, N, s, places):
        """First root along N, bracketed at `places` of the range: D, failed"""

        def outside(x):
            D = Dn + x * N
            return yeq(self.drive(eps, D)) > self.threshold(D, s)

        top = self.largest_step(Dn, N)
        low, high = 0.0, None
        for x in top * np.minimum(places, 1.0):
            if not outside(x):
                high = x
                break
            low = x
        if high is None:
            return Dn + top * N, True
        while high - low > ROOT_TOL * high:
            middle = 0.5 * (low + high)
            if middle <= low or middle >= high:
                break
            if outside(middle):
                low = middle
            else:
                high = middle
        return Dn + high * N, False

    def direction(self, eps_start, eps, Dn, drive, s):
        N = drive / np.linalg.norm(drive)
        tangent = np.sum(drive * self.slope_of_force(eps, Dn, N)) / (2.0 * yeq(drive)) - self.slope_of_threshold(Dn, N, s)
        delta = self.largest_step(Dn, N)
        if tangent < 0.0:
            delta = min(delta, (self.threshold(Dn, s) - yeq(drive)) / tangent)
        middle = self.drive(0.5 * (eps_start + eps), Dn + 0.5 * delta * N)
        size = np.linalg.norm(middle)
        if size == 0.0 or np.sum(middle * N) <= LARGEST_TURN * size:
            return N
        return middle / size

    def slope_of_force(self, eps, D, N):
        """dY along D + t N, from phi Z + Z phi = 2 X and its derivative, in nine unknowns"""
        phi = np.linalg.inv(EYE - D)
        rate = phi @ N @ phi
        system = np.kron(phi, EYE) + np.kron(EYE, phi)

        def reduced(X):
            return symmetric(np.linalg.solve(system, 2.0 * X.ravel()).reshape(3, 3))

        def slope(Z, dX):
            return reduced(dX - symmetric(rate @ Z))

        e = reduced(eps)
        de = slope(e, np.zeros((3, 3)))
        sigma = reduced(self.elastic(e))
        dsigma = slope(sigma, self.elastic(de))
        inner = symmetric(sigma @ e)
        return phi @ symmetric(dsigma @ e + sigma @ de) @ phi + 2.0 * symmetric(rate @ inner @ phi)

    def slope_of_threshold(self, D, N, s):
        if self.m == 0.0:
            return 0.0
        w, v = np.linalg.eigh(D)
        top = w >= w[-1] - 1e-9 * abs(w[-1])
        rate = np.mean([v[:, i] @ N @ v[:, i] for i in range(3) if top[i]])
        return self.m / (1.0 - w[-1]) * rate * self.threshold(D, s)


def yeq(drive):
    return np.sqrt(0.5 * np.sum(drive * drive))


def run(material, strains):
    """Rows (strain, damage, stress, Yeq/B0, failed, dissipation) of one path"""
    rows = []
    D = np.zeros((3, 3))
    start = np.zeros((3, 3))
    for strain in strains:
        eps = tensor(strain)
        new, failed = material.update(start, eps, D)
        before = material.state(eps, D)[3]
        _, _, sigma, after, _ = material.state(eps, new)
        rows.append((strain, six(new), np.zeros(6) if failed else six(sigma), yeq(material.drive(eps, new)) / material.B0, failed, before - after))
        D, start = new, eps
        if failed:
            break
    return rows


def sensitivity(material, strains, rows, rng):
    """1 for every row that a relative change of 1e-15 of the strains upsets"""
    flags = np.zeros(len(rows), dtype=int)
    n = len(rows)
    shape = (n, 6)
    # all strains up, all down, and every component up or down at random, twice
    for signs in (np.ones(shape), -np.ones(shape), rng.choice((-1.0, 1.0), shape), rng.choice((-1.0, 1.0), shape)):
        other = run(material, strains[:n] * (1.0 + 1e-15 * signs))
        for i in range(n):
            if i >= len(other) or other[i][4] != rows[i][4] or np.abs(other[i][1] - rows[i][1]).max() > 1e-12:
                flags[i] = 1
    return flags


# ---------------------------------------------------------------------- paths
def onset(material, strain):
    """Factor on `strain` (proportional, D = 0) at which damage begins"""
    eps = tensor(strain)
    zero = np.zeros((3, 3))
    s = material.weight(eps, zero)
    return np.sqrt(material.B0 / (s * yeq(material.drive(eps, zero))))


def random_direction(kind, rng):
    if kind == "compression":
        # negative definite strain with some shear
        frame, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        t = -(frame * rng.uniform(0.15, 1.0, 3)) @ frame.T
        return six(symmetric(t))
    t = rng.normal(size=6)
    if kind == "shear":
        t[:3] *= 0.1
    return t


def several_roots(material, factor, rng):
    """Random strain at onset, such that one step to `factor` times it from D = 0
    makes Yeq - B change sign more than once on the way to Dmax without failure"""
    zero = np.zeros((3, 3))
    for _ in range(5000):
        strain = random_direction("random", rng)
        strain *= onset(material, strain)
        eps = tensor(factor * strain)
        drive = material.drive(eps, zero)
        N = drive / np.linalg.norm(drive)
        top = material.largest_step(zero, N)
        s = material.weight(eps, zero)
        outside = [yeq(material.drive(eps, x * N)) > material.threshold(x * N, s) for x in np.linspace(0.0, top, 60)]
        changes = np.count_nonzero(np.diff(np.array(outside, dtype=int)))
        if changes > 1 and not material.update(zero, eps, zero)[1]:
            return strain
    raise RuntimeError("no such strain found")


def strain_path(kind, material, steps, reach, rng):
    t = np.arange(1, steps + 1) / steps
    if kind == "blend":
        first = random_direction("random", rng)
        second = random_direction("random", rng)
        first *= onset(material, first)
        second *= onset(material, second)
        # load to 0.4 reach, unload to 0.15 reach, reload to reach
        amplitude = reach * np.interp(t, (0.0, 0.4, 0.55, 1.0), (0.0, 0.4, 0.15, 1.0))
        share = 0.5 - 0.5 * np.cos(np.pi * t)
        direction = np.outer(1.0 - share, first) + np.outer(share, second)
        return amplitude[:, None] * direction
    if kind == "jump":
        direction = several_roots(material, JUMP, rng)
        return np.outer(np.linspace(JUMP, reach, steps), direction)
    direction = random_direction(kind, rng)
    direction *= onset(material, direction)
    return np.outer(reach * t, direction)


ISO = (60e9, 60e9, 0.3, 0.3, 60e9 / 2.0 / 1.3)
VTI_A = (50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9)
VTI_B = (91.6e9, 57.6e9, 0.318, 0.19, 34.1e9)
HIGH, LOW = 9.6e6, 9.6e3
JUMP = 1.25  # first step of the paths "jump", in onset strains

# kind, elastic set, B0, m, zeta, evolution, steps, reach (in onset strains)
PATHS = (
    ("random", ISO, HIGH, 0.0, 1.0, "monotone", 40, 5.0),
    ("random", ISO, LOW, 0.0, 1.0, "monotone", 80, 5.0),
    ("random", VTI_A, HIGH, 0.0, 1.0, "monotone", 60, 5.0),
    ("random", VTI_A, LOW, 0.0, 1.0, "monotone", 100, 5.0),
    ("random", VTI_B, HIGH, 0.0, 1.0, "monotone", 80, 5.0),
    ("random", VTI_B, LOW, 0.0, 1.0, "monotone", 50, 5.0),
    ("random", VTI_A, LOW, 0.0, 1.0, "monotone", 40, 5.0),
    ("random", VTI_B, HIGH, 0.0, 1.0, "monotone", 100, 5.0),
    ("random", ISO, LOW, 0.7, 1.0, "monotone", 80, 10.0),
    ("random", VTI_A, LOW, 0.7, 1.0, "monotone", 60, 5.0),
    ("random", VTI_B, HIGH, -0.4, 1.0, "monotone", 80, 5.0),
    ("random", VTI_A, LOW, 0.0, 0.1, "monotone", 60, 5.0),
    ("random", ISO, HIGH, 0.0, 1.0, "full", 60, 5.0),
    ("random", VTI_A, LOW, 0.0, 1.0, "full", 80, 5.0),
    ("random", VTI_B, LOW, 0.0, 1.0, "full", 60, 5.0),
    ("blend", ISO, HIGH, 0.0, 1.0, "monotone", 100, 5.0),
    ("blend", ISO, LOW, 0.0, 1.0, "monotone", 60, 5.0),
    ("blend", VTI_A, HIGH, 0.0, 1.0, "monotone", 100, 5.0),
    ("blend", VTI_A, LOW, 0.0, 1.0, "monotone", 80, 5.0),
    ("blend", VTI_B, HIGH, 0.0, 1.0, "monotone", 60, 5.0),
    ("blend", VTI_B, LOW, 0.0, 1.0, "monotone", 100, 5.0),
    ("blend", VTI_A, LOW, 0.0, 1.0, "monotone", 50, 5.0),
    ("blend", VTI_B, LOW, 0.7, 1.0, "monotone", 80, 9.0),
    ("blend", VTI_A, HIGH, -0.4, 1.0, "monotone", 100, 5.0),
    ("blend", ISO, LOW, 0.0, 0.1, "monotone", 80, 5.0),
    ("blend", VTI_B, HIGH, 0.0, 0.1, "monotone", 100, 5.0),
    ("blend", ISO, LOW, 0.0, 1.0, "full", 80, 5.0),
    ("blend", VTI_A, HIGH, 0.0, 1.0, "full", 60, 5.0),
    ("blend", VTI_B, LOW, 0.0, 1.0, "full", 80, 5.0),
    ("blend", VTI_A, LOW, 0.7, 1.0, "full", 80, 5.0),
    ("shear", ISO, HIGH, 0.0, 1.0, "monotone", 60, 5.0),
    ("shear", ISO, LOW, 0.0, 1.0, "monotone", 100, 5.0),
    ("shear", VTI_A, HIGH, 0.0, 1.0, "monotone", 80, 5.0),
    ("shear", VTI_A, LOW, 0.0, 1.0, "monotone", 60, 5.0),
    ("shear", VTI_B, LOW, 0.0, 1.0, "monotone", 80, 5.0),
    ("shear", VTI_B, HIGH, 0.7, 1.0, "monotone", 60, 5.0),
    ("shear", VTI_A, LOW, -0.4, 1.0, "monotone", 100, 5.0),
    ("shear", ISO, LOW, 0.0, 1.0, "full", 60, 5.0),
    ("shear", VTI_B, HIGH, 0.0, 1.0, "full", 80, 5.0),
    ("compression", ISO, HIGH, 0.0, 1.0, "monotone", 80, 5.0),
    ("compression", ISO, LOW, 0.0, 1.0, "monotone", 60, 5.0),
    ("compression", VTI_A, HIGH, 0.0, 1.0, "monotone", 60, 5.0),
    ("compression", VTI_A, LOW, 0.0, 1.0, "monotone", 80, 5.0),
    ("compression", VTI_B, LOW, 0.0, 1.0, "monotone", 60, 5.0),
    ("compression", VTI_B, HIGH, -0.4, 1.0, "monotone", 80, 5.0),
    ("compression", ISO, LOW, 0.0, 0.1, "monotone", 80, 5.0),
    ("compression", VTI_A, LOW, 0.0, 0.1, "monotone", 60, 5.0),
    ("compression", VTI_B, LOW, 0.0, 1.0, "full", 60, 5.0),
    ("jump", VTI_A, LOW, 0.0, 1.0, "full", 40, 4.0),
    ("jump", VTI_A, HIGH, 0.0, 1.0, "full", 60, 4.0),
)


def build():
    """(material, strains, rows) of every path"""
    for number, (kind, elastic, B0, m, zeta, evolution, steps, reach) in enumerate(PATHS):
        material = Material(*elastic, B0, m=m, zeta=zeta, evolution=evolution)
        strains = strain_path(kind, material, steps, reach, np.random.default_rng((SEED, number)))
        yield material, strains, run(material, strains)


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, "damage_paths.csv")
    header = ["path", "step", "Ep", "Ez", "nup", "nuzp", "Gzp", "B0", "Dcut", "m", "zeta", "evolution"]
    header += [letter + n for letter in "eDs" for n in NAMES]
    header += ["Yeq_over_B0", "failed", "dissipation", "sensitive"]
    with open(target, "w", encoding="ascii", newline="\n") as out:
        out.write(",".join(header) + "\n")
        for number, (material, strains, rows) in enumerate(build()):
            flags = sensitivity(material, strains, rows, np.random.default_rng((SEED, number, 1)))
            given = ["%s" % p if isinstance(p, str) else "%.17g" % p for p in material.parameters]
            for i, (strain, damage, stress, ratio, failed, lost) in enumerate(rows):
                fields = [str(number), str(i + 1)] + given
                # + 0.0 turns a negative zero into zero
                fields += ["%.17g" % (x + 0.0) for x in (*strain, *damage, *stress, ratio)]
                fields += [str(int(failed)), "%.17g" % (lost + 0.0), str(flags[i])]
                out.write(",".join(fields) + "\n")


if __name__ == "__main__":
    main()
