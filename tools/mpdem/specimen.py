# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""A specimen of examples/specimen: which runs there are, and what each gave.

The beads are poured once, cemented once for each content, and loaded once for each test.
"""
import csv
import glob
import math
import os
import re

import numpy as np

from . import response, runner, waves
from .run import Trouble

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "examples", "specimen")
STIFFNESS = (0.5, 0.6)  # up to this share of the peak, beyond the confining pressure, or to the first failure; from this share of that load
ROWS = 5  # of the curve that a slope needs
CALM = 1e-3  # kinetic share of the energy
FEWEST = 10  # beads that tell the strain
COLUMNS = (
    "label",
    "test",
    "content",
    "content_of_all",
    "pressure",
    "bonds",
    "points",
    "stiffness",
    "stiffness_of_ends",
    "strength",
    "strain_at_peak",
    "strain_at_end",
    "load_at_end",
    "awake_at_peak",
    "broken_at_peak",
    "awake_most",
    "broken",
    "debonding",
    "internal",
    "mixed",
    "kinetic_at_half",
    "kinetic_at_first_failure",
    "kinetic_at_peak",
    "imbalance",
    "work",
    "in_contacts",
    "steps",
    "wall",
    "beyond_cap",
    "springs_at_peak",
    "rubbed_at_first_failure",
    "rubbed_at_peak",
    "load_when_calm",
    "kinetic_share_at_first_failure",
    "unbalanced_at_first_failure",
    "pressure_off_to_peak",
    "pressure_off_after_peak",
    "load_at_first_failure",
    "kind",
    "q_peak",
    "axial_strain_at_q_peak",
    "q_at_end",
    "volume_strain_at_end",
    "coordination_at_end",
    "pieces_at_end",
    "largest_piece_at_end",
)
KINDS = ("drained", "undrained", "cyclic", "uncemented")  # of the loads with a pressure on the sides


def variables_of(script):
    """What may be set in a script: its variables of style index."""
    with open(script) as f:
        return re.findall(r"^variable +(\w+) +index ", f.read(), re.M)


def check_seed(text):
    """LIGGGHTS wants a prime above 10000, other than those of the grains in in.pour."""
    with open(os.path.join(FOLDER, "in.pour")) as f:
        taken = re.findall(r"^fix .* (?:particletemplate|particledistribution)/\S+ (\d+) ", f.read(), re.M)
    number = int(text) if text.isdigit() else 0
    if not 10000 < number < 2**31 or number in map(int, taken) or any(number % d == 0 for d in range(2, math.isqrt(number) + 1)):
        others = f"{', '.join(taken[:-1])} or {taken[-1]}"
        raise Trouble(f"--set seed={text}: must be a prime above 10000, not {others}, which in.pour has; 49979687 or 86028121 for instance")


class Stage:
    """A run of one of the scripts."""

    resumes = False  # it can go on from what it left when it was stopped
    includes = tuple(sorted(glob.glob(os.path.join(glob.escape(FOLDER), "*.in"))))

    def __init__(self, label, script, needs, cost, extra, own):
        self.label, self.script, self.needs, self.cost = label, os.path.join(FOLDER, script), needs, cost
        known = [v for path in (self.script, *self.includes) for v in variables_of(path)]
        self.arguments = {"here": FOLDER, **own, **{k: v for k, v in extra.items() if k in known}}

    def command(self, exe, ranks):
        return runner.command(exe, self.script, ranks, self.arguments)

    def progress(self, folder):
        return ""

    def share(self, folder):
        return 0.0


def output(folder):
    with open(os.path.join(folder, "out.txt"), errors="replace") as f:
        return f.read()


class Pour(Stage):
    def __init__(self, beads, extra):
        super().__init__("poured", "in.pour", (), 0.1 * beads, extra, {"beads": str(beads)})

    def results(self, folder):
        with open(os.path.join(folder, "poured.in")) as f:
            found = dict(re.findall(r"^variable (\w+) +index (\S+)", f.read(), re.M))
        return {k: float(v) for k, v in found.items()}

    def told(self, r):
        return f"{1e3 * r['side']:.3g} by {1e3 * r['side']:.3g} by {1e3 * r['height']:.3g} mm"


class Cement(Stage):
    """Beads cemented by the content of each bond, or, if `of_all`, by that of all beads."""

    def __init__(self, content, poured, extra, of_all=False):
        name = "calcite" if of_all else "content"
        super().__init__(f"cemented_{content:g}", "in.cement", (poured,), 0.1 * poured.cost, extra, {"poured": "../poured", name: f"{content:g}"})
        self.of_all = of_all

    def results(self, folder):
        text = output(folder)
        made = re.findall(r"^Cement at (\d+) contacts .*\n *in all (\d+) points", text, re.M)
        content = re.search(r"^CONTENT of a bond (\S+) of all beads (\S+)$", text, re.M)
        if not made or not content:
            raise Trouble(f"{os.path.join(folder, 'out.txt')}: lacks the line of create_cement; run again")
        return {"bonds": int(made[-1][0]), "points": int(made[-1][1]), "content_of_bond": float(content[1]), "content_of_all": float(content[2])}

    def told(self, r):
        return f"{r['bonds']} bonds of {r['points']} points, calcite {100 * r['content_of_all']:.3g} % of the mass of the beads, {100 * r['content_of_bond']:.3g} % at a bond"


NO_CEMENT = {"bonds": 0, "points": 0, "content_of_bond": 0.0, "content_of_all": 0.0}


class Load(Stage):
    """A loading of cemented beads, or, if `below` is the pouring, of beads without cement. strain: it ends there, and not after the peak."""

    resumes = True
    ends = {"compression": 7e-4, "tension": 3e-4}  # strain at which a test ends, a guess until one has

    def __init__(self, test, content, pressure, below, extra, kind="drained", strain=None, marks=()):
        confined = f"_{1e-6 * pressure:g}MPa" if pressure else ""
        cemented = kind != "uncemented"
        own = {"poured": "../poured", "test": "cyclic" if kind == "cyclic" else test, "pressure": f"{pressure:g}", "resume": "yes"}
        own.update({"cemented": f"../{below.label}"} if cemented else {"start": "poured"})
        own.update({"sides": "volume"} if kind == "undrained" else {})
        if strain is not None and test != "tension":
            own.update({"ends": "strain", "strain": f"{strain:g}"})
        super().__init__(
            f"{test if kind == 'drained' else kind}{f'_{content:g}' if cemented else ''}{confined}",
            "in.load",
            (below,),
            below.cost * (5.0 if test == "tension" else 30.0 if cemented else 0.03) * (max(strain / 1e-3, 1.0) if strain and test != "tension" else 1.0),
            extra,
            own,
        )
        if "cell" not in extra and "spacing" in extra:
            self.arguments["cell"] = f"{2 * float(extra['spacing']):g}"
        self.test, self.content, self.pressure, self.kind, self.strain = test, content, pressure, kind, strain
        if marks:
            self.arguments["marks"] = [f"{m:g}" for m in sorted(marks)]
        self.of_all = 0.0  # mass of the cement over that of the beads, once it is known

    def results(self, folder):
        found = results(folder, self)
        if self.strain is None and self.kind in ("drained", "undrained"):
            Load.ends[self.test] = found["strain_at_end"]
        return found

    def told(self, r):
        early = before_failure(r)
        stiffness = f"{1e-9 * r['stiffness']:.3g} GPa{early and ' ' + early}" if math.isfinite(r["stiffness"]) else f"n/a{early and ', ' + early}"
        return (
            f"strength {1e-6 * r['strength']:.3g} MPa at {1e3 * r['strain_at_peak']:.3g} per mille, stiffness {stiffness}, "
            f"{r['broken']} of {r['bonds']} bonds broken"
        )

    def line(self, folder):
        """The last line of progress of the script, by its names."""
        try:
            lines = re.findall(r"^PROGRESS (.*)\n", output(folder), re.M)
        except OSError:
            lines = []
        words = lines[-1].split() if lines else []
        return {k: float(v) for k, v in zip(words[::2], words[1::2])}

    def progress(self, folder):
        now = self.line(folder)
        if not now:
            return "begins"
        known = self.kind == "cyclic" or self.strain is not None
        left = f", at most {runner.time_left(now['left'])} left" if known and now["left"] > 0 else ""
        return f"at {1e3 * now['strain']:.3g} per mille, {now['load']:.4g} N, {now['awake']:.0f} awake, {now['broken']:.0f} broken{left}"

    def share(self, folder):
        now = self.line(folder)
        if not now:
            return 0.0
        return min(now["share"] if self.kind == "cyclic" or self.strain is not None else now["strain"] / self.ends[self.test], 0.95)


class Wave(Stage):
    """Wave speeds at a mark of a loading."""

    def __init__(self, strain, load, extra):
        own = {"poured": "../poured", "loaded": f"../{load.label}", "after": f"mark_{strain:g}"}
        shared = {k: v for k, v in load.arguments.items() if k == "cell"}
        super().__init__(f"waves_{strain:g}_{load.label}", "in.wave", (load,), 3.0 * load.needs[0].cost, extra, {**own, **shared})
        self.load, self.strain = load, strain

    def results(self, folder):
        rate = re.findall(r"^WAVE \d .* dt (\S+)$", output(folder), re.M)
        if len(rate) < 4:
            raise Trouble(f"{os.path.join(folder, 'out.txt')}: lacks a line WAVE; run again")
        return {"load": self.load.label, "strain": self.strain, **waves.results(folder, float(rate[-1]))}

    def told(self, r):
        return f"shear wave {r['shear']:.0f} m/s, compression wave {r['compression']:.0f} m/s at an axial strain of {100 * r['strain']:.3g} %"


class Curve:
    """The rows of curve.csv from where the ends begin to move; stress and strain by the first shape of the specimen."""

    def __init__(self, folder, test, pressure, young=None):
        table = response.whole(folder, "curve")
        shape = Pour.results(None, os.path.join(os.path.dirname(folder), "poured"))
        text = output(folder)
        found = re.search(r"^SPECIMEN long (\S+)$", text, re.M)
        if not found:
            raise Trouble(f"{os.path.join(folder, 'out.txt')}: lacks the line SPECIMEN; run again")
        self.long, self.height, self.section = float(found[1]), shape["height"], shape["side"] ** 2
        self.grip = 0.5 * (self.height - self.long)
        moves = np.flatnonzero(table["stage"] == 1)
        if moves.size < 5:
            raise Trouble(f"{os.path.join(folder, 'curve.csv')}: less than five rows of loading; set a smaller record")
        first = max(moves[0] - 1, 0)
        t = self.table = {k: v[first:] for k, v in table.items()}
        self.test, self.pressure = test, pressure
        self.time = t["time"] - t["time"][0]
        self.strain = (t["way"] - t["way"][0]) / self.long
        self.stress = t["force"] / self.section
        self.lateral = t["lateral"] - t["lateral"][0]
        kinetic, stored = t["kinetic_beads"] + t["kinetic"], t["elastic"] + t["coupling"]
        self.kinetic, self.stored = kinetic, stored
        self.work = self._work(table, shape["side"])[first:]
        self.kinetic_share = kinetic / np.maximum(np.maximum(self.work, stored + kinetic), 1e-300)  # of all that was put in
        self.in_cement = t["work"]
        self.in_contacts = self.work - self.in_cement - t["kinetic_beads"]
        self.peak = int(np.argmax(self.stress))
        self.springs = np.full(len(self.strain), np.nan)  # energy of the contacts, see Springs
        steps, energy = Springs(folder, young).energies()
        if steps.size:
            self.springs = np.interp(t["step"], steps, energy)
        # What friction and dashpots of the contacts took since the start.
        self.rubbed = self.in_contacts - self.in_contacts[0] - (self.springs - self.springs[0])

    def _work(self, table, side):
        """Of the walls and grips on the specimen; forces are means over the interval that ends with the row."""
        axial = np.cumsum(table["force"][1:] * np.diff(table["way"]))
        sides = np.cumsum(table["sideways"][1:] * np.diff(table["lateral"])) * 2 * side
        return np.concatenate(([0.0], axial - sides))


class Springs:
    """Elastic energy of the contacts by Hertz and Mindlin, of beads with each other and with walls, from what LIGGGHTS tells of them.

    The energy of the normal springs is exact, that of the tangential ones is the one of their present stiffness."""

    def __init__(self, folder, young):
        self.folder = folder
        with open(os.path.join(FOLDER, "beads.in")) as beads, open(os.path.join(FOLDER, "contacts.in")) as contacts:
            young = float(young or re.search(r"^variable +young +index (\S+)", beads.read(), re.M)[1])
            poisson = float(re.search(r"poissonsRatio peratomtype (\S+)", contacts.read())[1])
        self.Y, self.G = young / (2 * (1 - poisson**2)), young / (4 * (2 - poisson) * (1 + poisson))

    def of(self, radius, depth, slip=0.0):
        return 8.0 / 15.0 * self.Y * np.sqrt(radius) * depth**2.5 + 4.0 * self.G * np.sqrt(radius * depth) * slip**2

    def energies(self):
        """Steps and the energy at each, J."""
        radius = {i: b[3] for i, b in next(iter(beads_at(self.folder).values()), {}).items()}
        found = {}
        for step, rows in response.dumps(self.folder, "pairs").items():
            a, b = (np.array([radius[int(i)] for i in rows[:, n]]) for n in (0, 1))
            found[step] = self.of(a * b / (a + b), rows[:, 5], np.linalg.norm(rows[:, 2:5], axis=1)).sum()
        for step, rows in response.dumps(self.folder, "walls").items():
            found[step] = found.get(step, 0.0) + self.of(np.array([radius[int(i)] for i in rows[:, 0]]), rows[:, 1]).sum()
        steps = sorted(found)
        return np.array(steps, dtype=float), np.array([found[s] for s in steps])


def slope(x, y):
    scale = np.ptp(x) if x.size >= 2 and np.isfinite(x).all() else 0.0
    return float(np.polyfit((x - x[0]) / scale, y - y[0], 1)[0] / scale) if scale > 0.0 else float("nan")


def gauge_strain(folder, c):
    """Axial strain of the beads themselves, at the rows of the curve: that of the plates holds the contacts of beads and plates, too.

    It is the slope of the displacements of all beads along the axis; in tension without those in the grips."""
    beads = beads_at(folder)
    steps = sorted(s for s in beads if s >= c.table["step"][0] - 1) or sorted(beads)[-1:]
    ids = sorted(beads[steps[0]])
    z = np.array([[beads[s][i][2] for i in ids] for s in steps])
    if c.test == "tension":
        z = z[:, (z[0] > c.grip) & (z[0] < c.height - c.grip)]
    if z.shape[1] < FEWEST:
        return np.full(len(c.strain), np.nan)
    strain = [np.polyfit(z[0], row - z[0], 1)[0] for row in z]
    return np.interp(c.table["step"], steps, strain) * (1.0 if c.test == "tension" else -1.0)


def calm_from(c, rising, fails):
    """Share of the peak of the load from which on the kinetic share of the energy stays below CALM until the first point fails; nan: it does not."""
    loud = np.flatnonzero(c.kinetic_share[: max(fails, 1)] >= CALM)
    first = int(loud[-1]) + 1 if loud.size else 0
    return float(rising[first] / rising[c.peak]) if first < fails else float("nan")


def pressure_off(c, rows):
    """Largest deviation of the sides' pressure from that asked for, over it, in rows of the curve; nan: there is none."""
    wanted = c.pressure * np.sqrt(c.section) * c.height
    return float(np.abs(c.table["sideways"][rows] / wanted - 1).max()) if wanted > 0.0 and c.table["sideways"][rows].size else float("nan")


