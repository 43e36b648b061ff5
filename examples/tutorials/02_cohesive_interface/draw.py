#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 2: draws the three curves, and prints the peaks beside strength times attached area.

    ./draw.py [PICTURE.png]
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

AREA = 1.24239e-5  # m2, attached to one bead, as create_cement prints it

fig, ax = plt.subplots(figsize=(6, 3.8), dpi=110)
for name, tn, colour in (("weak", 8, "#1b6ca8"), ("middle", 15, "#3a8f5c"), ("strong", 40, "#c1272d")):
    bond = np.genfromtxt(f"bond_{name}.csv", delimiter=",", names=True)
    peak, full = bond["peak_tension"][-1], 1e6 * tn * AREA
    print(f"{name}: tn {tn} MPa, peak {peak:.1f} N, {peak / full:.2f} of tn times attached area")
    ax.plot(1e6 * bond["gap"], bond["tension"], color=colour, label=f"{name}: tn = {tn} MPa")
ax.set_xlim(0, 3)
ax.set_xlabel("opening of the gap (µm)")
ax.set_ylabel("tension (N)")
ax.legend(frameon=False)
fig.tight_layout()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "interface.png")
