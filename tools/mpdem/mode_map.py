# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Map of failure modes over content and strength of the interface: a panel for each shape and load.

The strength of the interface is `tn` of `bonding cohesive ...` over the tensile strength of the cement. A mark a run:
its form is the mode, its colour the share of the fracture surface that lies at a grain. Where the runs of a panel
have several energies of the interface, the marks of one content stand side by side, the largest energy first.
Above the panels stands the mode that Ham et al. (2022) saw on pairs of glass beads, by content.
"""
import math

import numpy as np
from matplotlib.lines import Line2D

from .figures import plt, styled
from .table_figure import HAM_COLOUR, MODES, SHAPES

MODULUS = 28.79e9  # Pa, along the axis of the elasticity of examples/pair_table
BESIDE = 0.28  # steps of the axis of contents between two energies
# contents in %, above the first and up to the second, what was seen; as the abstract of Ham et al. (2022) has it: mixed from 11 %
HAM_MODES = ((0.0, 10.9, "debonding"), (10.9, 17.0, "debonding,\nmixed"), (17.0, 100.0, "internal,\nmixed"))


def cement_strength(B0):
    """Tensile strength along the axis at the onset of damage: B0 = ft^2/(sqrt(2) E)."""
    return math.sqrt(math.sqrt(2.0) * B0 * MODULUS)


def law(run):
    """(strength over that of the cement, energy in J/m2) of a cohesive interface, else None."""
    words = str(run.extra.get("bonding", "penalty")).split()
    if words[0] != "cohesive":
        return None
    value = {k: float(v) for k, v in zip(words[1::2], words[2::2])}
    return value["tn"] / cement_strength(float(run.extra.get("B0", 9.6e3))), value["Gn"]


def wanted(rows):
    """Is there a map to draw: do the runs differ in the strength of their interface?"""
    return len({found[0] for found in (law(r) for r, _ in rows) if found}) > 1


@styled
def figure(rows):
    """rows: (run, results) as `table.write` gives them; those without a cohesive interface are left out."""
    rows = [(r, res, law(r)) for r, res in rows if law(r)]
    shapes = [s for s in SHAPES if any(r.shape == s for r, _, _ in rows)]
    loads = list(dict.fromkeys(r.load for r, _, _ in rows))
    contents = sorted({r.content for r, _, _ in rows})
    energies = sorted({found[1] for _, _, found in rows}, reverse=True)
    at = {c: i for i, c in enumerate(contents)}
    fig, axes = plt.subplots(len(shapes), len(loads), figsize=(3.4 * len(loads) + 0.4, 2.9 * len(shapes) + 0.6), squeeze=False, sharex=True, sharey=True)
    for row, shape in zip(axes, shapes):
        for ax, load in zip(row, loads):
            marks = panel(ax, [x for x in rows if (x[0].shape, x[0].load) == (shape, load)], at, energies)
            seen_by_ham(ax, contents, load in ("tension", "shear"))
            ax.set_title(f"{SHAPES[shape][0]}, {load}", loc="left", pad=20)
    for ax in axes[-1]:
        ax.set_xticks(range(len(contents)), [f"{100 * c:g}" for c in contents])
        ax.set_xlabel("calcite content, mass over mass of the beads (%)")
    for row in axes:
        row[0].set_ylabel("strength of the interface\nover that of the cement")
    columns = 3 if len(loads) > 1 else 1
    bottom, right = (0.5 if columns > 1 else 1.0) / fig.get_figheight(), 1.0 - 0.72 / fig.get_figwidth()  # for the legend, and the bar of colours
    fig.tight_layout(rect=(0, bottom, right, 1))
    colours = fig.colorbar(marks, cax=fig.add_axes((right + 0.015, bottom + 0.12, 0.11 / fig.get_figwidth(), 0.7 - bottom)))
    colours.set_label("share of the fracture surface at a bead")
    handles = [Line2D([], [], color="0.3", marker=m, ls="", ms=5, label=text) for text, m in MODES.values()]
    handles.append(Line2D([], [], color=HAM_COLOUR, lw=3, alpha=0.7, label="mode seen by Ham et al. (2022)"))
    if len(energies) > 1:
        handles.append(Line2D([], [], ls="", label="side by side: energy of the interface " + ", ".join(f"{e:g}" for e in energies) + " J/m²"))
    fig.legend(handles=handles, loc="lower left", ncol=columns, frameon=False, bbox_to_anchor=(0.02, 0.0))
    return fig


def panel(ax, rows, at, energies):
    marks = ax.scatter([], [], c=[], cmap="viridis", vmin=0.0, vmax=1.0)
    for mode, (_, form) in MODES.items():
        found = [
            (at[r.content] + BESIDE * (energies.index(e) - 0.5 * (len(energies) - 1)), strength, res) for r, res, (strength, e) in rows if res["mode"] == mode
        ]
        if not found:
            continue
        x, y, results = zip(*found)
        if mode == "intact":
            ax.plot(x, y, form, color="0.3", ms=5)
        else:
            share = np.array([float(res["share_grain1"]) + float(res["share_grain2"]) for res in results])
            ax.scatter(x, y, c=share, marker=form, s=26, cmap="viridis", vmin=0.0, vmax=1.0, edgecolors="0.3", linewidths=0.4)
    ax.set_yscale("log")
    ax.yaxis.set_major_formatter("{x:g}")
    strengths = [strength for _, _, (strength, _) in rows]
    if strengths and max(strengths) < 10.0 * min(strengths):  # less than a decade: few of its ticks are major ones
        ax.yaxis.set_minor_formatter("{x:g}")
    ax.set_xlim(-0.6, len(at) - 0.4)
    ax.set_axisbelow(True)
    ax.grid(True, axis="y", which="both", lw=0.3, color="0.9")
    return marks


def seen_by_ham(ax, contents, loaded_so):
    """A bar above the panel, over the contents at which each mode was seen."""
    if not loaded_so:
        return
    for low, high, words in HAM_MODES:
        inside = [i for i, c in enumerate(contents) if low < 100 * c <= high]
        if inside:
            left, right = inside[0] - 0.45, inside[-1] + 0.45
            ax.plot([left, right], [1.02, 1.02], color=HAM_COLOUR, lw=3, alpha=0.7, transform=ax.get_xaxis_transform(), clip_on=False)
            ax.annotate(
                words,
                (0.5 * (left + right), 1.035),
                xycoords=ax.get_xaxis_transform(),
                color=HAM_COLOUR,
                fontsize=6,
                linespacing=0.95,
                ha="center",
                va="bottom",
                annotation_clip=False,
            )
