# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Runs of examples/pair_table: which there are, what they gave."""
import csv
import itertools
import math
import os

from . import loading, runner
from .run import Trouble

SHAPES = ("flat", "meniscus", "coating", "coating+meniscus", "file")
LOADS = ("tension", "compression", "shear", "torsion", "bending", "mixed", "force")
RADIUS, DENSITY_RATIO = 0.005, 2500.0 / 2710.0
WAVE = 5146.0  # as in the script
SPEED = 0.04  # as in the script, m/s
WINDOW = 2e-6  # s over which the load is averaged to tell failure, at least

# Variables of the script that may be set, but for those this module computes.
VARIABLES = (
    "points",
    "share",
    "cap",
    "gap",
    "diameter",
    "percell",
    "grid",
    "inner",
    "B0",
    "cutoff",
    "zeta",
    "interface",
    "bonding",
    "regularization",
    "edge",
    "cracks",
    "axis",
    "speed",
    "ramp",
    "arm",
    "angle",
    "rate",
    "courant",
    "record",
    "chunk",
    "limit",
    "frames",
    "spacing",
)
OWN = {
    "refine": 1.0,  # divides the spacing
    "layers": 3.0,  # of points through a coating, at least
    "coarse": 1.25e-4,
}  # spacing where no coating asks for less, m
COLUMNS = (
    "shape",
    "load",
    "content",
    "dimension",
    "peak",
    "stress_section",
    "stress_grain",
    "stiffness",
    "energy",
    "mode",
    "left",
    "mode_ahead",
    "share_grain1",
    "share_grain2",
    "share_inside",
    "way_at_peak",
    "way_at_failure",
    "broken",
    "dissipated",
    "imbalance",
    "points",
    "failed",
    "let_go",
    "attached",
    "steps",
    "duration",
    "wall",
    "inner",
    "volume",
    "section",
    "spacing",
    "parameters",
)


def coating_thickness(content, gap=0.0):
    """Of shells on both grains whose union has the volume of `content`, by the closed form of the lens."""
    volume, d, t = content * 2 * 4 / 3 * math.pi * RADIUS**3 * DENSITY_RATIO, 2 * RADIUS + gap, 0.0
    for _ in range(60):
        S = RADIUS + t
        lens = math.pi * max(2 * S - d, 0.0) ** 2 * (d * d + 4 * d * S) / (12 * d)
        t = (RADIUS**3 + (volume + lens) * 3 / (8 * math.pi)) ** (1 / 3) - RADIUS
    return t


