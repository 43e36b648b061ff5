# SPDX-License-Identifier: GPL-2.0-or-later
"""What a run prints of itself: where its time went, and an error where there is no log."""
import re
import resource

import pytest
from scenes import cement, launch, pair, run

SCENE = pair(2e-4, cement="inner 1.4e-3 outer 2.2e-3") + cement(4e-4, 1e-8) + "fix hold grains freeze\n"
PHASES = ["scatter", "node update", "halo", "gather", "material", "coupling", "condensing", "layout", "output"]


@pytest.mark.parametrize("ranks", [1, 2])
def test_where_time_goes(ranks, tmp_path):
    """Two lines: seconds, steps and rates; the phases in per cent, those of the slowest rank each."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = run(SCENE + "run 200\n", tmp_path, ranks).output
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    number = r"([0-9.e+-]+)"
    found = re.search(
        rf"^fix mpm \(id cem\): {number} s in 200 steps, {number} point steps per second, {number} by CPU time, {number} bytes a point\n  (.*)$", out, re.M
    )
    assert found, out[-2000:]
    seconds, rate, by_cpu, size = (float(found[i]) for i in (1, 2, 3, 4))
    points = int(re.search(r"fix mpm \(id cem\): (\d+) material points", out)[1])
    assert abs(rate * seconds / (200 * points) - 1) < 1e-4 and 300 < size < 1e5
    # A rank takes no more CPU time than wall time, and no more than the whole program did. It may wait for a processor for any time.
    # The two clocks of a virtual machine were 2.7 % apart in a run of 6 ms; a clock that counts two ranks or a thread twice is a factor of 2.
    cpu = 200 * points / by_cpu
    assert 2e-9 * 200 * points < cpu < 1.1 * seconds + 1e-3
    assert cpu < after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    phases = found[5].split("; ")[0].split(", ")
    assert [re.sub(r" [0-9.]+ %$", "", p) for p in phases] == PHASES
    share = [float(p.split()[-2]) for p in phases]
    assert all(0 <= s <= 100 for s in share)
    if ranks == 1:
        assert abs(sum(share) - 100) < 0.5
    else:
        assert sum(share) > 99.5


@pytest.mark.parametrize(
    "damage, couple, line",
    [
        (
            "damage tensor B0 9.6e6",
            "",
            "cement that debonded goes through its grain, and faces of cracks through each other; 'friction' of fix mpm/couple makes them touch",
        ),
        ("damage tensor B0 9.6e6 unilateral yes", "", "cement that debonded goes through its grain; 'friction' of fix mpm/couple makes them touch"),
        ("damage tensor B0 9.6e6", " friction 0.3", None),
        ("", "", None),
    ],
)
def test_what_has_no_contact(damage, couple, line, tmp_path):
    """Said once, where fix mpm prints what the parameters imply."""
    scene = pair(2e-4, cement="inner 1.4e-3 outer 2.2e-3") + cement(4e-4, 1e-8, damage=damage, couple="kn auto kt auto" + couple)
    out = run(scene + "fix hold grains freeze\nrun 1\nrun 1\n", tmp_path).output
    assert re.findall(r"^  contact   (.*)$", out, re.M) == ([line] if line else [])


@pytest.mark.parametrize("ranks", [1, 2])
def test_the_set_up_is_not_timed(ranks, tmp_path):
    """The time in fix mpm is that of the steps. The set-up of a run takes longer than one step."""
    out = run(SCENE + 3 * "run 1\n", tmp_path, ranks).output
    seconds = [float(s) for s in re.findall(r"^fix mpm \(id cem\): ([0-9.e+-]+) s in 1 steps", out, re.M)]
    loops = [float(s) for s in re.findall(r"^Loop time of ([0-9.e+-]+) on", out, re.M)]
    assert len(seconds) == len(loops) == 3
    assert all(0.0 < s <= 1.01 * loop for s, loop in zip(seconds, loops)), (seconds, loops)


def test_error_without_a_log(tmp_path):
    """One line and status 1, as with a log."""
    result = launch(SCENE + "no_such_command\nrun 1\n", tmp_path, arguments=["-log", "none"])
    assert result.status == 1, result.output[-1000:]
    assert len(result.errors()) == 1 and "no_such_command" in result.errors()[0]
    assert not (tmp_path / "log.liggghts").exists()


def test_error_with_a_screen_of_its_own(tmp_path):
    result = launch(SCENE + "no_such_command\nrun 1\n", tmp_path, arguments=["-screen", "screen.txt"])
    assert result.status == 1
    for name in ("screen.txt", "log.liggghts"):
        errors = [line for line in (tmp_path / name).read_text().splitlines() if line.startswith("ERROR")]
        assert len(errors) == 1 and "no_such_command" in errors[0], name
