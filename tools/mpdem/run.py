# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Reading what a run leaves: the table of the bonds and the dumps of the points."""
import glob
import os
import sys

import numpy as np

from . import tables
from .tables import Trouble

# The columns used; the table holds more.
COLUMNS = (
    "step",
    "time",
    "bond",
    "grain1",
    "grain2",
    "gap",
    "tension",
    "points",
    "attached",
    "debonded",
    "failed",
    "peak_tension",
    "separated",
    "share_grain1",
    "share_grain2",
    "dissipated_energy",
    "energy_imbalance",
    "fx1",
    "fy1",
    "fz1",
)
MODES = ("debonding", "internal", "mixed", "intact")
DUMP_COLUMNS = ("x", "y", "z", "c_damage", "c_failed")
EXTRA_COLUMNS = ("id", "c_bond", "c_attached", "c_grain")  # read if there


def end_with_message(program, main):
    """Calls main(); of what goes wrong the user sees one line."""
    try:
        main()
    except Trouble as trouble:
        sys.exit(f"{program}: {trouble}")
    except OSError as trouble:
        sys.exit(f"{program}: {trouble.filename}: {trouble.strerror}; check the path, its rights and the disk")


class Bond:
    """The rows of one bond; a column is an attribute. `mode`: as the table has it in the last row; `broken`: of each row, whether it has one."""

    def __init__(self, path, number, rows, modes):
        self.path, self.number, self.mode = path, number, modes[-1]
        self.broken = np.array([m != "intact" for m in modes])
        for i, name in enumerate(COLUMNS):
            setattr(self, name, rows[:, i])
        self.force = np.sqrt(self.fx1**2 + self.fy1**2 + self.fz1**2)  # its magnitude, shear included
        self.lift = self.gap - self.gap[0]
        self.opening = self.lift  # the displacement of the load, which is another with follow()
        self.grains = int(self.grain1[0]), int(self.grain2[0])
        self.load, self.way_name, self.load_name = "tension", "gap opening", "tension"
        self.way_unit, self.way_scale, self.load_unit = "µm", 1e6, "N"

    def follow(self, load, step, way, force):
        """Take the displacement and the force of a load other than tension from its own table."""
        turned = load in ("torsion", "bending")
        self.load = load
        self.opening, self.tension = np.interp(self.step, step, way), np.interp(self.step, step, force)
        if abs(self.tension.min()) > self.tension.max():  # loaded in the other sense
            self.opening, self.tension = -self.opening, -self.tension
        self.peak_tension = np.maximum.accumulate(self.tension)
        self.force = np.abs(self.tension)
        self.way_name = "rotation" if turned else "gap opening" if load == "force" else "displacement"
        self.load_name = "moment" if turned else "tension" if load == "force" else "force"
        if turned:
            self.way_unit, self.load_unit = "µrad", "N m"

    def at(self, step, column):
        """Value of a column, a name or an array, at a step between the rows."""
        values = getattr(self, column) if isinstance(column, str) else column
        return float(np.interp(step, self.step, values))


def number(value):
    """Whole from 100 on, three digits below."""
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def beside(bond, kind):
    """What the run calls another of its files: KIND_NAME beside bond_NAME.csv, KIND beside bond.csv."""
    name = os.path.splitext(os.path.basename(bond.path))[0]
    return kind + (name[len("bond") :] if name == "bond" or name.startswith("bond_") else f"_{name}")


def make_folder(path):
    try:
        os.makedirs(path, exist_ok=True)
    except OSError as e:
        raise Trouble(f"{path}: {e.strerror}; name a folder that can be written") from None


def find_bond_file(run_dir, name):
    if not os.path.isdir(run_dir):
        raise Trouble(f"{run_dir}: no such folder; name the folder of the run's output")
    if name:
        paths = [os.path.join(run_dir, name), name]
        for path in paths:
            if os.path.isfile(path):
                return path
        raise Trouble(f"{paths[0]}: no such file; name the 'csv' file of fix mpm/couple with --bond")
    found = sorted(p for name in ("bond.csv", "bond_*.csv") for p in glob.glob(os.path.join(glob.escape(run_dir), name)))
    if not found:
        raise Trouble(
            f"{os.path.join(run_dir, 'bond_*.csv')}: no such file, nor bond.csv; write one with "
            "'fix mpm/couple ... csv 50 bond_NAME.csv' or name it with --bond"
        )
    if len(found) > 1:
        names = ", ".join(os.path.basename(f) for f in found)
        raise Trouble(f"{run_dir}: holds several tables ({names}); choose one with --bond")
    return found[0]