def results(folder, load):
    c = Curve(folder, load.test, load.pressure, load.arguments.get("young"))
    t, k = c.table, c.peak
    cement = NO_CEMENT if load.kind == "uncemented" else runner.finished(os.path.dirname(folder), load.needs[0])
    if cement is None:
        raise Trouble(f"{folder}: the scripts changed while it ran; run again")
    whole, fabric = response.write(folder)
    top, end_q = int(np.argmax(whole["q"])), whole["axial_strain"] >= whole["axial_strain"][-1] - 0.05 * np.ptp(whole["axial_strain"])
    rising = (c.stress - load.pressure)[: k + 1]
    fails = int(np.argmax(t["failed"] > 0)) if (t["failed"] > 0).any() else k
    end = min(int(np.argmax(rising > STIFFNESS[1] * rising[k])), fails)  # later drops are none of it
    first = float(rising[:fails].max() / rising[k]) if 0 < fails < k else 0.0 if fails == 0 else float("nan")
    inside = np.flatnonzero(rising[:end] >= STIFFNESS[0] * rising[k] * min(STIFFNESS[1], first if fails < k else 1.0))
    gauge = gauge_strain(folder, c)
    half = min(int(np.argmax(rising >= 0.5 * rising[k])), fails - 1)
    before = {name: float(t[name][max(fails - 1, 0)]) if name in t else float("nan") for name in ("kinetic_share", "unbalanced")}
    return {
        "test": load.test,
        "content": cement["content_of_bond"],
        "pressure": load.pressure,
        **{k: cement[k] for k in ("bonds", "points", "content_of_all")},
        "stiffness": slope(gauge[inside], c.stress[inside]) if inside.size >= ROWS else float("nan"),
        "stiffness_of_ends": slope(c.strain[inside], c.stress[inside]) if inside.size >= ROWS else float("nan"),
        "strength": float(c.stress[k]),
        "strain_at_peak": float(c.strain[k]),
        "strain_at_end": float(c.strain[-1]),
        "load_at_end": float(c.stress[-1] / c.stress[k]),
        "awake_at_peak": int(t["awake"][k]),
        "broken_at_peak": int(t["broken"][k]),
        "awake_most": int(t["awake"].max()),
        "broken": int(t["broken"][-1]),
        "debonding": int(t["debonding"][-1]),
        "internal": int(t["internal"][-1]),
        "mixed": int(t["mixed"][-1]),
        "kinetic_at_half": float(c.kinetic_share[half]) if half > 0 else float("nan"),
        "kinetic_at_first_failure": float(c.kinetic_share[max(fails - 1, 0)]),
        "kinetic_at_peak": float(c.kinetic_share[k]),
        "imbalance": float(np.abs(t["imbalance"][1:]).max()),
        "work": float(c.work[-1]),
        "in_contacts": float(c.in_contacts[-1]),
        "steps": int(t["step"][-1] - t["step"][0]),
        "springs_at_peak": float((c.springs[k] - c.springs[0]) / c.work[k]),
        "rubbed_at_first_failure": float(c.rubbed[fails - 1] / c.work[fails - 1]) if fails > 1 else float("nan"),
        "rubbed_at_peak": float(c.rubbed[k] / c.work[k]),
        "load_when_calm": calm_from(c, rising, fails),
        "kinetic_share_at_first_failure": before["kinetic_share"],
        "unbalanced_at_first_failure": before["unbalanced"],
        "pressure_off_to_peak": pressure_off(c, slice(1, k + 1)),
        "pressure_off_after_peak": pressure_off(c, slice(k + 1, None)),
        "load_at_first_failure": first,
        "kind": load.kind,
        "q_peak": float(whole["q"][top]),
        "axial_strain_at_q_peak": float(whole["axial_strain"][top]),
        "q_at_end": float(whole["q"][end_q].mean()),
        "volume_strain_at_end": float(whole["volume_strain"][-1]),
        "coordination_at_end": float(fabric["coordination"][-1]) if fabric else float("nan"),
        "pieces_at_end": int(fabric["pieces"][-1]) if fabric else 0,
        "largest_piece_at_end": int(fabric["largest"][-1]) if fabric else 1,
    }


