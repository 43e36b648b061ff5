# SPDX-License-Identifier: GPL-2.0-or-later
"""`balance yes`: whole bonds go to ranks that have less work, and nothing else changes."""
import csv
import re

import numpy as np
import pytest
from scenes import NEIGHBOURS, RADIUS, dump, host, launch, run

CELL, SIDE = 8e-4, 3
# Nothing is in the upper three quarters of the box: with a cut across z all cement is on the lower ranks.
LOW, HIGH, TOP = -1.1 * RADIUS, 2 * RADIUS * (SIDE - 1) + 1.1 * RADIUS, 16 * RADIUS


LOADS = tuple(f"{what}{axis}{grain}" for what in "fm" for grain in (1, 2) for axis in "xyz")


def beads(boundary="f f f", processors="1 1 2", speed=0.8):
    places = [[2 * RADIUS * k for k in (n % SIDE, n // SIDE % SIDE, n // SIDE**2)] for n in range(SIDE**3)]
    atoms = "".join(f"create_atoms 1 single {x} {y} {z} units box\n" for x, y, z in places)
    return (
        host(boundary=boundary, processors=processors)
        + f"region box block {LOW} {HIGH} {LOW} {HIGH} {LOW} {TOP} units box\ncreate_box 2 box\n"
        + atoms
        + f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n"
        + NEIGHBOURS
        + f"create_cement calcite contacts grains gap 1e-6 shape flat outer 2.5e-3 inner auto spacing {CELL / 2}\n"
        + f'variable vx atom "{speed}*x/0.02"\nvelocity grains set v_vx 0 0\n'
    )


def cement(balance, words=""):
    return f"""\
timestep 4e-8
fix cem calcite mpm cell {CELL} elastic vti 50.83e9 28.79e9 0.2744 0.2581 14.86e9 damage tensor B0 9.6e3 check 20 events events.csv {balance} {words}
fix bond grains mpm/couple cem csv 20 bond.csv
fix motion grains nve/sphere
thermo_style custom step f_cem[2] f_cem[12] atoms
thermo 20
"""


def table(folder, name="bond.csv"):
    rows = list(csv.reader((folder / name).open()))
    return rows[0], rows[1:]


def told(output):
    """The largest work of a rank over the mean at the end and at most, and how many bonds went to other ranks."""
    found = re.findall(r"balance: the rank with most work has (\S+) of the mean, (\S+) at most in this run; ranks were given (\d+) bonds", output)
    return [(float(now), float(most), int(bonds)) for now, most, bonds in found]


def fewest(output):
    """Atoms of the rank that has fewest, over the mean, at the end of a run."""
    mean, least = re.findall(r"Nlocal: +(\S+) ave \S+ max (\S+) min", output)[-1]
    return float(least) / float(mean)


@pytest.mark.parametrize(
    "ranks, processors, speed, words",
    [(2, "1 1 2", 0.8, ""), (4, "2 1 2", 0.8, ""), (2, "1 1 2", 1.5, "cracks split regularization nonlocal 8e-4"), (2, "1 1 2", 0.8, "kinematics updated")],
)
def test_same_answer(ranks, processors, speed, words, tmp_path, figures):
    found = {}
    for balance in ("no", "yes"):
        folder = tmp_path / balance
        result = run(beads(processors=processors, speed=speed) + cement(f"balance {balance}", words) + dump(400, ["x", "y", "z"]) + "run 400\n", folder, ranks)
        head, rows = table(folder)
        numbers = [head.index(name) for name in LOADS + ("step",)]
        found[balance] = (result, np.array([[float(row[k]) for k in numbers] for row in rows]), [(e[0], e[2]) for e in table(folder, "events.csv")[1]])
    (result, plain, events), (balanced_result, balanced, balanced_events) = found["no"], found["yes"]
    assert not told(result.output)
    ((now, most, bonds),) = told(balanced_result.output)
    places, balanced_places = result.points(400), balanced_result.points(400)
    assert fewest(result.output) < 0.1 < 0.8 < fewest(balanced_result.output), "points went to other ranks"
    assert (places["id"] == balanced_places["id"]).all()
    figures.below(
        f"{ranks} ranks {processors} {words}: places of the points at the end, over a cell",
        max(np.abs(places[k] - balanced_places[k]).max() for k in "xyz") / CELL,
        1e-3,
    )
    assert bonds > 5 and most > 1.5
    figures.below(f"{ranks} ranks {processors} {words}: largest work of a rank over the mean, balanced", now, 1.1)
    assert len(events) > 100 and events == balanced_events, "the same points fail at the same steps"
    before = plain[:, -1] < int(events[0][0])
    assert len(set(plain[before][:, -1])) > 3, "bonds went to other ranks before the first failure"
    assert balanced.shape == plain.shape
    largest = np.abs(plain[before][:, :6]).max()
    of_force, of_moment = (np.abs(balanced - plain)[before][:, k].max() for k in (slice(0, 6), slice(6, 12)))
    figures.below(
        f"{ranks} ranks {processors} {words}: loads up to the first failure, over the largest force", max(of_force, of_moment / RADIUS) / largest, 1e-9
    )


@pytest.mark.parametrize(
    "runs",
    [
        "run 200\nwrite_restart half.200\nrun 200\n",
        'run 400 every 200 "write_restart half.*"\n',
        "run 200\nset group grains density 2500\nwrite_restart half.200\nrun 200\n",
    ],
)
def test_restart(runs, tmp_path):
    """A run that goes on from a file written between two runs, within one, or after a command that returns points to the ranks of their positions, is
    bitwise identical to the run itself; on one rank it has the same events."""
    books = "thermo_style custom step f_cem[6] f_cem[8] f_cem[9] f_cem[11] f_cem[12]\nthermo_modify format float %.17g\n"
    whole_output = run(beads() + cement("balance yes") + books + runs, tmp_path, 2).output
    head, whole = table(tmp_path)
    _, events = table(tmp_path, "events.csv")
    assert any(int(e[0]) > 200 for e in events)
    for ranks in (2, 1):
        folder = tmp_path / f"on_{ranks}"
        folder.mkdir()
        out = run(
            host(processors="1 1 2" if ranks == 2 else "* * *") + "read_restart ../half.200\n" + NEIGHBOURS + cement("balance yes") + books + "run 200\n",
            folder,
            ranks,
        ).output
        if ranks == 1:
            assert [(e[0], e[2]) for e in events if int(e[0]) > 200] == [(e[0], e[2]) for e in table(folder, "events.csv")[1] if int(e[0]) > 200]
            continue
        assert told(out)[0][2] > 5
        assert [row for row in whole if int(row[head.index("step")]) > 200] == [row for row in table(folder)[1] if int(row[head.index("step")]) > 200]
        assert steps_after(200, whole_output) == steps_after(200, out)


def steps_after(step, output):
    """Lines of thermo of later steps."""
    lines = {line for line in output.splitlines() if re.fullmatch(r"\s*\d+( \S+){5}\s*", line) and int(line.split()[0]) > step}
    assert len(lines) == 10
    return lines


def most_atoms(output):
    return float(re.findall(r"Nlocal: +\S+ ave (\S+) max", output)[-1])


@pytest.mark.parametrize("boundary", ["f f f", "f f p"])
def test_four_subdomains_in_a_row(boundary, tmp_path):
    """Bonds go to the subdomain beside theirs, across a periodic side of the box too, and come back in a run without `balance`."""
    text = beads(boundary=boundary, processors="1 1 4")
    plain = run(text + cement("balance no") + "run 400\n", tmp_path / "no", 4)
    balanced = run(text + cement("balance yes") + "run 200\nwrite_restart half.200\nrun 200\n", tmp_path / "yes", 4)
    assert most_atoms(balanced.output) < 0.7 * most_atoms(plain.output)
    of_plain, of_balanced = ([(e[0], e[2]) for e in table(tmp_path / name, "events.csv")[1]] for name in ("no", "yes"))
    assert len(of_plain) > 100 and of_plain == of_balanced
    folder = tmp_path / "given_up"
    folder.mkdir()
    out = run(
        host(boundary=boundary, processors="1 1 4") + "read_restart ../yes/half.200\n" + NEIGHBOURS + cement("balance no") + "run 200\n", folder, 4
    ).output
    assert most_atoms(out) == most_atoms(plain.output), "points are with the ranks of their places"
    assert [(e[0], e[2]) for e in table(folder, "events.csv")[1] if int(e[0]) > 200] == [e for e in of_plain if int(e[0]) > 200]


@pytest.mark.parametrize(
    "words, boundary, message",
    [("balance maybe", "f f f", "'balance maybe'"), ("balance yes", "f f s", "along z follows the atoms; use 'boundary' with f or p, or 'balance no'")],
)
def test_bad_input(words, boundary, message, tmp_path):
    failed = launch(beads(boundary=boundary) + cement(words) + "run 10\n", tmp_path, 2)
    assert failed.status != 0 and any(message in e for e in failed.errors()), failed.output[-2000:]
