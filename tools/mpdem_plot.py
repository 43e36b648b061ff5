#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Summary and figures of loaded bonds.

    tools/mpdem_plot.py RUN_DIR [--bond bond_NAME.csv] [--points 'points_NAME.*.txt'] [--out DIR]

Reads the table of `fix mpm/couple ... csv` and the text dumps of the material points, prints a
summary and writes summary.csv, force_displacement.png and damage_cut.png; geometry.png, if the dumps
have the compute `attached`; interface.png, if there is the event log events_NAME.csv and links
debonded. With the table load_NAME.csv of examples/pair_table, displacement and load are those of its load.

summary.csv has a row a bond. Whether a bond is separated, the mode, the step and the shares are those of its table.
`peak_force_N` is the largest magnitude of the force along the line of centres, `sense` tells whether it is tension or
compression, `largest_force_with_shear_N` is of the whole force. Openings are those of the gap between the grains since
the first row of the table; below zero the gap has closed. `lowest_mean_load_over_peak` tells what is left of the load.
Needs Debian's python3-numpy, python3-pandas and python3-matplotlib.
"""
import argparse
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    from mpdem import figures, interface, run, summary
except ImportError as missing:
    sys.exit(
        f"mpdem_plot.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )


def positive(text):
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def arguments():
    p = argparse.ArgumentParser(description="Summary and figures of loaded bonds.")
    p.add_argument("run_dir", metavar="RUN_DIR", help="folder of the run's output")
    p.add_argument("--bond", metavar="CSV", help="table of fix mpm/couple (default: the only bond.csv or bond_*.csv in RUN_DIR)")
    p.add_argument(
        "--points",
        metavar="DUMP",
        nargs="+",
        help="dumps of the points, names or a pattern (default: points_NAME.*.txt, " "NAME as in bond_NAME.csv); 'none': no cut",
    )
    p.add_argument("--events", metavar="CSV", help="event log of fix mpm (default: events_NAME.csv, if it is there)")
    p.add_argument("--grain", metavar="ID", type=int, help="grain whose interface is drawn (default: where most links debonded)")
    p.add_argument("--out", metavar="DIR", help="where to write (default: RUN_DIR)")
    p.add_argument("--which", metavar="N", type=int, help="number of the bond to plot (default: the first)")
    p.add_argument("--radius", metavar="R", type=positive, default=0.005, help="of the two grains, m (0.005)")
    p.add_argument("--spacing", metavar="H", type=positive, help="of the material points, m (default: measured)")
    p.add_argument("--window", metavar="STEPS", type=positive, help="over which the load that is left is averaged (500, or as the script of pair_table)")
    return p.parse_args()


def main():
    args = arguments()
    bonds = run.read_bonds(run.find_bond_file(args.run_dir, args.bond))
    table = run.choose(bonds, args.which)
    window = interface.follow_load(args.run_dir, table)
    window = args.window or window or 500
    results = {b.number: summary.measure(b, window) for b in bonds}
    result = results[table.number]
    summary.show(table, result, results)

    out = args.out or args.run_dir
    run.make_folder(out)
    summary.write(os.path.join(out, "summary.csv"), bonds, results)
    written = ["summary.csv"]
    if not result.peak > 0.0:
        raise run.Trouble(f"{table.path}: bond {table.number} was never loaded, nothing to draw; " "move its grains or choose another bond with --which")

    # The curve is drawn even if something is wrong with the dumps; the complaint comes last.
    stages, trouble = [], None
    if args.points != ["none"]:
        try:
            dumps = run.find_dumps(args.run_dir, args.points, table)
            stages = summary.stages(table, result, dumps)
        except run.Trouble as t:
            trouble = t
    figures.save(figures.force_displacement(table, result, stages), os.path.join(out, "force_displacement.png"))
    written.append("force_displacement.png")
    if stages:
        try:
            spacing = args.spacing or run.spacing(run.read_dump(dumps[min(dumps)]))
            figures.save(figures.damage_cut(table, result, stages, args.radius, spacing), os.path.join(out, "damage_cut.png"))
            written.append("damage_cut.png")
            written += interface.draw(args, out, table, dumps, spacing)
        except run.Trouble as t:
            trouble = t
    print(f"  written to {out}: {', '.join(written)}", flush=True)
    if trouble:
        raise trouble


if __name__ == "__main__":
    run.end_with_message("mpdem_plot.py", main)