def before_failure(r, share=STIFFNESS[1]):
    """In words, where a value up to this share of the peak is one before the first failure instead; else nothing."""
    first = float(r["load_at_first_failure"])
    return f"before the first failure at {100 * first:.0f} % of the peak" if first < share else ""


def mohr_coulomb(rows):
    """Cohesion and friction angle (degrees) of the line strength = C + q pressure that fits best; the residual over the largest strength.

    Friction makes the strength rise by more than the pressure. Beyond the pressure of the largest strength less pressure the specimen is at its
    cap: the pressure itself breaks bonds. Those strengths are left out. `fit` is None where no two are left."""
    if len({float(r["pressure"]) for r in rows}) < 2:
        return None
    p, s = (np.array([float(r[k]) for r in sorted(rows, key=lambda r: float(r["pressure"]))]) for k in ("pressure", "strength"))
    cap = p[np.argmax(s - p)]
    found = {"beyond": [float(v) for v in p[p > cap]], "fitted": int((p <= cap).sum()), "fit": None}
    p, s = p[p <= cap], s[p <= cap]
    if len(set(p)) < 2:
        return found
    q, C = np.polyfit(p, s, 1)
    angle = np.degrees(np.arcsin((q - 1) / (q + 1)))
    found["fit"] = {
        "cohesion": float(C / (2 * np.sqrt(q))),
        "angle": float(angle),
        "slope": float(q),
        "unconfined": float(C),
        "off": float(np.abs(s - C - q * p).max() / s.max()),
    }
    return found


