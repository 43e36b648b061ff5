# SPDX-License-Identifier: GPL-2.0-or-later
"""The command delete_bond removes the cement of bonds between runs, joined or not. What it removes is counted, and the energy balance closes."""
import pytest
from scenes import edit, launch, restarted, run
from test_departures import FAILED, IMBALANCE, LEFT_ENERGY, LEFT_MASS, POINTS, fixes, scene
from test_fragments import DROPPED, SEPARATED, with_columns


def joined(more="cracks split", B0=1e12, pull=0.5):
    return with_columns(scene(more, B0=B0, pull=pull, high=0.012))


# name: (words, options of fix mpm, B0, speed, whether cement is deleted)
DELETED = {
    "joined": ("pair 2 1", "cracks split", 1e12, 0.5, True),
    "condensed": ("all", "condense yes", 1e12, 0.5, True),
    "separated": ("separated", "cracks split", 2e4, 0.5, True),
    "in pieces": ("broken", "condense yes", 1e5, 2.0, True),
    "group": ("group grains", "cracks split", 1e12, 0.5, True),
    "none is separated": ("separated", "cracks split", 1e12, 0.5, False),
}


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", DELETED)
def test_deleted(tmp_path, figures, name, ranks):
    """The cement of the bonds is gone, with its mass, and the energy balance closes. Grains fly on."""
    words, more, B0, pull, gone = DELETED[name]
    r = run(joined(more, B0, pull) + f"run 300\ndelete_bond {words}\nrun 100\n", tmp_path, ranks)
    t = r.table()
    end = list(t["step"]).index(300)
    assert (t[POINTS][-1] == 0 and t["atoms"][-1] == 2 and t[DROPPED][-1] == t[POINTS][0]) if gone else t[POINTS][-1] == t[POINTS][0]
    assert t[SEPARATED][-1] == t[SEPARATED][end]
    assert f"delete_bond: {int(gone)} of 1 bonds, {t[DROPPED][-1]:g} points" in r.output
    if gone:
        figures.below(f"{name}, {ranks} ranks: mass", abs(t[LEFT_MASS][-1] / (t["c_mass"][0] - t["c_mass"][-1]) - 1), 2e-14)
        assert t[LEFT_ENERGY][-1] > 0 or t[FAILED][end] > 0
    figures.below(f"{name}, {ranks} ranks: imbalance over the deletion", abs(t[IMBALANCE][end + 1] - t[IMBALANCE][end]), 1e-4)
    figures.below(f"{name}, {ranks} ranks: imbalance after it", abs(t[IMBALANCE][-1]), 1e-3)


@pytest.mark.parametrize("more", ["cracks split", "condense yes"])
def test_deleted_before_a_file(tmp_path, more):
    """A run goes on bitwise identically from a file that was written after a deletion."""
    a = run(joined(more) + "run 100\ndelete_bond all\nwrite_restart some.restart\nprint MIDDLE\nrun 100\n", tmp_path)
    b = run(restarted("some.restart") + with_columns(fixes(more, 1e12)) + "run 100\n", tmp_path, name="in.continued")
    last = [[line for line in r.output.splitlines() if line.split()[:1] == ["200"]][-1] for r in (a, b)]
    assert last[0] == last[1]


def test_deleted_without_points(tmp_path):
    script = edit(joined("condense yes"), "spacing 2e-4", "spacing 2e-4 points later")
    t = run(script + "run 50\ndelete_bond all\nrun 50\n", tmp_path, 2).table()
    assert t[POINTS][0] == t[DROPPED][-1] > 0 and t[POINTS][-1] == 0


BAD_COMMANDS = {
    "run 0\ndelete_bond": ["pair", "expected at the end"],
    "run 0\ndelete_bond pair 1": ["a whole number for 'pair 1'", "the ID of the second grain"],
    "run 0\ndelete_bond pair 1 3": ["'pair 1 3'", "no cement", "use the IDs"],
    "run 0\ndelete_bond some": ["'some'", "'separated'"],
    "run 0\ndelete_bond all 3": ["'3' is one word too many"],
    "run 0\ndelete_bond group none": ["'group none'", "define it before"],
    "delete_bond all": ["no run", "use 'run 0' before"],
    "unfix bond\nunfix cem\ndelete_bond all": ["no fix mpm", "define one before"],
}


@pytest.mark.parametrize("commands", BAD_COMMANDS)
def test_bad_commands(tmp_path, commands):
    result = launch(joined() + commands + "\n", tmp_path)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-2000:]
    assert all(w in result.errors()[0] for w in ["delete_bond", *BAD_COMMANDS[commands]]), result.errors()
