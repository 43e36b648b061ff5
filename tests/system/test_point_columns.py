# SPDX-License-Identifier: GPL-2.0-or-later
"""Every column of compute mpm/atom against closed forms: cement without a coupling, set in motion by v = L x.

No stress acts before the first step, so that after it every point has the same F = 1 + dt L. Two bonds in a row, so
that there are three grains and bonds with origins of their own.
"""
import numpy as np
import pytest
from scenes import CALCITE, RADIUS, cement, dump, edit, pair, point_quantities, run, uncoupled

DT, SPACING, INNER, OUTER = 1e-8, 2e-4, 1.4e-3, 2.2e-3
COMPONENTS = ["xx", "yy", "zz", "yz", "xz", "xy"]
INDEX = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
NAMES = ["damage", "drive", "stress_max", "pressure", "attached", "grain", "failed", "volume", "axis_x", "axis_y", "axis_z", "bond"] + [
    f"{t}_{c}" for t in ("damage", "stress", "strain") for c in COMPONENTS
]
N = np.array([2.0, 3.0, 6.0]) / 7.0  # no two components of N N are equal
AXIS = np.array([3.0, -2.0, 6.0]) / 7.0


def moved(F, tmp_path, **words):
    """The points after one step, by column."""
    L = (F - np.eye(3)) / DT
    text = pair(SPACING, cement=f"inner {INNER} outer {OUTER}", half_box=(6e-3, 6e-3, 22.5e-3))
    third = f"create_atoms 1 single 0 0 {3 * RADIUS} units box\n"
    text = edit(text, "set          type 1", third + "set          type 1")
    text += f"create_cement calcite pair 2 3 shape flat inner {INNER} outer {OUTER} film grid spacing {SPACING}\n"
    fixes = uncoupled(cement(2 * SPACING, DT, **words))
    text += fixes + "fix hold grains freeze\n"
    for i, v in enumerate(("vx", "vy", "vz")):
        text += f'variable {v} atom "{L[i, 0]:.17g}*x+{L[i, 1]:.17g}*y+{L[i, 2]:.17g}*z"\n'
    text += "velocity calcite set v_vx v_vy v_vz\n" + point_quantities(NAMES)
    text += dump(1, ["x", "y", "z"] + [f"c_{n}" for n in NAMES]) + "run 1\n"
    done = run(text, tmp_path)
    before, after = done.points(0), done.points(1)
    x, X = (np.column_stack([p[c] for c in "xyz"]) for p in (after, before))
    assert abs(x - X @ F.T).max() < 1e-12, "the motion is not that of F"
    return before, after


def tensor(points, name):
    """The components of one tensor, points x 6."""
    return np.column_stack([points[f"c_{name}_{c}"] for c in COMPONENTS])


def components(T):
    return np.array([T[i] for i in INDEX])


def stiffness(Ep, Ez, nu_p, nu_zp, Gzp, axis):
    """C_ijkl of transverse isotropy about an axis, from the compliance that defines the constants."""
    S = np.zeros((6, 6))  # xx yy zz yz xz xy of the frame with z along the axis, engineering shear
    S[:3, :3] = [[1 / Ep, -nu_p / Ep, -nu_zp / Ez], [-nu_p / Ep, 1 / Ep, -nu_zp / Ez], [-nu_zp / Ez, -nu_zp / Ez, 1 / Ez]]
    S[3:, 3:] = np.diag([1 / Gzp, 1 / Gzp, 2 * (1 + nu_p) / Ep])
    c = np.linalg.inv(S)
    C = np.zeros((3, 3, 3, 3))
    for I, (i, j) in enumerate(INDEX):
        for J, (k, m) in enumerate(INDEX):
            for a, b in {(i, j), (j, i)}:
                for d, e in {(k, m), (m, k)}:
                    C[a, b, d, e] = c[I, J]
    across = np.linalg.svd(axis[None])[2][1:]
    R = np.column_stack([*across, axis])
    return np.einsum("ai,bj,ck,dl,ijkl->abcd", R, R, R, R, C)