def read_bonds(path):
    """All bonds of a table, by number. A last line that is still being written is left out."""
    return bonds_of(path, tables.read(path))


def bonds_of(path, table):
    """All bonds of a table that was read from `path`."""
    lacking = [c for c in (*COLUMNS, "mode") if c not in table]
    if lacking:
        raise Trouble(f"{path}: no column {', '.join(lacking)}; take a table written by 'fix mpm/couple ... csv' of this version, with its header line")
    if table.empty:
        raise Trouble(f"{path}: a header without rows; let the run get past its setup, then read again")
    rows = table[list(COLUMNS)].to_numpy(dtype=float)
    bad = ~np.isfinite(rows[:, [COLUMNS.index("gap"), COLUMNS.index("tension")]]).all(axis=1)
    if bad.any():
        raise Trouble(f"{path}: gap or tension is not finite from step {rows[bad][0, 0]:.0f}; the run is unstable, reduce its time step")
    wrong = sorted(set(table["mode"]) - set(MODES))
    if wrong:
        raise Trouble(f"{path}: mode '{wrong[0]}' is none of {', '.join(MODES)}; delete that line or run again")
    of_bond = table["bond"].to_numpy()
    return [Bond(path, int(n), rows[of_bond == n], list(table["mode"][of_bond == n])) for n in np.unique(of_bond)]


def choose(bonds, number):
    if number is None:
        return bonds[0]
    for b in bonds:
        if b.number == number:
            return b
    raise Trouble(f"{bonds[0].path}: no bond {number}; choose a number from {bonds[0].number} to {bonds[-1].number}")


def matches(run_dir, name):
    """A name or pattern counts from the run's folder, else from here."""
    if os.path.isfile(os.path.join(run_dir, name)):
        return [os.path.join(run_dir, name)]
    return glob.glob(os.path.join(glob.escape(run_dir), name)) or glob.glob(name)


def find_dumps(run_dir, names, bond):
    """Paths by step; dumps beyond the table belong to another run."""
    if not names:
        names = [f"{beside(bond, 'points')}.*.txt"]
    shown = os.path.join(run_dir, names[0])
    dumps = {}
    for path in sorted({p for name in names for p in matches(run_dir, name)}):
        step = tables.dump_step(path)
        if step in dumps:
            raise Trouble(f"{dumps[step]} and {path}: both are of step {step}; name the dumps of one run with --points")
        dumps[step] = path
    if not dumps:
        raise Trouble(
            f"{shown}: no such dumps, so no damage_cut.png; name them with --points (--cut of mpdem_movie.py), or leave the cut of mpdem_plot.py out with '--points none'"
        )
    return dumps_of(shown, dumps, bond)


def dumps_of(shown, dumps, bond):
    """Those of the dumps, paths by step, that lie in the table of the bond."""
    kept = {s: dumps[s] for s in sorted(dumps) if bond.step[0] <= s <= bond.step[-1]}
    if not kept:
        raise Trouble(
            f"{shown}: no dump between the steps {bond.step[0]:.0f} and {bond.step[-1]:.0f} of {bond.path}; name the dumps of the same run with --points"
        )
    return kept


def read_dump(path):
    """Columns of the first snapshot of a text dump, by name."""
    step, table = tables.read_dump(path)
    lacking = [c for c in DUMP_COLUMNS if c not in table]
    if lacking:
        raise Trouble(f"{path}: no column {', '.join(lacking)}; dump x y z and 'compute mpm/atom' with the ID damage and the ID failed")
    if table.empty:
        raise Trouble(f"{path}: cut short, no points announced; delete this dump or run again")
    return {"step": step, **{c: table[c].to_numpy() for c in DUMP_COLUMNS + EXTRA_COLUMNS if c in table}}


def spacing(points):
    """Distance of the points inside the bond; those at its surface are closer or shifted."""
    x = np.column_stack([points[c] for c in "xyz"])
    if len(x) < 2:
        raise Trouble("too few points to measure their spacing; give it with --spacing")
    nearest = []
    for i in np.unique(np.linspace(0, len(x) - 1, 200).astype(int)):
        squares = ((x - x[i]) ** 2).sum(axis=1)
        squares[i] = np.inf
        nearest.append(squares.min())
    return float(np.sqrt(np.percentile(nearest, 90)))
