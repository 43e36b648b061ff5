# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Strength against content, a panel for each load; colour: shape, marker: failure mode."""
import numpy as np
from matplotlib.lines import Line2D

from .figures import plt, save

COLOURS = {"flat": "#1b2a49", "meniscus": "#2a8f7b", "coating": "#c8553d", "coating+meniscus": "#8a5fa8"}
MARKERS = {"debonding": "o", "internal": "s", "mixed": "D", "intact": "x"}
STYLES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))


def draw(path, rows):
    """rows: (run, results). Force over the cross-section of a bead, moment over that times its radius."""
    loads = list(dict.fromkeys(r.load for r, _ in rows))
    settings = list(dict.fromkeys(text_of(r) for r, _ in rows))
    across = min(len(loads), 3)
    down = -(-len(loads) // across)
    legend = 0.2 + 0.14 * max(len(settings), 4)
    fig, axes = plt.subplots(down, across, figsize=(max(2.6 * across, 4.2), 2.5 * down + legend), squeeze=False)
    for ax in axes.flat[len(loads):]:
        ax.set_visible(False)
    for ax, load in zip(axes.flat, loads):
        turned = load in ("torsion", "bending")
        for shape in COLOURS:
            for i, setting in enumerate(settings):
                points = sorted((r.content, res) for r, res in rows if (r.load, r.shape, text_of(r)) == (load, shape, setting))
                if not points:
                    continue
                x = np.array([100 * c for c, _ in points])
                y = np.array([res["stress_grain"] / (0.005 if turned else 1.0) / 1e3 for _, res in points])
                ax.plot(x, y, color=COLOURS[shape], ls=STYLES[i % len(STYLES)], lw=0.9, zorder=2)
                for a, b, (_, res) in zip(x, y, points):
                    ax.plot(a, b, MARKERS[res["mode"]], color=COLOURS[shape], ms=5, zorder=3,
                            mfc=COLOURS[shape] if res["mode"] == "debonding" else "none")
        ax.set_title(load, loc="left")
        low, high = (f(v for line in ax.get_lines() for v in line.get_ydata()) for f in (min, max))
        if high > 20 * low:
            ax.set_yscale("log")
        else:
            ax.set_ylim(0.0, 1.08 * high)
        ax.set_xlim(left=0.0)
        ax.set_xlabel("content (%)")
        ax.set_ylabel("peak moment / ($\\pi R^3$) (kPa)" if turned else "peak force / ($\\pi R^2$) (kPa)")
        ax.grid(True, which="both", lw=0.3, color="0.9")
    shapes = [s for s in COLOURS if any(r.shape == s for r, _ in rows)]
    modes = [m for m in MARKERS if any(res["mode"] == m for _, res in rows)]
    handles = [Line2D([], [], color=COLOURS[s], lw=1.5, label=s) for s in shapes]
    handles += [Line2D([], [], color="0.3", marker=MARKERS[m], ls="", ms=5, mfc="0.3" if m == "debonding" else "none", label=m)
                for m in modes]
    lines = [Line2D([], [], color="0.3", ls=STYLES[i % len(STYLES)], lw=0.9, label=s or "as in the script")
             for i, s in enumerate(settings)]
    fig.tight_layout(rect=(0, legend / fig.get_figheight(), 1, 1))
    fig.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.02, 0.005), ncol=2, frameon=False, columnspacing=1.0)
    if settings != [""]:
        fig.legend(handles=lines, loc="lower right", bbox_to_anchor=(0.99, 0.005), frameon=False, fontsize=6)
    save(fig, path)


def text_of(run):
    return ", ".join(f"{k} {v}" for k, v in sorted(run.extra.items()))
