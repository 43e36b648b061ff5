# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""The two figures, sized for print: force against displacement, damage on a cut."""
import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib import patheffects
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Patch

from . import run

CURVE, FAILED, DEBONDED, MARK = "#1b2a49", "#d98b4a", "#6aa69a", "#c1272d"
GRAIN, GRAIN_EDGE = "#ececec", "#707070"
BROKEN = "#e8172c"  # failed points; not a colour of the map
MAP = "viridis"
HALO = [patheffects.withStroke(linewidth=2.0, foreground="white")]
WIDTH = 7.48  # of the cuts, inches: a page of two columns
HALF_CUT = 1.4  # spacings: whole layers whether or not one lies on the plane
AROUND, ABOVE = np.radians(25.0), np.radians(12.0)  # direction in which packings are seen


styled = matplotlib.rc_context(  # of a function that returns a figure; the caller's own style stays as it is
    {
        "font.family": "DejaVu Sans",
        "font.size": 8,
        "axes.labelsize": 8,
        "axes.titlesize": 7.5,
        "legend.fontsize": 7,
        "xtick.labelsize": 7,
        "ytick.labelsize": 7,
        "axes.linewidth": 0.6,
        "lines.linewidth": 1.0,
        "xtick.direction": "in",
        "ytick.direction": "in",
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "mathtext.default": "regular",
    }
)


@styled
def force_displacement(bond, result, stages):
    fig, ax = plt.subplots(figsize=(5.2, 3.7))
    fig.subplots_adjust(left=0.12, right=0.88, bottom=0.115, top=0.835)
    counts = ax.twinx()
    ax.set_zorder(counts.get_zorder() + 1)
    ax.patch.set_visible(False)
    um = bond.way_scale * bond.opening
    peak = result.sense * result.peak
    handles = ax.plot(um, bond.tension, color=CURVE, label=bond.load_name)
    sheared = result.largest_force > 1.2 * result.peak
    if sheared:
        handles += ax.plot(um, bond.force, color=CURVE, lw=0.6, ls=(0, (4, 2)), label="whole force, with shear")
    if np.isfinite(result.stiffness):
        reach = bond.way_scale * 1.04 * peak / result.stiffness
        handles += ax.plot([0.0, reach], [0.0, 1.04 * peak], "--", color="0.5", lw=0.8, zorder=1, label="initial stiffness")
    if stages:
        at = np.array([(bond.way_scale * bond.at(s, bond.opening), bond.at(s, "tension")) for _, s, _ in stages])
        handles += ax.plot(at[:, 0], at[:, 1], "o", color="white", mec=CURVE, ms=4.5, mew=1.0, zorder=4, clip_on=False, label="stages of the cut")
    star = ax.plot(
        bond.way_scale * result.peak_opening,
        peak,
        "*",
        color=MARK,
        ms=8,
        zorder=5,
        mec="white",
        mew=0.4,
        clip_on=False,
        label=f"peak {run.number(result.peak)} {bond.load_unit}{' of compression' if result.sense < 0 else ''} at "
        f"{bond.way_scale * result.peak_opening:.3g} {bond.way_unit}",
    )
    handles += star
    if result.broken:
        handles.append(
            ax.axvline(
                bond.way_scale * result.failure_opening,
                color=MARK,
                lw=0.8,
                ls=":",
                zorder=1,
                label=f"{'separated' if result.separated else 'without load'} ({result.mode}) at {bond.way_scale * result.failure_opening:.3g} {bond.way_unit}",
            )
        )
    else:
        lowest = f" (mean ≥ {100 * result.lowest:.1f} % of the peak)" if np.isfinite(result.lowest) else ""
        handles += ax.plot([], [], " ", label="not separated" + lowest)
    handles += counts.plot(um, bond.failed, color=FAILED, lw=0.9, label="failed points")
    handles += counts.plot(um, bond.debonded, color=DEBONDED, lw=0.9, label="links debonded")

    # Every value is inside: nothing of tension, compression, opening or closing is cut off.
    high = max(bond.tension.max(), peak, result.largest_force if sheared else 0.0, 0.0)
    deep = min(bond.tension.min(), peak, 0.0)
    low, top = deep - (0.12 if deep < -0.25 * high else 0.04) * (high - deep), high + 0.12 * (high - deep)
    margin = 0.03 * max(np.ptp(um), 1e-9)
    ax.set_xlim(min(0.0, um.min() - margin * (um.min() < 0.0)), max(um.max() + margin, 0.0))
    ax.set_ylim(low, top)
    most = max(bond.failed.max(), bond.debonded.max(), 1.0) * 1.15
    counts.set_ylim(most * low / top if -low < top else -0.04 * most, most)
    counts.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(6, integer=True))
    counts.set_yticks([t for t in counts.get_yticks() if 0 <= t <= most])
    counts.tick_params(colors="0.45")
    counts.spines["right"].set_color("0.6")
    ax.axhline(0.0, color="0.75", lw=0.6, zorder=0)
    ax.set_xlabel(f"{bond.way_name} ({bond.way_unit})" + (", below zero: closing" if bond.lift is bond.opening and um.min() < 0.0 else ""))
    ax.set_ylabel(f"{bond.load_name} ({bond.load_unit})" + (", below zero: compression" if bond.load == "tension" and deep < -0.1 * high else ""))
    counts.set_ylabel("number of failed points, of links debonded", color="0.45")
    if stages:
        drawn = [h for h in handles if h.get_linestyle() != "None"]
        label_stages(ax, [s[0] for s in stages], at, drawn + star)
    ax.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.01), ncol=3, frameon=False, handlelength=1.6, columnspacing=1.4)
    return fig


