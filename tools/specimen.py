#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Pours a specimen of beads, cements it, and breaks it: compression, direct tension, triaxial compression.

    tools/specimen.py OUT
    tools/specimen.py OUT --calcite 0.025 --tests '' --pressures 5e4 --strain 0.05 --confined drained,uncemented --waves 0,0.01
    tools/specimen.py OUT --redraw

Runs the scripts of examples/specimen: in.pour once, in.cement once for each content, in.load for each content in
compression and in tension, and for each confining pressure at one content; in.wave at marks of these. Leaves
specimen.csv, waves.csv and figures in OUT, and prints cohesion and friction angle. Called again it goes on where it was
stopped: finished runs are kept, loadings go on from their last checkpoint. --redraw runs nothing. Needs Debian's
python3-numpy, python3-pandas and python3-matplotlib.
"""
import argparse
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    from mpdem import response, run, runner, specimen
except ImportError as missing:
    sys.exit(
        f"specimen.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def positive(text):
    try:
        found = [float(t) for t in text.split(",") if t]
    except ValueError:
        found = [-1.0]
    if any(not 0.0 < v < float("inf") for v in found):
        raise argparse.ArgumentTypeError(f"{text}: must be positive numbers with commas between them")
    return found


def strain(text):
    found = positive(text)
    if len(found) != 1 or found[0] >= 0.5:
        raise argparse.ArgumentTypeError(f"{text}: must be a number above 0, below 0.5")
    return found[0]


def strains(text):
    """Numbers from 0 on."""
    return [0.0 if t.strip() in ("0", "0.0") else positive(t)[0] for t in text.split(",") if t.strip()]


def arguments():
    p = argparse.ArgumentParser(description="Pours a specimen of beads, cements it, and breaks it.")
    p.add_argument("out", metavar="OUT", help="folder of the runs, specimen.csv and the figures")
    p.add_argument("--beads", metavar="N", type=beads, default=80, help="number of beads (80), 10 or more")
    amount = p.add_mutually_exclusive_group()
    amount.add_argument("--calcite", metavar="C,D", type=positive, help="mass of the cement over that of all beads, as laboratories give it")
    amount.add_argument(
        "--contents",
        metavar="C,D",
        type=positive,
        default=[0.003, 0.006, 0.012],
        help="mass of the cement of a bond over that of its two beads (0.003,0.006,0.012)",
    )
    p.add_argument("--pressures", metavar="P,Q", type=positive, default=[1.25e4, 2.5e4, 5e4], help="on the sides, Pa (1.25e4,2.5e4,5e4); none: ''")
    p.add_argument("--at", metavar="C", type=float, help="amount of cement at which the sides are pressed (default: the middle one)")
    p.add_argument("--tests", metavar="A,B", default="compression,tension", help="unconfined tests: compression and tension; none: ''")
    p.add_argument(
        "--confined", metavar="A,B", default="drained", help="tests at each pressure: drained (default), undrained (the volume stays), cyclic, uncemented"
    )
    p.add_argument("--strain", metavar="E", type=strain, help="axial strain at which compression ends (default: after the peak)")
    p.add_argument(
        "--waves", metavar="E,F", type=strains, default=[], help="axial strains at which the drained tests get their wave speeds; 0: before the plate moves"
    )
    p.add_argument("--set", metavar="NAME=VALUE", action="append", default=[], help="a variable of the scripts")
    p.add_argument("--redraw", action="store_true", help="run nothing, draw what is finished")
    runner.add_arguments(p, os.path.join(ROOT, "build", "liggghts-mpdem"))
    return p.parse_args()


def variables(words):
    """NAME=VALUE as a dict; names that no script has are refused."""
    known = sorted(
        {v for s in ("beads.in", "in.pour", "in.cement", "in.load", "in.wave") for v in specimen.variables_of(os.path.join(specimen.FOLDER, s))}
        - {"here", "poured", "cemented", "beads", "content", "calcite", "test", "pressure", "start", "loaded", "after", "resume", "sides", "ends", "marks"}
    )
    found = {}
    for word in words:
        name, _, value = word.partition("=")
        if name not in known or not value:
            raise run.Trouble(f"--set {word}: must be NAME=VALUE, with NAME one of {', '.join(known)}")
        if name == "seed":
            specimen.check_seed(value)
        found[name] = value
    return found


def plan(args):
    """All runs, and the content at which the sides are pressed."""
    extra, tests = variables(args.set), [t for t in args.tests.split(",") if t]
    for test in tests:
        if test not in ("compression", "tension"):
            raise run.Trouble(f"--tests {test}: must be compression or tension")
    confined = [k for k in args.confined.split(",") if k]
    for kind in confined:
        if kind not in specimen.KINDS:
            raise run.Trouble(f"--confined {kind}: must be drained, undrained, cyclic or uncemented")
    if args.waves and (args.strain is None or max(args.waves) > args.strain or "drained" not in confined or not args.pressures):
        raise run.Trouble("--waves: needs --strain, not below the largest of them, and drained tests at a pressure")
    contents = sorted(args.calcite or args.contents)
    if args.at is not None and not 0.0 < args.at < 1.0:
        raise run.Trouble(f"--at {args.at}: must be above 0 and below 1")
    reference = contents[len(contents) // 2] if args.at is None else args.at
    poured = specimen.Pour(args.beads, extra)
    cements = {c: specimen.Cement(c, poured, extra, bool(args.calcite)) for c in sorted({*contents, reference})}
    loads = [specimen.Load(test, c, 0.0, cements[c], extra, strain=args.strain) for c in contents for test in tests]
    for p in sorted(args.pressures):
        for kind in confined:
            below = poured if kind == "uncemented" else cements[reference]
            loads.append(specimen.Load("compression", reference, p, below, extra, kind, args.strain, args.waves if kind == "drained" else ()))
    used = {n.label for load in loads for n in load.needs}
    measured = [specimen.Wave(e, load, extra) for load in loads if load.pressure and load.kind == "drained" for e in sorted(args.waves)]
    return [poured, *(c for c in cements.values() if c.label in used), *loads, *measured], reference


def draw(out, rows, reference, line):
    from mpdem import specimen_figures as figures
    from mpdem.figures import save

    items = [(load, r, specimen.Curve(os.path.join(out, load.label), load.test, load.pressure, load.arguments.get("young"))) for load, r in rows]
    names, roses = [], []
    usual = [i for i in items if i[0].kind == "drained"]
    if usual:
        save(figures.curves(usual, reference), os.path.join(out, "curves.png"))
        save(figures.awake(usual), os.path.join(out, "awake.png"))
        save(figures.strengths(usual, reference, line), os.path.join(out, "strength.png"))
        names += ["curves.png", "awake.png", "strength.png"]
    confined = [i for i in items if i[0].pressure]
    if confined:
        drained = [i for i in confined if i[0].kind in ("drained", "cyclic")]
        if drained:
            save(figures.pressures(drained), os.path.join(out, "pressure.png"))
            names.append("pressure.png")
        names += respond(out, confined)
    for load, _, curve in (i for i in items if i[0].kind != "uncemented"):
        folder = os.path.join(out, load.label)
        bonds, beads = specimen.bonds_at(folder), specimen.beads_at(folder)
        save(figures.energy(load, curve), os.path.join(out, f"energy_{load.label}.png"))
        save(figures.bonds_in_space(load, curve, bonds, beads), os.path.join(out, f"bonds_{load.label}.png"))
        names += [f"energy_{load.label}.png", f"bonds_{load.label}.png"]
        roses.append((load, bonds[min(bonds)], bonds[max(bonds)], beads[min(beads)]))
    if roses:
        save(figures.rose(roses), os.path.join(out, "rose.png"))
        names.append("rose.png")
    return names


def respond(out, confined):
    """The figure of each cemented specimen beside the uncemented one of its pressure, and of an uncemented one that is alone."""
    from mpdem import response_figure
    from mpdem.figures import save

    names = []
    free = {load.pressure: load for load, _, _ in confined if load.kind == "uncemented"}
    cemented = [load for load, _, _ in confined if load.kind != "uncemented"]
    for load in cemented or free.values():
        shown = [load] + ([free[load.pressure]] if load.pressure in free and load.kind == "drained" else [])
        names.append(f"response_{load.label}.png")
        save(response_figure.response([(x, *response.read(os.path.join(out, x.label))) for x in shown]), os.path.join(out, names[-1]))
    return names


def tell(rows, reference):
    """The table, and cohesion and friction angle; returns these."""
    for load, r in rows:
        calm = f"below 1e-3 from {100 * r['load_when_calm']:.0f} % of the peak" if r["load_when_calm"] < 1.0 else "not below 1e-3 before"
        share, early = r["kinetic_at_half"], specimen.before_failure(r, 0.5)
        if load.pressure and (load.strain is not None or load.kind != "drained"):
            print(
                f"{load.label}: q {1e-3 * r['q_peak']:.4g} kPa at most, at {100 * r['axial_strain_at_q_peak']:.3g} %; at the end, {100 * r['strain_at_end']:.3g} %, "
                f"q {1e-3 * r['q_at_end']:.4g} kPa, volume strain {100 * r['volume_strain_at_end']:+.3g} %, {r['coordination_at_end']:.3g} contacts a bead, "
                f"{r['pieces_at_end']} pieces of joined beads, the largest of {r['largest_piece_at_end']}"
            )
        if load.kind != "drained":
            continue
        print(
            f"{load.label}: {load.told(r)}; kinetic share of the energy {f'{share:.1e}' if share > 0.0 else 'n/a'} {early or 'at half of the peak'}, {calm} until the first point fails; "
            f"energy imbalance of the cement {r['imbalance']:.1e}; of the work at the peak {100 * r['springs_at_peak']:.3g} % are in the springs of the contacts, "
            f"{100 * r['rubbed_at_peak']:.2g} % went to their friction and dashpots"
            + (
                f"; pressure of the sides off by at most {100 * r['pressure_off_to_peak']:.2g} % up to the peak, {100 * r['pressure_off_after_peak']:.2g} % after it"
                if load.pressure
                else ""
            )
        )
    line = specimen.mohr_coulomb([r for load, r in rows if specimen.counts(load) and load.content == reference])
    if not line:
        return None
    amount = next(f"{100 * load.of_all:.3g} % calcite" for load, _ in rows if load.content == reference)
    if line["beyond"]:
        print(
            f"{amount}: at {', '.join(f'{1e-6 * p:g}' for p in line['beyond'])} MPa the specimen is beyond its cap: the strength rises by less than the "
            "pressure, which breaks bonds itself; left out of cohesion and friction angle"
        )
    fit = line["fit"]
    if fit:
        print(
            f"{amount}: cohesion {1e-6 * fit['cohesion']:.3g} MPa, friction angle {fit['angle']:.3g} degrees, from {line['fitted']} strengths; "
            + (
                "a line fits two of them always, more --pressures would show how well"
                if line["fitted"] == 2
                else f"these are off the line by at most {100 * fit['off']:.2g} % of the largest"
            )
        )
    else:
        print(f"{amount}: no friction angle: less than two strengths are below the cap; set smaller --pressures or a larger content by --at")
    return line


def beads(text):
    number = runner.at_least_one(text)
    if number < 10:
        raise argparse.ArgumentTypeError(f"{number} beads are no specimen: their stiffness is that of one or two contacts; use 10 or more")
    return number


def main():
    args = arguments()
    runs, reference = plan(args)
    if not args.redraw:
        runner.check_executable(args)
    out = os.path.abspath(args.out)
    run.make_folder(out)
    all_runs, stopped = (None, False) if args.redraw else runner.make_runs(args, out, runs)
    rows = specimen.write(os.path.join(out, "specimen.csv"), runs, out, needs_rows=args.redraw)
    names = ["specimen.csv"] + ["waves.csv"] * bool(args.waves and rows) + (draw(out, rows, reference, tell(rows, reference)) if rows else [])
    print(f"written to {args.out}: {', '.join(names)}")
    if all_runs:
        runner.tell_end("specimen.py", all_runs, stopped)


if __name__ == "__main__":
    run.end_with_message("specimen.py", main)
