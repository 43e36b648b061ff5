#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Runs the benchmarks and writes tables and figures; see doc/performance.md.

    tools/bench_report.py [--quick] [--list] [--periods N] [--section N] [--build DIR] [--out DIR] [NAME ...]

NAME is the name of a benchmark or the beginning of it: `step/total`, `vortex`; none: all of
them, which takes 15 to 25 minutes. Writes results.json, rates.csv,
accuracy.csv, law.csv and a PNG a diagram to DIR, by default BUILD/bench/results.
"""
import argparse
import csv
import io
import json
import math
import os
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "bench"))
DEFAULT = "total/quadratic/none"
# Order in the cell size. All is second order, by the lumped mass, the quadrature at the points and
# the central difference. pic smooths the velocity by h^2/8 v'' in each of O(1/h) steps, which leaves
# first order; xpic2 by the square of that, and with apic the affine part takes it back.
EXPECTED = {"none": 2, "order2": 2, "flip": 2, "xpic2": 2, "pic": 1, "apic": 2}
# What a diagram shows on its axis of errors, all relative.
ERRORS = {
    "bar": "vibrating bar: error of the displacement (–)",
    "thick-bar": "thick vibrating bar: error of the displacement (–)",
    "cube": "stretched cube: error of the displacement (–)",
    "vortex": "vortex: error of the displacement (–)",
    "published-vortex": "published vortex: error of the displacement (–)",
    "stiffness": "ring between beads: error of the stiffness (–)",
    "peak": "peak force: distance from the finest default (–)",
}
PROBLEMS = ("bar", "thick-bar", "cube", "vortex", "published-vortex")
QUICK = [
    "law",
    "skip",
    "packing",
    "condensed",
    "fail",
    "machine",
    "scalar",
    "step/total/quadratic/none",
    "step/updated/quadratic/apic",
    "size/10648",
    f"bar/{DEFAULT}",
    "bar/total/linear/none",
    "bar/total/quadratic/order2",
    f"cube/{DEFAULT}",
    f"vortex/{DEFAULT}",
    "vortex/updated/quadratic/apic",
]


def arguments():
    p = argparse.ArgumentParser(description="Runs the benchmarks and writes tables and figures.")
    p.add_argument("names", metavar="NAME", nargs="*", help="benchmarks, by the first parts of their names")
    p.add_argument("--quick", action="store_true", help="a short run of less than a minute: few cells, short times")
    p.add_argument("--periods", metavar="N", type=int, default=1, help="how many periods the bars vibrate (1)")
    p.add_argument("--section", metavar="N", type=int, default=6, help="cells across the section of `bar` (6)")
    p.add_argument("--list", action="store_true", help="print the names")
    p.add_argument("--build", metavar="DIR", type=Path, default=ROOT / "build", help="build directory")
    p.add_argument("--out", metavar="DIR", type=Path, help="where to write (default: BUILD/bench/results)")
    args = p.parse_args()
    for word, value in (("--periods", args.periods), ("--section", args.section)):
        if value < 1:
            p.error(f"{word} {value}: must be 1 or more")
    return args


def output(*command):
    return subprocess.run([str(c) for c in command], check=True, stdout=subprocess.PIPE, text=True).stdout


def tell(text):
    print(text, file=sys.stderr, flush=True)


def chosen(names, wanted):
    """Those that begin with one of `wanted`, by whole names between slashes."""
    for w in wanted:
        if not any((n + "/").startswith(w.rstrip("/") + "/") for n in names):
            sys.exit(f"bench_report.py: unknown benchmark '{w}'; names, or the first parts of them, are\n  " + "\n  ".join(names))
    return [n for n in names if any((n + "/").startswith(w.rstrip("/") + "/") for w in wanted)]


def rates(program, names, quick):
    found = json.loads(output(program, *(f"^{n}$" for n in names), "--benchmark_format=json", f"--benchmark_min_time={0.02 if quick else 0.4}"))["benchmarks"]
    keep = ("points", "points/s", "bytes/point", "fill", "crossing", "growing", "flop/s", "bytes/s")
    # CPU time, so that what else runs on the machine counts little; `points/s` is by that already.
    return [{"name": b["name"], "ms": b["cpu_time"], **{k: b[k] for k in keep if k in b}} for b in found]


def accuracy(program, names, quick, bars):
    text = output(program, *(["--quick"] if quick else []), *bars, *(f"^{n}$" for n in names))
    rows = list(csv.DictReader(io.StringIO(text)))
    return [{k: v if k in ("problem", "method") else float(v) for k, v in r.items()} for r in rows]


def law(program, names, quick):
    text = output(program, *(["--quick"] if quick else []), *(f"^{n}$" for n in names))
    return [{k: v if k == "law" else float(v) for k, v in r.items()} for r in csv.DictReader(io.StringIO(text))]


def curves(rows, problem):
    """Method to its rows, coarse to fine."""
    found = {}
    for r in rows:
        if r["problem"] == problem:
            found.setdefault(r["method"], []).append(r)
    return {m: sorted(c, key=lambda r: r["cells"]) for m, c in found.items()}


def order(curve):
    """Slope of the error over the three finest cells, nan where the run broke down."""
    import numpy as np

    e = [(math.log(r["cells"]), math.log(r["error"])) for r in curve[-3:] if r["error"] > 0]
    return -np.polyfit(*zip(*e), 1)[0] if len(e) >= 2 and len(e) == len(curve[-3:]) else math.nan


def better(rows, problem):
    """For each cell of the default: the methods that are as accurate in less time, by a tenth."""
    c = curves(rows, problem)
    return [
        (r["cells"], sorted({m for m, other in c.items() for o in other if m != DEFAULT and o["error"] <= r["error"] and o["seconds"] < 0.9 * r["seconds"]}))
        for r in c.get(DEFAULT, [])
    ]


def diagram(rows, problem, file):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    colours = {"none": "black", "order2": "tab:purple", "pic": "tab:red", "flip": "tab:green", "apic": "tab:blue", "xpic2": "tab:orange"}
    transfers = {"none": "no transfer", "order2": "no transfer,\nmass of order 2", "pic": "PIC", "flip": "FLIP", "apic": "APIC", "xpic2": "XPIC of order 2"}
    references = {"total": "reference kept", "updated": "reference updated"}
    panels = {"linear": "linear hat functions", "quadratic": "quadratic B-splines", "cubic": "cubic B-splines"}
    fig, axes = plt.subplots(1, 3, figsize=(11, 4.6), sharex=True, sharey=True)
    every = curves(rows, problem)
    for ax, basis in zip(axes, panels):
        ax.set_title(panels[basis])
        ax.grid(True, which="both", lw=0.3)
        for method, curve in every.items():
            kinematics, own_basis, transfer = method.split("/")
            if own_basis != basis or method == DEFAULT:
                continue
            ax.loglog(
                [r["seconds"] for r in curve],
                [r["error"] for r in curve],
                color=colours[transfer],
                lw=1.1,
                ms=4,
                marker="o" if kinematics == "total" else "x",
                ls="-" if kinematics == "total" else "--",
                label=f"{references[kinematics]},\n{transfers[transfer]}",
            )
        if DEFAULT in every:
            curve = every[DEFAULT]
            ax.loglog(
                [r["seconds"] for r in curve],
                [r["error"] for r in curve],
                color="black",
                lw=3,
                alpha=0.55,
                label="default: quadratic\nB-splines, reference\nkept, no transfer",
            )
        ax.set_xlabel("CPU time on one core (s)")
    axes[0].set_ylabel(ERRORS[problem])
    named = {line.get_label(): line for ax in axes for line in ax.lines}
    fig.tight_layout(rect=(0, 0, 0.86, 1))
    fig.legend(named.values(), named.keys(), loc="center left", bbox_to_anchor=(0.86, 0.5), fontsize=8, frameon=False)
    fig.savefig(file, dpi=90)
    plt.close(fig)


def size_diagram(found, file):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    sizes = sorted((r["points"], 1e9 / r["points/s"]) for r in found if r["name"].startswith("size/"))
    fig, ax = plt.subplots(figsize=(5, 3.2))
    ax.semilogx(*zip(*sizes), "ko-")
    ax.set(xlabel="number of points (–)", ylabel="time a point and step, one core (ns)", ylim=(0, None))
    ax.grid(True, lw=0.3)
    fig.tight_layout()
    fig.savefig(file, dpi=90)
    plt.close(fig)


def report(result):
    machine = {r["name"]: r for r in result["rates"]}
    lines = [f"load average {result['load']:.2f}"]
    if result["rates"]:
        lines += ["", f"{'benchmark':48} {'M points/s':>10} {'B/point':>8} {'fill':>5} {'growing':>8}"]
    for r in result["rates"]:
        if "points/s" in r:
            lines.append(
                f"{r['name']:48} {r['points/s'] / 1e6:10.2f} {r.get('bytes/point', math.nan):8.0f} "
                f"{r.get('fill', math.nan):5.2f} {r.get('growing', math.nan):8.3f}"
            )
    step = machine.get(f"step/{DEFAULT}/elastic")
    if step and "machine/triad" in machine and "machine/multiply_add" in machine:
        lines += [
            "",
            "one core: triad {:.1f} GB/s, multiply-add {:.1f} Gflop/s; the step moves {:.1f} GB/s ({:.0%}) "
            "and computes {:.1f} Gflop/s ({:.0%})".format(
                machine["machine/triad"]["bytes/s"] / 1e9,
                machine["machine/multiply_add"]["flop/s"] / 1e9,
                step["bytes/s"] / 1e9,
                step["bytes/s"] / machine["machine/triad"]["bytes/s"],
                step["flop/s"] / 1e9,
                step["flop/s"] / machine["machine/multiply_add"]["flop/s"],
            ),
        ]
    scalar = machine.get(f"scalar/{DEFAULT}/elastic")
    if step and scalar:
        lines.append(f"the step is {step['points/s'] / scalar['points/s']:.1f} times as fast as the scalar kernel")
    for problem in (*PROBLEMS, "stiffness", "peak"):
        c = curves(result["accuracy"], problem)
        if not c:
            continue
        lines += ["", f"{problem:34} {'expected':>8} {'order':>6} {'finest':>10} {'seconds':>8}"]
        for method, curve in c.items():
            lines.append(f"  {method:32} {EXPECTED[method.split('/')[-1]]:8} {order(curve):6.2f} " f"{curve[-1]['error']:10.2e} {curve[-1]['seconds']:8.3f}")
        for cells, methods in better(result["accuracy"], problem):
            lines.append(f"  as accurate as the default with {cells:.5g} cells in less time: {', '.join(methods) or 'none'}")
    for r in result["accuracy"]:
        if r["problem"] == "ranks":
            lines.append(f"\none rank {r['one']:.2f} s, two ranks {r['two']:.2f} s: {r['speedup']:.2f} times as fast")
    for name in dict.fromkeys(r["law"] for r in result["law"]):
        lines += ["", f"{name:34} {'evaluations':>11} {'ns':>6} {'D':>9} {'9 of 10':>9} {'stress':>9} {'9 of 10':>9} {'energy':>9} {'9 of 10':>9}"]
        lines += [
            f"  step {r['step']:<27g} {r['evaluations']:11.1f} {r['ns']:6.0f} {r['D']:9.1e} {r['D_90']:9.1e} {r['stress']:9.1e} "
            f"{r['stress_90']:9.1e} {r['energy']:9.1e} {r['energy_90']:9.1e}"
            for r in result["law"]
            if r["law"] == name
        ]
    for r in result["packings"]:
        lines.append(
            f"\npacking {r['packing']}: {r['bonds']} bonds, {r['points']} points, {r['points/s'] / 1e6:.2f} M points/s, "
            f"{r['bytes/point']:.0f} B/point, two ranks {r['speedup']:.2f} times as fast\n  {r['phases']}"
        )
    for r in result["failures"]:
        lines.append(
            f"\npulled to failure, {r['fail']}: {r['seconds']:.1f} s of CPU, {r['points']} points, {r['steps']} steps, "
            f"{r['points/s'] / 1e6:.2f} M points/s, {r['mode']}, peak {r['peak']:.4g} N\n  "
            + ", ".join(f"{p} {share:.0f} %" for p, share in r["phases"].items())
        )
    for r in result["separations"]:
        if r["seconds"] is not None:
            lines.append(f"\na bond of {r['bonds']} comes apart: {1e3 * r['seconds']:.2f} ms of CPU above a step, median of {r['separations']}")
    for r in result["condensed"]:
        lines.append(
            f"\n{r['bonds']} condensed bonds, points {r['condensed']} ({r['points']}): {r['bytes/bond']:.0f} B/bond made and run, {r['bytes/bond, read']:.0f} read, "
            f"{r['file bytes/bond']:.0f} in the file; s of CPU: made {r['made']:.2f}, {r['steps']} steps {r['run']:.2f}, written {r['written']:.2f}, read {r['read']:.2f}"
        )
    for r in result["skips"]:
        lines.append(
            f"\nskip {r['skip']:10} in skip/{r['scene']}: {r['seconds']:.2f} s, without {r['without']:.2f} s: {r['without'] / r['seconds']:.2f} times as fast"
        )
    return "\n".join(lines)


def plain(value):
    """JSON has no nan."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    return [plain(v) for v in value] if isinstance(value, (list, tuple)) else value