def strain_and_turn(F):
    """Of one step, Hughes and Winget 1980: d and w of the displacement by the position in the middle of the step."""
    G = (F - np.eye(3)) @ np.linalg.inv(0.5 * (F + np.eye(3)))
    d, w = 0.5 * (G + G.T), 0.5 * (G - G.T)
    return d, np.linalg.inv(np.eye(3) - 0.5 * w) @ (np.eye(3) + 0.5 * w)


def check(figures, what, value, expected, size, limit=2e-11):
    figures.below(f"{what}: error over {size:.3g}", abs(value - expected).max() / size, limit)


def test_undamaged(tmp_path, figures):
    """Transverse isotropy about a skew axis under a strain of six different components."""
    F = np.eye(3) + 1e-3 * np.array([[1.0, 0.3, -0.5], [0.3, -0.6, 0.2], [-0.5, 0.2, -2.0]])
    _, p = moved(F, tmp_path, elastic=CALCITE, axis="global 3 -2 6", damage="damage tensor B0 9.6e9 interface 0.5")
    strain, _ = strain_and_turn(F)
    stress = np.einsum("ijkl,kl", stiffness(*CALCITE, AXIS), strain)
    check(figures, "strain", tensor(p, "strain"), components(strain), 2e-3)
    check(figures, "stress", tensor(p, "stress"), components(stress), abs(stress).max())
    assert np.trace(stress) < 0  # compressed, so the pressure is positive
    check(figures, "pressure", p["c_pressure"], -np.trace(stress) / 3, abs(stress).max())
    check(figures, "largest principal stress", p["c_stress_max"], np.linalg.eigvalsh(stress)[-1], abs(stress).max())
    assert not tensor(p, "damage").any() and not p["c_damage"].any() and not p["c_failed"].any()
    Y = 0.5 * (stress @ strain + strain @ stress)
    drive = np.sqrt(0.5 * (Y * Y).sum()) / 9.6e9 * np.where(p["c_attached"] > 0, 2.0, 1.0)
    check(figures, "drive, twice as large at the grains", p["c_drive"], drive, drive.max())
    for d, name in enumerate(("axis_x", "axis_y", "axis_z")):
        check(figures, name, p[f"c_{name}"], AXIS[d], 1.0)


def test_turned(tmp_path, figures):
    """The axis rotates with the spin, and so does the stress that belongs to it."""
    F = np.eye(3) + 0.02 * np.array([[0.0, -0.6, 0.3], [0.6, 0.0, -0.8], [-0.3, 0.8, 0.0]])
    _, p = moved(F, tmp_path, elastic=CALCITE, axis="global 3 -2 6")
    strain, Q = strain_and_turn(F)
    check(figures, "axis after a turn of a degree", np.column_stack([p[f"c_axis_{c}"] for c in "xyz"]), Q @ AXIS, 1.0)
    check(figures, "strain, of the step alone", tensor(p, "strain"), components(strain), abs(strain).max())
    stress = np.einsum("ijkl,kl", stiffness(*CALCITE, Q @ AXIS), strain)
    check(figures, "stress of the turned axis", tensor(p, "stress"), components(stress), abs(stress).max())


