# SPDX-License-Identifier: GPL-2.0-or-later
"""One answer on any number of ranks, however the box is cut: before failure, of every failure in its order,
and of what is left when the bond is separated."""
import numpy as np
import pytest
from bonds import bond
from scenes import CONTACT, NEIGHBOURS, RADIUS, cement, host, pull, run, thermo

CELL, EVERY = 4e-4, 4
LAYOUTS = {n: [(a, b, n // a // b) for a in range(1, n + 1) for b in range(1, n + 1) if n % (a * b) == 0] for n in (2, 4, 8)}
SHORT = [(1, 1, 2), (2, 2, 2), (8, 1, 1)]  # the last leaves ranks without cement, and without anything
ALL = sum(LAYOUTS.values(), [])
# name: (options of fix mpm, steps, of which seven tenths pull the bond in two)
SETTINGS = {"default": ("quasistatic 1 0.5", 1500), "updated": ("kinematics updated", 1500), "linear": ("basis linear quasistatic 1 0.5", 1500)}


def torn(words, steps, processors="* * *", **options):
    """A bond that is pulled in two and whose pieces come to rest."""
    text = bond(
        f"{words} events events.csv",
        timestep="2e-8",
        damage="damage tensor B0 9.6e6 cutoff 0.9",
        gap=options.pop("gap", 2e-4),
        processors=processors,
        **options,
    )
    return text + pull(8.0, 4e-6) + thermo(EVERY, ["f_bond", "f_bond[17]", "f_cem[2]", "f_bond[22]"]) + f"run {steps}\n"


def events(directory):
    """Step and point of every failure."""
    lines = (directory / "events.csv").read_text().splitlines()
    names = lines[0].split(",")
    return [tuple(int(line.split(",")[names.index(c)]) for c in ("step", "point")) for line in lines[1:]]


def compare(one, other, what, limit, figures):
    """Of two runs of a bond that is torn in two: its force, and every failure."""
    a, b = one.table(), other.table()
    first = int(np.argmax(a["f_cem[2]"] > 0))
    difference = abs(a["f_bond"] - b["f_bond"]) / a["f_bond"].max()
    assert first > 100 / EVERY and a["f_bond[22]"][-1] == b["f_bond[22]"][-1] != 0
    figures.below(f"{what}: force while no point fails (to step {EVERY * first}), of the peak", difference[:first].max(), limit)
    figures.note(f"{what}: force at any step, of the peak", f"{difference.max():.1e}")
    ours, theirs = events(one.directory), events(other.directory)
    assert len(ours) > 50
    figures.below(
        f"{what}: of {len(ours)} failures, those that differ in step, point or order",
        sum(p != q for p, q in zip(ours, theirs)) + abs(len(ours) - len(theirs)),
        0,
    )


_alone = {}


@pytest.fixture
def alone(tmp_path_factory):
    def get(name):
        if name not in _alone:
            words, steps = SETTINGS[name]
            _alone[name] = run(torn(words, steps), tmp_path_factory.mktemp("alone"))
        return _alone[name]

    return get


@pytest.mark.parametrize("processors", ALL, ids=lambda p: "x".join(map(str, p)))
@pytest.mark.parametrize("name", SETTINGS)
def test_layout(name, processors, alone, tmp_path, figures, long):
    if not long and (processors not in SHORT or name == "linear"):
        pytest.skip("runs with --long only")
    words, steps = SETTINGS[name]
    ranks = int(np.prod(processors))
    one, many = alone(name), run(torn(words, steps, " ".join(map(str, processors))), tmp_path, ranks)
    compare(one, many, f"{name}, {ranks} ranks, {'x'.join(map(str, processors))}", 1e-10, figures)


def at_place(middle, n, words, processors):
    """The same pair anywhere in a periodic box, so that it may lie across the boundaries."""
    box, n = 0.05, np.array(n)
    text = host("p p p", processors) + f"region box block 0 {box} 0 {box} 0 {box} units box\ncreate_box 2 box\n"
    for side in (-1, 1):
        text += "create_atoms 1 single {:.15g} {:.15g} {:.15g} units box\n".format(*(np.array(middle) + side * (RADIUS + 1e-4) * n) % box)
    text += f"set type 1 diameter {2 * RADIUS} density 2500\ngroup grains type 1\n" + NEIGHBOURS
    text += "create_cement calcite pair 1 2 shape flat inner 1.4e-3 outer 2.2e-3 film grid spacing 2e-4\n" + CONTACT
    text += cement(CELL, 2e-8, axis="radial", damage="damage tensor B0 9.6e6 cutoff 0.9 events events.csv " + words)
    return text + pull(8.0, 4e-6, n) + thermo(EVERY, ["f_bond", "f_cem[2]", "f_bond[22]"]) + "run 1500\n"


@pytest.mark.parametrize("words, axis", [("quasistatic 1 0.5", (0, 0, 1)), ("kinematics updated", (0.48, 0.6, 0.64))])
def test_across_periodic_boundaries(words, axis, tmp_path, figures, long):
    """A bond in the corner of a periodic box, cut by eight ranks, is the bond in the middle of it on one."""
    middle = run(at_place(3 * [0.025], axis, words, "* * *"), tmp_path / "middle")
    for ranks, cut in ((1, "* * *"), (8, "2 2 2")) if long else ((8, "2 2 2"),):
        corner = run(at_place(3 * [0.0501], axis, words, cut), tmp_path / f"corner{ranks}", ranks)
        # A position is rounded by 1e-17 m of the box in either, which the penalty feels.
        compare(middle, corner, f"{words}, bond in the corner on {ranks} ranks", 1e-9, figures)
