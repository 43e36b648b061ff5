# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Figures of what a run left. Each function takes an Output of mpdem.load and returns a matplotlib Figure; legends are words with units."""
from types import SimpleNamespace
from typing import Any, Dict, List, Optional, Tuple

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from . import figures, interface as faces, run, summary, units
from .figures import plt, styled
from .output import Output
from .tables import Trouble

PULL, PUSH = "#c1272d", "#1f6fb4"
MODES = {"internal": ("inside the cement", "#1f6fb4"), "mixed": ("mixed", "#8a5fa8"), "debonding": ("debonding from a grain", "#c1272d")}
WORDS = {
    "content": "bond content, mass of cement over mass of its two grains",
    "material": "number of the material, 0: that of fix mpm",
    "strength_factor": "factor on the strength",
    "moduli_factor": "factor on the moduli",
    "tension": "force along the line of centres, tension positive (N)",
    "peak_tension": "largest tension so far (N)",
    "largest_damage": "largest damage of a point",
    "mean_damage": "mean damage",
    "gap": "gap between the grains (m)",
    "failed": "failed points",
}


# ---------------------------------------------------------------------------------------------------- one bond


def _bond(output: Output, number: Optional[int]) -> Tuple[Any, Any]:
    """A bond and what is measured of it. The load is that of examples/pair_table, if its table is there, else tension."""
    table = output.bonds
    if table.empty:
        raise Trouble(f"{output.folder}: the table of bonds has no rows yet; let the run get past its setup")
    path = output._path("bond")
    bond = run.choose(run.bonds_of(path, table), number)
    window = faces.follow_load(output.folder, bond) or 500
    result = summary.measure(bond, window)
    if not result.peak > 0.0:
        raise Trouble(f"{path}: bond {bond.number} was never loaded, nothing to draw; choose another one")
    return bond, result


def force_displacement(output: Output, bond: Optional[int] = None) -> Figure:
    """Load against displacement of a bond (default: the first), with failed points and debonded links."""
    return figures.force_displacement(*_bond(output, bond), [])


def _stages(output: Output, bond: Any, result: Any) -> Tuple[Any, Any, float]:
    dumps = run.dumps_of(output.folder, output.dumps.get(output.points_name, {}), bond)
    return dumps, summary.stages(bond, result, dumps), run.spacing(run.read_dump(dumps[min(dumps)]))


def damage_cut(output: Output, bond: Optional[int] = None, radius: float = 0.005) -> Figure:
    """Damage on a cut through a bond on the z axis, at up to four stages. radius: of its grains, m."""
    found, result = _bond(output, bond)
    _, stages, spacing = _stages(output, found, result)
    return figures.damage_cut(found, result, stages, radius, spacing)


def interface(output: Output, bond: Optional[int] = None, grain: Optional[int] = None, radius: float = 0.005) -> Figure:
    """Damage and time of debonding of the points at a grain (default: where most links debonded), from dumps, bonds and events."""
    found, result = _bond(output, bond)
    dumps, _, spacing = _stages(output, found, result)
    first, last = (run.read_dump(dumps[s]) for s in (min(dumps), max(dumps)))
    lacking = [c for c in ("id", "c_attached", "c_grain") if c not in first]
    if lacking:
        raise Trouble(f"{dumps[min(dumps)]}: no column {', '.join(lacking)}; dump id and compute mpm/atom with the IDs attached and grain")
    of_bond = output.events[output.events["bond"] == found.number]
    events = {c: of_bond[c].to_numpy() for c in of_bond}
    if "c_bond" in first:
        first = {c: v[first["c_bond"] == found.number] if c != "step" else v for c, v in first.items()}
    at = {g: int(((events["grain"] == g) | faces.residue(events, first, g)).sum()) for g in found.grains}
    if grain is not None and grain not in at:
        raise Trouble(f"{output.folder}: grain {grain} is none of bond {found.number}; take {found.grains[0]} or {found.grains[1]}")
    return faces.interface(found, grain or max(at, key=lambda g: at[g]), first, last, events, radius, spacing)


# ---------------------------------------------------------------------------------------------------- curves


def curve(output: Output, x: str = "", y: str = "", name: str = "") -> Figure:
    """A column of a curve against another one (default: the load against the displacement; of a specimen q and volume strain against axial strain)."""
    curves = output.curves
    if not x and not y and not name and "response" in curves:
        return _response(curves["response"])
    table = curves.get(name) if name else output.curve
    if table is None:
        raise Trouble(f"{output.folder}: no curve '{name}'; there are {', '.join(curves)}")
    x, y = x or ("way" if "way" in table else str(table.columns[0])), y or (
        "load" if "load" in table else "force" if "force" in table else str(table.columns[-1])
    )
    for column in (x, y):
        if column not in table:
            raise Trouble(f"{output.folder}: no column '{column}' of the curve; there are {', '.join(table)}")
    return _plot(table, x, y)


