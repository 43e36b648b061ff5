# SPDX-License-Identifier: GPL-2.0-or-later
"""A bond that carries nothing any more is broken, though a path over intact points leads from grain to grain: sheared, struts between slanted
cracks rotate like a linkage. The same on ranks and after a restart."""
import csv
import re
import shutil

import numpy as np
import pytest
from scenes import cement, pair, restarted, run, thermo

CELL, STEP, CHECK = 6e-4, 4.66382e-8, 100
EVERY = 10
MOVED = """\
variable t equal step*dt
variable s equal "(v_t<1e-5)*0.02*(v_t-1e-5/PI*sin(PI*v_t/1e-5))+(v_t>=1e-5)*0.04*(v_t-0.5e-5)"
variable w equal "(v_t<1e-5)*0.02*(1-cos(PI*v_t/1e-5))+(v_t>=1e-5)*0.04"
fix hold first move linear 0 0 0
fix pull second move variable v_s NULL NULL v_w NULL NULL
"""
SCALARS = ["f_bond[7]", "f_bond[22]", "f_bond[23]", "f_bond[24]", "f_bond[38]", "f_cem[19]", "f_cem[26]"]


def sheared():
    return (
        cement(
            CELL, STEP, axis="radial", damage=f"damage tensor B0 9.6e3 cutoff 0.9 cracks bonds check {CHECK}", couple=f"kn auto kt auto csv {EVERY} bond.csv"
        )
        + MOVED
        + thermo(EVERY, SCALARS)
    )


START = pair(CELL / 2, shape="meniscus", cement="content 0.05", half_box=(12e-3, 12e-3, 20e-3))
# The run ends 200 steps after the bond is broken, whenever that is. The last restart file before that lies between two checks.
UNTIL = f"""\
variable part loop 100
label pull
run {CHECK - 30}
write_restart before.restart
run 30
if "$(f_bond[38]) == 1" then "jump SELF done"
shell mv before.restart middle.restart
next part
jump SELF pull
label done
run {CHECK}
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run(START + sheared() + UNTIL, tmp_path_factory.mktemp("whole"))


def goes_on(whole, directory, ranks=1, **options):
    """From the restart file to the end, in the same parts: the columns of both."""
    shutil.copy(whole.directory / "middle.restart", directory)
    t = whole.table()
    on = run(restarted("middle.restart", **options) + sheared() + f"run 30\nrun {CHECK - 30}\nrun 30\nrun {CHECK}\n", directory, ranks).table()
    at = np.searchsorted(t["step"], on["step"])
    assert on["f_bond[38]"][0] == 0 and on["f_bond[38]"][-1] == 1
    return {name: column[at] for name, column in t.items()}, on


def first_step(t):
    """In which the bond is told to be broken: that after a check."""
    return int(t["step"][np.argmax(t["f_bond[38]"] > 0)])


def rows(directory):
    with open(directory / "bond.csv", newline="") as f:
        return list(csv.DictReader(f))


def test_broken_without_being_in_two(whole, figures):
    t = whole.table()
    step, broken, force = t["step"], t["f_bond[38]"], abs(t["f_bond[7]"])
    since = first_step(t)
    assert 3000 < since < 10000 and (broken[step < since] == 0).all() and (broken[step >= since] == 1).all()
    assert (t["f_bond[22]"] == 0).all() and (t["f_cem[19]"] == 0).all() and (t["f_cem[26]"] == broken).all()
    shares = t["f_bond[23]"] + t["f_bond[24]"]
    assert (shares[step < since] == 0).all() and (shares[step >= since] > 0).all()
    modes = {int(r["step"]): r["mode"] for r in rows(whole.directory)}
    assert {m for s, m in modes.items() if s < since} == {"intact"} and "intact" not in {m for s, m in modes.items() if s >= since}
    told = re.findall(
        r"bond 1 of grains 1 and 2: (\w+), \d+ points failed, and less than 1 % of its peak load is left since step (\d+) though "
        r"(\d+) of (\d+) points of its weakest section are intact; of the fracture surface",
        whole.output,
    )[-1]
    assert told[0] == modes[since] and int(told[1]) == since - EVERY and 0 < int(told[2]) < int(told[3])
    window = 2 * CHECK  # 4 l over the speed of shear waves are 152 steps
    mean = abs(t["f_bond[7]"][(step > since - EVERY - window) & (step < since)].mean())
    # of the rows alone, and over the peak of the force without its moment
    figures.below("sheared meniscus: mean force of the last window before it is broken, over the peak", mean / force.max(), 0.015)


def test_after_a_restart(whole, tmp_path, figures):
    alone, on = goes_on(whole, tmp_path)
    for name in SCALARS[1:]:
        assert (alone[name] == on[name]).all(), name
    figures.below(
        "sheared meniscus, restart before it is broken: force over the largest",
        abs(alone["f_bond[7]"] - on["f_bond[7]"]).max() / abs(whole.table()["f_bond[7]"]).max(),
        3e-12,
    )


def test_on_ranks(whole, tmp_path, figures):
    """From the restart file: rounding of thousands of steps of softening would make another crack."""
    alone, on = goes_on(whole, tmp_path, 2, processors="2 1 1")
    for name in ("f_bond[22]", "f_bond[38]", "f_cem[26]"):
        assert (alone[name] == on[name]).all(), name
    for name in ("f_bond[23]", "f_bond[24]"):
        figures.below(f"sheared meniscus, 2 ranks: {name} against 1 rank", abs(alone[name] - on[name]).max(), 1e-12)
