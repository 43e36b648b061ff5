#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Unconfined strength over calcite content: specimens of this program beside published ones.

    tests/verification/published_strengths.py FIGURE

Reads doc/data/published_ucs.csv (numbers, medians and ranges of published specimens in classes of content) and
doc/data/specimen.csv (the 150 beads of doc/specimen.md), and doc/data/validation.json (80 beads with a share of their calcite at
contacts), prints the table of doc/validation.md and draws the figure.
Needs Debian's python3-numpy and python3-matplotlib.
"""
import csv
import json
import os
import sys

import numpy as np

DATA = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "doc", "data")
ALL = "all 13 studies"


def published():
    """Classes of content by study: content %, numbers, lowest, median, highest strength in MPa."""
    found = {}
    with open(os.path.join(DATA, "published_ucs.csv"), encoding="utf-8") as f:
        for row in csv.DictReader(f):
            found.setdefault(row["study"], []).append({k: float(v) for k, v in row.items() if k != "study"})
    return found


def ours():
    """Content in %, unconfined and tensile strength in MPa of the 150 beads."""
    with open(os.path.join(DATA, "specimen.csv"), encoding="utf-8") as f:
        rows = [r for r in csv.DictReader(f) if float(r["pressure"]) == 0]
    content = sorted({float(r["content_of_all"]) for r in rows})
    by = {(r["test"], float(r["content_of_all"])): 1e-6 * float(r["strength"]) for r in rows}
    return np.array([[100 * c, by["compression", c], by["tension", c]] for c in content])


def exponent(content, strength):
    """Of the power law that fits best."""
    return float(np.polyfit(np.log(content), np.log(strength), 1)[0])


def active_share(content, strength, mine):
    """Share of the calcite at contacts with which the beads have the strength: their power law of content, inverted."""
    slope, log_one = np.polyfit(np.log(mine[:, 0]), np.log(mine[:, 1]), 1)
    return np.exp((np.log(strength) - log_one) / slope) / content


def main():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"font.size": 8, "legend.fontsize": 6.5, "axes.linewidth": 0.6, "savefig.dpi": 200, "xtick.direction": "in", "ytick.direction": "in"})
    studies, mine = published(), ours()
    with open(os.path.join(DATA, "validation.json"), encoding="utf-8") as f:
        checks = json.load(f)["active_share_runs"]
    fig, (ax, share) = plt.subplots(1, 2, figsize=(7.5, 4.4), gridspec_kw={"width_ratios": (1.45, 1.0)})
    shown = [name for name, rows in studies.items() if name != ALL and len(rows) > 2]
    for i, name in enumerate(shown):
        style = {"lw": 0.8, "marker": "ov^sD"[i % 5], "ms": 2.5, "color": plt.get_cmap("tab20")(i % 20)}
        ax.plot([r["calcite_median_percent"] for r in studies[name]], [r["ucs_median_MPa"] for r in studies[name]], **style, label=f"{name}, medians")
    whole = studies[ALL]
    middle = np.array([r["calcite_median_percent"] for r in whole])
    median, low, high = (np.array([r[f"ucs_{n}_MPa"] for r in whole]) for n in ("median", "lowest", "highest"))
    ax.errorbar(
        middle,
        median,
        [median - low, high - median],
        fmt="o",
        ms=4,
        color="0.35",
        ecolor="0.75",
        elinewidth=4,
        capsize=0,
        zorder=0,
        label="351 specimens: median, range",
    )
    ax.plot(mine[:, 0], mine[:, 1], "s-", color="#1b2a49", ms=5, label="150 beads here, all calcite at contacts")
    at = np.exp(np.interp(np.log(mine[-1, 0]), np.log(middle), np.log(median)))
    ax.plot(
        mine[:, 0],
        mine[:, 1] * at / mine[-1, 1],
        "s--",
        color="#1b2a49",
        ms=4,
        mfc="white",
        lw=0.9,
        label=f"the same, B0 for the median at {mine[-1, 0]:.1f} %",
    )
    stars = [[100 * c["calcite"] for c in checks], [1e-6 * c["strength"] for c in checks]]
    shares = ", ".join(f"{100 * c['at_contacts']:.0f}" for c in checks)
    ax.plot(*stars, "*", color="#c1272d", ms=9, zorder=9, label=f"80 beads here, {shares} % at contacts")
    ax.set_yscale("log")
    ax.set_ylim(0.04, 20)
    ax.set_xlabel("calcite over mass of the grains, %")
    ax.set_ylabel("unconfined compressive strength, MPa")
    for axis in (ax, share):
        axis.set_xscale("log")
        axis.set_xlim(1, 40)
        axis.minorticks_off()
        axis.set_xticks([1, 2, 5, 10, 20, 40], labels=["1", "2", "5", "10", "20", "40"])
    ax.yaxis.set_major_formatter("{x:g}")
    needed = active_share(middle, median, mine)
    share.plot(middle, 100 * needed, "o-", color="0.35", ms=4)
    share.set_ylim(0, 60)
    share.set_xlabel("calcite over mass of the grains, %")
    share.set_ylabel("at contacts, % of the calcite,\nfor the median strength")
    fig.tight_layout(rect=(0, 0.18, 1, 1))
    fig.legend(*ax.get_legend_handles_labels(), frameon=False, loc="lower center", ncol=3, handlelength=1.8, labelspacing=0.3)
    fig.savefig(sys.argv[1])
    print("calcite, %  specimens  lowest, median, highest MPa  here over median  share at contacts, %")
    slope, log_one = np.polyfit(np.log(mine[:, 0]), np.log(mine[:, 1]), 1)
    for r, s in zip(whole, needed):
        here = np.exp(log_one + slope * np.log(r["calcite_median_percent"]))
        inside = mine[0, 0] < r["calcite_median_percent"] < 1.1 * mine[-1, 0]
        print(
            f"{r['calcite_from_percent']:g} to {r['calcite_to_percent']:g}  {r['specimens']:.0f}  {r['ucs_lowest_MPa']:g}, {r['ucs_median_MPa']:g}, {r['ucs_highest_MPa']:g}"
            f"  {here / r['ucs_median_MPa']:.1f}{'' if inside else ' (extrapolated)'}  {100 * s:.0f}"
        )
    print(f"exponent here {slope:.2f}, of the medians {exponent(middle, median):.2f}")
    for name, rows in studies.items():
        if len(rows) > 2:
            print(f"{name}: {exponent([r['calcite_median_percent'] for r in rows], [r['ucs_median_MPa'] for r in rows]):.2f}")


if __name__ == "__main__":
    main()
