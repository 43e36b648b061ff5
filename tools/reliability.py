#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Writes the table of doc/reliability.md from what the tests measured.

    tools/reliability.py build/figures doc/reliability.md

`make test` and `make stress` leave build/figures/<test file>.json, a list of figures with their limits.
One row a test: how many cases and figures, and the figure that came nearest to its limit. What stands
in the page between the two marks is replaced, the rest is left as it is.
"""
import glob
import json
import os
import sys

BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"


def rows(folder):
    files = sorted(glob.glob(os.path.join(folder, "*.json")))
    if not files:
        sys.exit(f"reliability.py: no figures in {folder}; run `make test` or `make stress`")
    for path in files:
        with open(path) as f:
            records = json.load(f)
        for test in dict.fromkeys(r["test"] for r in records):
            of_test = [r for r in records if r["test"] == test]
            limited = [r for r in of_test if r["limit"] is not None]
            if not limited:
                continue
            yield {"file": os.path.splitext(os.path.basename(path))[0], "test": test, "what": of_test[0]["what"],
                   "cases": len({r["case"] for r in of_test}), "figures": len(limited),
                   "worst": max(limited, key=closeness), "met": all(r["met"] for r in limited)}


def closeness(r):
    """Figure over limit; where nothing is allowed, any difference is beyond it."""
    if r["limit"] == 0.0:
        return 0.0 if r["value"] <= 0.0 else float("inf")
    return r["value"] / r["limit"]


def table(folder):
    text = ["| test | what was tried | cases, figures | figure nearest to its limit | measured | limit |", "|---|---|---|---|---|---|"]
    for r in rows(folder):
        w = r["worst"]
        name = f"`{r['file']}`: {r['test'].replace('test_', '').replace('_', ' ')}"
        what = (r["what"] or r["test"].replace("test_", "").replace("_", " ")).replace("|", "\\|")
        text.append(f"| {name} | {what} | {r['cases']}, {r['figures']} | {w['figure'].replace('|', chr(92) + '|')} | "
                    f"{w['value']:.2g}{'' if r['met'] else ' **not met**'} | {w['limit']:g} |")
    return "\n".join(text)


def main():
    if len(sys.argv) != 3:
        sys.exit("reliability.py: use: tools/reliability.py FOLDER PAGE")
    folder, page = sys.argv[1:]
    with open(page) as f:
        text = f.read()
    if text.count(BEGIN) != 1 or text.count(END) != 1 or text.index(END) < text.index(BEGIN):
        sys.exit(f"reliability.py: {page} needs the lines '{BEGIN}' and '{END}' once each, in this order")
    head, rest = text.split(BEGIN)
    with open(page, "w") as f:
        f.write(f"{head}{BEGIN}\n{table(folder)}\n{END}{rest.split(END)[1]}")
    print(f"reliability.py: table of {page} written from {folder}")


if __name__ == "__main__":
    try:
        main()
    except OSError as trouble:
        sys.exit(f"reliability.py: {trouble.filename}: {trouble.strerror}; check the path and its rights")
