#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Writes the tables of doc/reliability.md from what the tests measured.

    tools/reliability.py build/figures doc/reliability.md

`make test` and `make stress` leave build/figures/<test file>.json, a list of figures with their limits. `make fuzz` leaves
build/figures/fuzz.json: how many inputs of each scene ended in which way. `make mutants` leaves build/figures/mutants.json: which
test fails with each planted bug. Two tables go beside the page, into data/:

  reliability_tests.csv    a row for each test that measures: how many cases and figures, and the figure nearest to its limit
  reliability_mutants.csv  a row for each planted bug

The page has sums of both, the rows of PROMISES and the counts of the fuzzer, each between the marks of a table. What was not measured
stays as it is, except rows of test files that are gone.
"""
import contextlib
import csv
import glob
import io
import json
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FUZZ, MUTANTS = "fuzz.json", "mutants.json"
ROUNDING, WIDEST = 1e-9, 30  # a figure below the first measures rounding, and its limit is to be at most so many times as large
OUTCOMES = {
    "ok": "ended well",
    "message": "one message that names the command",
    "silent": "error without a message",
    "nameless": "message that names no command",
    "crash": "crash",
    "hang": "hang",
    "memory": "too much memory",
    "host": "LIGGGHTS' own crash or hang",
}
OF_TESTS = ("file", "test", "what", "cases", "figures", "nearest to its limit", "measured", "limit", "met", "rounding", "wide")
OF_MUTANTS = ("seed", "file", "line", "change", "outcome", "by")
# What the page promises, and the test whose figure it shows.
PROMISES = (
    ("Stiffness of a bond: that of finite elements", "test_stiffness_command", "test_finite_elements"),
    ("Stiffness: little effect of the position of the grid", "test_grid_and_points", "test_offset_of_the_grid"),
    ("Fracture energy of `nonlocal`: that of the script, with any cell", "test_nonlocal", "test_same_energy_at_any_cell"),
    ("Fracture energy of `interface cohesive`: that of the script", "test_interface_energy", "test_a_crack_that_runs"),
    ("Energy balance through failure", "test_energy", "test_balance_through_failure"),
    ("Energy balance with friction of crushed cement", "test_friction", "test_crushed_cement_keeps_the_balance"),
    ("Momentum of a pair that breaks in flight", "test_conservation", "test_breaking_pair"),
    ("Same forces on any number of ranks", "test_layouts", "test_layout"),
    ("A run from a restart file: results of the uninterrupted run", "test_interrupted", "test_killed"),
    ("Same forces for a bond in any direction", "test_symmetry_of_pairs", "test_any_direction"),
    ("Condensed bonds carry the forces of resolved ones", "test_condense", "test_packing"),
    ("Sub-steps give the forces of a run with short steps", "test_subcycle", "test_example"),
    ("Same numbers in si, cgs and micro", "test_scales", "test_units"),
    ("No drift of energy in a long vibration", "test_long_runs", "test_free_vibration"),
    ("Time steps up to the stable step are stable", "test_stable_step", "test_time_step"),
)


def files(folder):
    return [p for p in sorted(glob.glob(os.path.join(folder, "*.json"))) if os.path.basename(p) not in (FUZZ, MUTANTS)]


@contextlib.contextmanager
def reading(path):
    """What is wrong with a file is told in one line."""
    try:
        yield
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as wrong:
        sys.exit(f"reliability.py: {path}: holds no figures of tests ({type(wrong).__name__}: {wrong}); delete it and measure again")


def plain(name):
    return name.replace("test_", "").replace("_", " ")


def rows_of(path):
    """The tests of a file, each with its figure that is nearest to its limit."""
    with open(path) as f:
        records = json.load(f)
    name = os.path.splitext(os.path.basename(path))[0]
    for test in dict.fromkeys(r["test"] for r in records):
        of_test = [r for r in records if r["test"] == test]
        limited = [r for r in of_test if r["limit"] is not None]
        if not limited:
            continue
        worst = max(limited, key=closeness)
        row = (
            name,
            test,
            of_test[0]["what"] or plain(test),
            len({r["case"] for r in of_test}),
            len(limited),
            worst["figure"],
            f"{worst['value']:.2g}",
            f"{worst['limit']:g}",
            "yes" if all(r["met"] for r in limited) else "no",
            sum(bool(r["limit"]) and 0.0 < r["value"] < ROUNDING for r in limited),
            "; ".join(f"{limit:g} for {value:.1e}" for limit, value in wide_limits(limited)),
        )
        yield dict(zip(OF_TESTS, map(str, row)))


def closeness(r):
    """Figure over limit; where nothing is allowed, any difference is beyond it."""
    if r["limit"] == 0.0:
        return 0.0 if r["value"] <= 0.0 else float("inf")
    return r["value"] / r["limit"]


def wide_limits(records):
    """Limits of a test that are far above rounding that they hold: (limit, largest figure). Of several ranks or cases, which are figures of one line of
    the test, the largest counts. Where nothing is off, or nothing is allowed, there is nothing to compare."""
    largest = {}
    for r in records:
        if r["limit"]:
            key = r["limit"], r["line"]
            largest[key] = max(largest.get(key, 0.0), r["value"])
    return [(key[0], v) for key, v in largest.items() if 0.0 < v < ROUNDING and key[0] > WIDEST * v]


def read_table(path):
    """Rows of a table, each under its heads; none where there is no table yet."""
    if not os.path.exists(path):
        return []
    with open(path, newline="") as f:
        return list(csv.DictReader(f))


def text_of(heads, rows):
    text = io.StringIO()
    writer = csv.DictWriter(text, heads, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def is_there(name):
    return bool(glob.glob(os.path.join(ROOT, "tests", "*", f"{name}.py")))


def measured(folder, before):
    """Rows of the files that were measured, and those of before of the others that are still there."""
    rows = {}
    for path in files(folder):
        with reading(path):
            rows[os.path.splitext(os.path.basename(path))[0]] = list(rows_of(path))
    for row in before:
        if row["file"] not in rows and is_there(row["file"]):
            rows.setdefault("", []).append(row)
    return sorted((row for of_file in rows.values() for row in of_file), key=lambda row: row["file"])


def cell(text):
    return text.replace("|", "\\|")


def sum_of_tests(rows):
    missed = [r for r in rows if r["met"] != "yes"]
    wide = [r for r in rows if r["wide"]]
    text = [
        f"{sum(int(r['figures']) for r in rows)} figures of {len(rows)} tests have a limit. "
        + (f"**Not met** by {'; '.join(named(r) for r in missed)}." if missed else "All meet it."),
        f"{sum(int(r['rounding']) for r in rows)} of them measure rounding: they are below {ROUNDING:g}. "
        + f"{len(wide) or 'No'} tests hold such a figure by a limit that is more than {WIDEST} times as large{' (column `wide`)' if wide else ''}.",
    ]
    shown = [(words, r) for words, file, test in PROMISES for r in rows if (r["file"], r["test"]) == (file, test)]
    if shown:
        text += ["", "| promise | figure nearest to its limit | measured | limit | test file: test |", "|---|---|---|---|---|"]
        text += [f"| {words} | {cell(r['nearest to its limit'])} | {r['measured']} | {r['limit']} | {named(r)} |" for words, r in shown]
    return "\n".join(text)


def named(row):
    return f"`{row['file']}`: {plain(row['test'])}"


def fuzz_table(path):
    with open(path) as f:
        records = json.load(f)
    total = sum(sum(r["counts"].values()) for r in records)
    text = [f"{total} inputs of seed {records[0]['seed']}:", "", "| starts from | " + " | ".join(OUTCOMES.values()) + " |", "|---" * (len(OUTCOMES) + 1) + "|"]
    return "\n".join(text + [f"| {r['case']} | " + " | ".join(str(r["counts"][k]) for k in OUTCOMES) + " |" for r in records])


def mutants_of(path):
    """A change of a few letters needs its line."""
    with open(path) as f:
        records = json.load(f)
    for r in records:
        change = r["change"] if len(r["change"]) > 50 else f"{r['change']} in `{r['content']}`"
        yield dict(zip(OF_MUTANTS, map(str, (r["seed"], r["file"], r["line"], change, r["outcome"], r["by"]))))


def sum_of_mutants(rows):
    counts = (("killed", "fail a test"), ("changes nothing", "change nothing"), ("survives", "**survive**"), ("not run", "**were not run**"))
    found = {outcome: sum(r["outcome"] == outcome for r in rows) for outcome, _ in counts}
    return f"{len(rows)} mutants of seed {rows[0]['seed']}: " + ", ".join(f"{found[o]} {words}" for o, words in counts if found[o]) + "."


def replace(text, mark, new, page):
    """What stands between the two lines of a mark is replaced."""
    begin, end = f"<!-- {mark}: begin -->", f"<!-- {mark}: end -->"
    if text.count(begin) != 1 or text.count(end) != 1 or text.index(end) < text.index(begin):
        sys.exit(f"reliability.py: {page} needs the lines '{begin}' and '{end}' once each, in this order")
    head, rest = text.split(begin)
    return f"{head}{begin}\n{new}\n{end}{rest.split(end)[1]}"


def main():
    if len(sys.argv) != 3:
        sys.exit("reliability.py: use: tools/reliability.py FOLDER PAGE")
    folder, page = sys.argv[1:]
    tests, mutants = (os.path.join(os.path.dirname(page), "data", f"reliability_{name}.csv") for name in ("tests", "mutants"))
    with open(page) as f:
        text = f.read()
    written, tables = [], {}
    if files(folder):
        with reading(tests):
            rows = measured(folder, read_table(tests))
            tables[tests] = text_of(OF_TESTS, rows)
            text = replace(text, "table", sum_of_tests(rows), page)
        written.append("of tests")
    fuzz = os.path.join(folder, FUZZ)
    if os.path.exists(fuzz):
        with reading(fuzz):
            of_fuzz = fuzz_table(fuzz)
        text = replace(text, "fuzz", of_fuzz, page)
        written.append("of the fuzzer")
    planted = os.path.join(folder, MUTANTS)
    if os.path.exists(planted):
        with reading(planted):
            rows = list(mutants_of(planted))
            of_mutants = sum_of_mutants(rows)
        tables[mutants] = text_of(OF_MUTANTS, rows)
        text = replace(text, "mutants", of_mutants, page)
        written.append("of the mutants")
    if not written:
        sys.exit(f"reliability.py: no figures in {folder}; run `make test`, `make stress`, `make fuzz` or `make mutants`")
    for path, content in {**tables, page: text}.items():
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        with open(path, "w") as f:
            f.write(content)
    print(f"reliability.py: {page}: table {' and '.join(written)} written from {folder}")


if __name__ == "__main__":
    try:
        main()
    except OSError as trouble:
        sys.exit(f"reliability.py: {trouble.filename}: {trouble.strerror}; check the path and its rights")
