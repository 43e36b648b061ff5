# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Benchmarks of bonds in LIGGGHTS: names, and how each is measured.

    stiffness/METHOD   axial stiffness of the undamaged ring of tests/system/test_stiffness.py, its
                       error against axisymmetric finite elements, CPU seconds of the run
    peak/METHOD        peak force of examples/pair_flat/in.flat_scaled with a fifth of the cement,
                       its difference from the default method's on the finest cell
    ranks/flat         seconds of the first thousand steps of examples/pair_flat/in.flat_table1 on
                       one and on two ranks, taken in turns; medians
"""
import math
import os
import re
import resource
import statistics
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "system"), str(ROOT / "tests" / "verification")]

from axisymmetric_fe import TransverselyIsotropic, axis_uniform, converged_axial_stiffness  # noqa: E402
from scenes import NEIGHBOURS, RADIUS, VTI, cement, edit, host, launch, pair, shift, thermo  # noqa: E402

DEFAULT = "total/quadratic/none"
# With a transfer in every step the stable step is smaller by sqrt(2).
METHODS = {
    DEFAULT: 1.0,
    "total/cubic/none": 1.0,
    "total/linear/none": 1.0,
    "total/quadratic/apic": 0.7,
    "total/quadratic/xpic2": 0.7,
    "updated/quadratic/flip": 0.7,
    "updated/quadratic/apic": 0.7,
    "updated/quadratic/xpic2": 0.7,
    "updated/cubic/apic": 0.7,
}
STIFFNESS_CELLS = (4e-4, 2.83e-4, 2e-4, 1.41e-4)
PEAK_CELLS = (4e-4, 2.83e-4, 2e-4, 1.41e-4)
PEAK_REFERENCE = 1e-4
NAMES = [f"{group}/{m}" for group in ("stiffness", "peak") for m in METHODS] + ["ranks/flat"]


def words(method):
    """Of fix mpm."""
    kinematics, basis, transfer = method.split("/")
    text = f"basis {basis} kinematics {kinematics}"
    if transfer != "none":
        text += " transfer " + {"flip": "flip 1", "xpic2": "xpic 2"}.get(transfer, transfer)
        text += " reproject 1" if kinematics == "total" else ""
    return text


def loop_seconds(run):
    return sum(float(t) for t in re.findall(r"^Loop time of (\S+)", run.output, re.M))


def cpu_seconds():
    """Of all programs that were run so far; on a busy machine the time to trust."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def told_by_cement(run):
    """What fix mpm says of each run of a script: seconds, steps, points a second by CPU time, bytes a point, and the shares of
    its phases in per cent."""
    found = re.findall(r"fix mpm .*: (\S+) s in (\d+) steps, \S+ point steps per second, (\S+) by CPU time, (\S+) bytes a point\n +(.*)", run.output)
    return [
        {
            "seconds": float(s),
            "steps": int(n),
            "points/s": float(rate),
            "bytes/point": float(b),
            "said": said,
            "phases": {p: float(share) for p, share in re.findall(r"([a-z][a-z ]*) ([\d.e-]+) %", said)},
        }
        for s, n, rate, b, said in found
    ]


def failure(run):
    """What stopped the run, empty if nothing did."""
    return "" if run.status == 0 and not run.errors() else (run.errors() or [run.output[-200:]])[0]


def grains_at(centres, low, high):
    """A box from corner to corner with equal grains of radius RADIUS in it."""
    box = " ".join(f"{a} {b}" for a, b in zip(low, high))
    atoms = "".join(f"create_atoms 1 single {x} {y} {z} units box\n" for x, y, z in centres)
    return (
        host()
        + f"region box block {box} units box\ncreate_box 2 box\n"
        + atoms
        + f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n"
        + NEIGHBOURS
    )


def stiffness(method, cell, directory):
    distance, duration = 1e-8, 8e-6
    timestep = 1e-8 * cell / 1e-4 * METHODS[method]
    text = cement(cell, timestep)
    text = edit(text, "elastic vti", words(method) + " elastic vti")
    script = (
        pair(cell / 2, half_box=(6e-3, 6e-3, 12e-3))
        + text
        + shift(distance, duration)
        + f"run {round(duration / timestep)}\nunfix pull\nfix pull second move linear 0 0 0\n"
        + thermo(1, ["f_bond"])
        + f"run {round(4e-6 / timestep)}\n"
    )
    run = launch(script, directory)
    stop = failure(run)
    if stop:
        return {"seconds": math.nan, "value": math.nan, "stopped": stop}
    return {"loop": loop_seconds(run), "value": run.table()["f_bond"].mean() / distance}