def counts(*loads):
    """Strengths of these make cohesion and friction angle."""
    return all(load.test == "compression" and load.kind == "drained" for load in loads)


def bonds_at(folder):
    """The table of the bonds by step: for each a dict of columns, in the order of the bonds."""
    table = response.whole(folder, "bond")
    steps = np.unique(table["step"])
    return {int(s): {k: v[table["step"] == s] for k, v in table.items()} for s in steps}


def beads_at(folder):
    """Positions and radii of the beads by step, by ID."""
    return {step: {int(r[0]): r[1:5] for r in rows} for step, rows in response.dumps(folder, "beads").items()}


def write(path, runs, out, needs_rows=False):
    """The finished loads, measured anew; returns them with their results. needs_rows: none is a mistake."""
    rows = [
        (r, {**res, **r.results(os.path.join(out, r.label))})
        for r, res in ((r, runner.finished(out, r)) for r in runs if isinstance(r, Load))
        if res is not None
    ]
    for load, res in rows:
        load.of_all = res["content_of_all"]
        line = mohr_coulomb([other for peer, other in rows if counts(load, peer) and load.content == peer.content])
        res["beyond_cap"] = int(line is not None and load.pressure in line["beyond"])
    speeds = [r for w, r in ((w, runner.finished(out, w)) for w in runs if isinstance(w, Wave)) if r is not None]
    response.write_rows(os.path.join(os.path.dirname(path), "waves.csv"), [{k: v for k, v in r.items() if k != "wall"} for r in speeds])
    if not rows and (needs_rows or os.path.exists(path)):
        stays = f", and {path} stays as it is" if os.path.exists(path) else ""
        raise Trouble(f"{out}: no load of this plan is finished there{stays}; give the folder and the words of the runs")
    with open(path + ".tmp", "w", newline="") as f:
        w = csv.writer(f, lineterminator="\n")
        w.writerow(COLUMNS)
        for r, res in rows:
            known = {**res, "label": r.label}
            w.writerow([f"{known[c]:.6g}" if isinstance(known[c], float) else known[c] for c in COLUMNS])
    os.replace(path + ".tmp", path)
    return rows
