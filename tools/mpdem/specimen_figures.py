# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Figures of a loaded specimen: curves, energy, resolved bonds, strengths, bonds in space, rose of the broken ones."""
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.lines import Line2D

from .figures import plt, styled, view
from .specimen import before_failure

PALETTE = ("#1b2a49", "#2a8f7b", "#c8553d", "#8a5fa8", "#b8860b", "#4c78a8")
MODES = {"debonding": ("debonding from a bead", "#c1272d"), "mixed": ("mixed", "#8a5fa8"), "internal": ("inside the cement", "#1f6fb4")}
WHOLE, DAMAGED = ("untouched", "#b9bec7"), ("damaged, holds", "#e39a1f")
TITLES = {"compression": "unconfined compression", "tension": "direct tension"}


def name_of(load):
    words = f"{100 * load.of_all:.3g} % calcite" if load.of_all else "no cement"
    return words + (f", {1e-6 * load.pressure:.3g} MPa on the sides" if load.pressure else "")


def title_of(load):
    return ("triaxial compression" if load.pressure else TITLES[load.test]) + f", {name_of(load)}"


def groups(items, reference):
    """(title, items): unconfined, tension, the confined ones beside the unconfined one of their content."""
    plain = [i for i in items if i[0].test == "compression" and not i[0].pressure]
    pulled = [i for i in items if i[0].test == "tension"]
    confined = [i for i in items if i[0].pressure or i in plain and i[0].content == reference]
    found = [("unconfined compression", plain), ("direct tension", pulled)]
    of_all = next((i[0].of_all for i in confined), 0.0)
    return found + ([(f"triaxial compression, {100 * of_all:.3g} % calcite", confined)] if any(i[0].pressure for i in confined) else [])


@styled
def curves(items, reference):
    """items: (load, results, curve). Above stress, below bonds broken, a column a kind of test."""
    kinds = [g for g in groups(items, reference) if g[1]]
    fig, axes = plt.subplots(2, len(kinds), figsize=(2.75 * len(kinds) + 0.2, 4.0), squeeze=False, sharex="col", gridspec_kw={"height_ratios": (2.2, 1)})
    for (upper, lower), (title, members) in zip(axes.T, kinds):
        for colour, (load, r, c) in zip(PALETTE, members):
            x, label = 1e3 * c.strain, (f"{1e-6 * load.pressure:.3g} MPa" if title.startswith("triaxial") else name_of(load))
            upper.plot(x, 1e-6 * (c.stress - load.pressure), color=colour, label=label)
            upper.plot(x[c.peak], 1e-6 * (c.stress[c.peak] - load.pressure), "o", color=colour, ms=3.5)
            lower.plot(x, c.table["broken"], color=colour)
        upper.set_title(title, loc="left")
        upper.legend(frameon=False, title="on the sides" if title.startswith("triaxial") else None, title_fontsize=7)
        for ax in (upper, lower):
            ax.set_ylim(0.0, None)
            ax.set_xlim(0.0, None)
            ax.grid(True, lw=0.3, color="0.9")
        lower.set_xlabel("axial strain (‰)")
        upper.set_ylabel("axial stress less that on the sides (MPa)" if title.startswith("triaxial") else "axial stress (MPa)")
        lower.set_ylabel("bonds broken")
    fig.tight_layout()
    return fig


@styled
def pressures(items):
    """The pressure of the sides, a mean of each row of the curve, over the strain from where the plate moves; dashed: what was asked for."""
    fig, ax = plt.subplots(figsize=(4.6, 2.7))
    for colour, (load, r, c) in zip(PALETTE, items):
        of_side = 1e-3 / (np.sqrt(c.section) * c.height)
        ax.axhline(1e-3 * load.pressure, color="0.5", lw=0.6, ls="--")
        ax.plot(1e3 * c.strain[1:], of_side * c.table["sideways"][1:], color=colour, lw=0.8, label=name_of(load))
        ax.axvline(1e3 * c.strain[c.peak], color=colour, lw=0.6, ls=":")
    ax.set_xlabel("axial strain (‰); dotted: peak of the load")
    ax.set_ylabel("pressure of the sides (kPa)")
    ax.set_xlim(0.0, None)
    ax.set_ylim(0.0, 1.7e-3 * max(load.pressure for load, _, _ in items))
    ax.legend(frameon=False, loc="lower right")
    ax.grid(True, lw=0.3, color="0.9")
    fig.tight_layout()
    return fig


