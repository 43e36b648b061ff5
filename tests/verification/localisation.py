#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Band and energy of a crack of `regularization nonlocal`, from the equations of doc/theory.md: for the tests of localisation.cpp.

The infinite bar is a lattice of n points a length.  Unknowns are x = -ln(1 - d) where damage grows, an interval about
the middle, and the logarithm of the square of the stress.  Written apart from the C++, in the norm of the strain squared, by
quarters of its logarithm.
"""
import numpy as np


def band(m, cutoff=0.9, n=16, half=6.0, steps=60):
    """Width over L; energy, and what the band stores elastically at the cut-off in the middle, over sqrt2 B0 L."""
    power, compliance, threshold = 0.25, 4.0, 1.0 + m
    count = int(half * n)
    x = (np.arange(count) + 0.5) / n
    K = sum(np.exp(-0.5 * d**2) for d in (x[:, None] - x, x[:, None] + x, 2 * half - x[:, None] - x))
    K /= K.sum(axis=1)[:, None]

    def newton(a, middle, lam, S, before):
        lam = lam.copy()
        lam[a:] = before[a:]
        lam[0] = middle
        for _ in range(60):
            root = np.exp(power * (S + compliance * lam))
            rest = (K @ root - np.exp(power * threshold * lam))[:a]
            J = np.empty((a, a))
            J[:, 0] = power * (K @ root)[:a]
            J[:, 1:] = K[:a, 1:a] * (power * compliance * root[1:a])
            J[np.arange(1, a), np.arange(1, a)] -= (power * threshold * np.exp(power * threshold * lam))[1:a]
            change = np.linalg.solve(J, -rest)
            most = np.abs(change).max()
            change *= min(1.0, 0.3 / max(most, 1e-30))
            S += change[0]
            lam[1:a] += change[1:]
            if most < 1e-11:
                return lam, S, not (lam[1:a] < before[1:a] - 1e-12).any()
        return lam, S, False

    S, energy, widest, a = 0.0, 0.0, 0, None
    before = np.zeros(count)
    for middle in np.linspace(0, -np.log(1 - cutoff), steps + 1)[1:]:
        if a is None:
            found = None
            for k in range(2, count // 2):
                guess = middle * np.maximum(np.cos(0.5 * np.pi * x * n / k), 0)
                lam, s, good = newton(k, middle, guess, -0.1 * middle, before)
                if not good:
                    break
                found = k, lam, s
        else:
            for k in range(min(a + 1, count - 1), 0, -1):
                lam, s, good = newton(k, middle, before, S, before)
                if good:
                    found = k, lam, s
                    break
        a, lam, s = found
        Yeq = 0.5 * (np.exp(s + 3 * lam) + np.exp(S + 3 * before))
        energy += 2 / n * np.sum(Yeq * (np.exp(-before) - np.exp(-lam)))
        S, before, widest = s, lam, max(widest, a)
    opening = 2 / n * np.sum(np.exp(S / 2) * (np.exp(2 * before) - 1))
    return 2 * widest / n, energy, 0.5 * np.exp(S / 2) * opening


def exponent(energy):
    """The m with which a crack takes that energy, over sqrt2 B0 L, with what is stored at the cut-off."""
    lo, hi = -0.5, 2.0
    for _ in range(18):
        m = 0.5 * (lo + hi)
        lo, hi = (m, hi) if sum(band(m, n=8)[1:]) < energy else (lo, m)
    return m


if __name__ == "__main__":
    for m in (0.0, 1.0, 2.0):
        print("m", m, *(f"n {n}: width {band(m, n=n)[0]:.3f} energy {band(m, n=n)[1]:.4f} stored {band(m, n=n)[2]:.4f}" for n in (4, 8, 16)))