def label_stages(ax, letters, at, lines):
    """Letters as near to their marks as no line, mark, border or other letter forbids."""
    per_point = ax.figure.dpi / 72.0
    size = np.array([13.0, 10.0]) * per_point
    frame = ax.get_window_extent()
    marks = ax.transData.transform(at)
    taken = [marks]
    for line in lines:
        x, y = line.get_data()
        fine = np.linspace(0, len(x) - 1, 12 * len(x))
        xy = np.column_stack([np.interp(fine, np.arange(len(x)), v) for v in (x, y)])
        taken.append(line.get_transform().transform(xy))
    taken = np.concatenate(taken)
    places = [r * per_point * np.array([np.cos(a), np.sin(a)]) for r in (12, 16, 20, 25, 30) for a in np.radians([30, -30, 60, 150, 90, -60, 210, 120, 270])]
    for letter, point, mark in zip(letters, at, marks):
        for place in [mark + p for p in places] + [mark + places[0]]:
            clear = (np.abs(taken - place) > 0.5 * size).any(axis=1).all()
            inside = (np.abs(place - (frame.p0 + frame.p1) / 2) < (frame.size - size) / 2).all()
            if clear and inside:
                break
        taken = np.vstack([taken, place + 0.5 * size * np.array([[0, 0], [-1, -1], [1, -1], [1, 1], [-1, 1]])])
        ax.annotate(f"({letter})", point, xytext=(place - mark) / per_point, textcoords="offset points", ha="center", va="center", zorder=6, path_effects=HALO)


