#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Counts the conditions of the source that ask for an option, or for a state of a bond, outside the files of that option.

    tools/option_conditions.py                   of this source tree
    tools/option_conditions.py OLD/src -v        of another one, with every line
    tools/option_conditions.py --csv             a line for each option: name, conditions, files

What may be combined has to be thought of wherever one option asks about another. This count says how much there is of that.

A condition is a line where an expression that is tested has the option: what stands in if, while, for or switch, beside
&&, || or a comparison, behind ! or before ?, or what a function returns as a bool. An option that is handed on as an argument
is none, and neither is a loop over some of the bonds. Comments, texts in quotes and lines of the preprocessor are left out.
Renaming does not help:

* a function of one line that returns a bool and asks for an option stands for that option, and so does one that rests on it.
  Its uses count, besides the line that defines it. Uses of a function of another type, whose line tests the option, count
  wherever they stand. A function of a .cpp file stands for it in that file.
* a local name that has an option as its value stands for it to the end of its block.

What stands for several options counts for the first of the table. A line that asks for two options counts for both, and is
listed as one of several.
"""
import argparse
import csv
import re
import sys
from fnmatch import fnmatch
from pathlib import Path

# Name, patterns of code that ask for it, files that are its own. The split of restart_seal.cpp is that of a file.
OPTIONS = [
    (
        "split",
        r"\bsplit_?\b(?!\()|\bsplits\b(?=\s*(?:&&|\|\||\?|\)))|\bshares_failed_mass\(",
        "node_splitting.* split_nodes.* phantom_nodes.* node_splitter.* node_volumes.* node_aliases.* restart_seal.*",
    ),
    (
        "updated, transfers, reprojects",
        r"\bupdated\b(?!\.)|\b(?:transfers|reprojects)\(|\breproject_(?:every|distortion)\b",
        "updated.* advance_updated.* reproject.*",
    ),
    ("condense", r"\bcondense\b(?!\()|\bword_against_patterns\(|\bmay_leave_points_out\(", "condensing.* condensed_*.* activation.*"),
    (
        "is_resolved, condensed",
        r"\b(?:is_)?resolved(?:_indices)?\(|\bcondensed(?:_\.(?:has|any|any_shared|is)\(|\b(?!\())",
        "condensing.* condensed_*.* activation.* bond.h bond.cpp",
    ),
    ("unilateral", r"\bunilateral\b|\bclosing\.empty\(|\bfailed_as_undamaged\b", "closing_points.*"),
    (
        "nonlocal",
        r"\bnonlocal_?\b(?!\()|\bhalf_band\b|\bnear_threshold\b|\bo(?:ptions)?\.(?:length|imperfection)\b|\bcrack_band\(",
        "nonlocal.* drive_average.* field_drive.* imperfection.* localisation.*",
    ),
    (
        "friction",
        r"\b(?:faces_)?touches\(\)|\bfriction_?\b|\b(?:contacts?|faces)\.empty\(",
        "debonded_contact.* contact_remapping.* crack_faces.* closing_points.* piece_contact.* cement_surface.* surfaces.cpp cement_contacts.*",
    ),
    ("leaves_residue", r"\bleaves_residue\(|\bresidue_?\b|\bis_residue\b|\bkLeavesResidue\b", "cohesive_traction.* traction_law.h"),
    ("substeps", r"\bsubsteps\b(?:\(\))?|\b(?:begins|ends)_step\(|\bsubcycle\b|\bsubstep\b|\bLoads::spread\b", "substeps.* spread_loads.* shared_impulse.*"),
    ("mass_order", r"\bmass_order\b|\bstability_bound\(", "consistent_mass.*"),
    ("tied", r"\btied\b|\bconstraints\.empty\(", "extension_constraints.* edge_constraints.*"),
    ("relative_damping", r"\brelative_damping\b|\bmass_scale\b", "relative_damping.*"),
    ("point_template", r"\bpoint_template\b|\bhas_template\(", "point_template.* template_layouts.*"),
    ("separated", r"\bseparated\b(?:\()?|\bbroken\(|\bin_pieces\b", "separation.* cracks.*"),
    (
        "cut_by_ranks",
        r"\b(?:some_|any_)?(?:bond_)?(?:is_)?cut(?:_by_ranks)?\((?!\))|\bcut_by_ranks\(|\bany_shared\(|\bany_bond_is_cut_?\b|\bcut_\.count|\bshares_any\(",
        "halo_sum.* shared_nodes.*",
    ),
    ("ranks == 1", r"\b(?:ranks|ranks_|nprocs)\s*(?:==|!=|>)\s*1\b", "halo_sum.* all_to_all.* rendezvous.* gather_ranks.*"),
    ("film", r"\bfilm\.(?:empty|carries_load|all)\b|\bkFilm\b|\b\w*(?:->|\.)film\b(?![.\w(])|\bhas_film\b", "film.* film_fill.*"),
]
CODE = (".cpp", ".h")
NAME_BEFORE = re.compile(r"(?:\b(if|while|for|switch|return)\s*|([\w\]>})])\s*)$")
TESTS = re.compile(r"&&|\|\||(?<![<>=!-])(?:==|!=|<=|>=)(?!=)| [<>] ")
ONE_LINE = re.compile(r"\b(\w+\*?) (?:[A-Za-z]\w*::)?(\w+)\([^(){};]*\)(?: const)?(?: override| final)? \{\s*return ([^{};]*);\s*\}")
BODY = re.compile(r"\bbool [\w:]+\([^;{}]*\)(?: const)?(?: override)? \{|\](?:\([^;{}()]*\))?(?: -> bool)? \{")
VALUE = re.compile(r"[\w.>()-]*")  # that is handed on as it is
LOCAL = re.compile(r"\b(bool|auto|char|int|std::uint8_t) (\w+) = ([^;{},]*)")


def bare(text):
    """The text with all that is no code blanked out, as long as it was."""
    text = re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])\'', lambda found: re.sub(r"[^\n]", " ", found[0]), text, flags=re.S)
    return re.sub(r"(?m)^\s*#(?:.*\\\n)*.*$", lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def edge(text, at, step):
    """Place and letter where the expression around `at` ends to one side: a bracket that is not its own, or one of , ; ? : =."""
    depth = 0
    while 0 <= at < len(text):
        c = text[at]
        if c in (")]" if step < 0 else "(["):
            depth += 1
        elif c in ("([{}" if step < 0 else ")]{}"):
            if depth == 0 or c in "{}":
                return at, c
            depth -= 1
        elif depth == 0 and (
            c in ",;?"
            or c == ":"
            and ":" not in text[at - 1] + text[at + 1 : at + 2]
            or c == "="
            and text[at - 1] not in "=!<>+-*/|&"
            and text[at + 1 : at + 2] != "="
        ):
            return at, c
        at += step
    return at, ""


def is_tested(text, start, end, returns):
    """Whether the code from start to end is part of a condition. returns: whether a function that returns a bool has it."""
    if text[end - 1] == "(":  # a call
        end = edge(text, end, 1)[0] + 1
    while True:
        first, opening = edge(text, start - 1, -1)
        last, closing = edge(text, end, 1)
        expression = text[first + 1 : last]
        if closing == "?" or TESTS.search(expression) or re.search(r"!\s*[\w.>:()\[\]-]*$", text[first + 1 : start]):
            return True
        if opening in "{};" and returns and re.match(r"\s*return\b", expression):
            return True
        if opening == ";" and closing == ";" or opening == "(":  # a test of `for`, or a bracket
            bracket = first if opening == "(" else edge(text, first - 1, -1)[0]
            while text[bracket] in ";:,?=":
                bracket = edge(text, bracket - 1, -1)[0]
            before = NAME_BEFORE.search(text, max(0, bracket - 40), bracket)
            if text[bracket] == "(" and before and before[1] in ("if", "while", "switch", "for"):
                return True
            if opening == "(" and closing == ")" and (not before or before[1] == "return"):
                start, end = first, last + 1  # brackets of an expression, not of a call
                continue
        return False


def helpers(texts, options):
    """{option: pattern of what stands for it, pattern of what asks for it wherever it stands}."""
    tested = {name: pattern for name, pattern, own in options}
    always = {name: r"(?!)" for name in tested}
    functions = {m[2]: m for text in texts for m in ONE_LINE.finditer(text)}
    taken, size = {}, -1
    while size != len(taken):
        size = len(taken)
        for m in functions.values():
            found = [name for name in tested if re.search(tested[name], m[3])]
            named = [name for name in found if re.search(tested[name], m[2] + "()")]
            found = named or found
            if found and m[2] not in taken and (m[1] == "bool" or named and not VALUE.fullmatch(m[3]) or re.search(rf"(?:{tested[found[0]]})[^?:]*\?", m[3])):
                taken[m[2]] = found[0]
                (tested if m[1] == "bool" else always)[found[0]] += rf"|\b{m[2]}\("
    return {name: (re.compile(tested[name]), re.compile(always[name])) for name in tested}


def locals_for(text, patterns):
    """{option: [(name, first, last)]} of local names that have an option as their value, and where they stand for it."""
    found, taken = {name: [] for name in patterns}, set()
    for name, (tested, _) in patterns.items():
        for m in LOCAL.finditer(text):
            hit = tested.search(m[3])
            if not hit or m.start() in taken:
                continue
            at = m.start(3)
            if VALUE.fullmatch(m[3]) or m[1] != "int" and is_tested(text, at + hit.start(), at + hit.end(), False):
                taken.add(m.start())
                found[name].append((m[2], m.end(), block_of(text, m.start())))
    return found


def conditions(root, options=OPTIONS):
    """{option: {(file, line)}} of a folder, and the text of its files by name."""
    root = Path(root)
    files = {p.relative_to(root).as_posix(): p.read_text() for p in sorted(root.rglob("*")) if p.suffix in CODE}
    texts = {name: bare(text) for name, text in files.items()}
    headers = [text for name, text in texts.items() if name.endswith(".h")]
    patterns_of_headers = helpers(headers, options)
    found = {name: set() for name, _, _ in options}
    for file, text in texts.items():
        patterns = patterns_of_headers if file.endswith(".h") else helpers([*headers, text], options)  # a .cpp file has functions of its own
        returning = [(m.start(), m.end()) for m in ONE_LINE.finditer(text) if m[1] == "bool"]
        returning += [(m.start(), block_of(text, m.end() - 1)) for m in BODY.finditer(text)]
        stand_for = locals_for(text, patterns)
        for name, _, own in options:
            if any(fnmatch(Path(file).name, o) for o in own.split()):
                continue
            tested, always = patterns[name]
            hits = list(tested.finditer(text))
            for local, first, last in stand_for[name]:
                hits += re.compile(rf"(?<![\w.>]){local}\b(?!\()").finditer(text, first, last)
            asking = [m for m in hits if is_tested(text, m.start(), m.end(), any(first <= m.start() < last for first, last in returning))]
            found[name] |= {(file, text.count("\n", 0, m.start()) + 1) for m in asking + list(always.finditer(text))}
    return found, files


def block_of(text, at):
    """Where the block ends in which `at` stands, or which begins there."""
    depth = 1
    at += text[at] == "{"
    while at < len(text) and depth:
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        at += 1
    return at


def of_several(found):
    """{(file, line): options} of the lines that ask for two options or more."""
    by_line = {}
    for name, lines in found.items():
        for line in lines:
            by_line.setdefault(line, []).append(name)
    return {line: names for line, names in sorted(by_line.items()) if len(names) > 1}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", nargs="?", default=Path(__file__).resolve().parents[1] / "src", help="folder of the source; that of this tree if left out")
    parser.add_argument("-v", "--verbose", action="store_true", help="list the lines")
    parser.add_argument("--csv", action="store_true", help="write comma-separated values")
    given = parser.parse_args()
    found, files = conditions(given.source)
    if not files:
        sys.exit(f"option_conditions.py: no .cpp or .h below '{given.source}'; name the folder of the source")
    several = of_several(found)
    rows = [(name, len(lines), len({file for file, _ in lines})) for name, lines in found.items()]
    rows.append(("all", sum(len(lines) for lines in found.values()), len({file for lines in found.values() for file, _ in lines})))
    rows.append(("lines of several", len(several), len({file for file, _ in several})))
    if given.csv:
        csv.writer(sys.stdout, lineterminator="\n").writerows([("option", "conditions", "files"), *rows])
        return
    for name, count, of_files in [("option", "conditions", "files"), *rows]:
        print(f"{name:32}{count:>10}{of_files:>7}")
    if given.verbose:
        for name, lines in [*found.items(), ("several", several)]:
            print(f"\n{name}")
            for file, line in sorted(lines):
                print(f"  {file}:{line}: {files[file].splitlines()[line - 1].strip()[:150]}")


if __name__ == "__main__":
    main()
