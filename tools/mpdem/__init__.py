# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Output of USER-MPDEM as pandas tables with units, and figures of it: see doc/python.md.

    import mpdem
    run = mpdem.load("folder of a run")
    run.bonds, run.events, run.points, run.curves
"""
import os
from typing import TYPE_CHECKING, Optional, Union

if TYPE_CHECKING:
    from .output import Output

__all__ = ["Trouble", "label", "load", "read_points", "unit"]

from .tables import Trouble, read_points  # noqa: E402
from .units import label, unit  # noqa: E402


def load(folder: Union[str, "os.PathLike[str]"], name: Optional[str] = None) -> "Output":
    """The output of a run or of a driver. name: which run, if a folder has several, as NAME of bond_NAME.csv. Raises Trouble."""
    from .output import Output

    return Output(os.fspath(folder), name)
