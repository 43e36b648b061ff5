# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Frames of a specimen that is loaded: beads and cement in space, beside the curve as far as it has come and the broken bonds."""
from typing import Any, List, Tuple

import numpy as np
import pandas as pd

from . import figures, movie, scene
from .figures import plt
from .output import Output
from .run import number
from .tables import Trouble

SIZE, DPI = (7.2, 4.1), 110  # inches, pixels an inch


def choose(steps: List[int], table: pd.DataFrame, frames: int) -> List[int]:
    """Steps that lie evenly along the curve of load against way."""
    known = [s for s in steps if table["step"].iloc[0] <= s <= table["step"].iloc[-1]]
    if len(known) < 2:
        raise Trouble(f"less than two of the pictures lie in curve.csv, steps {table['step'].iloc[0]} to {table['step'].iloc[-1]}; let the run get further")
    x, y = (np.interp(known, table["step"], table[c]) for c in ("axial_strain", "q"))
    return [known[i] for i in movie.evenly(x, y, frames)]


def draw(output: Output, frames: int, column: str = scene.DAMAGE) -> List[np.ndarray]:
    """An array of pixels (height, width, 3) for each frame."""
    curve = output.curves.get("response")
    if curve is None or not len(curve):
        raise Trouble(f"{output.folder}: no curve.csv of examples/specimen with rows of loading; name the folder of in.load")
    steps = choose(scene.steps(output.folder), curve, frames)
    limits = scene.span(output.folder, steps, column)
    drawn = scene.Scene(output.folder, column, limits, (360, 440))
    return [picture(drawn.draw(step), curve, step, limits, column) for step in steps]


@figures.styled
def picture(pixels: np.ndarray, curve: pd.DataFrame, step: int, limits: Tuple[float, float], column: str) -> np.ndarray:
    fig = plt.figure(figsize=SIZE, dpi=DPI)
    high = fig.get_figheight()
    ax = fig.add_axes([0.0, 0.72 / high, 0.46, 1 - 0.74 / high])
    ax.imshow(pixels, interpolation="lanczos")
    ax.axis("off")
    scene.key(fig, (0.25, 0.62 / high), scene.WORDS.get(column, column[2:]), limits, 0.36)
    upper, lower = (fig.add_axes([0.56, bottom, 0.42, 0.36]) for bottom in (0.58, 0.12))
    e, q = 100 * curve["axial_strain"], 1e-3 * curve["q"]
    done = curve["step"] <= step
    panel(upper, e, q, done, "axial less side stress (kPa)")
    panel(lower, e, curve["broken"], done, "broken bonds")
    lower.set_xlabel("axial strain (%)")
    now = int(np.flatnonzero(done)[-1])
    upper.set_title(f"{number(q[now])} kPa at {e[now]:.3g} %, {int(curve['broken'][now])} bonds broken", loc="left")
    fig.canvas.draw()
    found = np.asarray(fig.canvas.buffer_rgba())[..., :3].copy()
    plt.close(fig)
    return found


def panel(ax: Any, x: pd.Series, y: pd.Series, done: pd.Series, words: str) -> None:
    ax.plot(x, y, color=movie.PALE, lw=1.2)
    ax.plot(x[done], y[done], color=figures.CURVE, lw=1.6)
    ax.plot(x[done].iloc[-1], y[done].iloc[-1], "o", color=figures.MARK, ms=5, zorder=5, clip_on=False)
    ax.set_xlim(0.0, x.max())
    ax.set_ylim(min(0.0, 1.1 * y.min()), max(1.1 * y.max(), 1e-12))
    ax.set_ylabel(words)
