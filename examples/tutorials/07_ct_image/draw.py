#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 7: draws a slice of the image with the spheres on it, the points of the cement, and the tension of both bonds.

    ./draw.py [PICTURE.png]
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.colors import ListedColormap  # noqa: E402

from mpdem import voxels  # noqa: E402

VOXEL, CEMENT = 5e-6, 9
um = 1e6
image = np.load("image.npy")
grains = voxels.spheres(image, VOXEL, CEMENT, fit="cement")
points = np.loadtxt("cement.txt", skiprows=2)
fig, (left, middle, right) = plt.subplots(1, 3, figsize=(8.6, 4.6), dpi=110, width_ratios=(1, 1, 2.2))

slice_y = image.shape[1] // 2
shown = np.where(image == CEMENT, 2, image > 0)[:, slice_y, :].T
extent = (0, um * VOXEL * image.shape[0], 0, um * VOXEL * image.shape[2])
left.imshow(shown, origin="lower", extent=extent, cmap=ListedColormap(["white", "#c8ccd2", "#d98b4a"]))
left.set_title("image and spheres", fontsize=9)
cut = abs(points[:, 3] - (slice_y + 0.5) * VOXEL) < 0.6 * VOXEL
middle.scatter(um * points[cut, 2], um * points[cut, 4], s=1.2, marker="s", c=np.where(points[cut, 0] == 1, "#1b6ca8", "#c1272d"))
middle.set_title("points of two bonds", fontsize=9)
for ax in (left, middle):
    for g in grains:
        ax.add_patch(plt.Circle((um * g.centre[0], um * g.centre[2]), um * g.radius, fill=False, ec="black", lw=0.8))
    ax.set(xlim=extent[:2], ylim=extent[2:], aspect="equal", xticks=[0, 200, 400])
    ax.set_xlabel("x (µm)")
left.set_ylabel("z (µm)")

bond = np.genfromtxt("bond.csv", delimiter=",", names=True)
for number, colour in ((1, "#1b6ca8"), (2, "#c1272d")):
    one = bond[bond["bond"] == number]
    right.plot(um * (one["gap"] - one["gap"][0]), one["tension"], color=colour, lw=1, label=f"bond {number}")
right.set_xlabel("opening of the gap (µm)")
right.set_ylabel("tension (N)")
right.legend(frameon=False)
fig.tight_layout()
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "ct.png")
