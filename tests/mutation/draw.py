# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Which candidates become mutants, and the mutated copy of the source.

A draw goes by the hash of the seed and of what a candidate is: its file, its line and the change, not its number. So
a line that changes elsewhere leaves the other mutants as they were.
"""
import hashlib
import re
from collections import Counter
from dataclasses import dataclass

MOST_OF_A_FILE = 3


@dataclass
class Candidate:
    path: str  # below src/USER-MPDEM
    operator: str  # its class
    start: int  # range in the text, bytes
    end: int
    line: int
    original: str
    mutated: str
    text: str = ""  # what the range is replaced by; {n} is the number
    content: str = ""  # the line, for keys and tables
    occurrence: int = 0

    def key(self):
        return "|".join((self.path, self.operator, self.content, self.original, self.mutated, str(self.occurrence)))

    def change(self):
        return f"`{self.original}` becomes `{self.mutated}`" if self.mutated else f"`{self.original}` is left out"


def lot(seed, *what):
    return hashlib.sha256("|".join(map(str, (seed,) + what)).encode()).hexdigest()


def folder(candidate):
    return candidate.path.split("/")[0]


def quotas(candidates, least, total):
    """`least` of each folder, the rest to the largest, in turn."""
    if not candidates:
        return {}
    sizes = Counter(folder(c) for c in candidates)
    order = [f for f, _ in sizes.most_common()]
    n = {f: least for f in order}
    for i in range(total - sum(n.values())):
        n[order[i % len(order)]] += 1
    return n


def changed_lines(diff):
    """File and line of what `git diff --unified=0 --relative` shows as new."""
    found, path = set(), ""
    for line in diff.splitlines():
        if line.startswith("+++ "):
            path = line[4:].removeprefix("b/")
        hunk = re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line)
        if hunk:
            first, number = int(hunk[1]), int(hunk[2] or 1)
            found.update((path, n) for n in range(first, first + number))
    return found


def draw(candidates, seed, least, total, refused, drawn=()):
    """The mutants in the order of the source. refused: keys of those that do not compile. drawn: those of another draw
    from the same source, which a place of theirs is not drawn for again."""
    chosen = []
    for name, number in sorted(quotas(candidates, least, total).items()):
        here = [
            c
            for c in candidates
            if folder(c) == name and c.key() not in refused and not any(c.path == d.path and c.start < d.end and d.start < c.end for d in drawn)
        ]
        # From each operator in turn, or half of them would be constants and indices.
        heaps = {}
        for c in sorted(here, key=lambda c: lot(seed, c.key())):
            heaps.setdefault(c.operator, []).append(c)
        turns = sorted(heaps, key=lambda operator: lot(seed, name, operator))
        most, taken = MOST_OF_A_FILE, []
        while len(taken) < number:
            before = len(taken)
            for operator in turns:
                heap = heaps[operator]
                while heap and len(taken) < number:
                    c = heap.pop(0)
                    if sum(c.path == t.path for t in taken) < most and not any(c.path == t.path and c.start < t.end and t.start < c.end for t in taken):
                        taken.append(c)
                        break
            if len(taken) == before:
                break
        chosen += taken
    return sorted(chosen, key=lambda c: (c.path, c.start))


def switched(source, mutants):
    """The bytes of a file with its mutants, (number, candidate), as switches. Lines stay where they are."""
    for number, c in sorted(mutants, key=lambda m: -m[1].start):
        source = source[: c.start] + c.text.replace("{n}", str(number)).encode() + source[c.end :]
    return source
