# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Frames of a bond that breaks: the cut with displacements drawn larger than they are, and the curve as far as it has come."""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Patch

from . import figures, run

SIZE, DPI = (7.2, 2.75), 110  # inches, pixels an inch
PALE = "#b9c2d0"


def choose(bond, steps, frames, until):
    """Steps that lie evenly along the curve of tension against opening, up to `until` times the opening at separation."""
    opening, tension = (np.interp(steps, bond.step, v) for v in (bond.opening, bond.tension))
    separated = np.flatnonzero(bond.separated > 0)
    end = until * bond.opening[separated[0]] if len(separated) else opening[-1]
    kept = np.flatnonzero(opening <= end)
    way = np.hypot(np.diff(opening[kept]) / max(np.ptp(opening[kept]), 1e-30), np.diff(tension[kept]) / max(np.ptp(tension[kept]), 1e-30))
    along = np.concatenate([[0.0], np.cumsum(way)])
    nearest = [int(np.argmin(abs(along - a))) for a in np.linspace(0.0, along[-1], frames)]
    return [steps[kept[i]] for i in sorted(set(nearest))]


def draw(bond, dumps, radius, magnify):
    """An array of pixels (height, width, 3) for each of the dumps."""
    first = run.read_dump(dumps[min(dumps)])
    if "id" not in first:
        raise run.Trouble(f"{dumps[min(dumps)]}: no column id; displacements need it, write it with 'dump ID group custom N cut_NAME.*.txt id x y z ...'")
    order = np.argsort(first["id"])
    start = np.column_stack([first[c][order] for c in "xyz"])
    half = 0.56 * run.spacing(first)  # a little more than a point's share, so that stretched cement shows no seams
    pictures = []
    for step, path in sorted(dumps.items()):
        points = run.read_dump(path)
        order = np.argsort(points["id"])
        if len(order) != len(start):
            raise run.Trouble(f"{path}: other points than in the first dump; name the dumps of one run with --cut")
        moved = np.column_stack([points[c][order] for c in "xyz"]) - start
        frame = {"x": start[:, 0] + magnify * moved[:, 0], "z": start[:, 2] + magnify * moved[:, 2]}
        frame |= {c: points[c][order] for c in ("c_damage", "c_failed")}
        pictures.append(picture(bond, step, max(dumps), frame, start, half, radius, magnify))
    return pictures


@figures.styled
def picture(bond, step, end, frame, start, half, radius, magnify):
    fig = plt.figure(figsize=SIZE, dpi=DPI)
    cut(fig.add_axes([0.015, 0.12, 0.56, 0.79]), bond, step, frame, start, half, radius, magnify)
    curve(fig.add_axes([0.66, 0.16, 0.325, 0.75]), bond, step, end)
    fig.canvas.draw()
    pixels = np.asarray(fig.canvas.buffer_rgba())[..., :3].copy()
    plt.close(fig)
    return pixels


def cut(ax, bond, step, frame, start, half, radius, magnify):
    mm = 1e3
    lift = magnify * bond.at(step, bond.lift)
    for z in (-radius - 0.5 * bond.gap[0], radius + 0.5 * bond.gap[0] + lift):
        ax.add_patch(Circle((0.0, mm * z), mm * radius, fc=figures.GRAIN, ec=figures.GRAIN_EDGE, lw=0.8, zorder=1))
    corners = mm * half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    centre = mm * np.column_stack([frame["x"], frame["z"]])
    failed = frame["c_failed"] > 0.5
    shades = plt.get_cmap(figures.MAP)(np.round(frame["c_damage"][~failed] * 16) / 16)  # few colours keep the file small
    ax.add_collection(PolyCollection(centre[~failed, None] + corners, fc=shades, lw=0, antialiased=False, zorder=2))
    ax.add_collection(PolyCollection(centre[failed, None] + corners, fc=figures.BROKEN, lw=0, antialiased=False, zorder=3))
    wide, high = 1.1 * mm * abs(start[:, 0]).max(), 1.15 * mm * abs(start[:, 2]).max()
    ax.set_xlim(-0.1 * wide, wide)  # half of the cut, from the line of centres
    ax.set_ylim(-high, 1.3 * high)
    ax.set_aspect("equal")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.set_title(f"half of a cut through the bond, displacements drawn x {magnify:g}", loc="left", fontsize=8.5, pad=4)
    shade = plt.get_cmap(figures.MAP)
    ax.legend(
        handles=[
            Patch(fc=shade(0.0), label="intact"),
            Patch(fc=shade(0.5), label="damage 0.5"),
            Patch(fc=shade(0.9), label="0.9"),
            Patch(fc=figures.BROKEN, label="failed"),
            Patch(fc=figures.GRAIN, ec=figures.GRAIN_EDGE, label="grain"),
        ],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.02),
        ncol=5,
        frameon=False,
        handlelength=1.0,
        columnspacing=1.2,
        fontsize=8,
    )


def curve(ax, bond, step, end):
    um = 1e6 * bond.opening
    done = bond.step <= step
    ax.plot(um, bond.tension, color=PALE, lw=1.2)
    ax.plot(um[done], bond.tension[done], color=figures.CURVE, lw=1.6)
    ax.plot([1e6 * bond.at(step, bond.opening)], [bond.at(step, "tension")], "o", color=figures.MARK, ms=6, zorder=5)
    ax.set_xlim(0.0, 1.04e6 * bond.at(end, bond.opening))
    ax.set_ylim(min(0.0, 1.1 * bond.tension.min()), 1.1 * bond.tension.max())
    ax.set_xlabel("opening of the gap (µm)", fontsize=8.5)
    ax.set_ylabel("tension (N)", fontsize=8.5)
    ax.tick_params(labelsize=8)
    state = "separated" if bond.at(step, "separated") >= 1.0 else f"{bond.at(step, 'failed'):.0f} points failed"
    ax.set_title(f"{round(bond.at(step, 'tension'))} N, {state}", loc="left", fontsize=8.5, pad=4)
