# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""What a run left in its folder, as pandas tables with units. doc/python.md shows how to use it."""
import glob
import os
import re
from functools import cached_property
from typing import Any, Dict, List, Optional

import numpy as np
import pandas as pd

from . import response, tables, units
from .tables import Trouble

POINTS = ("points", "cement_at", "cut")  # first words of dumps of the cement, the fullest first
GRAINS = ("beads_at", "beads", "grains")
CONTACTS = {9: "grain1 grain2 slip_x slip_y slip_z overlap fx fy fz", 6: "grain1 grain2 slip_x slip_y slip_z overlap"}
CURVES = ("curve", "response", "fabric", "fragments")  # of a loaded specimen
SUMMARIES = ("specimen", "table", "waves")  # of a driver


class Output:
    """The output of one run, or of a driver: tools/specimen.py or tools/pair_table.py. Files are read when they are asked for, once.

    folder: path; name: NAME of bond_NAME.csv, events_NAME.csv, ..., "" if they have none.
    Each table is a pandas DataFrame in the units of the script; table.attrs["units"] has the unit of each column."""

    def __init__(self, folder: str, name: Optional[str] = None):
        self.folder = os.fspath(folder)
        if not os.path.isdir(self.folder):
            raise Trouble(f"{self.folder}: no such folder; name the folder of the run's output")
        names = self._names()
        if name is None and len(names) > 1:
            raise Trouble(f"{self.folder}: holds several runs ({', '.join(n or 'without a name' for n in names)}); choose one with name=")
        if name is not None and name not in names:
            raise Trouble(f"{self.folder}: no run '{name}'; there are {', '.join(n or 'one without a name' for n in names) or 'none'}")
        self.name = names[0] if name is None and names else name or ""
        if not (names or self.dumps or self.runs or self.summaries or any(self._is_file(f"{c}.csv") for c in CURVES) or self._is_file("log.liggghts")):
            raise Trouble(f"{self.folder}: has no bond*.csv, events*.csv, load*.csv, curve.csv, dump or log.liggghts; name the folder of the run's output")

    def __repr__(self) -> str:
        has = [n for n in ("bonds", "events") if self._path(n.rstrip("s") if n == "bonds" else n)]
        has += [f"curves: {', '.join(self.curves)}"] * bool(self.curves) + [f"{len(self.point_steps)} dumps of points"] * bool(self.point_steps)
        has += [f"{len(self.runs)} runs"] * bool(self.runs)
        return f"<mpdem output of {self.folder}{f', run {self.name}' if self.name else ''}: {'; '.join(has) or 'a log'}>"

    # ------------------------------------------------------------------------------------------------ files

    def _is_file(self, name: str) -> bool:
        return os.path.isfile(os.path.join(self.folder, name))

    def _names(self) -> List[str]:
        found = set()
        for kind in ("bond", "events", "load"):
            for path in glob.glob(os.path.join(glob.escape(self.folder), f"{kind}*.csv")):
                match = re.fullmatch(rf"{kind}(?:_(?!from_\d+\.)(.*))?\.csv", os.path.basename(path))
                if match:
                    found.add(match[1] or "")
        return sorted(found)

    def _path(self, kind: str) -> str:
        """Of a table of this run; "" if there is none."""
        name = f"{kind}_{self.name}.csv" if self.name else f"{kind}.csv"
        return os.path.join(self.folder, name) if self._is_file(name) else ""

    def _table(self, kind: str, how: str) -> pd.DataFrame:
        path = self._path(kind)
        if not path:
            raise Trouble(f"{self.folder}: no {kind}{'_' + self.name if self.name else ''}.csv; write it with {how}")
        return tables.whole(self.folder, os.path.splitext(os.path.basename(path))[0])

    def _with_units(self, table: pd.DataFrame, kind: str, more: Optional[Dict[str, str]] = None) -> pd.DataFrame:
        return units.attach(table, kind, more or {}, self.unit_style)

    @cached_property
    def log(self) -> str:
        """The text of log.liggghts, "" without one."""
        return tables.whole_lines(os.path.join(self.folder, "log.liggghts")) if self._is_file("log.liggghts") else ""

    @cached_property
    def unit_style(self) -> str:
        """`units` of the script, "si" if the log does not tell. Units of the columns are known for that only."""
        found = re.search(r"^units +(\w+)", self.log, re.M)
        return found[1] if found else "si"

    # ------------------------------------------------------------------------------------------------ tables

    @cached_property
    def bonds(self) -> pd.DataFrame:
        """The table of fix mpm/couple: a row for each bond at each step that was written."""
        return self._with_units(self._table("bond", "'fix mpm/couple ... csv N FILE'"), "bonds")

    @cached_property
    def last_bonds(self) -> pd.DataFrame:
        """The last row of each bond, by its number."""
        table = self.bonds.groupby("bond", sort=True).tail(1).set_index("bond", drop=False).sort_index()
        return self._with_units(table, "bonds")

    def bond(self, number: int) -> pd.DataFrame:
        """The rows of one bond."""
        table = self.bonds[self.bonds["bond"] == number]
        if table.empty:
            known = self.bonds["bond"]
            raise Trouble(f"{self.folder}: no bond {number}; " + (f"they are {known.min()} to {known.max()}" if len(known) else "the table has no rows yet"))
        return self._with_units(table.reset_index(drop=True), "bonds")

    @cached_property
    def events(self) -> pd.DataFrame:
        """The table of fix mpm: a row for each point that failed and each link that debonded."""
        return self._with_units(self._table("events", "the word 'events FILE' of fix mpm"), "events")

    @cached_property
    def thermo(self) -> pd.DataFrame:
        """What the script printed with thermo_style, from log.liggghts, of all its runs."""
        return self._with_units(tables.read_thermo(self.log), "thermo")

    @cached_property
    def result(self) -> Dict[str, Any]:
        """The words of the last line RESULT of a script of `examples`; {} without one."""
        return tables.read_result(self.log)

    @property
    def load_name(self) -> str:
        """The load of a pair of examples/pair_table: tension, shear, ...; "" of another run."""
        found = re.search(r"^shape \S+, load (\w+), ", self.log, re.M)
        return found[1] if found else ""

    @cached_property
    def curves(self) -> Dict[str, pd.DataFrame]:
        """Curves by name, as far as they are there: `load` of a pair; `curve`, `response`, `fabric`, `fragments` of a specimen; `thermo`."""
        found: Dict[str, pd.DataFrame] = {}
        if self._path("load"):
            turned = self.load_name in ("torsion", "bending")
            found["load"] = self._with_units(tables.read(self._path("load")), "turn" if turned else "load")
        for name in CURVES:
            if self._is_file(f"{name}.csv"):
                found[name] = self._with_units(tables.whole(self.folder, name), name)
        if "curve" in found and "response" not in found and (found["curve"]["stage"] == 1).any():
            curve = {c: found["curve"][c].to_numpy() for c in found["curve"]}
            found["response"] = self._with_units(pd.DataFrame(response.response(curve)), "response")
        if len(self.thermo):
            found["thermo"] = self.thermo
        return found

    @property
    def curve(self) -> pd.DataFrame:
        """The first of `curves`: what the script was run for."""
        if not self.curves:
            raise Trouble(f"{self.folder}: no load*.csv, curve.csv or thermo output in log.liggghts; keep the log of the run in its folder")
        return next(iter(self.curves.values()))

    # ------------------------------------------------------------------------------------------------ dumps

    @cached_property
    def dumps(self) -> Dict[str, Dict[int, str]]:
        """Paths of the text dumps NAME.STEP.txt, by NAME and step."""
        return tables.dump_paths(self.folder)

    @cached_property
    def _columns(self) -> Dict[str, str]:
        """Units of the columns c_ID of dumps, by what the log says of the computes."""
        found = re.findall(r"^compute +(\S+) +\S+ +mpm/atom +\S+ +(\w+)", self.log, re.M)
        known = {"c_damage": "1", "c_failed": "1", "c_bond": "1", "c_attached": "1", "c_grain": "1"}
        return {**known, **{f"c_{ID}": units.of_quantity(quantity) for ID, quantity in found}}

    def _dump(self, firsts: Any) -> str:
        names = [f"{first}_{self.name}" if self.name else first for first in firsts]
        return next((n for n in [*names, *firsts] if n in self.dumps), "")

    @property
    def points_name(self) -> str:
        """NAME of the dumps of the cement: points, cement_at or cut, or the first with c_damage; "" without one."""
        found = self._dump(POINTS)
        if found:
            return found
        for name, paths in self.dumps.items():
            try:
                if "c_damage" in tables.read_dump(next(iter(paths.values())))[1]:
                    return name
            except Trouble:
                continue
        return ""

    @cached_property
    def point_steps(self) -> List[int]:
        """Steps of the dumps of the cement."""
        return list(self.dumps.get(self.points_name, {}))

    def snapshot(self, name: str, step: Optional[int] = None) -> pd.DataFrame:
        """The dump NAME.STEP.txt; without a step the last one that is whole. Rows are in the order of the IDs; attrs["step"] has the step."""
        paths = self.dumps.get(name, {})
        if not paths:
            there = f"there are {', '.join(self.dumps)}" if self.dumps else "there are none"
            raise Trouble(f"{self.folder}: no dumps {name or 'of the cement'}; {there}; write them with 'dump ID group custom N NAME.*.txt id x y z ...'")
        if step is not None and step not in paths:
            raise Trouble(f"{self.folder}: no dump {name} of step {step}; there are {min(paths)} to {max(paths)}, {len(paths)} of them")
        trouble = None
        for at in [step] if step is not None else sorted(paths, reverse=True):
            try:
                found, table = tables.read_dump(paths[at])
            except Trouble as t:
                trouble = t  # the last one may be being written
                continue
            if "id" in table:
                table = table.sort_values("id", ignore_index=True)
            table.attrs["step"] = found
            if name.split("_")[0] == "pairs" and len(table.columns) in CONTACTS:
                table.columns = CONTACTS[len(table.columns)].split()
                return self._with_units(table, "contacts")
            if name.split("_")[0] == "walls" and len(table.columns) == 2:
                table.columns = ["grain1", "overlap"]
                return self._with_units(table, "contacts")
            return self._with_units(table, "dump", self._columns)
        assert trouble
        raise trouble

    @cached_property
    def points(self) -> pd.DataFrame:
        """The points of the cement at the last dump that is whole."""
        return self.points_at(None)

    def points_at(self, step: Optional[int]) -> pd.DataFrame:
        return self.snapshot(self.points_name, step)

    def grains_at(self, step: Optional[int] = None) -> pd.DataFrame:
        """Centres and radii of the grains, by ID; without a step at the last dump."""
        table = self.snapshot(self._dump(GRAINS) or "beads", step)
        lacking = [c for c in ("id", "x", "y", "z", "radius") if c not in table]
        if lacking:
            raise Trouble(f"{self.folder}: the dumps of the grains have no column {', '.join(lacking)}; dump id x y z radius")
        attrs, table["id"] = table.attrs, table["id"].astype(int)
        table = table.set_index("id", drop=False)
        table.attrs = attrs
        return table

    @property
    def grain_steps(self) -> List[int]:
        """Steps of the dumps of the grains."""
        return list(self.dumps.get(self._dump(GRAINS), {}))

    def contacts_at(self, step: Optional[int] = None) -> pd.DataFrame:
        """Touching pairs of grains, of the dumps pairs.STEP.txt of examples/specimen: force on the first one, tangential displacement, overlap."""
        return self.snapshot("pairs", step)

    def bonds_at(self, step: Optional[int] = None) -> pd.DataFrame:
        """Rows of all bonds at the last step written up to this one, by number."""
        table = self.bonds
        there = table["step"][table["step"] <= step] if step is not None else table["step"]
        if there.empty:
            raise Trouble(f"{self.folder}: no row of bonds up to step {step}; let the run get further")
        return self._with_units(table[table["step"] == there.max()].set_index("bond", drop=False).sort_index(), "bonds")

    @cached_property
    def cement(self) -> pd.DataFrame:
        """The point file in the folder, of write_cement."""
        for path in sorted(glob.glob(os.path.join(glob.escape(self.folder), "*.txt"))):
            try:
                with open(path, errors="replace") as f:
                    if not re.match(r"#|x\s|grain_i\s", f.readline()):
                        continue
                return self._with_units(tables.read_points(path), "points")
            except (Trouble, OSError):
                continue
        raise Trouble(f"{self.folder}: no point file; write one with write_cement")

    # ------------------------------------------------------------------------------------------------ of drivers

    @cached_property
    def summaries(self) -> Dict[str, pd.DataFrame]:
        """specimen.csv, waves.csv, table.csv of a driver, by name."""
        texts = (*tables.TEXTS, "load", "broken") if self._is_file("table.csv") else (*tables.TEXTS, "load")
        return {n: self._with_units(tables.read(os.path.join(self.folder, f"{n}.csv"), texts), n) for n in SUMMARIES if self._is_file(f"{n}.csv")}

    @cached_property
    def runs(self) -> Dict[str, "Output"]:
        """The runs of a driver by their labels, also those that are not finished; {} of a single run."""
        found = {}
        for path in sorted(glob.glob(os.path.join(glob.escape(self.folder), "*", "begun.json"))):
            folder = os.path.dirname(path)
            try:
                found[os.path.basename(folder)] = Output(folder)
            except Trouble:
                continue  # it has not written anything yet
        return found

    # ------------------------------------------------------------------------------------------------ what follows from them

    def groups_at(self, step: Optional[int] = None) -> pd.Series:
        """Number of the group of joined grains of each grain, by ID: 0 is the largest one; grains that no cement joins have one of their own."""
        at = self.grains_at(step)
        joined = self.bonds_at(at.attrs["step"])
        holds = joined[joined["separated"] == 0]
        return pd.Series(response.fragment_numbers(at.index.to_numpy(), holds[["grain1", "grain2"]].to_numpy()), index=at.index, name="group")

    def content(self, grain_density: float = 2500.0, cement_density: float = 2710.0) -> pd.Series:
        """Bond content, mass of cement over that of its two grains, by bond: of the first dump of points with c_bond and radius."""
        first = self.point_steps[0] if self.point_steps else None
        points = self.points_at(first)
        lacking = [c for c in ("radius", "c_bond") if c not in points]
        if lacking:
            raise Trouble(f"{self.folder}: the dumps of the points have no column {', '.join(lacking)}; dump radius and compute mpm/atom with the ID bond")
        volume = (4 / 3 * np.pi * points["radius"] ** 3).groupby(points["c_bond"].astype(int)).sum()
        mass = grain_density * 4 / 3 * np.pi * self.grains_at(self.grain_steps[0] if self.grain_steps else None)["radius"] ** 3
        rows = self.bonds_at().reindex(volume.index).dropna(subset=["grain1", "grain2"])
        of_grains = mass.reindex(rows["grain1"]).to_numpy() + mass.reindex(rows["grain2"]).to_numpy()
        return pd.Series(cement_density * volume.reindex(rows.index).to_numpy() / of_grains, index=rows.index, name="content")
