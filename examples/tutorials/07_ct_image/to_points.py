#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 7: from the labels of image.npy to the files that in.ct reads.

    ./to_points.py           writes grains.data, cement.txt, cement.in

`coarse` voxels are the spacing of the material points. Needs Debian's python3-numpy and python3-scipy, and the package mpdem.
"""
import sys

import numpy as np

try:
    from mpdem import voxels
except ImportError as missing:
    sys.exit(f"to_points.py: {missing}; in the folder of the repository: export PYTHONPATH=$PWD/tools")

VOXEL = 5e-6  # m
CEMENT = 9  # label
COARSE = 1
FIT = "cement"  # radius below the cement; or "volume"

image = np.load("image.npy")
grains = voxels.spheres(image, VOXEL, CEMENT, fit=FIT)
cement = voxels.cement_points(image, VOXEL, CEMENT, grains, coarse=COARSE, attach=1.5)
print(voxels.report(grains, cement))

voxels.write_grains("grains.data", grains, density=2650)
voxels.write_points("cement.txt", cement)
with open("cement.in", "w") as script:
    script.write(voxels.commands(cement, "cement.txt", attach=1.5))
