# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Bugs that a careless change would bring, chosen by hand: planted.json, as mutants for draw.switched()."""
import json
from pathlib import Path

import draw

LIST = Path(__file__).resolve().parent / "planted.json"


def mutant_of(entry, source):
    """The mutant of an entry of the list. `source`: folder of the package. ValueError if the source has no such place."""
    where = f"{entry['file']}: '{entry['original']}' in '{entry['line']}'"
    text = (Path(source) / entry["file"]).read_text()
    at, places = 0, []
    for number, line in enumerate(text.splitlines(True), 1):
        if line.strip() == entry["line"]:
            places.append((number, at, line))
        at += len(line)
    if len(places) <= entry["occurrence"]:
        raise ValueError(f"{where}: there is no such line now")
    number, at, line = places[entry["occurrence"]]
    original, mutated = entry["original"], entry["mutated"]
    if line.count(original) != 1:
        raise ValueError(f"{where}: the line has it {line.count(original)} times")
    start = len(text[: at + line.index(original)].encode())
    if original.endswith(";"):
        switch = f"if (mpdem_mutant({{n}})) {{ {mutated} }} else {original}" if mutated else f"if (!mpdem_mutant({{n}})) {original}"
    else:
        switch = f"(mpdem_mutant({{n}}) ? ({mutated}) : ({original}))"
    return draw.Candidate(
        entry["file"], "planted", start, start + len(original.encode()), number, original, mutated, switch, entry["line"], entry["occurrence"]
    )


def mutants(source):
    """All of the list, in the order of the source."""
    return sorted((mutant_of(e, source) for e in json.loads(LIST.read_text())), key=lambda c: (c.path, c.start))
