#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 1: draws bond_pair.csv and a cut through the points of three dumps.

    ./draw.py [PICTURE.png]
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

STEPS = (300, 500, 700)

bond = np.genfromtxt("bond_pair.csv", delimiter=",", names=True)
fig = plt.figure(figsize=(8, 4.2), dpi=110)
curve = fig.add_axes([0.08, 0.13, 0.38, 0.78])
curve.plot(1e6 * bond["gap"], bond["tension"], color="#1b2a49")
curve.set_xlabel("opening of the gap (µm)")
curve.set_ylabel("tension (N)")
for i, step in enumerate(STEPS):
    at = np.argmin(abs(bond["step"] - step))
    curve.plot(1e6 * bond["gap"][at], bond["tension"][at], "o", color="#c1272d")
    curve.annotate("abc"[i], (1e6 * bond["gap"][at], bond["tension"][at]), xytext=(7, 5), textcoords="offset points")

    x, y, z, damage, failed = np.loadtxt(f"points_pair.{step}.txt", skiprows=9, usecols=(1, 2, 3, 4, 5)).T
    cut = abs(y) < 1e-4
    ax = fig.add_axes([0.53, 0.71 - 0.29 * i, 0.36, 0.25])
    colours = ax.scatter(1e3 * x[cut], 1e3 * z[cut], c=damage[cut], s=8, marker="s", cmap="viridis", vmin=0, vmax=1)
    gone = cut & (failed > 0)
    ax.scatter(1e3 * x[gone], 1e3 * z[gone], s=8, marker="s", color="#e8172c")
    for centre in (-5, 5 + 1e3 * bond["gap"][at]):
        ax.add_patch(plt.Circle((0, centre), 5, fc="#ececec", ec="#707070"))
    ax.set(xlim=(-2.7, 2.7), ylim=(-0.95, 0.95), aspect="equal", yticks=[-0.5, 0, 0.5])
    ax.set_title(f"{'abc'[i]}: {bond['tension'][at]:.0f} N", loc="left", fontsize=8, pad=3)
    ax.tick_params(labelsize=7, labelbottom=i == 2)
ax.set_xlabel("x (mm)", fontsize=8)
bar = fig.colorbar(colours, cax=fig.add_axes([0.91, 0.2, 0.015, 0.6]))
bar.set_label("damage; red: failed points", fontsize=8)
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "pair.png")
