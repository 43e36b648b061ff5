#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 4: draws tension of the bond between rigid and between elastic beads, and prints stiffnesses and peaks.

    ./draw.py [PICTURE.png]
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

fig, ax = plt.subplots(figsize=(6, 3.8), dpi=110)
for name, colour in (("rigid", "#1b2a49"), ("glass", "#c1272d")):
    bond = np.genfromtxt(f"bond_{name}.csv", delimiter=",", names=True)
    stiffness = np.genfromtxt(f"stiffness_{name}.csv", delimiter=",", names=True)
    print(
        f"{name}: tension {stiffness['tension']:.4g} N/m, shear {stiffness['shear_min']:.4g} N/m, "
        f"torsion {stiffness['torsion']:.4g} N m, bending {stiffness['bending_min']:.4g} N m, peak {bond['peak_tension'][-1]:.4g} N"
    )
    ax.plot(1e6 * bond["gap"], bond["tension"], color=colour, label=f"{name} beads")
    opening = np.array([0, 1e6 * 1.05 * bond["peak_tension"][-1] / stiffness["tension"]])
    ax.plot(opening, 1e-6 * opening * stiffness["tension"], color=colour, lw=0.8, ls="--")
ax.plot([], [], color="0.4", lw=0.8, ls="--", label="stiffness by bond_stiffness")
ax.set_xlim(0, 4)
ax.set_xlabel("opening of the gap (µm)")
ax.set_ylabel("tension (N)")
ax.legend(frameon=False)
fig.tight_layout()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "elastic.png")