@styled
def awake(items):
    """Resolved bonds over time, and the kinetic share of the energy."""
    fig, axes = plt.subplots(1, 2, figsize=(7.48, 2.9))
    for n, (load, r, c) in enumerate(items):
        style = {"color": PALETTE[n % len(PALETTE)], "ls": ("-", "--", ":")[n // len(PALETTE) % 3], "label": title_of(load)}
        axes[0].plot(1e3 * c.time, c.table["awake"], **style)
        axes[0].plot(1e3 * c.time[c.peak], c.table["awake"][c.peak], "o", color=style["color"], ms=3)
        before = slice(1, c.peak + 1)
        axes[1].semilogy(c.stress[before] / c.stress[c.peak], c.kinetic_share[before], **style)
        fails = int(np.argmax(c.table["failed"] > 0))
        if 0 < fails < c.peak:
            axes[1].plot(c.stress[fails] / c.stress[c.peak], c.kinetic_share[fails], "o", color=style["color"], ms=3)
    axes[0].axhline(items[0][1]["bonds"], color="0.5", lw=0.6, ls="--")
    axes[0].set_xlabel("time (ms); dots: peak of the load")
    axes[0].set_ylabel(f"awake bonds, of {items[0][1]['bonds']}")
    axes[1].axhline(1e-3, color="0.5", lw=0.6, ls="--")
    axes[1].set_xlabel("axial stress over its peak; dots: first failure")
    axes[1].set_ylabel("kinetic share of the energy")
    for ax in axes:
        ax.set_xlim(0.0, None)
    axes[0].set_ylim(0.0, None)
    fig.tight_layout(rect=(0, 0.16 + 0.045 * (len(items) // 4), 1, 1))
    fig.legend(*axes[0].get_legend_handles_labels(), loc="lower center", ncol=3, frameon=False, fontsize=6)
    return fig


@styled
def energy(load, c):
    """Where the work of walls and grips went."""
    t = c.table
    parts = (
        ("stored in the cement and its links", c.stored, "#1f6fb4"),
        ("dissipated by damage", t["dissipated"], "#c1272d"),
        ("released by points that failed", t["released"], "#e39a1f"),
        ("taken by dampers in the cement", t["damped"], "#8a5fa8"),
        ("kinetic, beads and cement", c.kinetic - c.kinetic[0], "#2a8f7b"),
        ("contacts: springs", c.springs - c.springs[0], "#9aa0a8"),
        ("contacts: friction, dashpots", c.rubbed, "#5b6169"),
    )
    fig, ax = plt.subplots(figsize=(5.2, 3.3))
    x, low = 1e3 * c.strain, np.zeros(len(c.strain))
    for label, value, colour in parts:
        ax.fill_between(x, 1e3 * low, 1e3 * (low + value), color=colour, alpha=0.85, lw=0, label=label)
        low = low + value
    ax.plot(x, 1e3 * (c.work - c.work[0] + c.stored[0]), color="k", lw=0.9, label="work of walls and grips")
    ax.axvline(x[c.peak], color="0.4", lw=0.6, ls=":")
    ax.set_xlim(0.0, x[-1])
    ax.set_ylim(0.0, None)
    ax.set_xlabel("axial strain (‰); dotted: peak of the load")
    ax.set_ylabel("energy (mJ)")
    ax.set_title(title_of(load), loc="left")
    ax.legend(frameon=False, fontsize=6.5, loc="upper left")
    fig.tight_layout()
    return fig


@styled
def strengths(items, reference, line):
    """Stiffness and strengths over content; circles of Mohr of one content."""
    fig, axes = plt.subplots(1, 3, figsize=(7.48, 2.7), gridspec_kw={"width_ratios": (1, 1, 1.5)})
    hollow = False
    for test, colour, label in (("compression", PALETTE[0], "compression"), ("tension", PALETTE[2], "tension")):
        rows = sorted(((load.content, r) for load, r, _ in items if load.test == test and not load.pressure), key=lambda row: row[0])
        if not rows:
            continue
        x = [100 * r["content_of_all"] for _, r in rows]
        axes[0].plot(x, [1e-9 * r["stiffness"] for _, r in rows], "o-", color=colour, ms=4, label=label)
        early = [(content, r) for content, r in rows if before_failure(r)]
        axes[0].plot([100 * r["content_of_all"] for _, r in early], [1e-9 * r["stiffness"] for _, r in early], "o", color=colour, mfc="white", ms=4)
        hollow = hollow or bool(early)
        axes[1].plot(x, [1e-6 * r["strength"] for _, r in rows], "o-", color=colour, ms=4, label=label)
    axes[0].set_ylabel("stiffness (GPa)")
    axes[1].set_ylabel("strength (MPa)")
    for ax in axes[:2]:
        ax.set_xlabel("calcite of the beads (%)" + ("\nhollow: before an early failure" if hollow and ax is axes[0] else ""))
        ax.set_xlim(0.0, None)
        ax.set_ylim(0.0, None)
        if ax.get_legend_handles_labels()[0]:
            ax.legend(frameon=False)
    circles(
        axes[2],
        [(r["pressure"], r["strength"]) for load, r, _ in items if load.test == "compression" and load.content == reference],
        [r["strength"] for load, r, _ in items if load.test == "tension" and load.content == reference],
        line,
    )
    axes[2].set_title(next((name_of(load).split(",")[0] for load, _, _ in items if load.content == reference), ""), loc="left")
    fig.tight_layout()
    return fig


def circles(ax, pairs, tensions, line):
    angle, fit = np.linspace(0.0, np.pi, 200), line and line["fit"]
    for (low, high), colour in zip(sorted(pairs), PALETTE):
        ax.plot(
            1e-6 * (0.5 * (low + high) + 0.5 * (high - low) * np.cos(angle)),
            1e-6 * 0.5 * (high - low) * np.sin(angle),
            color=colour,
            lw=0.9,
            ls=":" if line and low in line["beyond"] else "-",
        )
    for strength in tensions:
        ax.plot(-1e-6 * 0.5 * strength * (1 + np.cos(angle)), 1e-6 * 0.5 * strength * np.sin(angle), color=PALETTE[2], lw=0.9, ls="--")
    if fit:
        tan = np.tan(np.radians(fit["angle"]))
        x = np.array([-fit["cohesion"] / tan if tan > 0 else 0.0, 0.6 * max(h for _, h in pairs)])
        ax.plot(1e-6 * x, 1e-6 * (fit["cohesion"] + tan * x), color="k", lw=0.8, label=f"cohesion {1e-6 * fit['cohesion']:.3g} MPa, {fit['angle']:.3g}°")
        ax.legend(frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    ax.set_aspect("equal")
    ax.set_ylim(0.0, None)
    ax.axvline(0.0, color="0.7", lw=0.6)
    ax.set_xlabel("normal stress (MPa); dashed: tension" + ("; dotted: beyond the cap" if line and line["beyond"] else "") + "")
    ax.set_ylabel("shear stress (MPa)")


def state_of(row, n):
    if row["separated"][n] > 0:
        return MODES[row["mode"][n]]
    return DAMAGED if row["largest_damage"][n] > 0 else WHOLE


def stages(c, steps):
    """(title, step): half of the peak, the peak, the load fallen by half, the end; of the steps that there are."""
    s, top = c.table["step"], c.stress[c.peak]
    after = np.flatnonzero(c.stress[c.peak :] < 0.5 * top)
    fallen = c.peak + int(after[0]) if after.size else (c.peak + len(s) - 1) // 2
    rows = (("half of the peak", int(np.argmax(c.stress >= 0.5 * top))), ("peak", c.peak), ("after the peak", fallen), ("end", len(s) - 1))
    found = []
    for title, row in rows:
        step = min(steps, key=lambda k: abs(k - s[row]))
        at = int(np.argmin(np.abs(s - step)))
        found.append((f"{title}\n{1e3 * c.strain[at]:.3g} ‰, {1e-6 * c.stress[at]:.3g} MPa, {int(c.table['broken'][at])} broken", step))
    return found


@styled
def bonds_in_space(load, c, bonds, beads):
    """Four stages: bonds as bars between the centres of their beads, far ones paler, beads as outlines."""
    shown = stages(c, [s for s in bonds if s in beads])
    fig, axes = plt.subplots(1, len(shown), figsize=(7.48, 3.1))
    seen = set()
    for ax, (title, step) in zip(axes, shown):
        row, at = bonds[step], beads[step]
        place = {i: view(1e3 * b[:3]) for i, b in at.items()}
        xy = np.array([p[:2] for p in place.values()])
        wide = np.array([2e3 * b[3] for b in at.values()])
        ax.add_collection(
            EllipseCollection(wide, wide, np.zeros(len(wide)), units="xy", offsets=xy, transOffset=ax.transData, facecolors="none", edgecolors="0.88", lw=0.4)
        )
        far = np.array([p[2] for p in place.values()])
        lines = []
        for n in range(len(row["bond"])):
            a, b = (place[int(row[g][n])] for g in ("grain1", "grain2"))
            if np.linalg.norm(a - b) > 3 * wide.max():
                continue  # its beads are far apart by now
            name, colour = state_of(row, n)
            seen.add(name)
            depth = (0.5 * (a[2] + b[2]) - far.min()) / np.ptp(far)
            lines.append((name == WHOLE[0], -depth, [a[:2], b[:2]], colour, depth))
        lines.sort(key=lambda k: (not k[0], k[1]))
        rgba = [plt.matplotlib.colors.to_rgba(colour, 1.0 - 0.6 * depth) for _, _, _, colour, depth in lines]
        ax.add_collection(LineCollection([k[2] for k in lines], colors=rgba, linewidths=[0.8 if k[0] else 2.2 for k in lines], capstyle="round"))
        ax.set_aspect("equal")
        low, high = xy.min(axis=0) - 0.6 * wide.max(), xy.max(axis=0) + 0.6 * wide.max()
        ax.set_xlim(low[0], high[0])
        ax.set_ylim(low[1], high[1])
        ax.axis("off")
        ax.set_title(title, fontsize=6.5)
    known = [k for k in (WHOLE, DAMAGED, *MODES.values()) if k[0] in seen]
    handles = [Line2D([], [], color=colour, lw=2.2, label=("broken: " if (name, colour) in MODES.values() else "") + name) for name, colour in known]
    fig.suptitle(title_of(load), fontsize=8, x=0.02, ha="left")
    fig.tight_layout(rect=(0, 0.07, 1, 1))
    fig.legend(handles=handles, loc="lower center", ncol=len(handles), frameon=False)
    return fig


@styled
def rose(items):
    """items: (load, bonds of the first step, bonds of the last step, beads of the first). Directions of broken bonds against those of all."""
    across = min(len(items), 5)
    down = -(-len(items) // across)
    fig, axes = plt.subplots(down, across, figsize=(1.5 * across, 2.1 * down + 0.4), subplot_kw={"projection": "polar"}, squeeze=False)
    edges = np.radians(np.arange(0.0, 91.0, 15.0))
    for ax in axes.flat[len(items) :]:
        ax.set_visible(False)
    for ax, (load, first, last, beads) in zip(axes.flat, items):
        direction = np.array([beads[int(b)][:3] - beads[int(a)][:3] for a, b in zip(first["grain1"], first["grain2"])])
        angle = np.arccos(np.abs(direction[:, 2]) / np.linalg.norm(direction, axis=1))
        broken = last["separated"] > 0
        whole = np.histogram(angle, edges)[0]
        share = np.histogram(angle[broken], edges)[0] / np.maximum(whole, 1)
        for quarter in range(4):
            at = [(a + b) / 2 for a, b in zip(edges, edges[1:])]
            at = [x if quarter == 0 else np.pi - x if quarter == 1 else np.pi + x if quarter == 2 else 2 * np.pi - x for x in at]
            ax.bar(at, 100 * share, width=np.diff(edges), color="#c1272d", alpha=0.8, edgecolor="white", lw=0.4)
        mean = 100 * broken.mean()
        ax.plot(np.linspace(0, 2 * np.pi, 200), np.full(200, mean), color="0.3", lw=0.7, ls="--")
        ax.set_theta_zero_location("N")
        ax.set_theta_direction(-1)
        ax.set_thetagrids((0, 90, 180, 270), ("0°", "90°", "", ""))
        ax.tick_params(labelsize=5, pad=-1)
        ax.grid(lw=0.3, color="0.85")
        ax.set_axisbelow(True)
        ax.set_rlabel_position(45)
        ax.yaxis.set_major_locator(plt.MaxNLocator(3))
        ax.set_title(f"{title_of(load).split(',')[0]}\n{name_of(load)}\n{int(broken.sum())} of {len(broken)} broken", fontsize=5.5)
    fig.suptitle("share of the bonds of each direction that broke (%)\n0°: along the axis of the load; dashed: of all bonds", fontsize=6.5, y=0.02, va="bottom")
    fig.tight_layout(rect=(0, 0.4 / fig.get_figheight(), 1, 1))
    return fig
