# SPDX-License-Identifier: GPL-2.0-or-later
"""The tool that plants bugs draws the same ones again, and keeps the source as it was where none is chosen."""
import json
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "mutation"))
import draw  # noqa: E402
import planted  # noqa: E402

FILES = [f"{folder}/{name}.cpp" for folder in ("mpm", "styles", "host") for name in "abcdef"]


def candidates(shift=0):
    """Four operators in each of ten lines of every file; `shift` lines were inserted above them."""
    return [
        draw.Candidate(
            path,
            operator,
            100 * line + 10 * k,
            100 * line + 10 * k + 5,
            line + shift,
            f"x{line}",
            f"y{line}",
            f"(mpdem_mutant({{n}}) ? y{line} : x{line})",
            f"line {line}",
            0,
        )
        for path in FILES
        for line in range(10)
        for k, operator in enumerate(("sign", "index", "order", "logic"))
    ]


def keys(mutants):
    return {m.key() for m in mutants}


def test_quotas_and_spread():
    mutants = draw.draw(candidates(), 1, 8, 26, set())
    of = {f: sum(draw.folder(m) == f for m in mutants) for f in ("mpm", "styles", "host")}
    assert sorted(of.values()) == [8, 9, 9]
    assert max(sum(m.path == f for m in mutants) for f in FILES) <= draw.MOST_OF_A_FILE
    for folder in of:
        assert {m.operator for m in mutants if draw.folder(m) == folder} == {"sign", "index", "order", "logic"}


def test_what_changes_elsewhere_leaves_a_draw_alone():
    first = draw.draw(candidates(), 1, 8, 24, set())
    assert keys(first) == keys(draw.draw(candidates(shift=7), 1, 8, 24, set()))
    assert keys(first) != keys(draw.draw(candidates(), 2, 8, 24, set()))
    gone = first[5]
    again = draw.draw(candidates(), 1, 8, 24, {gone.key()})
    assert gone.key() not in keys(again) and len(again) == 24 and len(keys(first) & keys(again)) >= 22


def test_more_in_lines_that_changed():
    diff = "\n".join(
        [
            "diff --git a/mpm/a.cpp b/mpm/a.cpp",
            "--- a/mpm/a.cpp",
            "+++ b/mpm/a.cpp",
            "@@ -3,0 +4,2 @@ int f() {",
            "+x",
            "+y",
            "@@ -9 +11 @@",
            "-z",
            "+w",
            "@@ -20,2 +21,0 @@",
            "-gone",
            "-gone",
        ]
    )
    assert draw.changed_lines(diff) == {("mpm/a.cpp", 4), ("mpm/a.cpp", 5), ("mpm/a.cpp", 11)}
    first = draw.draw(candidates(), 1, 8, 26, set())
    young = [c for c in candidates() if c.line >= 5]
    more = draw.draw(young, 1, 1, 5, set(), first)
    assert len(more) == 5 and all(c.line >= 5 for c in more) and not keys(more) & keys(first)
    assert draw.draw([], 1, 1, 5, set()) == []


def test_switches():
    source = b"a = x0;\nb = x1;\n"
    one = draw.Candidate("mpm/a.cpp", "sign", 4, 6, 1, "x0", "-(x0)", "(mpdem_mutant({n}) ? -(x0) : (x0))")
    two = draw.Candidate("mpm/a.cpp", "sign", 12, 14, 2, "x1", "-(x1)", "(mpdem_mutant({n}) ? -(x1) : (x1))")
    assert draw.switched(source, [(3, one), (4, two)]) == b"a = (mpdem_mutant(3) ? -(x0) : (x0));\nb = (mpdem_mutant(4) ? -(x1) : (x1));\n"


def test_lines_that_change_nothing_are_still_there():
    """What was argued holds for the line as it was."""
    for entry in json.loads((ROOT / "tests" / "mutation" / "equivalent.json").read_text()):
        lines = [line.strip() for line in (ROOT / "src" / "USER-MPDEM" / entry["file"]).read_text().splitlines()]
        assert entry["line"] in lines, f"{entry['file']}: '{entry['line']}' is another line now: argue anew, or leave the entry out"
        assert len(entry["reason"]) > 40 and "change" in entry


def test_planted_bugs_still_fit():
    """Each line of the list is in the source as it is written there, with one place for the change, and no two changes meet."""
    source = ROOT / "src" / "USER-MPDEM"
    entries = json.loads(planted.LIST.read_text())
    wrong = []
    for entry in entries:
        assert len(entry["bug"]) > 10 and entry["original"] != entry["mutated"]
        try:
            planted.mutant_of(entry, source)
        except ValueError as e:
            wrong.append(str(e))
    assert not wrong, "change the list, or leave these out:\n" + "\n".join(wrong)
    mutants = planted.mutants(source)
    assert len(keys(mutants)) == len(entries) >= 24
    for one, other in zip(mutants, mutants[1:]):
        assert one.path != other.path or one.end <= other.start, f"{one.path}:{one.line}"


def test_switches_of_planted_bugs(tmp_path):
    """Expressions become a choice, statements a condition; bytes before them count, not characters."""
    (tmp_path / "a.cpp").write_text("// \u00b5\n  a = x + y;\n  b();\n")
    entry = {"file": "a.cpp", "line": "a = x + y;", "original": "x + y", "mutated": "x - y", "occurrence": 0}
    statement = {"file": "a.cpp", "line": "b();", "original": "b();", "mutated": "", "occurrence": 0}
    made = [planted.mutant_of(e, tmp_path) for e in (entry, statement)]
    text = draw.switched((tmp_path / "a.cpp").read_bytes(), list(enumerate(made, 1))).decode()
    assert text == "// \u00b5\n  a = (mpdem_mutant(1) ? (x - y) : (x + y));\n  if (!mpdem_mutant(2)) b();\n"
