# SPDX-License-Identifier: GPL-2.0-or-later
"""What a bond that is failing says of itself, against its points: means, links, and where the events are."""
import csv

import numpy as np
import pytest
from scenes import cement, dump, pair, point_quantities, run, thermo

CELL, RING, STEPS, DT = 4e-4, "inner 1.4e-3 outer 2.2e-3 grid 3e-5 -5e-5 7e-5", 500, 2e-8
N = np.array([2.0, -1.0, 2.0]) / 3.0  # the line of centres; the coordinate axis most across it is y
NAMES = ["damage", "failed", "attached", "grain", "volume"]
OPENING = np.array([2.0, 1.0, 3.0]) / np.sqrt(14.0)  # askew, so that nothing about the crack is symmetric


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """A bond along N that has begun to fail, by what it wrote."""
    text = pair(CELL / 2, cement=RING, direction=N, half_box=3 * (12e-3,))
    text += cement(CELL, DT, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9 interface 0.7 events events.csv")
    text += point_quantities(NAMES)
    text += dump(STEPS, ["x", "y", "z"] + [f"c_{n}" for n in NAMES])
    T = STEPS * DT
    for axis, c in zip("xyz", 8e-6 * OPENING):
        text += f'variable d{axis} equal "{c:.17g}*(step*dt/{T})^2"\n' f'variable v{axis} equal "{2 * c / T:.17g}*step*dt/{T}"\n'
    text += "fix hold first move linear 0 0 0\nfix pull second move variable v_dx v_dy v_dz v_vx v_vy v_vz\n"
    text += thermo(STEPS, ["f_cem[2]", "f_cem[3]", "f_cem[4]"] + [f"f_bond[{i}]" for i in (16, 17, 18, 19, 20)]) + f"run {STEPS}\n"
    done = run(text, tmp_path_factory.mktemp("broken"))
    with open(done.directory / "events.csv") as f:
        events = list(csv.DictReader(f))
    return done.points(0), done.points(STEPS), {k: v[-1] for k, v in done.table().items()}, events


def test_means_and_counts(broken, figures):
    """Of all points, by volume: those of cut cells are smaller, and at the rim, where it breaks first."""
    _, p, t, _ = broken
    V, D = p["c_volume"], p["c_damage"]
    mean = (V * D).sum() / V.sum()
    assert abs(D.mean() / mean - 1) > 0.01, "volumes make no difference"
    for column in ("f_cem[4]", "f_bond[20]"):
        figures.below(f"{column}: mean damage against the points", abs(t[column] / mean - 1), 2e-14)
    for column in ("f_cem[3]", "f_bond[19]"):
        figures.below(f"{column}: largest damage against the points", abs(t[column] / D.max() - 1), 1e-12)
    assert t["f_cem[2]"] == t["f_bond[18]"] == p["c_failed"].sum() > 30


def test_links(broken):
    """Links have debonded where their point failed, and nowhere else."""
    _, p, t, _ = broken
    linked = p["c_attached"] > 0
    assert ((p["c_attached"] == 2) == (linked & (p["c_failed"] == 1))).all()
    assert t["f_bond[16]"] == (p["c_attached"] == 1).sum() > 30
    assert t["f_bond[17]"] == (p["c_attached"] == 2).sum() > 30


def test_place_of_events(broken, figures):
    """r, theta and z are those of the point where it was made: theta from the coordinate axis most across the line of
    centres, right-handed about the line from the first to the second grain."""
    start, p, t, events = broken
    assert len(events) == t["f_cem[2]"]
    at = {int(i): np.array(x) for i, *x in zip(start["id"], start["x"], start["y"], start["z"])}
    failed = {int(i): (int(g), d) for i, f, g, d in zip(p["id"], p["c_failed"], p["c_grain"], p["c_damage"]) if f}
    assert {int(e["point"]) for e in events} == set(failed)
    e1 = np.array([0.0, 1.0, 0.0]) - N[1] * N
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(N, e1)
    worst, quadrants = 0.0, set()
    for e in events:
        X = at[int(e["point"])]
        r, theta, z = (float(e[k]) for k in ("r", "theta", "z"))
        worst = max(worst, np.linalg.norm(z * N + r * (np.cos(theta) * e1 + np.sin(theta) * e2) - X))
        quadrants.add((theta > 0, abs(theta) < np.pi / 2))
        grain, damage = failed[int(e["point"])]
        assert int(e["grain"]) == grain and e["mode"] == ("debonding" if grain else "internal")
        assert abs(float(e["damage1"]) - damage) < 1e-8 and int(e["bond"]) == 1
    assert len(quadrants) > 2, "too few of the directions"
    figures.below("place of events, over the cell", worst / CELL, 1e-6)


def test_eigenvalues_of_events(broken, figures):
    """They are in descending order, the direction is a unit vector, and steps and times go together."""
    _, _, _, events = broken
    for e in events:
        d = [float(e[f"damage{i}"]) for i in (1, 2, 3)]
        assert d[0] >= d[1] >= d[2] >= -1e-12
        n = np.array([float(e[f"direction_{c}"]) for c in "xyz"])
        assert abs(np.linalg.norm(n) - 1) < 3e-6 and n[abs(n).argmax()] > 0
        assert abs(float(e["time"]) / (int(e["step"]) * DT) - 1) < 1e-9
    steps = [(int(e["step"]), int(e["point"])) for e in events]
    assert steps == sorted(steps)


def test_a_separated_bond_is_noticed_within_five_steps(tmp_path):
    """Whatever `check` is: paths through the bond are watched, not only looked for now and then."""
    steps = {}
    for check in (1, 100000):
        fixes = cement(CELL, 7e-8, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 interface 0.2 check {check}")
        text = pair(CELL / 2, cement=RING) + fixes
        text += (
            'variable d equal "5e-6*(step/200)^2"\nvariable v equal "5e-6*2*step/200/200/dt"\n'
            "fix hold first move linear 0 0 0\nfix pull second move variable NULL NULL v_d NULL NULL v_v\n"
        )
        t = run(text + thermo(1, ["f_bond[16]", "f_bond[22]"]) + "run 200\n", tmp_path / str(check)).table()
        assert t["f_bond[22]"][-1] == 1
        steps[check] = int(t["step"][np.argmax(t["f_bond[22]"] == 1)])
    # Added mass of debonded links is dropped at the checks, so that the two runs are not the same either.
    assert 10 < steps[1] < 190 and abs(steps[100000] - steps[1]) <= 5, steps