# B0; share of the points that is damaged, and that has failed, in the bulk and with a link
@pytest.mark.parametrize("B0, damaged, failed", [(60e3, (1, 1), (0, 0)), (200e3, (0, 1), (0, 0)), (9e3, (1, 1), (0, 1)), (1e3, (1, 1), (1, 1))])
def test_damaged(B0, damaged, failed, tmp_path, figures):
    """Stretch e along N without Poisson's effect: D = d N N with (1 - d) E e^2 = sqrt(2) B0, stress (1 - d)^2 E e N N.
    `interface` halves B0 of points with a link."""
    E, e, cutoff = 50e9, 2e-3 / 1.001, 0.95
    F = np.eye(3) + 2e-3 * np.outer(N, N)
    _, p = moved(F, tmp_path, elastic=(E, E, 0.0, 0.0, E / 2), axis="global 0 0 1", damage=f"damage tensor B0 {B0} cutoff {cutoff} interface 0.5")
    linked = p["c_attached"] > 0
    threshold = B0 * np.where(linked, 0.5, 1.0)
    d = np.clip(1 - np.sqrt(2) * threshold / (E * e**2), 0.0, cutoff)
    broken = d == cutoff
    for k, of in ((0, ~linked), (1, linked)):
        assert ((d[of] > 0) == damaged[k]).all() and (broken[of] == failed[k]).all(), "not the case that it is meant to be"
    sigma = np.where(broken, 0.0, (1 - d) ** 2 * E * e)
    NN, size = components(np.outer(N, N)), E * e
    drive = np.where(broken, 0.0, np.where(d > 0, 1.0, E * e**2 / np.sqrt(2) / threshold))
    what = f"B0 {B0:g}"
    check(figures, f"{what}: strain", tensor(p, "strain"), e * NN, e)
    check(figures, f"{what}: damage", p["c_damage"], d, 1.0)
    check(figures, f"{what}: damage tensor", tensor(p, "damage"), d[:, None] * NN, 1.0)
    check(figures, f"{what}: drive", p["c_drive"], drive, 1.0)
    check(figures, f"{what}: stress", tensor(p, "stress"), sigma[:, None] * NN, size)
    check(figures, f"{what}: pressure", p["c_pressure"], -sigma / 3, size)
    check(figures, f"{what}: largest principal stress", p["c_stress_max"], sigma, size)
    assert (p["c_failed"] == broken).all()
    assert not tensor(p, "stress")[broken].any(), "failed points carry stress"


def test_what_does_not_deform(tmp_path, figures):
    """Number of the bond, volume, links and their grains, by where the points are."""
    p, _ = moved(np.eye(3), tmp_path, elastic=CALCITE)
    at = np.column_stack([p[c] for c in "xyz"])
    bond = np.where(at[:, 2] < RADIUS, 1, 2)
    assert (p["c_bond"] == bond).all() and set(bond) == {1, 2}
    exact = 2 * np.pi * RADIUS * (OUTER**2 - INNER**2) - 4 / 3 * np.pi * ((RADIUS**2 - INNER**2) ** 1.5 - (RADIUS**2 - OUTER**2) ** 1.5)
    for b in (1, 2):
        figures.below(f"volume of bond {b}: error", abs(p["c_volume"][bond == b].sum() / exact - 1), 5e-13)
    assert p["c_volume"].std() > 0.1 * SPACING**3
    middle = np.where(bond == 1, 0.0, 2 * RADIUS)
    # 0 without link, else the grain on whose side of the middle of the gap the point is
    assert set(p["c_attached"]) == {0, 1}
    side = np.where(at[:, 2] < middle, bond, bond + 1)
    assert (p["c_grain"] == np.where(p["c_attached"] > 0, side, 0)).all()


@pytest.mark.parametrize("ranks", [1, 2])
def test_before_a_run(ranks, tmp_path, monkeypatch):
    """`write_dump` evaluates the compute without a run, whatever lies in the memory that LIGGGHTS gives to it."""
    monkeypatch.setenv("MALLOC_PERTURB_", "1")
    text = pair(SPACING, cement=f"inner {INNER} outer {OUTER}") + cement(2 * SPACING, DT)
    run(text + "compute v calcite mpm/atom cem volume\nwrite_dump calcite custom points.txt id c_v\n", tmp_path, ranks)
    rows = np.loadtxt((tmp_path / "points.txt").read_text().split("ITEM: ATOMS")[-1].splitlines()[1:])
    assert len(rows) > 100 and (rows[:, 1] > 0).all()
