#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 9: draws pull.csv of check.sh: stress by the law and by its closed form, and the damage.

    ./draw.py [PICTURE.png]
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

rows = np.genfromtxt("pull.csv", delimiter=",", names=True)
fig, ax = plt.subplots(figsize=(6, 3.8), dpi=110)
damage = ax.twinx()
ax.plot(1e3 * rows["strain"], 1e-6 * rows["closed_form_Pa"], color="#b9c2d0", lw=4, label="closed form")
ax.plot(1e3 * rows["strain"], 1e-6 * rows["stress_Pa"], "o", color="#1b2a49", ms=4, label="law")
damage.plot(1e3 * rows["strain"], rows["damage"], color="#c1272d", lw=1)
ax.set_xlabel("strain along the axis (per mille)")
ax.set_ylabel("stress along the axis (MPa)")
damage.set_ylabel("damage (red line)")
ax.legend(frameon=False, loc="lower center")
fig.tight_layout()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "law.png")
