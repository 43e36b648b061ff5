# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Runs of examples/pair_table: which there are, running them side by side, what they gave.

Each run has a folder; `done.json` in it, written last, holds its parameters and results. A run
whose `done.json` is of the same parameters and script is not run again.
"""
import csv
import hashlib
import itertools
import json
import math
import os
import shutil
import signal
import subprocess
import time

from . import loading
from .run import Trouble

SHAPES = ("flat", "meniscus", "coating", "coating+meniscus")
LOADS = ("tension", "compression", "shear", "torsion", "bending", "mixed", "force")
RADIUS, DENSITY_RATIO = 0.005, 2500.0 / 2710.0
WAVE = 5146.0  # as in the script
WINDOW = 2e-6  # s over which the load is averaged to tell failure, at least

# Variables of the script that may be set, but for those this module computes.
VARIABLES = ("share", "cap", "gap", "percell", "grid", "inner", "B0", "cutoff", "zeta", "interface", "bonding", "regularization", "edge", "cracks", "axis",
             "speed", "ramp", "arm", "angle", "rate", "courant", "record", "chunk", "limit", "frames", "spacing")
OWN = {"refine": 1.0,        # divides the spacing
       "layers": 3.0,        # of points through a coating, at least
       "coarse": 1.25e-4}    # spacing where no coating asks for less, m
COLUMNS = ("shape", "load", "content", "dimension", "peak", "stress_section", "stress_grain", "stiffness", "energy", "mode",
           "left", "mode_ahead", "share_grain1", "share_grain2", "share_inside", "way_at_peak", "way_at_failure", "broken", "dissipated",
           "imbalance", "points", "failed", "let_go", "attached", "steps", "duration", "wall", "inner", "volume",
           "section", "spacing", "parameters")


def coating_thickness(content, gap=0.0):
    """Of shells on both grains whose union has the volume of `content`, by the closed form of the lens."""
    volume, d, t = content * 2 * 4 / 3 * math.pi * RADIUS**3 * DENSITY_RATIO, 2 * RADIUS + gap, 0.0
    for _ in range(60):
        S = RADIUS + t
        lens = math.pi * max(2 * S - d, 0.0)**2 * (d * d + 4 * d * S) / (12 * d)
        t = (RADIUS**3 + (volume + lens) * 3 / (8 * math.pi))**(1 / 3) - RADIUS
    return t


class Run:
    """One pair: words of the table and variables of the script."""

    def __init__(self, shape, load, content, extra):
        if shape not in SHAPES:
            raise Trouble(f"shape {shape}: must be one of {', '.join(SHAPES)}")
        if load not in LOADS:
            raise Trouble(f"load {load}: must be one of {', '.join(LOADS)}")
        if not 0.0 < content <= 1.0:
            raise Trouble(f"content {content:g}: must lie in (0, 1], the mass of cement over that of the beads")
        for key in extra:
            if key not in VARIABLES and key not in OWN:
                raise Trouble(f"{key}: no variable of the table; known are {', '.join(VARIABLES + tuple(OWN))}")
        self.shape, self.load, self.content, self.extra = shape, load, content, dict(extra)
        own = {k: number(k, extra.get(k, v)) for k, v in OWN.items()}
        spacing = own["coarse"]
        if shape.startswith("coating"):
            share = number("share", extra.get("share", 0.5)) if shape == "coating+meniscus" else 1.0
            spacing = min(spacing, coating_thickness(share * content, float(extra.get("gap", 0.0))) / own["layers"])
        self.spacing = number("spacing", extra.get("spacing", spacing / own["refine"]))
        step = number("courant", extra.get("courant", 0.4)) * self.spacing * number("percell", extra.get("percell", 2)) / WAVE
        self.arguments = {"shape": shape, "load": load, "content": f"{content:g}", "spacing": f"{self.spacing:.6g}",
                          "chunk": str(10 * max(10, math.ceil(0.1 * WINDOW / step))),
                          "record": str(max(5, 5 * round(0.02 * WINDOW / step))), "frames": "100000000",
                          "limit": str(100 * math.ceil(1e-6 / step))}
        self.arguments.update({k: str(v) for k, v in extra.items() if k not in OWN})
        words = [f"{k}={str(v).replace(' ', '_').replace('/', '_')}" for k, v in sorted(self.extra.items())]
        self.window = number("chunk", self.arguments["chunk"]) * step  # s over which the script averages
        self.label = ",".join([shape, load, f"{content:g}"] + words)
        # seconds are about proportional to points times steps
        volume = content * 2 * 4 / 3 * math.pi * RADIUS**3 * DENSITY_RATIO
        if shape == "coating":
            volume *= min(0.02 + content, 1.0)  # only what is near the bond
        self.cost = volume / self.spacing**3 / step

    def command(self, exe, script, ranks):
        words = [exe, "-in", script]
        for k, v in self.arguments.items():
            words += ["-var", k, v]
        return (["mpirun", "--oversubscribe", "--bind-to", "none", "-np", str(ranks)] if ranks > 1 else []) + words


def number(name, value):
    try:
        v = float(value)
    except (TypeError, ValueError):
        v = float("nan")
    if not 0.0 < v < float("inf"):
        raise Trouble(f"{name} {value}: must be a positive number")
    return v


def product(group):
    """The runs of {"shapes": [...], "loads": [...], "contents": [...], "set": {...}, "vary": {...}}."""
    for key in group:
        if key not in ("title", "shapes", "loads", "contents", "set", "vary"):
            raise Trouble(f"{key}: no word of a table; known are title, shapes, loads, contents, set, vary")
    for key in ("shapes", "loads", "contents"):
        if not group.get(key):
            raise Trouble(f"a group of the table lacks {key}; give a list")
    vary = group.get("vary", {})
    runs = []
    for values in itertools.product(*vary.values()):
        extra = {**group.get("set", {}), **dict(zip(vary, values))}
        runs += [Run(s, l, float(c), extra) for s, l, c in itertools.product(group["shapes"], group["loads"], group["contents"])]
    return runs


def stamp(run, script):
    with open(script, "rb") as f:
        return {"arguments": run.arguments, "script": hashlib.sha256(f.read()).hexdigest()[:16]}


def finished(out, run, script):
    """The results of a run that was finished with these parameters, else None."""
    try:
        with open(os.path.join(out, run.label, "done.json")) as f:
            done = json.load(f)
    except (OSError, ValueError):
        return None
    return done["results"] if done.get("stamp") == stamp(run, script) else None


class Runner:
    """Keeps `jobs` runs going; `go` returns how many failed. Stopped by SIGINT or SIGTERM, it stops them."""

    def __init__(self, out, runs, exe, script, jobs, ranks):
        self.out, self.exe, self.script, self.jobs, self.ranks = out, exe, script, jobs, ranks
        self.waiting = [r for r in runs if finished(out, r, script) is None]
        self.skipped = len(runs) - len(self.waiting)
        self.all, self.active, self.failed, self.spent, self.start = runs, [], [], 0.0, time.time()
        self.wake = 0.0

    def go(self):
        say(f"{len(self.all)} runs, {self.skipped} finished before, {len(self.waiting)} to do, "
            f"{self.jobs} at a time on {self.ranks} rank{'s' * (self.ranks > 1)} each")
        # the longest first, so that none is left alone at the end
        self.waiting.sort(key=lambda r: -r.cost)
        self.total = sum(r.cost for r in self.waiting)
        try:
            while self.waiting or self.active:
                while self.waiting and len(self.active) < self.jobs:
                    self.launch(self.waiting.pop(0))
                time.sleep(0.1)
                for item in list(self.active):
                    if item["process"].poll() is not None:
                        self.active.remove(item)
                        self.finish(item)
                if self.active and time.time() > self.wake:
                    self.wake = time.time() + 15.0
                    self.progress()
        finally:
            for item in self.active:
                os.killpg(item["process"].pid, signal.SIGKILL)  # it begins anew, so it need not save anything
            for item in self.active:
                item["process"].wait()
                item["out"].close()
        return len(self.failed)

    def launch(self, run):
        folder = os.path.join(self.out, run.label)
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        out = open(os.path.join(folder, "out.txt"), "w")
        environment = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", **os.environ}
        process = subprocess.Popen(run.command(self.exe, self.script, self.ranks), cwd=folder, stdout=out, env=environment,
                                   stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, start_new_session=True)
        self.active.append({"run": run, "process": process, "out": out, "folder": folder, "since": time.time()})

    def finish(self, item):
        item["out"].close()
        run, folder, wall = item["run"], item["folder"], time.time() - item["since"]
        self.spent += run.cost
        with open(os.path.join(folder, "out.txt"), errors="replace") as f:
            text = f.read()
        trouble = [line for line in text.splitlines() if line.startswith("ERROR")]
        if item["process"].returncode or trouble or "\nRESULT " not in text:
            self.failed.append((run, trouble[0] if trouble else f"ended with status {item['process'].returncode}; "
                                f"see {os.path.join(folder, 'out.txt')}"))
            say(f"{self.count()} FAILED {run.label}: {self.failed[-1][1]}")
            return
        try:
            results = loading.results(folder, RADIUS, window=0.999 * run.window)
        except Trouble as t:
            self.failed.append((run, str(t)))
            say(f"{self.count()} FAILED {run.label}: {t}")
            return
        results["wall"] = wall
        text = json.dumps({"stamp": stamp(run, self.script), "results": results}, indent=1, default=float)
        with open(os.path.join(folder, "done.tmp"), "w") as f:
            f.write(text)
        os.replace(os.path.join(folder, "done.tmp"), os.path.join(folder, "done.json"))
        say(f"{self.count()} {run.label}: {results['mode']}, peak {results['peak']:.4g}, {results['points']} points, "
            f"{results['steps']} steps, {wall:.0f} s{self.left()}")

    def count(self):
        done = len(self.all) - len(self.waiting) - len(self.active)
        return f"[{done}/{len(self.all)}]"

    def left(self):
        if not self.waiting and not self.active or not self.spent:
            return ""
        seconds = (time.time() - self.start) * (self.total / self.spent - 1)
        return f"; about {seconds / 60:.0f} min left" if seconds > 90 else f"; about {seconds:.0f} s left"

    def progress(self):
        parts = []
        for item in self.active:
            step = last_step(os.path.join(item["folder"], "load_run.csv"))
            parts.append(f"{item['run'].label} at step {step} of at most {item['run'].arguments['limit']}")
        say(f"{self.count()} running: {'; '.join(parts)}{self.left()}")


def last_step(path):
    try:
        with open(path, "rb") as f:
            f.seek(max(os.path.getsize(path) - 300, 0))
            lines = f.read().split(b"\n")
        return int(lines[-2].split(b",")[0])
    except (OSError, ValueError, IndexError):
        return 0


def say(text):
    print(text, flush=True)


def write(path, runs, out, script):
    """The finished ones of the runs; returns them with their results."""
    rows = [(r, res) for r, res in ((r, finished(out, r, script)) for r in runs) if res is not None]
    with open(path + ".tmp", "w", newline="") as f:
        w = csv.writer(f, lineterminator="\n")
        w.writerow(COLUMNS)
        for run, res in rows:
            known = {**res, "shape": run.shape, "load": run.load, "content": run.content, "spacing": run.spacing,
                     "parameters": " ".join(f"{k}={str(v).replace(' ', ':')}" for k, v in sorted(run.extra.items())),
                     "broken": "yes" if res["broken"] else "no"}
            row = [known.get(c, "") for c in COLUMNS]  # a run may be older than a column
            w.writerow([f"{v:.6g}" if isinstance(v, float) else v for v in row])
    os.replace(path + ".tmp", path)
    return rows
