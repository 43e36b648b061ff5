#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The same bonds here and as cohesive contacts of Yade: a pair of 10 mm beads and a specimen of 80 beads.

    tests/verification/beside_yade.py OUT --exe build/liggghts-mpdem
    tests/verification/beside_yade.py OUT --redraw

Yade gets positions, radii, bonds, stiffness and strength from this program: stiffness of bond_stiffness, strength of pairs
that in.pair_table pulls and shears. Leaves results.json and two figures in OUT. Runs one process at a time; finished runs
are kept. Needs Debian's packages yade, python3-numpy and python3-matplotlib; tests need none of it.
"""
import argparse
import csv
import glob
import json
import os
import re
import resource
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
PAIR = os.path.join(ROOT, "examples", "pair_table", "in.pair_table")
SPECIMEN = os.path.join(ROOT, "examples", "specimen")
LOADS = ("tension", "shear", "bending")
FLAT = ["-var", "shape", "flat", "-var", "content", "0.01", "-var", "gap", "5e-4", "-var", "inner", "0", "-var", "cracks", "split"]
FLAT += ["-var", "regularization", "nonlocal 2e-4 energy 10"]
# A film of the specimen's content between beads that touch. Stresses do not depend on the size of the beads.
FILM = ["-var", "shape", "flat", "-var", "content", "0.006", "-var", "spacing", "5e-4", "-var", "zeta", "0.1", "-var", "courant", "0.1"]
ELASTIC = "elastic vti 50.83e9 28.79e9 0.2744 0.2581 14.86e9 axis radial"
SPEED, RAMP = 0.007, 2e-4  # of the plate, as in in.load
POINTS = 200  # of a curve that is kept
STIFFNESS = f"""
units si
atom_style mpdem
atom_modify map array first grains
boundary f f f
newton off
communicate single vel yes
region box block -0.012 0.012 -0.012 0.012 -0.02 0.02 units box
create_box 2 box
create_atoms 1 single 0 0 -0.00525 units box
create_atoms 1 single 0 0 0.00525 units box
set type 1 diameter 0.01 density 2500
group grains type 1
communicate single vel yes group grains
neighbor 0.001 bin
neigh_modify include grains delay 0
create_cement calcite pair 1 2 shape flat content 0.01 inner 0 spacing 1e-4
timestep 1e-9
fix cem calcite mpm cell 2e-4 {ELASTIC}
fix bond grains mpm/couple cem
bond_stiffness stiffness.csv
"""
STIFFNESS_OF_SPECIMEN = f"""
variable here index {SPECIMEN}
include ${{here}}/beads.in
read_restart ../cemented/cemented.restart
include ${{here}}/contacts.in
timestep 1e-9
fix cem calcite mpm cell 4e-4 {ELASTIC}
fix bond grains mpm/couple cem
dump beads grains custom 1 beads.txt id x y z radius
dump_modify beads format "%d %.12g %.12g %.12g %.12g"
bond_stiffness stiffness.csv
run 0
"""


class Runs:
    """Runs of OUT, each in a folder of its own, whose file `cpu` is written last."""

    def __init__(self, out, exe):
        self.out, self.exe = os.path.abspath(out), os.path.abspath(exe)

    def folder(self, name):
        return os.path.join(self.out, name)

    def make(self, name, command):
        """CPU seconds of the run."""
        folder = self.folder(name)
        done = os.path.join(folder, "cpu")
        if not os.path.exists(done):
            os.makedirs(folder, exist_ok=True)
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            with open(os.path.join(folder, "out"), "w", encoding="utf-8") as f:
                subprocess.run(command, cwd=folder, stdout=f, stderr=subprocess.STDOUT, check=True)
            with open(done, "w", encoding="utf-8") as f:
                f.write(f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before:.2f}\n")
        with open(done, encoding="utf-8") as f:
            return float(f.read())

    def ours(self, name, script, words=()):
        return self.make(name, [self.exe, "-in", script, *words])

    def text(self, name, script):
        os.makedirs(self.folder(name), exist_ok=True)
        path = os.path.join(self.folder(name), "in.script")
        with open(path, "w", encoding="utf-8") as f:
            f.write(script)
        return self.ours(name, path)

    def yade(self, name, case):
        os.makedirs(self.folder(name), exist_ok=True)
        path = os.path.join(self.folder(name), "case.json")
        with open(path, "w", encoding="utf-8") as f:
            json.dump({**case, "results": os.path.join(self.folder(name), "results.json")}, f)
        self.make(name, ["yade", "-n", "-x", "-j1", os.path.join(HERE, "yade_bonds.py"), path])
        with open(os.path.join(self.folder(name), "results.json"), encoding="utf-8") as f:
            return json.load(f)

    def table(self, name, file):
        return np.genfromtxt(os.path.join(self.folder(name), file), delimiter=",", names=True)

    def said(self, name, pattern):
        with open(os.path.join(self.folder(name), "out"), encoding="utf-8", errors="replace") as f:
            return re.findall(pattern, f.read(), re.M)[-1]


def thinned(*columns):
    """Rows of a curve, at most POINTS and the peak of its second column."""
    table = np.array(columns, dtype=float)
    if table.shape[1] <= POINTS:
        keep = np.arange(table.shape[1])
    else:
        keep = np.unique(np.append(np.linspace(0, table.shape[1] - 1, POINTS).astype(int), table[1].argmax()))
    return [[float(f"{v:.6g}") for v in column] for column in table[:, keep]]


def pairs(runs):
    """The pair of 10 mm beads, by load: here and in Yade."""
    runs.text("pair/stiffness", STIFFNESS)
    k = runs.table("pair/stiffness", "stiffness.csv")
    found = {"stiffness": {name: float(k[name]) for name in ("tension", "shear_min", "torsion", "bending_min")}, "loads": {}}
    ours = {}
    for load in LOADS:
        cpu = runs.ours(f"pair/{load}", PAIR, [*FLAT, "-var", "load", load])
        curve = runs.table(f"pair/{load}", "load_run.csv")
        mode, steps = runs.said(f"pair/{load}", r"^RESULT .* mode (\S+) .* steps (\d+)")
        ours[load] = {"peak": float(curve["load"].max()), "mode": mode, "steps": int(steps), "cpu": cpu, "curve": thinned(curve["way"], curve["load"])}
    strength, shear = ours["tension"]["peak"], ours["shear"]["peak"]
    bond = [1, 2, *(found["stiffness"][n] for n in ("tension", "shear_min", "torsion", "bending_min")), strength, shear]
    for load in LOADS:
        case = {"beads": [[1, 0, 0, -0.00525, 0.005], [2, 0, 0, 0.00525, 0.005]], "bonds": [bond], "damping": 0, "load": load}
        way = ours[load]["curve"][0]
        reach = 1.5 * way[int(np.argmax(ours[load]["curve"][1]))]
        case.update({"speed": 0.04 if load != "bending" else 16.0, "rows": 200, "every": 20})
        case["step"] = reach / (case["speed"] * case["rows"] * case["every"])
        yade = runs.yade(f"yade/{load}", case)
        rows = np.array(yade["curve"])
        mode = "broken" if rows[-1, 2] else "not broken"
        theirs = {"peak": float(rows[:, 1].max()), "mode": mode, "steps": yade["steps"], "cpu": yade["cpu"], "curve": thinned(rows[:, 0], rows[:, 1])}
        found["loads"][load] = {"here": ours[load], "yade": theirs}
    return found


def films(runs):
    """Tension and shear that break a film of the specimen, over the radius of its larger bead squared, by the ratio of the diameters."""
    found = {}
    for ratio, diameter in ((1.0, "0.01"), (0.85, "0.0085")):
        values = []
        for load in ("tension", "shear"):
            runs.ours(f"film/{load}_{diameter}", PAIR, [*FILM, "-var", "diameter", diameter, "-var", "load", load, "-var", "limit", "6000"])
            values.append(float(runs.said(f"film/{load}_{diameter}", r"^PEAK of all steps ([^,]+),")) / 0.005**2)
        found[ratio] = values
    return found


def loading(folder):
    """Rows of in.load, which writes a new table after each checkpoint."""
    later = sorted(glob.glob(os.path.join(folder, "curve_from_*.csv")), key=lambda name: int(re.findall(r"\d+", os.path.basename(name))[0]))
    tables = [np.genfromtxt(name, delimiter=",", names=True) for name in (os.path.join(folder, "curve.csv"), *later)]
    return np.concatenate([tables[0], *(t[1:] for t in tables[1:])])  # the force of the first row of a later table is 0


def specimen(runs):
    """The specimen: compression here and in Yade, there with moments of the bonds and without."""
    here = ["-var", "here", SPECIMEN]
    runs.ours("poured", os.path.join(SPECIMEN, "in.pour"), [*here, "-var", "beads", "80"])
    runs.ours("cemented", os.path.join(SPECIMEN, "in.cement"), [*here, "-var", "poured", "../poured", "-var", "content", "0.006"])
    runs.text("stiffness", STIFFNESS_OF_SPECIMEN)
    cpu = runs.ours("compression", os.path.join(SPECIMEN, "in.load"), [*here, "-var", "poured", "../poured", "-var", "cemented", "../cemented"])
    with open(os.path.join(runs.folder("poured"), "poured.in"), encoding="utf-8") as f:
        size = {k: float(v) for k, v in re.findall(r"^variable (\w+) +index (\S+)", f.read(), re.M)}
    curve = loading(runs.folder("compression"))
    strain, stress = curve["way"] / size["height"], curve["force"] / size["side"] ** 2
    with open(os.path.join(runs.folder("stiffness"), "beads.txt"), encoding="utf-8") as f:
        beads = [[float(v) for v in row.split()] for row in f.read().splitlines()[9:]]
    radius = {int(b[0]): b[4] for b in beads}
    strengths, bonds = films(runs), []
    with open(os.path.join(runs.folder("stiffness"), "stiffness.csv"), encoding="utf-8") as f:
        for row in csv.DictReader(f):
            one, other = int(row["grain1"]), int(row["grain2"])
            small, large = sorted((radius[one], radius[other]))
            tension, shear = (large**2 * v for v in strengths[1.0 if small > 0.99 * large else 0.85])
            bending = 0.5 * (float(row["bending_min"]) + float(row["bending_max"]))
            bonds.append([one, other, float(row["tension"]), float(row["shear_min"]), float(row["torsion"]), bending, tension, shear])
    steps = int(curve["step"][-1] - curve["step"][0])
    found = {
        "beads": len(beads),
        "bonds": len(bonds),
        "height": size["height"],
        "side": size["side"],
        "strength_over_radius_squared": {str(k): v for k, v in strengths.items()},
        "here": {
            "strength": float(stress.max()),
            "strain": float(strain[stress.argmax()]),
            "broken_at_peak": int(curve["broken"][stress.argmax()]),
            "broken": int(curve["broken"][-1]),
            "steps": steps,
            "step": float(np.diff(curve["time"])[5] / np.diff(curve["step"])[5]),
            "cpu": cpu,
            "curve": thinned(strain, stress, curve["broken"]),
        },
    }
    case = {"load": "compression", "beads": [[int(b[0]), *b[1:]] for b in beads], **size, "speed": SPEED, "ramp": RAMP, "every": 50, "limit": 200000}
    case.update({"strain": 1.5 * found["here"]["strain"], "safety": 0.5})
    for name, damping, moments in (("yade", 0.2, 1.0), ("yade, no moments", 0.2, 0.0), ("yade, damping 0.05", 0.05, 1.0)):
        own = [[*b[:4], moments * b[4], moments * b[5], *b[6:]] for b in bonds]
        yade = runs.yade(name.replace(", ", "_").replace(" ", "_") + "/compression", {**case, "bonds": own, "damping": damping})
        rows = np.array(yade["curve"]).T
        top = int(rows[1].argmax())
        found[name] = {"strength": float(rows[1, top]), "strain": float(rows[0, top]), "broken_at_peak": int(rows[3, top]), "broken": int(rows[3, -1])}
        found[name].update({k: yade[k] for k in ("steps", "step", "cpu")})
        found[name]["curve"] = thinned(rows[0], rows[1], rows[3])
    return found


def draw(out, found):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({"font.size": 8, "legend.fontsize": 7, "axes.linewidth": 0.6, "savefig.dpi": 200, "xtick.direction": "in", "ytick.direction": "in"})
    fig, axes = plt.subplots(1, 3, figsize=(7.5, 2.7))
    names = {"tension": ("displacement, um", "tension, N"), "shear": ("displacement, um", "shear force, N"), "bending": ("rotation, mrad", "moment, N m")}
    for ax, load in zip(axes, LOADS):
        both = found["pair"]["loads"][load]
        scale = 1e3 if load == "bending" else 1e6
        ax.plot(scale * np.array(both["here"]["curve"][0]), both["here"]["curve"][1], color="#1b2a49", label="cement of material points")
        ax.plot(scale * np.array(both["yade"]["curve"][0]), both["yade"]["curve"][1], "--", color="#c1272d", label="cohesive contact of Yade")
        ax.set_xlim(0, scale * both["yade"]["curve"][0][-1])
        ax.set_ylim(0, 1.35 * both["here"]["peak"])
        ax.set_xlabel(names[load][0])
        ax.set_ylabel(names[load][1])
        ax.set_title(f"{load}: {both['here']['mode']}; Yade: {both['yade']['mode']}", fontsize=7.5)
    fig.tight_layout(rect=(0, 0, 1, 0.91))
    handles, labels = axes[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="upper center", ncol=2, frameon=False)
    fig.savefig(os.path.join(out, "study_yade_pair.png"))
    fig, (ax, count) = plt.subplots(1, 2, figsize=(7.5, 3.0))
    lines = (
        ("here", "cement of material points", "#1b2a49", "-"),
        ("yade", "cohesive contacts of Yade", "#c1272d", "-"),
        ("yade, no moments", "the same without moments", "#d98b4a", "--"),
        ("yade, damping 0.05", "the same, local damping 0.05 (else 0.2)", "#6aa69a", ":"),
    )
    for key, label, colour, style in lines:
        curve = found["specimen"][key]["curve"]
        ax.plot(1e3 * np.array(curve[0]), 1e-6 * np.array(curve[1]), style, color=colour, label=label, lw=1.0)
        count.plot(1e3 * np.array(curve[0]), curve[2], style, color=colour, lw=1.0)
    for axis, label in ((ax, "stress on the plate, MPa"), (count, f"broken bonds of {found['specimen']['bonds']}")):
        axis.set_xlabel("strain between the plates, per mille")
        axis.set_ylabel(label)
        axis.set_xlim(0, None)
        axis.set_ylim(0, None)
    ax.legend(frameon=False, loc="upper left")
    ax.set_ylim(0, 1.45 * max(1e-6 * found["specimen"][key]["strength"] for key, *_ in lines))
    fig.tight_layout()
    fig.savefig(os.path.join(out, "study_yade_specimen.png"))


def main():
    parser = argparse.ArgumentParser(description="The same bonds here and in Yade.")
    parser.add_argument("out", metavar="OUT")
    parser.add_argument("--exe", default=os.path.join(ROOT, "build", "liggghts-mpdem"), help="the executable")
    parser.add_argument("--redraw", action="store_true", help="run nothing, draw what is in results.json")
    args = parser.parse_args()
    path = os.path.join(args.out, "results.json")
    if not args.redraw:
        runs = Runs(args.out, args.exe)
        found = {"pair": pairs(runs), "specimen": specimen(runs)}
        with open(path, "w", encoding="utf-8") as f:
            json.dump(found, f)
            f.write("\n")
    with open(path, encoding="utf-8") as f:
        draw(args.out, json.load(f))


if __name__ == "__main__":
    main()
