#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Writes the tables of doc/reliability.md from what the tests measured.

    tools/reliability.py build/figures doc/reliability.md

`make test` and `make stress` leave build/figures/<test file>.json, a list of figures with their limits.
One row a test: how many cases and figures, and the figure that came nearest to its limit. `make fuzz`
leaves build/figures/fuzz.json: how many inputs of each scene ended in which way. `make mutants` leaves
build/figures/mutants.json: which test fails with each planted bug. What stands in the page
between the marks of a table is replaced if it was measured, the rest is left as it is.
"""
import contextlib
import glob
import json
import os
import sys

FUZZ, MUTANTS = "fuzz.json", "mutants.json"
ROUNDING, WIDEST = 1e-9, 30  # a figure below the first measures rounding, and its limit is to be at most so many times as large
OUTCOMES = {
    "ok": "ended well",
    "message": "one message that names its command",
    "silent": "error without a message",
    "nameless": "message that names no command",
    "crash": "crash",
    "hang": "hang",
    "memory": "too much memory",
    "host": "LIGGGHTS' own crash or hang",
}


def files(folder):
    return [p for p in sorted(glob.glob(os.path.join(folder, "*.json"))) if os.path.basename(p) not in (FUZZ, MUTANTS)]


@contextlib.contextmanager
def reading(path):
    """What is wrong with a file is told in one line."""
    try:
        yield
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as wrong:
        sys.exit(f"reliability.py: {path}: holds no figures of tests ({type(wrong).__name__}: {wrong}); delete it and measure again")


def rows(path):
    """The tests of a file, each with its figure that is nearest to its limit."""
    with open(path) as f:
        records = json.load(f)
    for test in dict.fromkeys(r["test"] for r in records):
        of_test = [r for r in records if r["test"] == test]
        limited = [r for r in of_test if r["limit"] is not None]
        if not limited:
            continue
        yield {
            "file": os.path.splitext(os.path.basename(path))[0],
            "test": test,
            "what": of_test[0]["what"],
            "cases": len({r["case"] for r in of_test}),
            "figures": len(limited),
            "worst": max(limited, key=closeness),
            "met": all(r["met"] for r in limited),
        }


def closeness(r):
    """Figure over limit; where nothing is allowed, any difference is beyond it."""
    if r["limit"] == 0.0:
        return 0.0 if r["value"] <= 0.0 else float("inf")
    return r["value"] / r["limit"]


def wide_limits(records):
    """Limits of a test that are far above rounding that they hold: (test, limit, largest figure). Of several ranks or cases, which are figures of one
    line of the test, the largest counts. Where nothing is off, or nothing is allowed, there is nothing to compare."""
    largest = {}
    for r in records:
        if r["limit"]:
            key = r["test"], r["limit"], r["line"]
            largest[key] = max(largest.get(key, 0.0), r["value"])
    return [(*key[:2], v) for key, v in largest.items() if 0.0 < v < ROUNDING and key[1] > WIDEST * v]


def told_limits(folder):
    found, some = [], 0
    for path in files(folder):
        with reading(path):
            with open(path) as f:
                records = json.load(f)
            some += sum(bool(r["limit"]) and 0.0 < r["value"] < ROUNDING for r in records)
            name = os.path.splitext(os.path.basename(path))[0]
            found += [f"`{name}`: {test.replace('test_', '').replace('_', ' ')} ({limit:g} for {value:.1e})" for test, limit, value in wide_limits(records)]
    text = f"{some} figures measure rounding: they are below {ROUNDING:g}. "
    return text + (
        f"Of these limits are above {WIDEST} times the largest figure that they hold: {'; '.join(found)}."
        if found
        else f"No limit of them is above {WIDEST} times the largest figure that it holds."
    )


def row_of(r):
    w = r["worst"]
    name = f"`{r['file']}`: {r['test'].replace('test_', '').replace('_', ' ')}"
    what = (r["what"] or r["test"].replace("test_", "").replace("_", " ")).replace("|", "\\|")
    return (
        f"| {name} | {what} | {r['cases']}, {r['figures']} | {w['figure'].replace('|', chr(92) + '|')} | "
        f"{w['value']:.2g}{'' if r['met'] else ' **not met**'} | {w['limit']:g} |"
    )


def table(folder):
    text = ["| test | what was tried | cases, figures | figure nearest to its limit | measured | limit |", "|---|---|---|---|---|---|"]
    for path in files(folder):
        with reading(path):
            text += [row_of(r) for r in rows(path)]
    return "\n".join(text + ["", told_limits(folder)])


def fuzz_table(path):
    with open(path) as f:
        records = json.load(f)
    total = sum(sum(r["counts"].values()) for r in records)
    text = [f"{total} inputs of seed {records[0]['seed']}:", "", "| starts from | " + " | ".join(OUTCOMES.values()) + " |", "|---" * (len(OUTCOMES) + 1) + "|"]
    return "\n".join(text + [f"| {r['case']} | " + " | ".join(str(r["counts"][k]) for k in OUTCOMES) + " |" for r in records])


def mutants_table(path):
    """One row a mutant. Code may hold bars, which would end a cell."""
    with open(path) as f:
        rows = json.load(f)
    text = [
        f"{len(rows)} mutants of seed {rows[0]['seed']}: "
        + ", ".join(
            f"{sum(r['outcome'] == o for r in rows)} {words}"
            for o, words in (("killed", "fail a test"), ("changes nothing", "change nothing"), ("survives", "**survive**"), ("not run", "**were not run**"))
            if any(r["outcome"] == o for r in rows)
        )
        + ".",
        "",
        "| file, line | what was changed | test that fails, or why nothing changes |",
        "|---|---|---|",
    ]
    for r in rows:
        by = {"killed": f"`{r['by']}`", "changes nothing": r["by"], "survives": "**survives**", "not run": "**not run**"}[r["outcome"]]
        # A change of a few letters needs its line.
        change = r["change"] if len(r["change"]) > 50 else f"{r['change']} in `{r['content']}`"
        text.append("| " + " | ".join(cell.replace("|", "\\|") for cell in (f"{r['file']}:{r['line']}", change, by)) + " |")
    return "\n".join(text)


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
    fuzz = os.path.join(folder, FUZZ)
    written = []
    with open(page) as f:
        text = f.read()
    if files(folder):
        text = replace(text, "table", table(folder), page)
        written.append("of tests")
    if os.path.exists(fuzz):
        with reading(fuzz):
            of_fuzz = fuzz_table(fuzz)
        text = replace(text, "fuzz", of_fuzz, page)
        written.append("of the fuzzer")
    mutants = os.path.join(folder, MUTANTS)
    if os.path.exists(mutants):
        with reading(mutants):
            of_mutants = mutants_table(mutants)
        text = replace(text, "mutants", of_mutants, page)
        written.append("of the mutants")
    if not written:
        sys.exit(f"reliability.py: no figures in {folder}; run `make test`, `make stress`, `make fuzz` or `make mutants`")
    with open(page, "w") as f:
        f.write(text)
    print(f"reliability.py: {page}: table {' and '.join(written)} written from {folder}")


if __name__ == "__main__":
    try:
        main()
    except OSError as trouble:
        sys.exit(f"reliability.py: {trouble.filename}: {trouble.strerror}; check the path and its rights")
