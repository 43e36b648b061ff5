#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs the benchmarks and reports them: text on screen, JSON, CSV and PNG in BUILD/bench/report.

    bench_report.py BUILD [--quick] [rates] [accuracy] [bond] [ranks]

rates     points a second of the full step, one core, every kinematics, basis and transfer
accuracy  error against wall time on problems with exact solutions, orders of convergence
bond      stiffness of a bond against finite elements, through the script interface
ranks     1 against 2 ranks on the flat pair
"""
import argparse
import csv
import json
import math
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
PARTS = ("rates", "accuracy", "bond", "ranks")
DEFAULT = "total quadratic none"
# Axisymmetric finite elements of a ring from 1 to 2 mm between touching 5 mm grains, VTI
# (60e9, 40e9, 0.25, 0.2, 18e9), axis along the bond: tests/verification/axisymmetric_fe.py.
EXACT_STIFFNESS = 9.2743094e8


def environment():
    return {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", **os.environ}


def write_csv(path, rows):
    with open(path, "w", newline="") as f:
        writer = csv.DictWriter(f, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def rates(build, out, quick):
    command = [build / "bench/bench_step", "--benchmark_format=json", f"--benchmark_min_time={0.05 if quick else 0.5}"]
    if quick:
        command.append("--benchmark_filter=quadratic.*/(none|apic)/|machine|scalar")
    text = subprocess.run(command, capture_output=True, text=True, env=environment(), check=True).stdout
    result = json.loads(text)
    (out / "rates.json").write_text(text)
    by_name = {b["name"]: b for b in result["benchmarks"]}
    band, peak = by_name["machine/triad"]["bytes/s"], by_name["machine/fma"]["flop/s"]
    print(f"machine: {band / 1e9:.1f} GB/s (triad), {peak / 1e9:.1f} GFLOP/s (multiply-add), load {os.getloadavg()[0]:.1f}")
    rows = []
    for name, b in by_name.items():
        if "points/s" not in b:
            continue
        row = {"name": name, "points": b.get("points", 110592), "million_points_per_second": b["points/s"] / 1e6,
               "bytes_per_point": b.get("bytes/point", math.nan), "share_of_bandwidth": math.nan}
        if name.startswith(("step/total", "size")) and "/none/elastic" in name:
            row["share_of_bandwidth"] = b["points/s"] * BYTES_TOUCHED / band
            row["share_of_peak"] = b["points/s"] * FLOPS[name.split("/")[2]] / peak
        else:
            row["share_of_peak"] = math.nan
        rows.append(row)
        print(f"  {name:48s} {row['million_points_per_second']:8.1f} M/s {row['bytes_per_point']:8.0f} bytes a point")
    write_csv(out / "rates.csv", rows)
    names = [r for r in rows if r["name"].startswith(("step", "scalar"))]
    figure, axes = plt.subplots(figsize=(8, 0.22 * len(names) + 1.2))
    axes.barh([r["name"] for r in names][::-1], [r["million_points_per_second"] for r in names][::-1],
              color=["C1" if "damaging" in r["name"] else "C7" if "scalar" in r["name"] else "C0" for r in names][::-1])
    axes.set_xlabel("million points a second, one core")
    axes.tick_params(axis="y", labelsize=7)
    figure.tight_layout()
    figure.savefig(out / "rates.png", dpi=110)


# Read and written by the pass of total kinematics for an undamaged point: position, volume, F,
# frame and strain of 23 doubles, of which 19 are written.
BYTES_TOUCHED = 8 * (23 + 19)
# Multiplications and additions of a point: gather and scatter of S^3 nodes by their factors, and
# about 330 for kinematics and stress.
FLOPS = {name: 330 + 2 * (S * S * 3 * (4 * S + 6) + S * 36 + S * S * 3 * 9 + S ** 3 * 9)
         for name, S in (("linear", 2), ("quadratic", 3), ("cubic", 4))}


def orders(rows):
    """Observed order of each row against the next coarser one of the same method."""
    last = {}
    for r in rows:
        key = (r["problem"], r["method"])
        r["order"] = math.nan
        if key in last and r["error"] > 0:
            before = last[key]
            r["order"] = math.log(before["error"] / r["error"]) / math.log(before["h"] / r["h"])
        last[key] = r


def diagram(rows, out, name, title, x="seconds"):
    figure, axes = plt.subplots(figsize=(6.5, 4.6))
    for method in dict.fromkeys(r["method"] for r in rows):
        mine = [r for r in rows if r["method"] == method and math.isfinite(r["error"]) and r["error"] < 10]
        if not mine:
            continue
        axes.loglog([r[x] for r in mine], [r["error"] for r in mine], "o-", ms=4,
                    lw=2.5 if method == DEFAULT else 1, color="k" if method == DEFAULT else None,
                    label=method + (" (default)" if method == DEFAULT else ""))
    axes.set_xlabel("wall time, s")
    axes.set_ylabel("relative error")
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(out / f"{name}.png", dpi=110)
    plt.close(figure)


def envelope(rows):
    """Is the default nowhere beaten in error and time at once?"""
    mine = [r for r in rows if r["method"] == DEFAULT]
    return {r["method"] for r in rows for d in mine
            if r["method"] != DEFAULT and r["error"] < d["error"] and r["seconds"] < d["seconds"]}


def accuracy(build, out, quick):
    command = [build / "bench/accuracy", "levels", "2" if quick else "4"]
    text = subprocess.run(command, capture_output=True, text=True, env=environment(), check=True).stdout
    rows = []
    for r in csv.DictReader(text.splitlines()):
        rows.append({"problem": r["problem"], "method": f"{r['kinematics']} {r['basis']} {r['transfer']}", "h": float(r["h"]),
                     "points": int(r["points"]), "steps": int(r["steps"]), "error": float(r["error"]), "seconds": float(r["seconds"])})
    orders(rows)
    write_csv(out / "accuracy.csv", rows)
    for problem in dict.fromkeys(r["problem"] for r in rows):
        mine = [r for r in rows if r["problem"] == problem]
        print(problem)
        for r in mine:
            print(f"  {r['method']:26s} h {r['h']:.4f}  error {r['error']:.3e}  order {r['order']:5.2f}  {r['seconds']:.3g} s")
        better = envelope(mine)
        print("  below and left of the default:", ", ".join(sorted(better)) or "none")
        diagram(mine, out, f"accuracy_{problem}", f"{problem}: error against wall time")


def script(cell, words):
    """A ring bond stretched by 10 nm in 4 us and held; the force after MEASURED, step by step."""
    duration = 4e-6
    return f"""units si