def example(directory, cell=1e-4, method=DEFAULT, timestep=None, content=None, parts=None, scaled=True, ranks=1):
    source = ROOT / "examples" / "pair_flat"
    directory = Path(directory)
    directory.mkdir(exist_ok=True)
    pull = (source / "pull.in").read_text()
    pull = edit(pull, "basis quadratic kinematics total", words(method))
    pull = re.sub(r"^dump .*\n", "", pull, flags=re.M)
    # The local law with steps of its own: `nonlocal` needs cells of L or smaller.
    pull = edit(pull, " regularization ${regularization} timestep auto 0.7", "")
    pull = edit(pull, "fix          cem ", f"timestep {timestep or 1e-9:.10g}\nfix          cem ")
    if parts:
        pull = edit(pull, "loop 60", f"loop {parts}")
    (directory / "pull.in").write_text(pull)
    script = (source / ("in.flat_scaled" if scaled else "in.flat_table1")).read_text()
    speed = "0.1265" if scaled else "4"
    arguments = ["-var", "cell", f"{cell:.10g}", "-var", "spacing", f"{cell / 2:.10g}"]
    arguments += ["-var", "inner", "share 0.2", "-var", "speed", speed, "-var", "ramp", "4e-6"]
    if content:
        arguments += ["-var", "content", str(content)]
    return launch(script, directory, ranks=ranks, arguments=arguments)


def peak(method, cell, directory):
    run = example(directory, cell, method, timestep=2e-9 * cell / 1e-4 * METHODS[method], content=0.002)
    stop = failure(run)
    if stop:
        return {"seconds": math.nan, "value": math.nan, "stopped": stop}
    # columns of the thermo line: step time f_bond[13] f_bond f_bond[21] ...
    rows = [line.split() for line in run.output.splitlines() if re.fullmatch(r"\s*\d+(\s+[-+.\deE]+){10}\s*", line)]
    return {"loop": loop_seconds(run), "value": float(rows[-1][4])}


def measure(names, directory, quick, tell):
    """Rows (dicts) of the chosen names."""
    rows = []
    groups = {"stiffness": (stiffness, STIFFNESS_CELLS[:2] if quick else STIFFNESS_CELLS), "peak": (peak, PEAK_CELLS[:1] if quick else PEAK_CELLS)}
    exact = {}
    for name in names:
        group, _, method = name.partition("/")
        if group == "ranks":
            rows += ranks(directory, quick, tell)
            continue
        function, cells = groups[group]
        if group not in exact and group == "stiffness":
            exact[group] = converged_axial_stiffness(RADIUS, 1e-3, 2e-3, 0.0, TransverselyIsotropic(*VTI), axis_uniform(0.0, 1.0)).value
        if group not in exact:
            exact[group] = math.nan if quick else peak(DEFAULT, PEAK_REFERENCE, directory / "peak_reference")["value"]
        for cell in cells:
            before = cpu_seconds()
            row = {
                "problem": group,
                "method": method,
                "cells": 1 / cell,
                "cell": cell,
                **function(method, cell, directory / f"{group}_{method.replace('/', '_')}_{cell:g}"),
            }
            if not math.isnan(row["value"]):
                row["seconds"] = cpu_seconds() - before
            row["error"] = abs(row["value"] / exact[group] - 1)
            row["reference"] = exact[group]
            tell(row)
            rows.append(row)
    return rows


def ranks(directory, quick, tell):
    times = {1: [], 2: []}
    for turn in range(1 if quick else 5):
        for n in times:
            run = example(directory / f"ranks_{n}_{turn}", parts=1 if quick else 2, scaled=False, ranks=n, cell=2e-4 if quick else 1e-4)
            assert not failure(run), failure(run)
            times[n].append(loop_seconds(run))
    one, two = (statistics.median(times[n]) for n in times)
    row = {"problem": "ranks", "method": "flat", "one": one, "two": two, "speedup": one / two, "all": times, "load": os.getloadavg()[0]}
    tell(row)
    return [row]