@styled
def _plot(table: pd.DataFrame, x: str, y: str) -> Figure:
    fig, ax = plt.subplots(figsize=(4.6, 3.2))
    ax.plot(table[x], table[y], color=figures.CURVE)
    ax.axhline(0.0, color="0.75", lw=0.6, zorder=0)
    ax.set_xlabel(units.label(table, x))
    ax.set_ylabel(units.label(table, y))
    ax.grid(True, lw=0.3, color="0.9")
    fig.tight_layout()
    return fig


@styled
def _response(r: pd.DataFrame) -> Figure:
    """Stress, volume strain, broken bonds by where they broke, over the axial strain."""
    fig, axes = plt.subplots(1, 3, figsize=(7.48, 2.9))
    e = 100 * r["axial_strain"]
    axes[0].plot(e, 1e-3 * r["q"], color=figures.CURVE)
    top = int(np.argmax(r["q"]))
    axes[0].plot(e[top], 1e-3 * r["q"][top], "o", color=figures.MARK, ms=4, label=f"peak {run.number(1e-3 * r['q'][top])} kPa at {e[top]:.2g} %")
    axes[0].set_ylim(top=1.12 * 1e-3 * r["q"][top])
    axes[0].legend(frameon=False, loc="upper left", handletextpad=0.2, borderaxespad=0.1)
    axes[1].plot(e, 100 * r["volume_strain"], color=figures.CURVE)
    low = np.zeros(len(r))
    for mode, (words, colour) in MODES.items():
        if r[mode].any():
            axes[2].fill_between(e, low, low + r[mode], color=colour, alpha=0.85, lw=0, label=words)
        low = low + r[mode]
    if axes[2].get_legend_handles_labels()[0]:
        axes[2].legend(frameon=False, loc="upper left")
    for ax, words in zip(axes, ("axial less side stress (kPa)", "volume strain, dilation upward (%)", "broken bonds, by where they broke")):
        ax.set_ylabel(words)
        ax.set_xlabel("axial strain (%)")
        ax.set_xlim(0.0, None)
        ax.grid(True, lw=0.3, color="0.9")
    axes[2].set_ylim(0.0, max(1.15 * float(low.max()), 1.0))
    fig.tight_layout()
    return fig


# ---------------------------------------------------------------------------------------------------- a packing


def _seen(grains: pd.DataFrame) -> Dict[int, np.ndarray]:
    """Places of the grains as they are seen, mm: to the right, upward, away."""
    return dict(zip(grains.index, figures.view(1e3 * grains[["x", "y", "z"]].to_numpy())))


def _outlines(ax: Any, grains: pd.DataFrame, place: Dict[int, np.ndarray], colours: Any = "none", edge: str = "0.85") -> None:
    """The grains as discs, far ones first."""
    order = sorted(grains.index, key=lambda i: -place[i][2])
    wide = 2e3 * grains["radius"].reindex(order).to_numpy()
    xy = np.array([place[i][:2] for i in order])
    faces = colours if isinstance(colours, str) else [colours[i] for i in order]
    ax.add_collection(
        EllipseCollection(wide, wide, np.zeros(len(wide)), units="xy", offsets=xy, transOffset=ax.transData, facecolors=faces, edgecolors=edge, lw=0.4)
    )
    ax.set_aspect("equal")
    reach = 0.52 * wide[:, None]
    low, high = (xy - reach).min(axis=0), (xy + reach).max(axis=0)
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.axis("off")
    size = 10.0 ** np.floor(np.log10(0.4 * (high[0] - low[0])))
    ax.plot([low[0], low[0] + size], [low[1], low[1]], color="0.2", lw=1.5, solid_capstyle="butt", clip_on=False)
    ax.annotate(f"{size:g} mm", (low[0] + 0.5 * size, low[1]), xytext=(0, -3), textcoords="offset points", ha="center", va="top", annotation_clip=False)


