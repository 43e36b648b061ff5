#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 7: an image as of X-ray CT, with labels. Three grains of sand of about 0.3 mm, and calcite (label 9) around two contacts.

    ./make_image.py          writes image.npy

A real image is segmented by another program. Save its labels as an array of NumPy, with indices in the order x, y, z.
"""
import numpy as np

CEMENT = 9
x, y, z = np.indices((80, 80, 200)) + 0.5  # centres of the voxels

image = np.zeros(x.shape, dtype=np.uint8)
image[(x - 40) ** 2 + (y - 40) ** 2 + (z - 36) ** 2 <= 30**2] = 1
image[(x - 40) ** 2 + (y - 40) ** 2 + (z - 97) ** 2 <= 30**2] = 2
image[((x - 40) / 31.5) ** 2 + ((y - 40) / 30) ** 2 + ((z - 154) / 26) ** 2 <= 1] = 3  # no sphere

from_axis = np.hypot(x - 40, y - 40)
image[(image == 0) & (from_axis < 16) & (z > 36) & (z < 97)] = CEMENT
image[(image == 0) & (from_axis < 13) & (z > 97) & (z < 154)] = CEMENT
image[(image == 0) & (x > 64) & (abs(y - 40) < 6) & (abs(z - 36) < 8) & (x < 72)] = CEMENT  # on grain 1 alone

np.save("image.npy", image)
print("image.npy:", image.shape, "voxels, labels", *np.unique(image))
