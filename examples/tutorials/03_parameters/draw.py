#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 3: draws the curves of compression that are named, and prints their peaks.

    ./draw.py ucs.csv [second.csv] [PICTURE.png]
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

tables = [name for name in sys.argv[1:] if name.endswith(".csv")]
pictures = [name for name in sys.argv[1:] if name.endswith(".png")]
fig, ax = plt.subplots(figsize=(6, 3.8), dpi=110)
broken = ax.twinx()
for name, colour in zip(tables, ("#1b2a49", "#c1272d", "#3a8f5c")):
    strain, stress, bonds = np.genfromtxt(name, delimiter=",", skip_header=1).T
    top = stress.argmax()
    print(f"{name}: unconfined strength {stress[top]:.4g} Pa at a strain of {strain[top]:.3g}, {bonds[top]:.0f} bonds broken there, {bonds[-1]:.0f} at the end")
    ax.plot(1e3 * strain, 1e-3 * stress, color=colour, label=name)
    broken.plot(1e3 * strain, bonds, color=colour, lw=0.8, ls="--")
ax.set_xlabel("axial strain (per mille)")
ax.set_ylabel("stress on the plate (kPa)")
broken.set_ylabel("broken bonds (dashed)")
ax.legend(frameon=False)
fig.tight_layout()
fig.savefig(pictures[0] if pictures else "ucs.png")
