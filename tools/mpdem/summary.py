# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""The numbers that describe a pulled bond, and the stages worth a picture."""
import csv
from dataclasses import dataclass

import numpy as np

from . import run

FAILED_BELOW = 0.01        # of the peak
STIFFNESS = (0.10, 0.40)   # of the peak


@dataclass
class Result:
    """SI units; nan where the run does not tell."""
    peak: float
    peak_step: float
    peak_opening: float
    stiffness: float
    broken: bool
    failure_step: float
    failure_opening: float  # middle of the window
    lowest: float           # least mean tension after the peak, of the peak
    lowest_opening: float
    window: float
    failed: int
    let_go: int
    attached: int
    dissipated: float
    imbalance: float
    mean: np.ndarray        # tension averaged over the window that ends at each row


def measure(bond, window):
    after, peak_step, peak_opening, peak = _peak(bond)
    mean, mean_opening = (_trailing_mean(bond.step, v, window) for v in (bond.tension, bond.opening))
    nan = float("nan")
    r = Result(peak, peak_step, peak_opening, nan, False, nan, nan, nan, nan, window, int(bond.failed[-1]),
               int(bond.debonded[-1]), int(bond.attached[-1]), bond.dissipated_energy[-1],
               bond.energy_imbalance[-1], mean)
    if not peak > 0.0:
        return r
    r.stiffness = _stiffness(bond, after, peak)
    past = np.flatnonzero(bond.step >= peak_step + window)  # whole windows after the peak
    if past.size:
        k = past[np.argmin(mean[past])]
        r.lowest, r.lowest_opening = mean[k] / peak, mean_opening[k]
    below = past[mean[past] < FAILED_BELOW * peak]
    if below.size:
        r.broken, r.failure_step, r.failure_opening = True, bond.step[below[0]], mean_opening[below[0]]
    return r


def _peak(bond):
    """The peak may fall between rows: peak_tension knows it if the run evaluated it there."""
    row = int(np.argmax(bond.tension))
    peak = float(bond.tension[row])
    seen = float(np.max(bond.peak_tension))
    if not seen > peak * (1.0 + 1e-9):
        return row, bond.step[row], bond.opening[row], peak
    row = int(np.argmax(bond.peak_tension >= seen))
    before = max(row - 1, 0)
    return row, 0.5 * (bond.step[before] + bond.step[row]), 0.5 * (bond.opening[before] + bond.opening[row]), seen


def _trailing_mean(step, values, window):
    first = np.searchsorted(step, step - window, side="right")
    total = np.concatenate(([0.0], np.cumsum(values)))
    end = np.arange(1, len(values) + 1)
    return (total[end] - total[first]) / (end - first)


def _stiffness(bond, after, peak):
    """Slope of the last rise through the range before the peak."""
    tension, opening = bond.tension[:after + 1], bond.opening[:after + 1]
    end = int(np.argmax(tension > STIFFNESS[1] * peak)) if (tension > STIFFNESS[1] * peak).any() else len(tension)
    low = np.flatnonzero(tension[:end] < STIFFNESS[0] * peak)
    start = int(low[-1]) + 1 if low.size else 0
    if end - start < 3 or np.ptp(opening[start:end]) <= 0.0:
        return float("nan")
    return float(np.polyfit(opening[start:end] * 1e6, tension[start:end], 1)[0]) * 1e6


def stages(bond, result, dumps):
    """(letter, step, path) of the dumps nearest to half the peak, the peak, half after it, the end."""
    row = int(np.argmax(bond.tension >= 0.5 * result.peak))
    wanted = [bond.step[row], result.peak_step]
    after = np.flatnonzero((bond.step > result.peak_step) & (result.mean <= 0.5 * result.peak))
    if after.size:
        wanted.append(bond.step[after[0]] - 0.5 * result.window)  # middle of the window
    wanted.append(bond.step[-1])
    have = np.array(sorted(dumps))
    nearest = sorted({int(have[np.argmin(np.abs(have - s))]) for s in wanted})
    return [("abcd"[i], s, dumps[s]) for i, s in enumerate(nearest)]


def show(bond, r, bonds):
    def line(label, value):
        print(f"  {label:<29}{value}")

    print(f"{bond.path}: bond {bond.number} of {bonds}, grains {bond.grains[0]} and {bond.grains[1]}, "
          f"steps {bond.step[0]:.0f} to {bond.step[-1]:.0f}")
    way, unit = bond.way_scale, bond.way_unit.replace("µ", "u")
    force = "moment" if bond.load_unit == "N m" else "force"
    line(f"peak {force}", f"{r.peak:.5g} {bond.load_unit}" + (f" ({bond.load})" if bond.load != "tension" else ""))
    line("stiffness", f"{r.stiffness:.4g} {bond.load_unit}/{'rad' if force == 'moment' else 'm'}" if np.isfinite(r.stiffness)
         else "too few rows between 10 and 40 % of the peak")
    line("displacement at peak", f"{r.peak_opening * way:.4g} {unit} (step {r.peak_step:.0f})")
    mean = f"mean {bond.load_name} of {r.window:g} steps"
    if r.broken:
        line("displacement at failure", f"{r.failure_opening * way:.4g} {unit} (step {r.failure_step:.0f}: {mean} "
             f"below {100 * FAILED_BELOW:g} % of the peak)")
    elif np.isfinite(r.lowest):
        line("displacement at failure", f"not broken (lowest {mean} after the peak: "
             f"{100 * r.lowest:.3g} % of it, at {r.lowest_opening * way:.4g} {unit})")
    else:
        line("displacement at failure", f"not broken (the run ends at step {bond.step[-1]:.0f}, less than {r.window:g} steps "
             "after the peak)" if r.peak > 0.0 else "not broken (never in tension)")
    line("failed points", f"{r.failed} of {bond.points[-1]:.0f}")
    line("links let go", f"{r.let_go} of {r.let_go + r.attached}")
    line("links attached", f"{r.attached}")
    line("dissipated energy", f"{r.dissipated:.5g} J" + (" (all bonds)" if bonds > 1 else ""))
    line("energy imbalance at the end", f"{r.imbalance:.2g} of the work" + (" (all bonds)" if bonds > 1 else ""))


def write(path, bonds, results):
    header = ["bond", "grain1", "grain2", "peak_force_N", "stiffness_N_per_m", "opening_at_peak_m", "broken",
              "opening_at_failure_m", "lowest_mean_tension_over_peak", "opening_at_lowest_m", "points",
              "failed_points", "links_let_go", "links_attached", "dissipated_energy_all_bonds_J",
              "energy_imbalance_all_bonds", "last_step", "window_steps"]
    try:
        with open(path, "w", newline="") as f:
            out = csv.writer(f, lineterminator="\n")
            out.writerow(header)
            for b in bonds:
                r = results[b.number]
                values = [r.peak, r.stiffness, r.peak_opening, "yes" if r.broken else "no", r.failure_opening, r.lowest,
                          r.lowest_opening, int(b.points[-1]), r.failed, r.let_go, r.attached, r.dissipated,
                          r.imbalance, int(b.step[-1]), r.window]
                out.writerow([b.number, *b.grains] + [f"{v:.8g}" if isinstance(v, float) else v for v in values])
    except OSError as e:
        raise run.Trouble(f"{path}: {e.strerror}; name a folder that can be written with --out") from None