class Run:
    """One pair: entries of the table and variables of the script."""

    needs = includes = ()

    def __init__(self, shape, load, content, extra, script=None):
        if shape not in SHAPES:
            raise Trouble(f"shape {shape}: must be one of {', '.join(SHAPES)}")
        if load not in LOADS:
            raise Trouble(f"load {load}: must be one of {', '.join(LOADS)}")
        if not 0.0 < content <= 1.0:
            raise Trouble(f"content {content:g}: must lie in (0, 1], the mass of cement over that of the beads")
        for key in extra:
            if key not in VARIABLES and key not in OWN:
                raise Trouble(f"{key}: no variable of the table; known are {', '.join(VARIABLES + tuple(OWN))}")
        self.shape, self.load, self.content, self.extra, self.script = shape, load, content, dict(extra), script
        if (shape == "file") != ("points" in extra):
            raise Trouble("points FILE is for shape file, which needs it: the path of the points, from the folder of the run")
        own = {k: number(k, extra.get(k, v)) for k, v in OWN.items()}
        spacing = own["coarse"]
        if shape.startswith("coating"):
            share = number("share", extra.get("share", 0.5)) if shape == "coating+meniscus" else 1.0
            spacing = min(spacing, coating_thickness(share * content, float(extra.get("gap", 0.0))) / own["layers"])
        self.spacing = number("spacing", extra.get("spacing", spacing / own["refine"]))
        step = number("courant", extra.get("courant", 0.4)) * self.spacing * number("percell", extra.get("percell", 2)) / WAVE
        self.arguments = {
            "shape": shape,
            "load": load,
            "content": f"{content:g}",
            "spacing": f"{self.spacing:.6g}",
            "chunk": str(10 * max(10, math.ceil(0.1 * WINDOW / step))),
            "record": str(max(5, 5 * round(0.02 * WINDOW / step))),
            "frames": "100000000",
            "limit": str(100 * math.ceil(0.01 * self.duration() / step)),
        }
        self.arguments.update({k: str(v) for k, v in extra.items() if k not in OWN})
        words = [f"{k}={str(v).replace(' ', '_').replace('/', '_')}" for k, v in sorted(self.extra.items())]
        self.window = number("chunk", self.arguments["chunk"]) * step  # s over which the script averages
        self.label = ",".join([shape, load, f"{content:g}"] + words)
        # seconds are about proportional to points times steps
        volume = content * 2 * 4 / 3 * math.pi * RADIUS**3 * DENSITY_RATIO
        if shape == "coating":
            volume *= min(0.02 + content, 1.0)  # only what is near the bond
        self.cost = volume / self.spacing**3 / step

    def duration(self):
        """Time after which the run ends unbroken, s. A cohesive interface may take longer to open than the cement to break."""
        words = str(self.extra.get("bonding", "")).split()
        law = {k: number("bonding", v) for k, v in zip(words[1::2], words[2::2]) if k in ("tn", "tt", "Gn", "Gt")}
        opening = max((2 * law[G] / law[t] for G, t in (("Gn", "tn"), ("Gt", "tt")) if G in law and t in law), default=0.0)
        return 4e-4 + 2 * opening / abs(float(self.extra.get("speed", SPEED)))

    def command(self, exe, ranks):
        return runner.command(exe, self.script, ranks, self.arguments)

    def results(self, folder):
        return loading.results(folder, RADIUS, window=0.999 * self.window)

    def told(self, results):
        return f"{results['mode']}, peak {results['peak']:.4g}, {results['points']} points, {results['steps']} steps"

    def progress(self, folder):
        return f"at step {last_step(os.path.join(folder, 'load_run.csv'))} of at most {self.arguments['limit']}"

    def share(self, folder):
        return 0.0  # it ends when the pair is broken


def number(name, value):
    try:
        v = float(value)
    except (TypeError, ValueError):
        v = float("nan")
    if not 0.0 < v < float("inf"):
        raise Trouble(f"{name} {value}: must be a positive number")
    return v


def product(group, script):
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
        runs += [Run(s, l, float(c), extra, script) for s, l, c in itertools.product(group["shapes"], group["loads"], group["contents"])]
    return runs


def last_step(path):
    try:
        with open(path, "rb") as f:
            f.seek(max(os.path.getsize(path) - 300, 0))
            lines = f.read().split(b"\n")
        return int(lines[-2].split(b",")[0])
    except (OSError, ValueError, IndexError):
        return 0


def write(path, runs, out):
    """The finished ones of the runs; returns them with their results."""
    rows = [(r, res) for r, res in ((r, runner.finished(out, r)) for r in runs) if res is not None]
    with open(path + ".tmp", "w", newline="") as f:
        w = csv.writer(f, lineterminator="\n")
        w.writerow(COLUMNS)
        for run, res in rows:
            known = {
                **res,
                "shape": run.shape,
                "load": run.load,
                "content": run.content,
                "spacing": run.spacing,
                "parameters": " ".join(f"{k}={str(v).replace(' ', ':')}" for k, v in sorted(run.extra.items())),
                "broken": "yes" if res["broken"] else "no",
            }
            row = [known.get(c, "") for c in COLUMNS]  # a run may be older than a column
            w.writerow([f"{v:.6g}" if isinstance(v, float) else v for v in row])
    os.replace(path + ".tmp", path)
    return rows
