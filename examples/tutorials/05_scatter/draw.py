#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 5: draws the pull on the upper layer of all curve_NAME.csv, and the strengths of the bonds that broke in one of them.

    ./draw.py [PICTURE.png]
"""
import glob
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

SHOWN = "seed_1"
fig, (ax, right) = plt.subplots(1, 2, figsize=(8, 3.6), dpi=110)
for path in sorted(glob.glob("curve_*.csv")):
    name = path[len("curve_") : -len(".csv")]
    curve = np.genfromtxt(path, delimiter=",", names=True)
    bond = np.genfromtxt(f"bond_{name}.csv", delimiter=",", names=True)
    last = bond[bond["step"] == bond["step"].max()]
    factor, apart = last["strength_factor"], last["separated"] > 0
    print(f"{name}: peak {curve['pull_N'].max():.0f} N, {apart.sum()} of {len(last)} bonds separated, weakest strength factor {factor.min():.3f}")
    ax.plot(curve["way_um"], curve["pull_N"], label=name, lw=1.8 if name == "equal" else 1)
    if name == SHOWN:
        bins = np.linspace(0.3, 1.5, 19)
        right.hist(factor, bins, color="#b9c2d0", label="all bonds")
        right.hist(factor[apart], bins, color="#c1272d", label="separated at the end")
ax.set_xlim(0, 2.5)
ax.set_xlabel("displacement of the upper layer (µm)")
ax.set_ylabel("pull on the upper layer (N)")
ax.legend(frameon=False)
right.set_title(SHOWN, fontsize=9)
right.set_xlabel("strength factor of a bond")
right.set_ylabel("bonds")
right.legend(frameon=False)
fig.tight_layout()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "scatter.png")