def write_csv(rows, file):
    keys = list(dict.fromkeys(k for r in rows for k in r))
    with open(file, "w", newline="") as f:
        w = csv.DictWriter(f, keys, restval="")
        w.writeheader()
        w.writerows(rows)


def main():
    args = arguments()
    step, precise, damage = (args.build / "bench" / name for name in ("bench_step", "accuracy", "law"))
    for program in (step, precise, damage):
        if not program.exists():
            sys.exit(f"bench_report.py: {program} is missing; configure with -DMPDEM_BENCH=ON and build, or run `make bench`")
    os.environ.setdefault("MPDEM_EXE", str(args.build / "liggghts-mpdem"))
    import bonds
    import condensed
    import failures
    import packings
    import separations
    import skips

    names = {
        "rates": output(step, "--benchmark_list_tests").split(),
        "accuracy": output(precise, "--list").split(),
        "law": output(damage, "--list").split(),
        "bonds": bonds.NAMES,
        "skips": skips.NAMES,
        "packings": packings.NAMES,
        "failures": failures.NAMES,
        "separations": separations.NAMES,
        "condensed": condensed.NAMES,
    }
    every = [n for group in names.values() for n in group]
    wanted = args.names or (QUICK if args.quick else sorted({n.split("/")[0] for n in every}))
    picked = set(chosen(every, wanted))
    names = {k: [n for n in v if n in picked] for k, v in names.items()}
    if args.list:
        print("\n".join(n for v in names.values() for n in v))
        return
    out = args.out or args.build / "bench" / "results"
    out.mkdir(parents=True, exist_ok=True)
    result = {
        "load": os.getloadavg()[0],
        "quick": args.quick,
        "rates": [],
        "accuracy": [],
        "law": [],
        "skips": [],
        "packings": [],
        "failures": [],
        "separations": [],
        "condensed": [],
    }
    if names["rates"]:
        tell(f"{len(names['rates'])} rates ...")
        result["rates"] = rates(step, names["rates"], args.quick)
        write_csv(result["rates"], out / "rates.csv")
    if names["accuracy"]:
        tell(f"{len(names['accuracy'])} methods on problems with a known solution ...")
        result["accuracy"] = accuracy(precise, names["accuracy"], args.quick, ["--periods", args.periods, "--section", args.section])
    if names["law"]:
        tell(f"{len(names['law'])} kinds of paths of the law of damage ...")
        result["law"] = law(damage, names["law"], args.quick)
        write_csv(result["law"], out / "law.csv")
    runs = out / "runs"
    runs.mkdir(exist_ok=True)
    if names["bonds"]:
        result["accuracy"] += bonds.measure(names["bonds"], runs, args.quick, tell)
    if names["packings"]:
        result["packings"] = packings.measure(names["packings"], runs, args.quick, tell)
    if names["failures"]:
        result["failures"] = failures.measure(names["failures"], runs, args.quick, tell)
    if names["separations"]:
        result["separations"] = separations.measure(names["separations"], runs, args.quick, tell)
    if names["condensed"]:
        result["condensed"] = condensed.measure(names["condensed"], runs, args.quick, tell)
    if names["skips"]:
        result["skips"] = skips.measure(names["skips"], runs, args.quick, tell)
    if result["accuracy"]:
        write_csv(result["accuracy"], out / "accuracy.csv")
    result["orders"] = {f"{p}/{m}": order(c) for p in PROBLEMS for m, c in curves(result["accuracy"], p).items()}
    (out / "results.json").write_text(json.dumps(plain(result), indent=1))
    for problem in (*PROBLEMS, "stiffness", "peak"):
        if curves(result["accuracy"], problem):
            diagram(result["accuracy"], problem, out / f"{problem}.png")
    if any(r["name"].startswith("size/") for r in result["rates"]):
        size_diagram(result["rates"], out / "size.png")
    text = report(result)
    (out / "report.txt").write_text(text + "\n")
    print(text)
    print(f"\nResults: {out}")


if __name__ == "__main__":
    main()
