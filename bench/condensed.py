# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Condensed bonds: memory and CPU time a bond, made, run for 100 steps, written and read again.

    condensed/now/BONDS, condensed/later/BONDS
                    beads in a cubic packing, equal bonds of 336 points at their contacts, with their points made at once
                    or when they are needed; on one rank
"""
import os
import re
from pathlib import Path

from scenes import CALCITE, NEIGHBOURS, RADIUS, host, launch

CELL, STEPS = 8e-4, 100
SIDES = {"1000": 7, "10000": 15, "100000": 33}
NAMES = [f"condensed/{points}/{bonds}" for points, most in (("now", 2), ("later", 3)) for bonds in list(SIDES)[:most]]
# What the program and its siblings have used so far: seconds, and the largest memory in kB.
MARK = """#!/bin/sh
# mark.sh NAME: appends to marks.txt what all ranks have used
rank=$PPID
while [ "$(cat /proc/$rank/comm)" = sh ]; do rank=$(cut -d' ' -f4 /proc/$rank/stat); done
parent=$(cut -d' ' -f4 /proc/$rank/stat)
for p in $(cat /proc/$parent/task/*/children); do
  [ -r /proc/$p/status ] || continue
  echo "$1 $(cut -d' ' -f14,15 /proc/$p/stat) $(grep VmHWM /proc/$p/status | tr -dc 0-9)" >> marks.txt
done
"""
RUN = f"""
fix motion grains nve/sphere
thermo_style custom step atoms f_cem[1] f_cem[2] f_cem[12] f_cem[24]
thermo {STEPS}
"""


def fixes():
    return (
        f"""
timestep 4e-8
fix cem calcite mpm cell {CELL} elastic vti {" ".join(str(e) for e in CALCITE)} axis radial damage tensor B0 9.6e3 condense yes
fix bond grains mpm/couple cem kn auto kt auto
"""
        + RUN
    )


def made(side, points):
    low, high = -1.1 * RADIUS, 2 * RADIUS * (side - 1) + 1.1 * RADIUS
    inner = 2 * RADIUS * (side - 0.5)
    return (
        host() + f"region box block {low} {high} {low} {high} {low} {high} units box\ncreate_box 2 box\nlattice sc {2 * RADIUS}\n"
        f"region beads block -{RADIUS} {inner} -{RADIUS} {inner} -{RADIUS} {inner} units box\ncreate_atoms 1 region beads\n"
        f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n"
        + NEIGHBOURS
        + f"shell sh mark.sh start\ncreate_cement calcite contacts grains gap 1e-6 shape flat outer 2.5e-3 inner auto spacing {CELL / 2} points {points}\n"
        "shell sh mark.sh made\n" + fixes() + f'variable vx atom "0.01*z/{high}"\nvelocity grains set v_vx 0 0\n'
        f"run {STEPS}\nshell sh mark.sh run\nwrite_restart packing.restart\nshell sh mark.sh written\n"
    )


def read():
    return host() + "read_restart packing.restart\n" + NEIGHBOURS + fixes() + "run 1\nshell sh mark.sh read\n"


def marks(directory):
    """Seconds and kB of all ranks together, by the names of the marks."""
    tick, found = os.sysconf("SC_CLK_TCK"), {}
    for line in (directory / "marks.txt").read_text().splitlines():
        name, user, system, kB = line.split()
        seconds, memory = found.get(name, (0.0, 0))
        found[name] = (seconds + (int(user) + int(system)) / tick, memory + int(kB))
    (directory / "marks.txt").unlink()
    return found


def measure(names, directory, quick, tell):
    """Rows (dicts) of the chosen names."""
    rows = []
    for name in names:
        _, points, count = name.split("/")
        if quick and (count != "1000" or points != "later"):
            continue
        where = Path(directory) / name.replace("/", "_")
        where.mkdir(parents=True, exist_ok=True)
        (where / "mark.sh").write_text(MARK)
        (where / "marks.txt").unlink(missing_ok=True)
        run = launch(made(SIDES[count], points), where, 1, minutes=30)
        assert run.status == 0 and not run.errors(), run.output[-2000:]
        bonds = int(re.search(r"condensed (\d+) of \d+ bonds", run.output)[1])
        (total,) = (int(line.split()[2]) for line in run.output.splitlines() if re.fullmatch(rf" +{STEPS}( +\S+){{5}} *", line))
        first = marks(where)
        size = (where / "packing.restart").stat().st_size
        again = launch(read(), where, 1, name="in.read", minutes=30)
        assert again.status == 0 and not again.errors(), again.output[-2000:]
        second = marks(where)
        (where / "packing.restart").unlink()
        row = {
            "condensed": points,
            "bonds": bonds,
            "steps": STEPS,
            "points": total,
            "MB": first["written"][1] / 1024,
            "bytes/bond": (first["written"][1] - first["start"][1]) * 1024 / bonds,
            "bytes/bond, read": (second["read"][1] - first["start"][1]) * 1024 / bonds,
            "file bytes/bond": size / bonds,
            "load": os.getloadavg()[0],
        }
        before = "start"
        for mark in ("made", "run", "written"):
            row[mark] = first[mark][0] - first[before][0]
            before = mark
        row["read"] = second["read"][0]
        rows.append(row)
        tell(row)
    return rows
