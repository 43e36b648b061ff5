#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Loads pairs of beads of every shape, load and content of a table, on all cores.

    tools/pair_table.py OUT --shapes flat,meniscus --loads tension,shear --contents 0.01,0.05
    tools/pair_table.py OUT --table doc/data/study_strength.json
    tools/pair_table.py OUT --redraw doc/data/study_strength.csv

Runs examples/pair_table/in.pair_table once for each entry, as many at a time as there are cores, and
leaves table.csv and table.png in OUT, and map.png if the runs differ in the strength of a cohesive
interface: the modes over content and that strength. Called again it goes on where it was stopped:
finished runs are kept, others are run from the start; what is finished is written when it is stopped,
too. --redraw runs nothing: it draws the figures anew. Needs Debian's python3-numpy, python3-pandas and python3-matplotlib.
"""
import argparse
import json
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    from mpdem import run, runner, table
except ImportError as missing:
    sys.exit(
        f"pair_table.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def arguments():
    p = argparse.ArgumentParser(description="Loads pairs of beads of every shape, load and content of a table.")
    p.add_argument("out", metavar="OUT", help="folder of the runs, table.csv and table.png")
    p.add_argument("--table", metavar="JSON", help="groups of runs; instead of the words below")
    p.add_argument("--redraw", metavar="CSV", help="a table.csv of earlier runs, to be drawn again")
    p.add_argument("--shapes", metavar="A,B", default="flat,meniscus,coating", help=", ".join(table.SHAPES))
    p.add_argument("--loads", metavar="A,B", default="tension,shear", help=", ".join(table.LOADS))
    p.add_argument("--contents", metavar="C,D", default="0.05,0.11,0.17,0.25", help="masses of cement over mass of the beads")
    p.add_argument("--set", metavar="NAME=VALUE", action="append", default=[], help="a variable of the script, or refine, layers, coarse")
    p.add_argument("--vary", metavar="NAME=V,W", action="append", default=[], help="the same, with several values")
    runner.add_arguments(p, os.path.join(ROOT, "build", "liggghts-mpdem"))
    p.add_argument("--script", metavar="FILE", default=os.path.join(ROOT, "examples", "pair_table", "in.pair_table"))
    return p.parse_args()


def pairs(words, option):
    found = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not (name and equals and value):
            raise run.Trouble(f"{option} {word}: must be NAME=VALUE")
        found[name] = value
    return found


def numbers(text):
    try:
        return [float(t) for t in text.split(",")]
    except ValueError:
        raise run.Trouble(f"--contents {text}: must be numbers with commas between them") from None


def groups(args):
    if not args.table:
        return [
            {
                "shapes": args.shapes.split(","),
                "loads": args.loads.split(","),
                "contents": numbers(args.contents),
                "set": pairs(args.set, "--set"),
                "vary": {k: v.split(",") for k, v in pairs(args.vary, "--vary").items()},
            }
        ]
    try:
        with open(args.table) as f:
            found = json.load(f)
    except ValueError as e:
        raise run.Trouble(f"{args.table}: not JSON ({e}); see doc/data/study_strength.json") from None
    if not isinstance(found, list) or not found or not all(isinstance(g, dict) for g in found):
        raise run.Trouble(f"{args.table}: must be a list of groups, at least one; see doc/data/study_strength.json")
    return found


def draw(out, rows):
    """The figures of finished runs; their names."""
    from mpdem import mode_map, table_figure
    from mpdem.figures import save

    names = []
    if rows:
        save(table_figure.draw(rows), os.path.join(out, "table.png"))
        names.append("table.png")
    if mode_map.wanted(rows):
        save(mode_map.figure(rows), os.path.join(out, "map.png"))
        names.append("map.png")
    return names


def main():
    args = arguments()
    if args.redraw:
        from mpdem import table_figure

        rows = table_figure.read(args.redraw)
        run.make_folder(args.out)
        print(f"written to {args.out}: {', '.join(draw(args.out, rows))}")
        return
    runner.check_executable(args)
    entries = {}
    for group in groups(args):
        entries.update({r.label: r for r in table.product(group, os.path.abspath(args.script))})
    runs = list(entries.values())
    run.make_folder(args.out)
    all_runs, stopped = runner.make_runs(args, args.out, runs)
    rows = table.write(os.path.join(args.out, "table.csv"), runs, os.path.abspath(args.out))
    print(f"written to {args.out}: {', '.join(['table.csv'] + draw(args.out, rows))}")
    runner.tell_end("pair_table.py", all_runs, stopped)


if __name__ == "__main__":
    run.end_with_message("pair_table.py", main)
