#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Stability of sub-steps: how fast the fastest mode of a free pair grows in a step of LIGGGHTS.

Two grains, a chain of nodes between them with links and added mass as in src/USER-MPDEM/coupling/added_mass.h, and a contact beside it that LIGGGHTS knows
at the ends of its step alone. Its load is an impulse that grains and cement share, one of the grains alone, or is held for the step. The sub-step is 0.9 of the limit of the chain. The step is SHARE of the limit of the grains (with the mass of the cement that goes
along) on bond and contact, the contact is what makes it so. 200 ratios of step and sub-step between 1 and 40.

usage: subcycle_stability.py
"""
import numpy as np

CELLS, LINK = 8, 50.0  # of the chain; stiffness of a link over that of a cell
RATIOS = (0.1, 1, 10, 100, 1000, 10000)  # mass of both grains over that of the cement


def pair(ratio):
    """Stiffness and mass matrices of grain, nodes, grain; the sub-step; how the nodes follow the grains; mass of nodes."""
    m = np.r_[0.5, np.ones(CELLS - 1), 0.5]
    n = CELLS + 3
    M = np.diag(np.r_[ratio * m.sum() / 2, m, ratio * m.sum() / 2])
    K = np.zeros((n, n))
    for i in range(n - 1):
        k = LINK if i in (0, n - 2) else 1.0
        K[i:i + 2, i:i + 2] += k * np.array([[1, -1], [-1, 1]])
    chain = K[1:-1, 1:-1] - LINK * np.diag(np.r_[1, np.zeros(CELLS - 1), 1])
    largest = np.linalg.eigvalsh(chain / np.sqrt(np.outer(m, m)))[-1]
    dt = 0.9 * 2 / np.sqrt(largest)
    for grain, node in ((0, 1), (n - 1, n - 2)):
        t = m.sum() / M[grain, grain]
        c = max(0.0, 1.05 * dt**2 / 4 * LINK * (1 + t) - M[node, node] * (1 - dt**2 * largest / 4))
        M[np.ix_([grain, node], [grain, node])] += c * np.array([[1, -1], [-1, 1]])
    s = np.r_[0, np.linspace(0, 1, CELLS + 1), 1]
    return K, M, dt, np.stack([1 - s, s], axis=1)


def growth(ratio, steps, share, how):
    """Of a step, or None where no contact makes the step that share of the limit. share 0: without a contact."""
    K, M, dt, follow = pair(ratio)
    size = len(K)
    n = int(np.ceil(steps - 1e-9))
    dt *= steps / n
    across = np.r_[1, np.zeros(size - 2), -1]
    mass = follow.T @ M @ follow
    reduced = 1 / (np.array([1, -1]) @ np.linalg.solve(mass, np.array([1, -1])))
    bond = 1 / (CELLS + 2 / LINK)
    contact = reduced * (2 * share / (n * dt))**2 - bond if share else 0.0
    if contact < 0:
        return None
    inverse = np.linalg.inv(M)
    impulse = follow @ np.linalg.solve(mass, follow.T) if how == "shared" else inverse
    pull = -contact * impulse @ np.outer(across, across)
    one, none = np.eye(size), np.zeros((size, size))
    kick = np.block([[one, none], [-dt * inverse @ K, one]])
    drift = np.block([[one, dt * one], [none, one]])
    if how == "held":  # state: place, velocity at the same time, acceleration by the contact
        half = np.block([[one, none, none], [-0.5 * dt * inverse @ K, one, 0.5 * dt * one], [none, none, one]])
        whole = np.block([[one, dt * one, none], [none, one, none], [none, none, one]])
        after = np.linalg.matrix_power(half @ whole @ half, n) @ np.block([[one, none], [none, one], [pull, none]])
        x, v, a = after[:size], after[size:2 * size], after[2 * size:]
        return np.abs(np.linalg.eigvals(np.vstack([x, v + 0.5 * n * dt * (pull @ x - a)]))).max() - 1
    first = kick.copy()
    first[size:, :size] += n * dt * pull
    step = np.linalg.matrix_power(drift @ kick, n - 1) @ drift @ first
    return np.abs(np.linalg.eigvals(step)).max() - 1


def main():
    print("M/m: steps that grow by more than e in 1e5 steps, of how many; the fastest growth in a step")
    for share, how in ((0, "shared"), *((share, how) for how in ("held", "grains alone", "shared") for share in (0.9, 0.5, 0.2))):
        row = []
        for ratio in RATIOS:
            found = [g for g in (growth(ratio, r, share, how) for r in np.linspace(1, 40, 200)) if g is not None]
            row.append(f"{ratio:g}: {sum(g > 1e-5 for g in found)}/{len(found)} {max(found, default=0):.0e}")
        name = f"contact at {share} of the limit, {how}" if share else "no contact"
        print(f"{name:42s}", " | ".join(row), flush=True)


if __name__ == "__main__":
    main()