def _lines(place: Dict[int, np.ndarray], first: Any, second: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Ends of the lines between the centres of pairs of grains, and the order from far to near."""
    pairs = np.array([[place[int(a)], place[int(b)]] for a, b in zip(first, second)]).reshape(-1, 2, 3)
    return pairs[:, :, :2], np.argsort(-pairs[:, :, 2].mean(axis=1))


def _step(output: Output, step: Optional[int]) -> int:
    """The step of the dump of grains nearest to a step; the last one without it."""
    steps = output.grain_steps
    if not steps:
        raise Trouble(f"{output.folder}: no dumps of the grains; write 'dump ID grains custom N beads.*.txt id x y z radius'")
    wanted = steps[-1] if step is None else step
    return min(steps, key=lambda s: abs(s - wanted))


def packing(output: Output, column: str = "content", step: Optional[int] = None) -> Figure:
    """Bonds as lines between the centres of their grains, coloured by a column of the table of bonds or by their content, beside its distribution.

    step: the dump of grains nearest to it (default: the last dump; the first one for what does not change with time)."""
    steady = column in ("content", "material", "strength_factor", "moduli_factor")
    at = _step(output, output.grain_steps[0] if step is None and steady and output.grain_steps else step)
    grains, rows = output.grains_at(at), output.bonds_at(at)
    if column != "content" and column not in rows:
        raise Trouble(f"{output.folder}: no column '{column}' of the bonds; there are content, {', '.join(rows)}")
    values = (output.content() if column == "content" else rows[column]).reindex(rows.index).dropna()
    if values.empty or not pd.api.types.is_numeric_dtype(values):
        raise Trouble(f"{output.folder}: column '{column}' has no numbers to draw; choose another one")
    if column == "content":
        return coloured_bonds(grains, rows.loc[values.index], 100 * values.to_numpy(dtype=float), "bond content (%)")
    words = WORDS.get(column, units.label(output.bonds, column))
    return coloured_bonds(grains, rows.loc[values.index], values.to_numpy(dtype=float), words, column == "tension", column == "material")


@styled
def coloured_bonds(grains: pd.DataFrame, pairs: pd.DataFrame, value: np.ndarray, words: str, signed: bool = False, whole: bool = False) -> Figure:
    """grains: x, y, z, radius by ID; pairs: grain1 and grain2 of each bond; value: of each bond. signed: around 0; whole: whole numbers."""
    if np.ptp(value) < 1e-4 * np.abs(value).max():
        value = np.full(len(value), float(f"{value.mean():.5g}"))  # equal but for rounding
    kinds = np.unique(value)
    few = whole and len(kinds) <= 6
    fig, (space, spread) = plt.subplots(1, 2, figsize=(7.48, 3.5), gridspec_kw={"width_ratios": [1.3, 1]})
    place = _seen(grains)
    _outlines(space, grains, place)
    ends, order = _lines(place, pairs["grain1"], pairs["grain2"])
    most, span = float(np.abs(value).max()) or 1.0, float(np.ptp(value))
    slack = 1e-9 * most * (span == 0.0)
    norm = plt.Normalize(-most, most) if signed else plt.Normalize(value.min() - slack, value.max() + slack)
    colours = plt.get_cmap("coolwarm" if signed else "viridis", len(kinds) if few and len(kinds) > 1 else None)
    wide = 1.2 + 2.0 * (np.abs(value) / most if signed else np.asarray(norm(value)))
    lines = LineCollection(ends[order], array=value[order], cmap=colours, norm=norm, linewidths=wide[order], capstyle="round")
    space.add_collection(lines)
    bar = fig.colorbar(lines, ax=space, shrink=0.8, pad=0.02, label=words)
    if few or not span:
        bar.set_ticks(list(kinds))
    spread.hist(value, bins=np.append(kinds - 0.5, kinds[-1] + 0.5) if few else 20, color="0.6", rwidth=0.8 if few else None)
    if few:
        spread.set_xticks(kinds)
    spread.set_xlabel(words)
    spread.set_ylabel("bonds")
    mean = float(value.mean())
    varies = f", coefficient of variation {value.std() / mean:.2g}" if mean > 0.0 and span and not signed and not few else ""
    spread.set_title(f"{len(value)} bonds, mean {mean:.3g}{varies}", loc="left")
    fig.tight_layout()
    return fig


@styled
def force_chains(output: Output, step: Optional[int] = None) -> Figure:
    """Forces between grains along the line of centres: red tension, blue compression, width by the force over the largest one. Left of the cement, right of the contacts of grains."""
    at = _step(output, step)
    grains, rows = output.grains_at(at), output.bonds_at(at)
    held = rows[(rows["separated"] == 0) & rows["grain1"].isin(grains.index) & rows["grain2"].isin(grains.index)]
    parts: List[Tuple[str, pd.DataFrame]] = [("forces of the cement", held.assign(force=held["tension"]))]
    if "pairs" in output.dumps and at in output.dumps["pairs"]:
        touch = output.contacts_at(at)
        if "fx" in touch and len(touch):
            a, b = (grains[["x", "y", "z"]].loc[touch[g].astype(int)].to_numpy() for g in ("grain1", "grain2"))
            along = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
            parts.append(("forces of the contacts", touch.assign(force=(touch[["fx", "fy", "fz"]].to_numpy() * along).sum(axis=1))))
    if not any(t["force"].abs().max() > 0.0 for _, t in parts if len(t)):
        raise Trouble(f"{output.folder}: no forces at step {at}; choose a later one")
    place = _seen(grains)
    fig, axes = plt.subplots(1, len(parts), figsize=(3.6 * len(parts) + 0.3, 4.3), squeeze=False)
    for ax, (title, table) in zip(axes[0], parts):
        _outlines(ax, grains, place)
        force = table["force"].to_numpy()
        most = float(np.abs(force).max()) if len(force) else 0.0
        ends, order = _lines(place, table["grain1"], table["grain2"])
        colours = [PULL if f > 0 else PUSH for f in force[order]]
        ax.add_collection(LineCollection(ends[order], colors=colours, linewidths=6.0 * np.abs(force[order]) / (most or 1.0), capstyle="round", alpha=0.85))
        pulls = int((force > 0).sum())
        ax.set_title(f"{title}: {pulls} pull, {int((force < 0).sum())} push\nwidest line: {run.number(most)} N", loc="left")
    handles = [Line2D([], [], color=PULL, lw=3, label="tension"), Line2D([], [], color=PUSH, lw=3, label="compression")]
    handles.append(Line2D([], [], color="0.85", marker="o", mfc="none", ls="", ms=8, label="grains"))
    fig.tight_layout(rect=(0, 0.07, 1, 1))
    fig.legend(handles=handles, loc="lower center", ncol=3, frameon=False)
    return fig


@styled
def fragments(output: Output, step: Optional[int] = None) -> Figure:
    """Grains coloured by the group that cement still joins, far ones first; grains that nothing joins are pale."""
    at = _step(output, step)
    grains, number = output.grains_at(at), output.groups_at(at)
    size = number.map(number.value_counts())
    groups = [n for n in sorted(number.unique()) if (number == n).sum() > 1]
    palette = plt.get_cmap("tab10")
    shade = {n: palette(i) for i, n in enumerate(groups[:8])}
    colours = {i: "#efefef" if size[i] == 1 else matplotlib.colors.to_rgba(shade.get(number[i], "#8f8f8f"), 0.85) for i in grains.index}
    fig, ax = plt.subplots(figsize=(5.6, 3.7))
    _outlines(ax, grains, _seen(grains), colours, "0.45")
    handles = [Line2D([], [], color=shade[n], marker="o", ls="", ms=7, label=f"group of {int((number == n).sum())} grains") for n in groups[:8]]
    if len(groups) > 8:
        handles.append(Line2D([], [], color="#8f8f8f", marker="o", ls="", ms=7, label=f"{len(groups) - 8} smaller groups"))
    alone = int((size == 1).sum())
    if alone:
        handles.append(Line2D([], [], color="#efefef", mec="0.45", marker="o", ls="", ms=7, label=f"{alone} grains that nothing joins"))
    held = output.bonds_at(at)["separated"]
    ax.set_title(f"step {at}: {int((held > 0).sum())} of {len(held)} bonds separated", loc="left")
    ax.legend(handles=handles, loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    fig.tight_layout()
    return fig


def compare(outputs: Dict[str, Output], x: str = "", y: str = "") -> Figure:
    """Curves of several runs in one figure, by their names: the columns x and y of `curve`, in words with units."""
    tables = {name: out.curve for name, out in outputs.items()}
    if not tables:
        raise Trouble("compare: needs at least one output")
    return _compare(tables, SimpleNamespace(x=x, y=y))


@styled
def _compare(tables: Dict[str, pd.DataFrame], columns: Any) -> Figure:
    first = next(iter(tables.values()))
    x, y = columns.x or ("way" if "way" in first else str(first.columns[0])), columns.y or ("load" if "load" in first else "force")
    fig, ax = plt.subplots(figsize=(4.6, 3.2))
    for n, (name, table) in enumerate(tables.items()):
        lacking = [c for c in (x, y) if c not in table]
        if lacking:
            raise Trouble(f"compare: the curve of {name} has no column {', '.join(lacking)}")
        ax.plot(table[x], table[y], lw=1.0, label=name, color=plt.get_cmap("tab10")(n % 10))
    ax.set_xlabel(units.label(first, x))
    ax.set_ylabel(units.label(first, y))
    ax.legend(frameon=False)
    ax.grid(True, lw=0.3, color="0.9")
    fig.tight_layout()
    return fig
