# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Frames of a bond that breaks: the cut with displacements drawn larger than they are, and the curve as far as it has come."""
import os
import shutil
import subprocess

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Patch

from . import figures, run

SIZE, DPI = (7.2, 2.75), 110  # inches, pixels an inch
PALE = "#b9c2d0"
COLOURS = 48  # of the palette of a GIF, that of the last frame: it has all of them


def choose(bond, steps, frames, until):
    """Steps that lie evenly along the curve of tension against opening, up to `until` times the opening at separation."""
    opening, tension = (np.interp(steps, bond.step, v) for v in (bond.opening, bond.tension))
    separated = np.flatnonzero(bond.separated > 0)
    end = until * bond.opening[separated[0]] if len(separated) else opening[-1]
    kept = np.flatnonzero(opening <= end)
    return [steps[kept[i]] for i in evenly(opening[kept], tension[kept], frames)]


def evenly(x, y, frames):
    """Indices of at most so many points that lie evenly along a curve."""
    way = np.hypot(np.diff(x) / max(np.ptp(x), 1e-30), np.diff(y) / max(np.ptp(y), 1e-30))
    along = np.concatenate([[0.0], np.cumsum(way)])
    return sorted({int(np.argmin(np.abs(along - a))) for a in np.linspace(0.0, along[-1], frames)})


def draw(bond, dumps, radius, magnify):
    """An array of pixels (height, width, 3) for each of the dumps."""
    first = run.read_dump(dumps[min(dumps)])
    if "id" not in first:
        raise run.Trouble(f"{dumps[min(dumps)]}: no column id; displacements need it, write it with 'dump ID group custom N cut_NAME.*.txt id x y z ...'")
    order = np.argsort(first["id"])
    start = np.column_stack([first[c][order] for c in "xyz"])
    sliced = np.abs(start[:, 1]) < figures.HALF_CUT * run.spacing(first)
    if not sliced.any():
        raise run.Trouble(f"{dumps[min(dumps)]}: no points near the plane y = 0; the cut needs the line of centres on the z axis")
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
        frame = {c: v[sliced] for c, v in frame.items()}
        pictures.append(picture(bond, step, max(dumps), frame, start[sliced], half, radius, magnify))
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
    aside = magnify * bond.at(step, bond.opening) if bond.load == "shear" else 0.0
    for x, z in ((0.0, -radius - 0.5 * bond.gap[0]), (aside, radius + 0.5 * bond.gap[0] + lift)):
        ax.add_patch(Circle((mm * x, mm * z), mm * radius, fc=figures.GRAIN, ec=figures.GRAIN_EDGE, lw=0.8, zorder=1))
    corners = mm * half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    centre = mm * np.column_stack([frame["x"], frame["z"]])
    failed = frame["c_failed"] > 0.5
    shades = plt.get_cmap(figures.MAP)(np.round(frame["c_damage"][~failed] * 16) / 16)  # few colours keep the file small
    ax.add_collection(PolyCollection(centre[~failed, None] + corners, fc=shades, lw=0, antialiased=False, zorder=2))
    ax.add_collection(PolyCollection(centre[failed, None] + corners, fc=figures.BROKEN, lw=0, antialiased=False, zorder=3))
    wide, high = 1.1 * mm * abs(start[:, 0]).max(), 1.15 * mm * abs(start[:, 2]).max()
    ax.set_xlim((-wide if bond.load == "shear" else -0.1 * wide), wide)  # of tension half of the cut, from the line of centres
    ax.set_ylim(-high, 1.3 * high)
    ax.set_aspect("equal")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.set_title(f"{'a' if bond.load == 'shear' else 'half of a'} cut through the bond, displacements drawn x {magnify:g}", loc="left", fontsize=8.5, pad=4)
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
    x = bond.way_scale * bond.opening
    done = bond.step <= step
    ax.plot(x, bond.tension, color=PALE, lw=1.2)
    ax.plot(x[done], bond.tension[done], color=figures.CURVE, lw=1.6)
    ax.plot([bond.way_scale * bond.at(step, bond.opening)], [bond.at(step, "tension")], "o", color=figures.MARK, ms=6, zorder=5)
    ax.set_xlim(0.0, 1.04 * bond.way_scale * bond.at(end, bond.opening))
    ax.set_ylim(min(0.0, 1.1 * bond.tension.min()), 1.1 * bond.tension.max())
    ax.set_xlabel(f"{'opening of the gap' if bond.way_name == 'gap opening' else bond.way_name} ({bond.way_unit})", fontsize=8.5)
    ax.set_ylabel(f"{bond.load_name} ({bond.load_unit})", fontsize=8.5)
    ax.tick_params(labelsize=8)
    state = "separated" if bond.at(step, "separated") >= 1.0 else f"{bond.at(step, 'failed'):.0f} points failed"
    ax.set_title(f"{run.number(bond.at(step, 'tension'))} {bond.load_unit}, {state}", loc="left", fontsize=8.5, pad=4)


def write(pictures, path, duration, last):
    """Frames, arrays of pixels, as a GIF or, with ffmpeg, as MP4 or WebM. duration: ms of a frame; last: ms that the last one stays."""
    kind = os.path.splitext(path)[1].lower()
    try:
        if kind == ".gif":
            _write_gif(pictures, path, duration, last)
        elif kind in (".mp4", ".webm"):
            _write_film(pictures, path, duration, last)
        else:
            raise run.Trouble(f"{path}: must end in .gif, .mp4 or .webm")
    except OSError as e:
        raise run.Trouble(f"{path}: {e.strerror}; name a file in a folder that can be written") from None


def _write_gif(pictures, path, duration, last):
    from PIL import Image

    frames = [Image.fromarray(p) for p in pictures]
    palette = frames[-1].quantize(COLOURS, dither=Image.Dither.NONE)
    frames = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=[duration] * (len(frames) - 1) + [last], loop=0, optimize=True)


def _write_film(pictures, path, duration, last):
    if not shutil.which("ffmpeg"):
        raise run.Trouble(f"{path}: needs ffmpeg; apt-get install ffmpeg, or name a .gif")
    high, wide = (n - n % 2 for n in pictures[0].shape[:2])  # codecs want even numbers
    words = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{wide}x{high}", "-r", f"{1000 / duration:g}", "-i", "-"]
    words += ["-pix_fmt", "yuv420p", *(["-c:v", "libx264", "-crf", "20"] if path.endswith("mp4") else ["-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0"]), path]
    frames = [*pictures, *[pictures[-1]] * (last // duration)]
    done = subprocess.run(words, input=b"".join(np.ascontiguousarray(p[:high, :wide]).tobytes() for p in frames), capture_output=True)
    if done.returncode:
        raise run.Trouble(f"{path}: ffmpeg: {' '.join(done.stderr.decode(errors='replace').split())[-300:]}")
