#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 6: draws stress and broken bonds over strain of the specimens of a folder of tools/specimen.py.

    ./draw.py [FOLDER] [PICTURE.png]
"""
import glob
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

folder = sys.argv[1] if len(sys.argv) > 1 else "out"
fig, (ax, lower) = plt.subplots(2, 1, figsize=(6, 5), dpi=110, sharex=True, height_ratios=(3, 2))
for path, colour in zip(sorted(glob.glob(os.path.join(folder, "compression_*", "response.csv"))), ("#1b2a49", "#c1272d", "#3a8f5c")):
    name = os.path.basename(os.path.dirname(path))
    rows = np.genfromtxt(path, delimiter=",", names=True)
    ax.plot(1e3 * rows["axial_strain"], 1e-6 * rows["axial_stress"], color=colour, label=name)
    lower.plot(1e3 * rows["axial_strain"], rows["broken"], color=colour)
ax.set_ylabel("axial stress (MPa)")
ax.legend(frameon=False)
lower.set_ylabel("broken bonds")
lower.set_xlabel("axial strain (per mille)")
fig.tight_layout()
fig.savefig(sys.argv[2] if len(sys.argv) > 2 else "specimen.png")
