#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""What do pores, soft places and contact in patches take from the strength of a flat bond, in tension and shear?

    tools/flawed_pairs.py OUT
    tools/flawed_pairs.py OUT --pores 0.2,0.4 --softness '' --contact '' --seeds 3
    tools/flawed_pairs.py OUT --redraw doc/data/study_flaws.csv

Makes the points of a bond without flaws by examples/flawed_pair/in.solid, puts flaws into them (tools/mpdem/flaws.py) and loads each
by examples/pair_table/in.pair_table. Leaves flaws.csv and flaws.png in OUT. Called again it goes on where it was stopped.
--redraw runs nothing. Needs Debian's python3-numpy, python3-pandas and python3-matplotlib.
"""
import argparse
import csv
import os
import subprocess
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    from mpdem import flaws, run, runner, table
except ImportError as missing:
    sys.exit(
        f"flawed_pairs.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
COLUMNS = ("flaw", "amount", "seed", "load", "peak", "mode", "share_beads", "broken", "imbalance", "points", "steps", "wall")
CUTOFF = 0.9  # of the damage, as in the script
TITLES = {"pores": "pores, share of the volume", "softness": "largest damage at the start", "contact": "attached share of one bead's area"}


def shares(text):
    try:
        found = [float(t) for t in text.split(",") if t]
    except ValueError:
        found = [-1.0]
    if any(not 0.0 < v < 1.0 for v in found):
        raise argparse.ArgumentTypeError(f"{text}: must be numbers between 0 and 1 with commas between them")
    return found


def positive(text):
    try:
        return table.number("it", text)
    except run.Trouble:
        raise argparse.ArgumentTypeError(f"{text}: must be a positive number") from None


def arguments():
    p = argparse.ArgumentParser(description="Strength of flat bonds with pores, soft places and contact in patches.")
    p.add_argument("out", metavar="OUT", help="folder of the runs, flaws.csv and flaws.png")
    p.add_argument("--pores", metavar="P,Q", type=shares, default=[0.1, 0.2, 0.3, 0.4, 0.5], help="shares of the volume without cement")
    p.add_argument("--softness", metavar="D,E", type=shares, default=[0.3, 0.6, 0.85], help="largest damages at the start, below 0.9")
    p.add_argument("--contact", metavar="S,T", type=shares, default=[0.5, 0.25, 0.1, 0.05], help="attached shares of the area at one bead")
    p.add_argument("--seeds", metavar="N", type=runner.at_least_one, default=2, help="bonds of each, with flaws in other places (2)")
    p.add_argument("--size", metavar="R", type=positive, default=3e-4, help="radius of pores, soft places and patches, m (3e-4)")
    p.add_argument("--content", metavar="C", type=positive, default=0.05, help="mass of cement over that of the beads, before there are flaws (0.05)")
    p.add_argument("--coarse", metavar="S", type=positive, default=1e-4, help="spacing of the points, m (1e-4)")
    p.add_argument("--bonding", metavar="LAW", default="cohesive tn 1e7 tt 1e7 Gn 10.6 Gt 10.6", help="interface of the bonds with contact in patches")
    p.add_argument("--redraw", metavar="CSV", help="a flaws.csv of earlier runs, to be drawn again")
    runner.add_arguments(p, os.path.join(ROOT, "build", "liggghts-mpdem"))
    return p.parse_args()


def make_points(args):
    """Files of the points, each once; (flaw, amount, seed, name) of each."""
    folder = os.path.join(args.out, "points")
    run.make_folder(folder)
    key = f"{args.content:g}_{args.coarse:g}"
    solid = f"solid_{key}.txt"
    if not os.path.exists(os.path.join(folder, solid)):
        command = runner.command(
            os.path.abspath(args.exe),
            os.path.join(ROOT, "examples", "flawed_pair", "in.solid"),
            1,
            {"content": f"{args.content:g}", "spacing": f"{args.coarse:g}", "out": solid + ".tmp"},
        )
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if done.returncode or "RESULT" not in done.stdout:
            trouble = [line for line in done.stdout.splitlines() if line.startswith("ERROR")]
            raise run.Trouble(trouble[0] if trouble else f"no points were made: status {done.returncode}")
        os.replace(os.path.join(folder, solid + ".tmp"), os.path.join(folder, solid))
    found = [(kind, 1.0 if kind == "contact" else 0.0, 0, solid) for kind in flaws.KINDS if getattr(args, kind)]
    for kind in flaws.KINDS:
        for amount in getattr(args, kind):
            for seed in range(1, args.seeds + 1):
                name = f"{kind}_{amount:g}_{seed}_{args.size:g}_{key}.txt"
                if not os.path.exists(os.path.join(folder, name)):
                    flaws.make(kind, amount, args.size, seed, os.path.join(folder, solid), os.path.join(folder, name + ".tmp"))
                    os.replace(os.path.join(folder, name + ".tmp"), os.path.join(folder, name))
                found.append((kind, amount, seed, name))
    return found


def pair(args, kind, name, load):
    extra = {
        "points": f"../points/{name}",
        "coarse": f"{args.coarse:g}",
        "cracks": "split",
        "regularization": f"nonlocal {2 * args.coarse:g} energy {10.6 * args.coarse / 1e-4:g}",
    }
    if kind == "contact":
        extra["bonding"] = args.bonding
    return table.Run("file", load, args.content, extra, os.path.join(ROOT, "examples", "pair_table", "in.pair_table"))


def write(path, rows):
    with open(path + ".tmp", "w", newline="") as f:
        w = csv.writer(f, lineterminator="\n")
        w.writerow(COLUMNS)
        for row in rows:
            w.writerow([f"{row[c]:.6g}" if isinstance(row[c], float) else row[c] for c in COLUMNS])
    os.replace(path + ".tmp", path)


def read(path):
    try:
        with open(path, newline="") as f:
            table = csv.DictReader(f)
            rows = list(table)
        lacking = [c for c in COLUMNS[:5] if c not in (table.fieldnames or [])]
        if lacking or not rows:
            raise ValueError
        return [{**r, "amount": float(r["amount"]), "peak": float(r["peak"])} for r in rows]
    except (KeyError, ValueError, TypeError):
        raise run.Trouble(f"{path}: not a flaws.csv of flawed_pairs.py, or one without rows; name another") from None


def draw(path, rows):
    from mpdem.figures import plt, save

    kinds = [k for k in flaws.KINDS if any(r["flaw"] == k for r in rows)]
    fig, axes = plt.subplots(1, len(kinds), figsize=(3.0 * len(kinds) + 0.4, 3.2), squeeze=False, sharey=True)
    for ax, kind in zip(axes[0], kinds):
        for load, colour, mark in (("tension", "#1b2a49", "o"), ("shear", "#c8553d", "s")):
            mine = [r for r in rows if r["flaw"] == kind and r["load"] == load]
            whole = [r["peak"] for r in mine if r["amount"] == (1.0 if kind == "contact" else 0.0)]
            if whole:
                ax.plot([r["amount"] for r in mine], [r["peak"] / whole[0] for r in mine], mark, color=colour, mfc="none", label=load)
        ax.set_xlabel(TITLES[kind])
        ax.set_xlim(-0.03, 1.03)
        ax.grid(alpha=0.3, which="both")
    axes[0][0].set_yscale("log")
    axes[0][0].set_yticks([0.05, 0.1, 0.2, 0.5, 1.0], ["0.05", "0.1", "0.2", "0.5", "1"])
    axes[0][0].set_yticks([], minor=True)
    axes[0][0].set_ylabel("largest force over that\nof the bond without flaws")
    fig.tight_layout(rect=(0, 0.1, 1, 1))
    fig.legend(*axes[0][0].get_legend_handles_labels(), loc="lower center", ncol=2, frameon=False)
    save(fig, path)


def main():
    args = arguments()
    if args.redraw:
        rows = read(args.redraw)
        run.make_folder(args.out)
        draw(os.path.join(args.out, "flaws.png"), rows)
        print(f"written to {args.out}: flaws.png")
        return
    soft = [d for d in args.softness if d >= CUTOFF]
    if soft:
        raise run.Trouble(f"--softness {soft[0]:g}: must be below {CUTOFF:g}, the cut-off of the script")
    runner.check_executable(args)
    run.make_folder(args.out)
    files = make_points(args)
    pairs = {(kind, amount, seed, load): pair(args, kind, name, load) for kind, amount, seed, name in files for load in ("tension", "shear")}
    distinct = {r.label: r for r in pairs.values()}
    all_runs, stopped = runner.make_runs(args, args.out, list(distinct.values()))
    rows = []
    for (kind, amount, seed, load), of_pair in pairs.items():
        results = runner.finished(os.path.abspath(args.out), of_pair)
        if results is not None:
            rows.append(
                {
                    **results,
                    "flaw": kind,
                    "amount": amount,
                    "seed": seed,
                    "load": load,
                    "share_beads": results["share_grain1"] + results["share_grain2"],
                    "broken": "yes" if results["broken"] else "no",
                }
            )
    write(os.path.join(args.out, "flaws.csv"), rows)
    names = ["flaws.csv"]
    if rows:
        draw(os.path.join(args.out, "flaws.png"), rows)
        names.append("flaws.png")
    print(f"written to {args.out}: {', '.join(names)}")
    runner.tell_end("flawed_pairs.py", all_runs, stopped)


if __name__ == "__main__":
    run.end_with_message("flawed_pairs.py", main)