@styled
def damage_cut(bond, result, stages, radius, spacing):
    """The lower grain fixed, the upper one displaced by the opening of the gap; line of centres on z."""
    cuts = [cut(run.read_dump(p), p, spacing, bond.number) for _, _, p in stages]
    mm = 1e3
    wide = 1.06 * mm * np.percentile(np.abs(np.concatenate([c["x"] for c in cuts])), 99.9)
    high = 1.35 * mm * np.percentile(np.abs(np.concatenate([c["z"] for c in cuts])), 99.9)
    n = len(stages)
    left, right, between, below, above = 0.44, 0.06, 0.10, 0.84, 0.33  # inches
    panel_w = min((WIDTH - left - right - (n - 1) * between) / n, 3.4)
    panel_h = panel_w * high / wide
    width, height = left + n * panel_w + (n - 1) * between + right, below + panel_h + above
    fig = plt.figure(figsize=(width, height))
    for i, ((letter, step, _), points) in enumerate(zip(stages, cuts)):
        ax = fig.add_axes([(left + i * (panel_w + between)) / width, below / height, panel_w / width, panel_h / height])
        opening = bond.at(step, bond.opening)
        outlines(ax, radius * mm, bond.gap[0] * mm, bond.at(step, bond.lift) * mm)
        colours = squares(ax, points, 0.52 * spacing * mm)
        tension = bond.at(step, "tension")
        ax.set_title(
            f"({letter}) {bond.way_name.split()[-1]} {bond.way_scale * opening:.3g} {bond.way_unit}\n"
            f"{run.number(tension)} {bond.load_unit}, "
            f"{100 * result.sense * tension / result.peak:.0f} % of peak",
            loc="left",
            pad=3,
            linespacing=1.15,
        )
        ax.set_xlim(-wide, wide)
        ax.set_ylim(-high, high)
        ax.set_aspect("equal")
        ax.xaxis.set_major_locator(matplotlib.ticker.MaxNLocator(5, steps=[1, 2, 5, 10]))
        ax.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(3, steps=[1, 2, 5, 10]))
        ax.set_xlabel("x (mm)", labelpad=1)
        if i:
            ax.tick_params(labelleft=False)
        else:
            ax.set_ylabel("z (mm)", labelpad=1)
    bar_w, legend_w = min(2.6, 0.4 * width), 2.0
    start = max(0.5 * (width - bar_w - legend_w), 0.2)
    bar = fig.add_axes([start / width, 0.32 / height, bar_w / width, 0.09 / height])
    fig.colorbar(colours, cax=bar, orientation="horizontal", ticks=np.linspace(0, 1, 6))
    bar.set_xlabel("largest damage (–)", labelpad=1)
    fig.legend(
        handles=[Patch(fc=BROKEN, label="failed points"), Patch(fc=GRAIN, ec=GRAIN_EDGE, label="grains")],
        loc="center left",
        bbox_to_anchor=((start + bar_w + 0.15) / width, 0.37 / height),
        ncol=2,
        frameon=False,
    )
    return fig


def cut(points, path, spacing, number):
    keep = np.abs(points["y"]) < HALF_CUT * spacing
    if "c_bond" in points:
        keep &= points["c_bond"] == number
    if not keep.any():
        raise run.Trouble(
            f"{path}: no points within {HALF_CUT:g} spacings of the plane y = 0; the cut needs "
            "the line of centres on the z axis (or another --spacing), else use '--points none'"
        )
    order = np.argsort(points["c_damage"][keep] + points["c_failed"][keep], kind="stable")
    return {c: points[c][keep][order] for c in run.DUMP_COLUMNS}


def outlines(ax, radius, gap, opening):
    for z in (-radius - 0.5 * gap, radius + 0.5 * gap + opening):
        ax.add_patch(Circle((0.0, z), radius, fc=GRAIN, ec=GRAIN_EDGE, lw=0.6, zorder=1))


def squares(ax, points, half):
    """One square a point, a little larger than its share of the bond so that no seams show."""
    centre = 1e3 * np.column_stack([points["x"], points["z"]])
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    failed = points["c_failed"] > 0.5
    sound = PolyCollection(
        centre[~failed, None] + corners, array=points["c_damage"][~failed], cmap=MAP, norm=plt.Normalize(0.0, 1.0), lw=0, antialiased=False, zorder=2
    )
    ax.add_collection(sound)
    ax.add_collection(PolyCollection(centre[failed, None] + corners, fc=BROKEN, lw=0, antialiased=False, zorder=3))
    return sound


def view(xyz):
    """Places as a packing is seen: to the right, upward, away."""
    right = np.array([np.cos(AROUND), np.sin(AROUND), 0.0])
    away = np.array([-np.sin(AROUND) * np.cos(ABOVE), np.cos(AROUND) * np.cos(ABOVE), -np.sin(ABOVE)])
    return xyz @ np.array([right, np.cross(right, away), away]).T


@styled
def save(fig, path, dpi=600):
    """Writes a figure and closes it."""
    try:
        fig.savefig(path, dpi=dpi)
    except OSError as e:
        raise run.Trouble(f"{path}: {e.strerror}; name a folder that can be written") from None
    plt.close(fig)