atom_style mpdem
atom_modify map array first grains
boundary f f f
newton off
communicate single vel yes
region box block -6e-3 6e-3 -6e-3 6e-3 -12.5e-3 12.5e-3 units box
create_box 2 box
create_atoms 1 single 0 0 -5e-3 units box
create_atoms 1 single 0 0 5e-3 units box
set type 1 diameter 1e-2 density 2500
group grains type 1
communicate single vel yes group grains
neighbor 0.0005 bin
neigh_modify include grains delay 0
create_cement calcite pair 1 2 shape flat inner 1e-3 outer 2e-3 spacing {cell / 2}
fix cem calcite mpm cell {cell} {words} timestep auto 0.9 elastic vti 60e9 40e9 0.25 0.2 18e9 axis global 0 0 1
fix bond grains mpm/couple cem
group first id 1
group second id 2
variable x equal "step*dt/{duration}"
variable d equal "1e-8*(v_x-sin(2*PI*v_x)/2/PI)"
variable s equal "1e-8/{duration}*(1-cos(2*PI*v_x))"
fix hold first move linear 0 0 0
fix pull second move variable NULL NULL v_d NULL NULL v_s
variable n equal ceil({duration}/dt)
variable m equal ceil({0.75 * duration}/dt)
run 0
run ${{n}}
unfix pull
fix pull second move linear 0 0 0
run ${{m}}
thermo_style custom step f_bond
thermo 1
print MEASURED
run ${{m}}
"""


def bond(build, out, quick):
    rows = []
    directory = out / "bond"
    directory.mkdir(exist_ok=True)
    methods = ["basis linear", "basis quadratic", "basis cubic", "basis quadratic kinematics updated transfer apic",
               "basis quadratic kinematics updated transfer flip 0.99"]
    for words in methods[:2] if quick else methods:
        for cell in (2e-4,) if quick else (2e-4, 1.414e-4, 1e-4):
            (directory / "in.bond").write_text(script(cell, words))
            start = time.perf_counter()
            done = subprocess.run([build.resolve() / "liggghts-mpdem", "-in", "in.bond"], cwd=directory, capture_output=True,
                                  text=True, env=environment())
            seconds = time.perf_counter() - start
            after = done.stdout.rpartition("\nMEASURED\n")[2]
            forces = [float(w[1]) for w in (line.split() for line in after.splitlines()) if len(w) == 2 and w[0].isdigit()]
            if done.returncode or not forces:
                sys.exit("bench_report: the script of the bond failed:\n" + done.stdout[-1500:])
            words_ = words.split()
            method = f"{'updated' if 'updated' in words_ else 'total'} {words_[1]} {words_[5] if len(words_) > 5 else 'none'}"
            stiffness = statistics.mean(forces) / 1e-8
            rows.append({"problem": "bond", "method": method, "h": cell, "stiffness": stiffness,
                         "error": abs(stiffness / EXACT_STIFFNESS - 1), "seconds": seconds})
    orders(rows)
    write_csv(out / "bond.csv", rows)
    print("stiffness of a ring bond against finite elements")
    for r in rows:
        print(f"  {r['method']:26s} h {1e3 * r['h']:.3f} mm  error {100 * r['error']:.3f} %  {r['seconds']:.2f} s")
    print("  below and left of the default:", ", ".join(sorted(envelope(rows))) or "none")
    diagram(rows, out, "bond", "stiffness of a ring bond: error against wall time")


def ranks(build, out, quick):
    """Medians of interleaved runs, so that other load hits both alike."""
    directory = out / "ranks"
    directory.mkdir(exist_ok=True)
    for name in ("in.flat_table1", "pull.in"):
        (directory / name).write_text((ROOT / "examples/pair_flat" / name).read_text().replace("part loop 60", "part loop 2"))
    times = {1: [], 2: []}
    for _ in range(1 if quick else 5):
        for n in times:
            done = subprocess.run(["mpirun", "-np", str(n), build.resolve() / "liggghts-mpdem", "-in", "in.flat_table1"],
                                  cwd=directory, capture_output=True, text=True, env=environment(), check=True)
            loops = [float(line.split()[3]) for line in done.stdout.splitlines() if line.startswith("Loop time of")]
            times[n].append(sum(loops))
    ratio = statistics.median(times[1]) / statistics.median(times[2])
    rows = [{"ranks": n, "run": i, "seconds": t} for n in times for i, t in enumerate(times[n])]
    write_csv(out / "ranks.csv", rows)
    print(f"flat pair, 88 944 points, 1000 elastic steps: 1 rank {statistics.median(times[1]):.2f} s, 2 ranks "
          f"{statistics.median(times[2]):.2f} s, ratio {ratio:.2f}, load {os.getloadavg()[0]:.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("--quick", action="store_true", help="small sizes, about a minute")
    parser.add_argument("parts", nargs="*")
    arguments = parser.parse_intermixed_args()
    for part in arguments.parts:
        if part not in PARTS:
            parser.error(f"'{part}' is no benchmark; known are {', '.join(PARTS)}")
    for needed in ("bench/bench_step", "bench/accuracy", "liggghts-mpdem"):
        if not (arguments.build / needed).exists():
            parser.error(f"{arguments.build / needed} is missing; build it with 'make bench' or -DMPDEM_BENCH=ON")
    out = arguments.build / "bench/report"
    out.mkdir(parents=True, exist_ok=True)
    for part in arguments.parts or PARTS:
        globals()[part](arguments.build, out, arguments.quick)
    print(f"Results: {out}")


if __name__ == "__main__":
    main()
