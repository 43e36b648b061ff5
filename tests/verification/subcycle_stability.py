#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Stability of sub-steps: how fast the fastest mode of a free pair grows in a step of LIGGGHTS.

Two grains, a chain of nodes between them with links and added mass as in src/USER-MPDEM/coupling/added_mass.h, and a contact beside it that LIGGGHTS knows
at the ends of its step alone. Of its load the mean of the last steps acts in each sub-step on the grains, the rest is an impulse that grains and cement share
(spread; the weight of the last load in the mean is that of loads that swing, and then, in 1e5 steps, as it is found in each step). Others: all of it is such an impulse (shared), one of the grains alone, or is held for the step. The sub-step is 0.9 of the limit of the chain. The step is
SHARE of the limit of the grains (with the mass of the cement that goes along) on bond and contact, the contact is what makes it so. 200 ratios of step and
sub-step between 1 and 40.

usage: subcycle_stability.py
"""
import numpy as np

CELLS, LINK = 8, 50.0  # of the chain; stiffness of a link over that of a cell
RATIOS = (0.1, 1, 10, 100, 1000, 10000)  # mass of both grains over that of the cement
SLOW, FAST, AVERAGE, SWING, MEANS = 0.02, 0.5, 0.1, 0.5, 3  # as in src/USER-MPDEM/cement/bond/spread_loads.cpp


def pair(ratio):
    """Stiffness and mass matrices of grain, nodes, grain; the sub-step; how the nodes follow the grains; mass of nodes."""
    m = np.r_[0.5, np.ones(CELLS - 1), 0.5]
    n = CELLS + 3
    M = np.diag(np.r_[ratio * m.sum() / 2, m, ratio * m.sum() / 2])
    K = np.zeros((n, n))
    for i in range(n - 1):
        k = LINK if i in (0, n - 2) else 1.0
        K[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    chain = K[1:-1, 1:-1] - LINK * np.diag(np.r_[1, np.zeros(CELLS - 1), 1])
    largest = np.linalg.eigvalsh(chain / np.sqrt(np.outer(m, m)))[-1]
    dt = 0.9 * 2 / np.sqrt(largest)
    for grain, node in ((0, 1), (n - 1, n - 2)):
        t = m.sum() / M[grain, grain]
        c = max(0.0, 1.05 * dt**2 / 4 * LINK * (1 + t) - M[node, node] * (1 - dt**2 * largest / 4))
        M[np.ix_([grain, node], [grain, node])] += c * np.array([[1, -1], [-1, 1]])
    s = np.r_[0, np.linspace(0, 1, CELLS + 1), 1]
    return K, M, dt, np.stack([1 - s, s], axis=1)


class Scene:
    """A pair in steps of n sub-steps, with a contact that makes the step that share of the limit; share 0: without one. contact is None where none does."""

    def __init__(self, ratio, steps, share):
        K, M, self.dt, follow = pair(ratio)
        self.size = len(K)
        self.n = int(np.ceil(steps - 1e-9))
        self.dt *= steps / self.n
        self.across = np.r_[1, np.zeros(self.size - 2), -1]
        mass = follow.T @ M @ follow
        reduced = 1 / (np.array([1, -1]) @ np.linalg.solve(mass, np.array([1, -1])))
        bond = 1 / (CELLS + 2 / LINK)
        self.contact = reduced * (2 * share / (self.n * self.dt)) ** 2 - bond if share else 0.0
        if self.contact < 0:
            self.contact = None
        self.inverse = np.linalg.inv(M)
        self.shared = follow @ np.linalg.solve(mass, follow.T)
        self.pull = self.inverse @ K  # of the cement

    def step(self, impulse):
        """Places and velocities after a step, from those before it, the load of the contact and what is spread in the last and in the next step."""
        size, n, dt = self.size, self.n, self.dt
        x, v, load, last, held = slice(0, size), slice(size, 2 * size), 2 * size, 2 * size + 1, 2 * size + 2
        within = np.eye(2 * size + 3)
        within[v, x] -= dt * self.pull
        drift = np.eye(2 * size + 3)
        drift[x, v] = dt * np.eye(size)
        first = within.copy()
        within[v, held] += dt * self.inverse @ self.across
        first[v, load] += n * dt * impulse @ self.across
        first[v, last] -= (n - 1) / 2 * dt * impulse @ self.across
        first[v, held] += dt * self.inverse @ self.across - ((n - 1) / 2 + 1) * dt * impulse @ self.across
        return (np.linalg.matrix_power(drift @ within, n - 1) @ drift @ first)[: 2 * size]


def growth(ratio, steps, share, how):
    """Of a step, or None where no contact makes the step that share of the limit. share 0: without a contact."""
    s = Scene(ratio, steps, share)
    if s.contact is None:
        return None
    size, n, dt, pull = s.size, s.n, s.dt, -s.contact * s.inverse @ np.outer(s.across, s.across)
    if how == "held":  # state: place, velocity at the same time, acceleration by the contact
        one, none = np.eye(size), np.zeros((size, size))
        half = np.block([[one, none, none], [-0.5 * dt * s.pull, one, 0.5 * dt * one], [none, none, one]])
        whole = np.block([[one, dt * one, none], [none, one, none], [none, none, one]])
        after = np.linalg.matrix_power(half @ whole @ half, n) @ np.block([[one, none], [none, one], [pull, none]])
        x, v, a = after[:size], after[size : 2 * size], after[2 * size :]
        return np.abs(np.linalg.eigvals(np.vstack([x, v + 0.5 * n * dt * (pull @ x - a)]))).max() - 1
    means = MEANS if how == "spread" else 0
    unit = np.eye(2 * size + means)
    load = -s.contact * s.across @ unit[:size]
    after, of_mean = unit.copy(), load
    for row in range(2 * size, 2 * size + means):
        of_mean = after[row] = (1 - SLOW) * unit[row] + SLOW * of_mean
    last, held = (unit[-1], after[-1]) if means else (0 * load, 0 * load)
    impulse = s.inverse if how == "grains alone" else s.shared
    after[: 2 * size] = s.step(impulse) @ np.vstack([unit[: 2 * size], load, last, held])
    return np.abs(np.linalg.eigvals(after)).max() - 1


def swings(scenes, steps):
    """Largest speed of a grain in the second half of so many steps over that in the first thousand, of each scene; the grains start apart. Weights are found in each step."""
    size = scenes[0].size
    maps = np.array([s.step(s.shared) for s in scenes])
    contact = np.array([s.contact for s in scenes])
    state = np.zeros((len(scenes), 2 * size + 3))
    state[:, 0], state[:, size - 1] = 1, -1
    means, off, squared = np.zeros((MEANS, len(scenes))), np.zeros(len(scenes)), np.zeros(len(scenes))
    most = np.zeros((2, len(scenes)))
    for step in range(steps):
        load = -contact * (state[:, 0] - state[:, size - 1])
        state[:, 2 * size], state[:, 2 * size + 1] = load, means[-1]
        error = load - means[-1]
        off += AVERAGE * (error - off)
        squared += AVERAGE * (error**2 - squared)
        trend = np.divide(off**2, squared, out=np.zeros_like(off), where=squared > 0)
        weight = SLOW + (FAST - SLOW) * np.maximum(0, trend - SWING) / (1 - SWING)
        for mean in means:
            mean += weight * (load - mean)
            load = mean
        state[:, 2 * size + 2] = means[-1]
        state[:, : 2 * size] = np.einsum("cij,cj->ci", maps, state)
        if step < 1000 or step >= steps // 2:
            most[int(step >= 1000)] = np.maximum(most[int(step >= 1000)], np.abs(state[:, size]))
    return most[1] / most[0]


def main():
    print("M/m: steps that grow by more than e in 1e5 steps, of how many; the fastest growth in a step")
    for share, how in ((0, "shared"), *((share, how) for how in ("held", "grains alone", "shared", "spread") for share in (0.9, 0.5, 0.2))):
        row = []
        for ratio in RATIOS:
            found = [g for g in (growth(ratio, r, share, how) for r in np.linspace(1, 40, 200)) if g is not None]
            row.append(f"{ratio:g}: {sum(g > 1e-5 for g in found)}/{len(found)} {max(found, default=0):.0e}")
        name = f"contact at {share} of the limit, {how}" if share else "no contact"
        print(f"{name:42s}", " | ".join(row), flush=True)
    print("speed of the grains in the second half of 1e5 steps over that in the first thousand, the largest of 10 ratios of the steps without growth above")
    for share in (0.9, 0.5, 0.2):
        row = []
        for ratio in RATIOS:
            scenes = [Scene(ratio, r, share) for r in np.linspace(1, 40, 200)[::20] if (growth(ratio, r, share, "shared") or 0) < 1e-5]
            scenes = [s for s in scenes if s.contact is not None]
            if scenes:
                row.append(f"{ratio:g}: {swings(scenes, 100000).max():.3g}")
        print(f"contact at {share} of the limit, spread", " | ".join(row), flush=True)


if __name__ == "__main__":
    main()
