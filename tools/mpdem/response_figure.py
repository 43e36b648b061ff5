# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Stress, volume strain, broken bonds and contacts of a specimen over its axial strain."""
import numpy as np

from .figures import plt, styled

COLOURS = ("#1b2a49", "#c8553d")
MODES = (("internal", "inside the cement", "#1f6fb4"), ("mixed", "mixed", "#8a5fa8"), ("debonding", "debonding from a bead", "#c1272d"))


def smooth(x, rows):
    """Running mean over an odd number of rows, fewer at the ends."""
    rows = max(min(rows, len(x)), 1)
    ones = np.ones(rows)
    return np.convolve(x, ones, "same") / np.convolve(np.ones(len(x)), ones, "same")


def name_of(load):
    return f"{100 * load.of_all:.3g} % calcite" if load.of_all else "no cement"


def residual(ax, items):
    """An inset with the stress after a high peak."""
    r = items[0][1]
    top = int(np.argmax(r["q"]))
    after = r["axial_strain"] > 2 * r["axial_strain"][top]
    if not after.any() or r["q"][after].mean() > 0.3 * r["q"][top]:
        return
    inset = ax.inset_axes((0.34, 0.22, 0.62, 0.46))
    for (_, r, _), colour in zip(items, COLOURS):
        inset.plot(100 * r["axial_strain"], 1e-3 * smooth(r["q"], 2 * (len(r["q"]) // 400) + 1), color=colour, lw=0.8)
    high = 2.0e-3 * np.percentile(items[0][1]["q"][after], 90)
    inset.set_xlim(0.0, max(100 * r["axial_strain"].max() for _, r, _ in items))
    inset.set_ylim(0.0, max(high, 1e-6))
    inset.set_title("the same, after the peak", fontsize=6, pad=2)
    inset.tick_params(labelsize=6)
    inset.grid(True, lw=0.3, color="0.9")


@styled
def response(items):
    """items: (load, response, fabric); the first one is drawn with all that is known, another one beside it."""
    first = items[0][0]
    fig, axes = plt.subplots(2, 2, figsize=(7.48, 5.0), sharex="col")
    (stress, volume), (bonds, contacts) = axes
    for (load, r, f), colour in zip(items, COLOURS):
        e = 100 * r["axial_strain"]
        rows = 1 if first.kind == "cyclic" else 2 * (len(e) // 400) + 1
        stress.plot(e, 1e-3 * r["q"], color=colour, lw=0.4, alpha=0.35)
        stress.plot(e, 1e-3 * smooth(r["q"], rows), color=colour, lw=1.0, label=name_of(load))
        top = int(np.argmax(r["q"]))
        stress.plot(e[top], 1e-3 * r["q"][top], "o", color=colour, ms=3)
        if first.kind == "undrained":
            volume.plot(e, 1e-3 * smooth(load.pressure - r["side_stress"], rows), color=colour, lw=1.0, label=name_of(load))
        else:
            volume.plot(e, 100 * r["volume_strain"], color=colour, lw=1.0, label=name_of(load))
        x = 100 * f["axial_strain"]
        more = f"{name_of(load)}: " if len(items) > 1 else ""
        some = 1 if first.kind == "cyclic" else 2 * (len(x) // 100) + 1
        contacts.plot(x, smooth(f["coordination"], some), color=colour, lw=1.0, label=f"{more}touching beads")
        if load.kind != "uncemented":
            contacts.plot(x, smooth(f["coordination_with_bonds"], some), color=colour, lw=0.8, ls="--", label=f"{more}touching or joined by cement")
        contacts.plot(x, smooth(2 * f["new_contacts"] / f["beads"], some), color=colour, lw=0.8, ls=":", label=f"{more}new touching beads")
    r = items[0][1]
    e = 100 * r["axial_strain"]
    if first.kind != "uncemented":
        if first.kind == "cyclic":
            bonds.plot(e, r["broken"], color=COLOURS[0], lw=1.0, label="all")
        else:
            low = np.zeros(len(e))
            for key, words, colour in MODES:
                if r[key].any():
                    bonds.fill_between(e, low, low + r[key], color=colour, alpha=0.8, lw=0, label=words)
                low = low + r[key]
        bonds.plot(100 * items[0][2]["axial_strain"], items[0][2]["pieces"], color="k", lw=0.8, ls="--", label="pieces of joined beads")
    stress.set_ylabel("axial stress less that of the sides (kPa)")
    volume.set_ylabel("pressure of the pores (kPa)" if first.kind == "undrained" else "volume strain, dilation upward (%)")
    bonds.set_ylabel("broken bonds, by where they broke")
    contacts.set_ylabel("contacts a bead")
    kinds = {"drained": "drained", "undrained": "undrained, the volume stays", "cyclic": "cyclic", "uncemented": "drained"}
    stress.set_title(f"triaxial, {1e-3 * first.pressure:.4g} kPa on the sides, {kinds[first.kind]}", loc="left")
    if first.kind != "cyclic":
        stress.set_ylim(0.0, None)
        residual(stress, items)
    bonds.set_ylim(0.0, 1.25 * max(bonds.get_ylim()[1], 1.0))
    contacts.set_ylim(0.0, 1.6 * contacts.get_ylim()[1])
    for ax in axes.flat:
        ax.grid(True, lw=0.3, color="0.9")
        if first.kind != "cyclic":
            ax.set_xlim(0.0, max(100 * r["axial_strain"].max() for _, r, _ in items))
        if ax.get_legend_handles_labels()[0]:
            ax.legend(frameon=False, fontsize=6, loc="upper right" if ax is stress else "upper left")
    for ax in axes[1]:
        ax.set_xlabel("axial strain (%)")
    fig.tight_layout()
    return fig
