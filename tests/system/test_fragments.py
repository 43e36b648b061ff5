# SPDX-License-Identifier: GPL-2.0-or-later
"""`fragments drop` of fix mpm: what is removed, by age and size, how it is counted and told, and that a divided run equals a single one."""
import numpy as np
import pytest
from scenes import edit, launch, restarted, run
from test_departures import COLUMNS, FAILED, IMBALANCE, LEFT_MASS, LEFT_POINTS, POINTS, WEIGHT, fixes, scene

DROPPED, MASS_DROPPED, SEPARATED = "f_cem[35]", "f_cem[36]", "f_cem[19]"
MORE = COLUMNS + [DROPPED, MASS_DROPPED, SEPARATED]
STEP, CHECK = 4e-7, 10


def with_columns(script):
    old = "custom step " + " ".join(COLUMNS)
    return edit(edit(script, old, "custom step " + " ".join(MORE)), "COLUMNS step " + " ".join(COLUMNS), "COLUMNS step " + " ".join(MORE))


def broken(more, steps=1000, every=10, **options):
    """A pair whose bond is torn off one bead, while a large weight pulls what is loose aside. Nothing leaves the box."""
    return edit(with_columns(scene(more, high=0.012, extra=WEIGHT, **options)), "thermo 50", f"thermo {every}") + f"run {steps}\n"


def first(table, name):
    return int(np.flatnonzero(table[name])[0])


def told(result):
    """Lines about points that were dropped, in the run and at its end."""
    return [line for line in result.output.splitlines() if "were dropped" in line]


@pytest.mark.parametrize("more, ranks, energy", [("cracks split", 1, 1e-4), ("cracks split", 2, 1e-4), ("kinematics updated", 1, 1e-3)])
def test_dropped(tmp_path, figures, more, ranks, energy):
    """What is dropped is missing in points and mass, is counted, and is told once in the run and at its end."""
    r = run(broken(more + " fragments drop"), tmp_path, ranks)
    t = r.table()
    lost = t[POINTS][0] - t[POINTS][-1]
    name = f"{more}, {ranks} ranks"
    assert lost > 0 and lost == t[DROPPED][-1] == t[LEFT_POINTS][-1] == t["atoms"][0] - t["atoms"][-1]
    figures.below(f"{name}: mass dropped against mass that is missing", abs(t[MASS_DROPPED][-1] / (t["c_mass"][0] - t["c_mass"][-1]) - 1), 2e-13)
    assert t[LEFT_MASS][-1] == t[MASS_DROPPED][-1]
    at = first(t, DROPPED)
    figures.below(f"{name}: imbalance of the energy over the first drop", abs(t[IMBALANCE][at] - t[IMBALANCE][at - 1]), energy)
    lines = told(r)
    assert len(lines) == 2 and "dropped at step" in lines[0] and f"{lost:g} of them" in lines[1], lines


def test_ranks_drop_the_same(tmp_path):
    """One rank and two drop the same points in the same steps."""
    a, b = (run(broken("cracks split fragments drop age 1e-5"), tmp_path, ranks).table() for ranks in (1, 2))
    assert a[DROPPED][-1] > 0 and list(a[DROPPED]) == list(b[DROPPED]) and list(a[POINTS]) == list(b[POINTS])


def test_age(tmp_path):
    """Each point is dropped at the first check at which it has been loose for that long."""
    age = 20 * CHECK * STEP
    at_once, later = (run(broken(f"cracks split fragments drop{words}", 600), tmp_path).table() for words in ("", f" age {age:g}"))
    steps = int(at_once["step"][first(at_once, DROPPED)]), int(later["step"][first(later, DROPPED)])
    assert steps[1] - steps[0] == 20 * CHECK
    assert later[DROPPED][first(later, DROPPED)] == at_once[DROPPED][first(at_once, DROPPED)]


