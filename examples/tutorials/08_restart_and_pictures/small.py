#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Tutorial 8: makes a picture for print small enough for a page: fewer pixels and colours.

    ./small.py PICTURE.png SMALL.png
"""
import sys

from PIL import Image

picture = Image.open(sys.argv[1]).convert("RGB")
picture.thumbnail((1300, 1300), Image.Resampling.LANCZOS)
picture.quantize(128, dither=Image.Dither.NONE).save(sys.argv[2], optimize=True)
print(sys.argv[2], "{} by {} pixels".format(*picture.size))
