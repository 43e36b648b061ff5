# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Strength against content, a panel for each load; colour: shape, marker: failure mode.

Beside tension and shear stand the strengths that Ham et al. (2022) measured on pairs of glass beads cemented by
calcite: J. Geotech. Geoenviron. Eng. 148 (9), as its abstract gives them. The abstract does not name the area that
its kPa refer to; the curves refer to the cross-section of a bead.
"""
import csv
from types import SimpleNamespace

import numpy as np
from matplotlib.lines import Line2D

from . import run as files
from .figures import plt, styled

SHAPES = {
    "flat": ("flat ring", "#1b2a49"),
    "meniscus": ("meniscus", "#2a8f7b"),
    "coating": ("coating", "#c8553d"),
    "coating+meniscus": ("coating and meniscus", "#8a5fa8"),
    "file": ("points of a file", "#6b6b6b"),
}
MODES = {
    "debonding": ("debonding from a bead", "o"),
    "internal": ("inside the cement", "s"),
    "mixed": ("mixed", "D"),
    "intact": ("not separated at the end", "x"),
}
STYLES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)))
HAM_CONTENT = 17.0  # %: debonding below, internal failure above
HAM = {"tension": (35.0, 8.0), "shear": (13.0, 7.0)}  # kPa, below and above
HAM_COLOUR = "#b8860b"


def metres(value):
    return f"{1e3 * float(value):.3g} mm"


# What a variable of the run is called in a legend, in the order in which they are told. None: not told.
def softening(words):
    """The value of `regularization`."""
    how, *numbers = words.split()
    if how == "none":
        return "local law"
    energy = f"crack energy {numbers[-1]} J/m²"
    if how == "crackband":
        return energy
    return f"strain averaged over {metres(numbers[0])}" + (f", {energy}" if "energy" in numbers else "")


def bonding(words):
    """The value of `bonding`."""
    if words == "penalty":
        return None
    _, *pairs = words.split()
    value = dict(zip(pairs[::2], pairs[1::2]))
    return f"interface of {float(value['tn']) / 1e6:.3g} and {float(value['tt']) / 1e6:.3g} MPa, " f"{value['Gn']} and {value['Gt']} J/m² in opening and shear"


WORDS = {
    "points": lambda v: v.rsplit("/", 1)[-1],
    "regularization": softening,
    "cracks": lambda v: "nodes split at cracks" if v == "split" else "nodes split where bonds part",
    "interface": lambda v: f"threshold at the beads {v} of that inside",
    "bonding": bonding,
    "B0": lambda v: f"threshold {float(v) / 1e3:.4g} kPa",
    "cutoff": lambda v: f"failure at damage {v}",
    "zeta": lambda v: f"tensile over compressive strength {v}",
    "axis": lambda v: f"elastic axis {v}",
    "edge": lambda v: f"edge nodes {v}",
    "share": lambda v: f"{100 * float(v):.3g} % of the cement in the coating",
    "cap": lambda v: f"coating up to {v}°",
    "gap": lambda v: f"beads {metres(v)} apart",
    "diameter": lambda v: f"upper bead of {metres(v)}",
    "inner": lambda v: None if v == "auto" else f"no cement within {metres(v)}",
    "coarse": lambda v: f"spacing {metres(v)}",
    "spacing": lambda v: f"spacing {metres(v)}",
    "refine": lambda v: None if float(v) == 1 else f"spacing divided by {v}",
    "layers": lambda v: f"{v} layers of points in a shell",
    "percell": lambda v: f"{v} spacings a cell",
    "grid": lambda v: "grid off by " + ", ".join(metres(x) for x in v.split()),
    "courant": lambda v: f"step {v} of cell over wave speed",
    "speed": lambda v: f"{1e3 * float(v):.4g} mm/s",
    "ramp": lambda v: f"speed reached in {1e6 * float(v):.3g} µs",
    "rate": lambda v: f"{1e-6 * float(v):.3g} N/µs",
    "arm": lambda v: f"arm {metres(v)}",
    "angle": lambda v: f"{v}° from the line of centres",
}


def text_of(run):
    """The settings of a run, in words with units."""
    known = {"regularization": "none", **{k: str(v) for k, v in run.extra.items()}}
    return ", ".join(t for t in (WORDS[k](known[k]) for k in WORDS if k in known) if t)


def read(path):
    """Rows of a table.csv as `draw` takes them."""
    try:
        with open(path, newline="") as f:
            rows = list(csv.DictReader(f))
        if not rows:
            raise ValueError("it has no rows")
        return [
            (
                SimpleNamespace(
                    shape=r["shape"], load=r["load"], content=float(r["content"]), extra=dict(w.replace(":", " ").split("=") for w in r["parameters"].split())
                ),
                {
                    "stress_grain": float(r["stress_grain"]),
                    "mode": r["mode"],
                    "share_grain1": float(r["share_grain1"]),
                    "share_grain2": float(r["share_grain2"]),
                },
            )
            for r in rows
        ]
    except (KeyError, ValueError, TypeError, AttributeError, csv.Error) as e:
        raise files.Trouble(f"{path}: not a table.csv of pair_table.py ({e}); name one") from None


@styled
def draw(rows):
    """rows: (run, results). Force over the cross-section of a bead, moment over that times its radius."""
    loads = list(dict.fromkeys(r.load for r, _ in rows))
    settings = list(dict.fromkeys(text_of(r) for r, _ in rows))
    shapes = [s for s in SHAPES if any(r.shape == s for r, _ in rows)]
    modes = [m for m in MODES if any(res["mode"] == m for _, res in rows)]
    across = min(len(loads), 3)
    down = -(-len(loads) // across)
    measured = any(load in HAM for load in loads)
    keys, line = -(-(len(shapes) + len(modes) + measured) // 2), 0.15  # lines of the first legend, inches a line
    beside = across > 1  # the second legend stands beside the first, else above it
    legend = 0.2 + line * (max(keys, len(settings)) if beside else keys + len(settings) + 1)
    fig, axes = plt.subplots(down, across, figsize=(max(3.3 * across, 4.2), 2.8 * down + legend), squeeze=False)
    for ax in axes.flat[len(loads) :]:
        ax.set_visible(False)
    for ax, load in zip(axes.flat, loads):
        panel(ax, load, [(r, res) for r, res in rows if r.load == load], settings)
    fig.tight_layout(rect=(0, legend / fig.get_figheight(), 1, 1))
    handles = [Line2D([], [], color=SHAPES[s][1], lw=1.5, label=SHAPES[s][0]) for s in shapes]
    handles += [Line2D([], [], color="0.3", marker=MODES[m][1], ls="", ms=5, mfc="0.3" if m == "debonding" else "none", label=MODES[m][0]) for m in modes]
    if measured:
        handles.append(Line2D([], [], color=HAM_COLOUR, lw=3, alpha=0.7, label="measured, Ham et al. (2022)"))
    kinds = [Line2D([], [], color="0.3", ls=STYLES[i % len(STYLES)], lw=0.9, label=s) for i, s in enumerate(settings)]
    fig.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.02, 0.005), ncol=2, frameon=False, columnspacing=1.0)
    place = (
        dict(loc="lower right", bbox_to_anchor=(0.99, 0.005))
        if beside
        else dict(loc="lower left", bbox_to_anchor=(0.02, 0.005 + line * (keys + 0.5) / fig.get_figheight()))
    )
    fig.legend(handles=kinds, frameon=False, **place)
    return fig


def panel(ax, load, rows, settings):
    turned = load in ("torsion", "bending")
    for shape, (_, colour) in SHAPES.items():
        for i, setting in enumerate(settings):
            points = sorted(((r.content, res) for r, res in rows if (r.shape, text_of(r)) == (shape, setting)), key=lambda p: p[0])
            if not points:
                continue
            x = np.array([100 * c for c, _ in points])
            y = np.array([res["stress_grain"] / (0.005 if turned else 1.0) / 1e3 for _, res in points])
            ax.plot(x, y, color=colour, ls=STYLES[i % len(STYLES)], lw=0.9, zorder=2)
            for a, b, (_, res) in zip(x, y, points):
                ax.plot(a, b, MODES[res["mode"]][1], color=colour, ms=5, zorder=3, mfc=colour if res["mode"] == "debonding" else "none")
    right = max(1.05 * max(100 * r.content for r, _ in rows), 1.5 * HAM_CONTENT if load in HAM else 0.0)
    if load in HAM:
        under, above = HAM[load]
        style = dict(color=HAM_COLOUR, lw=3, alpha=0.7, zorder=1, solid_capstyle="butt")
        ax.plot([0.0, HAM_CONTENT], [under, under], **style)
        ax.plot([HAM_CONTENT, right], [above, above], **style)
        words = dict(color=HAM_COLOUR, fontsize=6.5, ha="center", va="bottom", xytext=(0, 3), textcoords="offset points")
        ax.annotate(f"mostly debonding, {under:g} kPa", (0.5 * HAM_CONTENT, under), **words)
        ax.annotate(f"internal, {above:g} kPa", (0.5 * (HAM_CONTENT + right), above), **words)
    low, high = (f(v for line in ax.get_lines() for v in line.get_ydata()) for f in (min, max))
    if high > 20 * low:
        ax.set_yscale("log")
    else:
        ax.set_ylim(0.0, 1.08 * high)
    ax.set_xlim(0.0, right)
    ax.set_title(load, loc="left")
    ax.set_xlabel("calcite content, mass over mass of the beads (%)")
    ax.set_ylabel("peak moment over cross-section\nand radius of a bead (kPa)" if turned else "peak force over cross-section of a bead (kPa)")
    ax.grid(True, which="both", lw=0.3, color="0.9")