@pytest.mark.parametrize("words, goes", [("", True), ("size 464", False), ("size 465", True), ("share 0.9", False), ("size 465 share 0.9", False)])
def test_size(tmp_path, words, goes):
    """A bond of 464 points that comes off both beads is one fragment, which must meet all conditions."""
    interface = "interface cohesive tn 1e4 tt 1e4 Gn 1e-3 Gt 1e-3"
    t = run(broken(f"cracks bonds fragments drop {words}", 200, B0=1e12, couple=interface), tmp_path).table()
    assert t[SEPARATED][-1] == 1 and t[FAILED][-1] == 0 and t[POINTS][0] == 464 and t[DROPPED][-1] == (464 if goes else 0)


@pytest.mark.parametrize("more", ["cracks split", "condense yes"])
def test_bonds(tmp_path, figures, more):
    """All cement of a bond goes once it is separated, and the bond stays separated in tables. Free grains stay."""
    t = run(broken(f"{more} fragments drop bonds", 400), tmp_path).table()
    assert t[POINTS][-1] == 0 and t["atoms"][-1] == 2 and t[DROPPED][-1] == t[POINTS][0] and t[SEPARATED][-1] == 1
    at = first(t, DROPPED)
    assert t["step"][at] - t["step"][first(t, SEPARATED)] <= 2 * CHECK
    figures.below(f"{more}: imbalance of the energy over the drop", abs(t[IMBALANCE][at] - t[IMBALANCE][at - 1]), 1e-4)


@pytest.mark.parametrize("words, ranks", [("age 4.1e-5", 1), ("age 4.1e-5 size 3", 2), ("bonds age 1.1e-4", 1)])
def test_goes_on_from_a_file(tmp_path, words, ranks):
    """A run from a restart file, and a second `run`, go on bitwise identically, whether points are loose at that step or were dropped."""
    for middle in (110, 400):
        a = run(broken(f"cracks split fragments drop {words}", middle, 50) + "write_restart middle.restart\nprint MIDDLE\nrun 400\n", tmp_path, ranks)
        more = edit(with_columns(fixes(f"cracks split fragments drop {words}", 1e5, WEIGHT)), "thermo 50", "thermo 50")
        b = run(restarted("middle.restart") + more + "run 400\n", tmp_path, ranks, name="in.continued")
        rows = [
            [line for line in text.splitlines() if line.split()[:1] and line.split()[0].isdigit() and len(line.split()) == 1 + len(MORE)]
            for text in (a.output.split("MIDDLE")[-1], b.output)
        ]
        assert len(rows[0]) >= 8 and rows[0] == rows[1]
    whole = run(broken(f"cracks split fragments drop {words}", 800, 50), tmp_path, ranks).table()
    assert float(rows[0][-1].split()[1 + MORE.index(DROPPED)]) == whole[DROPPED][-1] > 0


def test_keeps_by_default(tmp_path):
    """Nothing is dropped without the word, and `fragments keep` changes nothing."""
    a, b = (run(broken(f"cracks split{words}", 200, 50), tmp_path) for words in ("", " fragments keep"))
    assert a.table()[DROPPED][-1] == 0 and told(a) == [] and all(np.array_equal(a.table()[c], b.table()[c]) for c in MORE)


BAD_WORDS = {
    "fragments": ["keep, drop", "expected at the end"],
    "fragments lose": ["'fragments lose'", "keep, drop"],
    "fragments drop age -1": ["'fragments drop age -1'", "negative"],
    "fragments drop size 0": ["'fragments drop size 0'", "from 1"],
    "fragments drop share 2": ["'fragments drop share 2'", "[0, 1]"],
    "fragments drop bonds size 3": ["'fragments drop bonds'", "leave them out"],
    "fragments drop age 1 age 2": ["'age' is given twice"],
}


@pytest.mark.parametrize("words", BAD_WORDS)
def test_bad_words(tmp_path, words):
    result = launch(scene(words) + "run 1\n", tmp_path)
    assert result.status != 0 and len(result.errors()) == 1
    assert all(w in result.errors()[0] for w in ["fix mpm (id cem)", *BAD_WORDS[words]]), result.errors()
