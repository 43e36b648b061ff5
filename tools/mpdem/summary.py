# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""The numbers that describe a loaded bond, and the stages worth a picture.

Whether a bond is separated or broken, when and by which mode is what the table says. Loads and displacements keep their sign: tension
and opening of the gap are positive, compression and closing negative. `sense` is that of the largest load.
"""
import csv
from dataclasses import dataclass

import numpy as np

from . import run

STIFFNESS = (0.10, 0.40)  # of the peak


@dataclass
class Result:
    """SI units; nan where the run does not tell. Means are over the window, of the load times `sense`, over the peak."""

    sense: int  # 1: the largest load is tension, -1: compression
    peak: float  # magnitude
    peak_step: float
    peak_opening: float
    stiffness: float
    separated: bool
    broken: bool  # separated, or without load
    failure_step: float  # first row in which the bond is broken
    failure_opening: float
    mode: str
    shares: tuple  # of the fracture surface: at the first grain, at the second, inside
    lowest: float  # least mean after the peak
    lowest_opening: float
    window: float
    failed: int
    links_debonded: int
    attached: int
    dissipated: float
    imbalance: float
    mean: np.ndarray  # that ends at each row
    largest_force: float  # magnitude of the whole force, shear included


def measure(bond, window):
    sense, after, peak_step, peak_opening, peak = _peak(bond)
    mean, mean_opening = (_trailing_mean(bond.step, v, window) for v in (sense * bond.tension, bond.opening))
    nan = float("nan")
    broken = np.flatnonzero(bond.broken)
    row = broken[0] if broken.size else None
    shares = (bond.share_grain1[-1], bond.share_grain2[-1], max(0.0, 1.0 - bond.share_grain1[-1] - bond.share_grain2[-1]))
    r = Result(
        sense,
        peak,
        peak_step,
        peak_opening,
        nan,
        bool(bond.separated[-1]),
        row is not None,
        nan,
        nan,
        bond.mode,
        shares,
        nan,
        nan,
        window,
        int(bond.failed[-1]),
        int(bond.debonded[-1]),
        int(bond.attached[-1]),
        bond.dissipated_energy[-1],
        bond.energy_imbalance[-1],
        mean,
        float(bond.force.max()),
    )
    if r.broken:
        r.failure_step, r.failure_opening = bond.step[row], bond.opening[row]
    if not peak > 0.0:
        return r
    r.stiffness = _stiffness(bond, sense, after, peak)
    past = np.flatnonzero(bond.step >= peak_step + window)  # whole windows after the peak
    if past.size:
        k = past[np.argmin(mean[past])]
        r.lowest, r.lowest_opening = mean[k] / peak, mean_opening[k]
    return r


def _peak(bond):
    """The largest tension may fall between rows: peak_tension is that of every step."""
    row = int(np.argmax(np.abs(bond.tension)))
    peak = float(abs(bond.tension[row]))
    seen = float(np.max(bond.peak_tension))
    if not seen > peak * (1.0 + 1e-9):
        return -1 if bond.tension[row] < 0.0 else 1, row, bond.step[row], bond.opening[row], peak
    row = int(np.argmax(bond.peak_tension >= seen))
    before = max(row - 1, 0)
    return 1, row, 0.5 * (bond.step[before] + bond.step[row]), 0.5 * (bond.opening[before] + bond.opening[row]), seen


def _trailing_mean(step, values, window):
    first = np.searchsorted(step, step - window, side="right")
    total = np.concatenate(([0.0], np.cumsum(values)))
    end = np.arange(1, len(values) + 1)
    return (total[end] - total[first]) / (end - first)


def _stiffness(bond, sense, after, peak):
    """Slope of the last rise through the range before the peak."""
    load, opening = sense * bond.tension[: after + 1], sense * bond.opening[: after + 1]
    above = np.flatnonzero(load > STIFFNESS[1] * peak)
    end = int(above[0]) if above.size else len(load)
    low = np.flatnonzero(load[:end] < STIFFNESS[0] * peak)
    start = int(low[-1]) + 1 if low.size else 0
    if end - start < 3 or np.ptp(opening[start:end]) <= 0.0:
        return float("nan")
    return float(np.polyfit(opening[start:end] * 1e6, load[start:end], 1)[0]) * 1e6


def stages(bond, result, dumps):
    """(letter, step, path) of the dumps nearest to half the peak, the peak, half after it, the end."""
    row = int(np.argmax(result.sense * bond.tension >= 0.5 * result.peak))
    wanted = [bond.step[row], result.peak_step]
    after = np.flatnonzero((bond.step > result.peak_step) & (result.mean <= 0.5 * result.peak))
    if after.size:
        wanted.append(bond.step[after[0]] - 0.5 * result.window)  # middle of the window
    wanted.append(bond.step[-1])
    have = np.array(sorted(dumps))
    nearest = sorted({int(have[np.argmin(np.abs(have - s))]) for s in wanted})
    return [("abcd"[i], s, dumps[s]) for i, s in enumerate(nearest)]


def way(bond, value):
    """A displacement in words: of the gap between the grains, whether it opened or closed since the first row."""
    size = f"{abs(value) * bond.way_scale:.4g} {bond.way_unit.replace('µ', 'u')}"
    if bond.way_name != "gap opening":
        return ("-" if value < 0.0 else "") + size
    return "gap as in the first row" if value == 0.0 else f"gap {'opened' if value > 0.0 else 'closed'} by {size}"


def state(r):
    """What the table says of the bond at its last row."""
    if not r.broken:
        return "not separated"
    at = ", ".join(f"{100 * s:.0f} % {where}" for s, where in zip(r.shares, ("at the first grain", "at the second", "inside")))
    return f"{'separated' if r.separated else 'without load, not separated'}, {r.mode}: {at}"


def show(bond, r, results):
    def line(label, value):
        print(f"  {label:<29}{value}")

    bonds = len(results)
    print(f"{bond.path}: bond {bond.number} of {bonds}, grains {bond.grains[0]} and {bond.grains[1]}, " f"steps {bond.step[0]:.0f} to {bond.step[-1]:.0f}")
    if bonds > 1:
        apart = [x for x in results.values() if x.separated]
        modes = ", ".join(f"{sum(x.mode == m for x in apart)} {m}" for m in run.MODES[:3])
        line("all bonds", f"{len(apart)} of {bonds} separated ({modes})")
    force = "moment" if bond.load_unit == "N m" else "force"
    kind = bond.load if bond.load != "tension" else "" if r.sense > 0 else "compression"
    line(f"peak {force}", f"{r.peak:.5g} {bond.load_unit}" + (f" ({kind})" if kind else ""))
    line(
        "stiffness",
        f"{r.stiffness:.4g} {bond.load_unit}/{'rad' if force == 'moment' else 'm'}"
        if np.isfinite(r.stiffness)
        else "too few rows between 10 and 40 % of the peak",
    )
    line("displacement at peak", f"{way(bond, r.peak_opening)} (step {r.peak_step:.0f})")
    line("state", state(r))
    if r.broken:
        line(
            "displacement at failure",
            f"{way(bond, r.failure_opening)} (step {r.failure_step:.0f}, the first row in which the bond is "
            f"{'separated' if r.separated else 'without load'})",
        )
    mean = f"lowest mean {bond.load_name if r.sense > 0 else 'compression'} of {r.window:g} steps after the peak"
    if np.isfinite(r.lowest):
        line("load left", f"{100 * r.lowest:.3g} % of the peak ({mean})")
    else:
        line(
            "load left", f"not known: the run ends at step {bond.step[-1]:.0f}, less than {r.window:g} steps after the peak" if r.peak > 0.0 else "never loaded"
        )
    line("failed points", f"{r.failed} of {bond.points[-1]:.0f}")
    line("links debonded", f"{r.links_debonded} of {r.links_debonded + r.attached}")
    line("links attached", f"{r.attached}")
    line("dissipated energy", f"{r.dissipated:.5g} J" + (" (all bonds)" if bonds > 1 else ""))
    line("energy imbalance at the end", f"{r.imbalance:.2g} of the work" + (" (all bonds)" if bonds > 1 else ""))


def write(path, bonds, results):
    """`separated`, `mode` and `step_of_separation` (or since when it is without load) are the table's; openings are of the gap since its first row, below zero: closed."""
    header = [
        "bond",
        "grain1",
        "grain2",
        "peak_force_N",
        "stiffness_N_per_m",
        "opening_at_peak_m",
        "separated",
        "opening_at_separation_m",
        "lowest_mean_load_over_peak",
        "opening_at_lowest_m",
        "points",
        "failed_points",
        "links_let_go",
        "links_attached",
        "dissipated_energy_all_bonds_J",
        "energy_imbalance_all_bonds",
        "last_step",
        "window_steps",
        "sense",
        "mode",
        "step_of_separation",
        "share_grain1",
        "share_grain2",
        "largest_force_with_shear_N",
    ]
    try:
        with open(path, "w", newline="") as f:
            out = csv.writer(f, lineterminator="\n")
            out.writerow(header)
            for b in bonds:
                r = results[b.number]
                values = [
                    r.peak,
                    r.stiffness,
                    r.peak_opening,
                    "yes" if r.separated else "no",
                    r.failure_opening,
                    r.lowest,
                    r.lowest_opening,
                    int(b.points[-1]),
                    r.failed,
                    r.links_debonded,
                    r.attached,
                    r.dissipated,
                    r.imbalance,
                    int(b.step[-1]),
                    r.window,
                    "tension" if r.sense > 0 else "compression",
                    r.mode,
                    int(r.failure_step) if r.broken else "",
                    r.shares[0],
                    r.shares[1],
                    r.largest_force,
                ]
                out.writerow([b.number, *b.grains] + [f"{v:.8g}" if isinstance(v, float) else v for v in values])
    except OSError as e:
        raise run.Trouble(f"{path}: {e.strerror}; name a folder that can be written") from None
