# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Geometry of the cement with its attached points, and how it debonds from a grain.

A point is drawn where it was at the first dump. `attached` of a dump: 0 no link, 1 attached, 2 debonded. Points that fail and stay on the grain
as residue are green.
"""
import os
import re

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Patch

from . import loading, run
from .figures import GRAIN, GRAIN_EDGE, HALF_CUT, MAP, plt, save, styled

FREE, ATTACHED, KEPT, RESIDUE = "#9db4c8", "#c8553d", "#dddddd", "#4f9d69"
TIMES = "plasma"


def follow_load(folder, bond):
    """Displacement and load of examples/pair_table, if its table is there; its log names the load.
    Returns the steps over which the script averages, None without that table."""
    path = os.path.join(folder, f"{run.beside(bond, 'load')}.csv")
    if not os.path.isfile(path):
        return None
    table = loading.read_table(path)
    found = None
    log = os.path.join(folder, "log.liggghts")
    if os.path.isfile(log):
        with open(log, errors="replace") as f:
            found = re.search(r"^shape \S+, load (\w+), content \S+, chunk (\d+)", f.read(), re.M)
    if found is None:
        raise run.Trouble(f"{log}: does not name the load of {path}; keep the log of the run beside it")
    bond.follow(found[1], table["step"], table["way"], table["load"])
    return int(found[2])


def draw(args, out, bond, dumps, spacing):
    """Writes what the files allow; names of what was written."""
    first = run.read_dump(dumps[min(dumps)])
    if "c_attached" not in first:
        return []
    if "c_bond" in first:
        first = {c: v[first["c_bond"] == bond.number] if c != "step" else v for c, v in first.items()}
    save(geometry(bond, first, args.radius, spacing), os.path.join(out, "geometry.png"))
    written = ["geometry.png"]
    name = args.events or f"{run.beside(bond, 'events')}.csv"
    path = next((p for p in (os.path.join(args.run_dir, name), name) if os.path.isfile(p)), None)
    if path is None:
        if args.events:
            raise run.Trouble(f"{name}: no such file; name the 'events' file of fix mpm with --events")
        return written
    if "id" not in first or "c_grain" not in first:
        return written
    with open(path) as f:
        lines = f.readlines()
    missing = [c for c in ("bond", "grain", "point") if c not in (lines[0].strip().split(",") if lines else [])]
    if missing:
        raise run.Trouble(f"{path}: no column '{missing[0]}'; name the 'events' file of fix mpm with --events")
    if len(lines) < 2:
        return written  # nothing failed
    events = loading.read_table(path)
    events = {c: np.asarray(v)[events["bond"] == bond.number] for c, v in events.items()}
    at_grain = {g: ((events["grain"] == g) | residue(events, first, g)).sum() for g in bond.grains}
    if not any(at_grain.values()):
        return written
    grain = args.grain or max(bond.grains, key=at_grain.get)
    if grain not in bond.grains:
        raise run.Trouble(f"--grain {grain}: the grains of bond {bond.number} are {bond.grains[0]} and {bond.grains[1]}")
    last = run.read_dump(dumps[max(dumps)])
    save(interface(bond, grain, first, last, events, args.radius, spacing), os.path.join(out, "interface.png"))
    return written + ["interface.png"]


def residue(events, first, grain):
    """Events of points that failed and stayed on the grain: a law of the interface of its own has them."""
    linked = first["id"][(first["c_attached"] > 0) & (first["c_grain"] == grain)].astype(int)
    return (events["grain"] == 0) & np.isin(events["point"].astype(int), linked)


def tiles(x, y, half):
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return np.column_stack([x, y])[:, None] + corners


@styled
def geometry(bond, points, radius, spacing):
    """A cut through the line of centres, and the points attached to the first grain from above."""
    mm, half = 1e3, 0.46e3 * spacing
    x, y, z = (mm * points[c] for c in "xyz")
    attached = points["c_attached"] > 0
    keep = np.abs(points["y"]) < HALF_CUT * spacing
    wide = 1.12 * np.hypot(x, y).max()
    high = 1.25 * np.abs(z[keep]).max() if keep.any() else wide
    shape = min(max(high / wide, 0.3), 1.1)
    fig = plt.figure(figsize=(7.2, max(3.0 * shape + 1.0, 2.9)))
    cut = fig.add_axes([0.07, 0.5 / fig.get_figheight(), 0.52, 1 - 0.85 / fig.get_figheight()])
    for c in (-radius - 0.5 * bond.gap[0], radius + 0.5 * bond.gap[0]):
        cut.add_patch(Circle((0.0, mm * c), mm * radius, fc=GRAIN, ec=GRAIN_EDGE, lw=0.6, zorder=1))
    for group, colour in ((keep & ~attached, FREE), (keep & attached, ATTACHED)):
        cut.add_collection(PolyCollection(tiles(x[group], z[group], half), fc=colour, lw=0, zorder=2))
    cut.set_xlim(-wide, wide)
    cut.set_ylim(-high, high)
    cut.set_aspect("equal")
    cut.set_xlabel("x (mm)", labelpad=1)
    cut.set_ylabel("z (mm)", labelpad=1)
    cut.set_title(f"cut: {len(x)} points, {attached.sum()} attached", loc="left")
    top = fig.add_axes([0.66, 0.5 / fig.get_figheight(), 0.32, 1 - 0.85 / fig.get_figheight()])
    disc = attached & (points["c_grain"] == bond.grains[0] if "c_grain" in points else points["z"] < 0)
    top.add_collection(PolyCollection(tiles(x[disc], y[disc], 0.6e3 * spacing), fc=ATTACHED, lw=0, antialiased=False))
    top.set_ylim(-wide, wide)
    top.set_xticks(top.get_yticks())
    top.set_xlim(-wide, wide)
    top.set_ylim(-wide, wide)
    top.set_aspect("equal", anchor="W")
    top.set_xlabel("x (mm)", labelpad=1)
    top.set_ylabel("y (mm)", labelpad=1)
    top.set_title(f"attached to grain {bond.grains[0]}", loc="left")
    fig.legend(
        handles=[Patch(fc=ATTACHED, label="attached"), Patch(fc=FREE, label="not attached"), Patch(fc=GRAIN, ec=GRAIN_EDGE, label="grains")],
        loc="lower left",
        ncol=3,
        frameon=False,
        bbox_to_anchor=(0.05, 0.0),
    )
    return fig


@styled
def interface(bond, grain, first, last, events, radius, spacing):
    """Disc of the points linked to a grain: damage at the last dump, time of debonding; radius against time.

    Lines mark where the surface of the grain crosses from one layer of the lattice of points to the next:
    rings that lie on these are the lattice's, not the material's.
    """
    linked = (first["c_attached"] > 0) & (first["c_grain"] == grain)
    ids = first["id"][linked].astype(int)
    x, y = 1e3 * first["x"][linked], 1e3 * first["y"][linked]
    at = dict(zip(last["id"].astype(int), last["c_damage"]))
    damage = np.array([at.get(i, np.nan) for i in ids])
    mine = events["grain"] == grain
    when = dict(zip(events["point"][mine].astype(int), events["time"][mine]))
    time = 1e6 * np.array([when.get(i, np.nan) for i in ids])
    gone = np.isfinite(time)
    stayed = np.isin(ids, events["point"][residue(events, first, grain)].astype(int)) & ~gone
    half, wide = 0.58e3 * spacing, 1.06 * (np.hypot(x, y).max() + 1e3 * spacing)
    fig, axes = plt.subplots(1, 3, figsize=(9.4, 3.3), gridspec_kw={"width_ratios": [1, 1, 1.15]})
    panels = (
        (damage, plt.Normalize(0, 1), MAP, "largest damage (–)", "at the last dump"),
        (
            time,
            plt.Normalize(np.nanmin(time), max(np.nanmax(time), np.nanmin(time) + 1e-9)) if gone.any() else None,
            TIMES,
            "time of debonding (µs)",
            f"{gone.sum()} of {len(ids)} points debonded" + (f",\n{stayed.sum()} stayed as residue" if stayed.any() else ""),
        ),
    )
    for ax, (values, norm, colours, label, title) in zip(axes, panels):
        known = np.isfinite(values)
        ax.add_collection(PolyCollection(tiles(x[~known], y[~known], half), fc=KEPT, lw=0, antialiased=False))
        shown = PolyCollection(tiles(x[known], y[known], half), array=values[known], cmap=colours, norm=norm, lw=0, antialiased=False)
        ax.add_collection(shown)
        ax.set_xlim(-wide, wide)
        ax.set_ylim(-wide, wide)
        ax.set_aspect("equal")
        ax.set_xlabel("x (mm)")
        ax.set_ylabel("y (mm)", labelpad=0)
        ax.set_title(title, loc="left")
        if values is time and stayed.any():
            ax.add_collection(PolyCollection(tiles(x[stayed], y[stayed], half), fc=RESIDUE, lw=0, antialiased=False))
        bar = fig.colorbar(shown, ax=ax, orientation="horizontal", pad=0.18, fraction=0.05)
        bar.set_label(label)
    axes[0].set_title(f"grain {grain}, points attached at the start\ndamage at the last dump", loc="left")
    ax = axes[2]
    r = np.hypot(x, y)
    ax.plot(time[gone], r[gone], "s", ms=1.6, color="0.25", mew=0, label="a point debonds")
    ax.axhspan(r.min(), r.max(), color="0.95", zorder=0, label="attached at the start")
    layers = np.arange(1, int(radius / spacing)) * spacing - 0.5 * bond.gap[0]
    layers = 1e3 * np.sqrt(np.maximum(2 * radius * layers - layers**2, 0.0))
    for i, level in enumerate(layers[(layers > r.min() - 0.02) & (layers < r.max())]):
        ax.axhline(level, color="#2a6fbb", lw=0.5, ls=":", zorder=1, label="next layer of points" if not i else None)
    ax.set_xlabel("time (µs)")
    ax.set_ylabel("distance from the line of centres (mm)")
    load = ax.twinx()
    load.plot(1e6 * bond.time, bond.tension, color="#c8553d", lw=0.8)
    load.set_ylabel(f"{bond.load_name} ({bond.load_unit})", color="#c8553d")
    load.tick_params(colors="#c8553d")
    if gone.any():
        reach = 0.08 * np.ptp(time[gone]) + 0.1
        ax.set_xlim(np.nanmin(time) - reach, np.nanmax(time) + reach)
    ax.legend(loc="upper left", bbox_to_anchor=(-0.05, 1.2), frameon=False, ncol=2, markerscale=2.5, columnspacing=1.2)
    fig.subplots_adjust(left=0.055, right=0.935, bottom=0.13, top=0.87, wspace=0.32)
    # the discs keep room for their bars; the third panel fills the height
    box = ax.get_position()
    for a in (ax, load):
        a.set_position([box.x0 + 0.01, 0.15, box.width, 0.70])
    return fig
