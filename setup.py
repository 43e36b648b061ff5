# SPDX-License-Identifier: GPL-2.0-or-later
"""The version of the Python package is that of the program: src/USER-MPDEM/version.h. pyproject.toml has the rest."""
import re
from pathlib import Path

from setuptools import setup

setup(version=re.search(r'kVersion = "(.*)"', (Path(__file__).parent / "src" / "USER-MPDEM" / "version.h").read_text())[1])
