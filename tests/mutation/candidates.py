# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Places of a source file that can be mutated, found in clang's syntax tree.

A candidate is a range of the text and what replaces it when the mutant is chosen. Both are whole expressions
(or `break` and `continue`), so that `mpdem_mutant(17) ? (mutated) : (original)` can stand in the place of the
original: all mutants are in one program (Untch, Offutt and Harrold, Mutation analysis using mutant schemata, 1993).
"""
import os
import re
import sys

from draw import Candidate

try:
    from clang.cindex import CursorKind, Index, TypeKind
except ImportError:
    sys.exit("mutate.py: the Python bindings of libclang are missing; install them with " "'apt-get install python3-clang-14 libclang-common-14-dev'")

RELATIONS = {  # of whole numbers: the boundary moves; of others, where a boundary is almost nothing: the sense
    "<": ("<=", ">"),
    "<=": ("<", ">="),
    ">": (">=", "<"),
    ">=": (">", "<="),
    "==": ("!=", "!="),
    "!=": ("==", "=="),
}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*"}
LOGIC = {"&&": "||", "||": "&&"}
ASSIGNMENTS = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "|=": "&=", "&=": "|="}
INTEGERS = {getattr(TypeKind, n) for n in ("BOOL", "CHAR_S", "SCHAR", "UCHAR", "SHORT", "USHORT", "INT", "UINT", "LONG", "ULONG", "LONGLONG", "ULONGLONG")}
NUMBERS = (INTEGERS - {TypeKind.BOOL}) | {TypeKind.FLOAT, TypeKind.DOUBLE, TypeKind.VECTOR, TypeKind.DEPENDENT}
LOOPS = {CursorKind.FOR_STMT, CursorKind.WHILE_STMT, CursorKind.DO_STMT, CursorKind.CXX_FOR_RANGE_STMT}


def one_line(text):
    """The same without comments and line ends."""
    return re.sub(r"\s+", " ", re.sub(r"//[^\n]*", "", text)).strip()


class File:
    """The candidates of one file."""

    def __init__(self, path, source):
        self.path, self.source, self.found = path, source, []
        self.lines = source.decode().split("\n")

    def text(self, cursor):
        return self.source[cursor.extent.start.offset : cursor.extent.end.offset].decode()

    def between(self, left, right):
        return one_line(self.source[left.extent.end.offset : right.extent.start.offset].decode())

    def before(self, cursor):
        return self.source[: cursor.extent.start.offset].decode().rstrip()[-1:]

    def add(self, operator, cursor, mutated, template="(mpdem_mutant({n}) ? ({mutated}) : ({original}))", original=None):
        start, end = cursor.extent.start.offset, cursor.extent.end.offset
        whole = self.source[start:end].decode()
        line = self.source[:start].count(b"\n")
        self.found.append(
            Candidate(
                self.path,
                operator,
                start,
                end,
                line + 1,
                one_line(original or whole),
                one_line(mutated),
                template.replace("{mutated}", one_line(mutated)).replace("{original}", whole),
                self.lines[line].strip(),
            )
        )

    # ------------------------------------------------------------------------ what is done where

    def visit(self, c, parent=None, role=""):
        children = list(c.get_children())
        kind = c.kind
        if kind == CursorKind.BINARY_OPERATOR and len(children) == 2:
            self.binary(c, *children)
        elif kind == CursorKind.COMPOUND_ASSIGNMENT_OPERATOR and len(children) == 2:
            op = self.between(*children)
            if op in ASSIGNMENTS:
                a, b = (self.text(x) for x in children)
                self.add("assignment", c, f"{a} {ASSIGNMENTS[op]} {b}")
        elif kind == CursorKind.UNARY_OPERATOR and children:
            self.unary(c, children[0])
        elif kind == CursorKind.IF_STMT and children and children[0].kind.is_expression():
            self.add("condition", children[0], f"!({self.text(children[0])})", "(mpdem_mutant({n}) ? {mutated} : !!({original}))")
        elif kind == CursorKind.CONDITIONAL_OPERATOR and len(children) == 3:
            q, a, b = (self.text(x) for x in children)
            self.add("choice", c, f"({q}) ? ({b}) : ({a})")
        elif kind in (CursorKind.INTEGER_LITERAL, CursorKind.FLOATING_LITERAL):
            self.constant(c, parent)
        elif kind == CursorKind.ARRAY_SUBSCRIPT_EXPR and len(children) == 2:
            self.index(children[1])
        elif kind == CursorKind.CALL_EXPR:
            self.call(c, children)
        elif kind == CursorKind.VAR_DECL and children and children[-1].kind.is_expression():
            self.sign(children[-1], c.type)
        elif kind == CursorKind.RETURN_STMT and children:
            self.sign(children[0], children[0].type)
        elif kind in (CursorKind.BREAK_STMT, CursorKind.CONTINUE_STMT):
            word = self.text(c)
            if word in ("break", "continue"):
                other = {"break": "continue", "continue": "break"}[word]
                self.add("loop", c, other, "if (mpdem_mutant({n})) {mutated}; else {original}")
        if role == "statement" and kind in (
            CursorKind.CALL_EXPR,
            CursorKind.BINARY_OPERATOR,
            CursorKind.COMPOUND_ASSIGNMENT_OPERATOR,
            CursorKind.UNARY_OPERATOR,
        ):
            self.add("statement", c, "", "(mpdem_mutant({n}) ? (void)0 : (void)({original}))")
        for i, child in enumerate(children):
            body = kind == CursorKind.COMPOUND_STMT or (kind == CursorKind.IF_STMT and i > 0) or (kind in LOOPS and i == len(children) - 1)
            self.visit(child, c, "statement" if body else "")

    def binary(self, c, left, right):
        op, a, b = self.between(left, right), self.text(left), self.text(right)
        if op in RELATIONS:
            whole = left.type.get_canonical().kind in INTEGERS and right.type.get_canonical().kind in INTEGERS
            self.add("relation", c, f"{a} {RELATIONS[op][0 if whole else 1]} {b}")
        elif op in ARITHMETIC:
            self.add("arithmetic", c, f"{a} {ARITHMETIC[op]} {b}")
            if op in "-/":
                self.add("order", c, f"({b}) {op} ({a})")
        elif op in LOGIC:
            self.add("logic", c, f"{a} {LOGIC[op]} {b}")
        elif op == "=":
            self.sign(right, left.type)

    def unary(self, c, operand):
        text = self.text(c)
        if text.startswith("!"):
            self.add("condition", c, f"!!({self.text(operand)})")
        elif text.startswith("-") and not text.startswith("--"):
            self.add("sign", c, self.text(operand))

    def sign(self, value, type_):
        if (
            type_.get_canonical().kind in NUMBERS
            and type_.get_canonical().kind not in INTEGERS
            and not re.fullmatch(r"0(\.0)?|\{\}|-.*", self.text(value), re.S)
        ):
            self.add("sign", value, f"-({self.text(value)})")

    def constant(self, c, parent):
        text = self.text(c)
        if self.before(c) == "[":
            if parent.kind not in (CursorKind.VAR_DECL, CursorKind.FIELD_DECL, CursorKind.PARM_DECL):
                self.index(c)
        elif re.fullmatch(r"\d+u?", text):
            self.add("constant", c, f"{text} + 1")
        elif re.fullmatch(r"\d*\.\d*", text):  # not 1e-12 and the like: tolerances and what only has to be huge or tiny
            self.add("constant", c, "1.0" if float(text) == 0.0 else f"2 * {text}")

    def index(self, c):
        if c.type.get_canonical().kind in INTEGERS | {TypeKind.DEPENDENT} and not self.text(c).startswith('"'):
            if not any(f.operator == "index" and f.start == c.extent.start.offset for f in self.found):
                text = self.text(c)
                self.add("index", c, f"{text} + 1" if re.fullmatch(r"\w+", text) else f"({text}) + 1")

    def call(self, c, children):
        text = self.text(c)
        if c.spelling == "operator[]" and len(children) == 3:
            self.index(children[2])
        swap = re.match(r"std::(min|max)\(", text)
        if swap:
            self.add("choice", c, f"std::{'max' if swap[1] == 'min' else 'min'}{text[8:]}")


# Clocks, which no test can hold to a figure, and what only says which type a thing is.
LEFT_OUT = re.compile(r"timer_|clock|ticks|static_assert|constexpr|\bcase\b|enum |#define|template")
FILES_LEFT_OUT = ("step_timer.h", "pass_clock.h")


def find(commands, root, report):
    """All candidates of the source below `root` that the commands (compile_commands.json) compile, and for each
    file one that compiles it."""
    index = Index.create()
    files, compiled_by = {}, {}
    for i, command in enumerate(commands):
        report(f"reading {i + 1}/{len(commands)}")
        words = command["command"].split()[1:]
        arguments = [w for w in words if w.startswith(("-I", "-D", "-std", "-march", "/usr/"))] + [
            x for w, n in zip(words, words[1:]) if w == "-isystem" for x in (w, n)
        ]
        unit = index.parse(command["file"], args=["-w", "-std=gnu++17"] + arguments)
        bad = [d for d in unit.diagnostics if d.severity >= 3]
        if bad:
            report(f"{command['file']}: {bad[0]}", keep=True)
        here = {}

        def walk(cursor):
            for c in cursor.get_children():
                name = os.path.normpath(c.location.file.name) if c.location.file else ""
                if not name.startswith(root + "/"):
                    continue
                path = name[len(root) + 1 :]
                if path in files or path.endswith(FILES_LEFT_OUT):
                    continue
                if c.kind == CursorKind.NAMESPACE:
                    walk(c)
                    continue
                if path not in here:
                    with open(name, "rb") as f:
                        here[path] = File(path, f.read())
                here[path].visit(c)

        walk(unit.cursor)
        for path in here:
            compiled_by.setdefault(path, command)
        files.update(here)
    found = []
    for path, file in sorted(files.items()):
        seen = {}
        for c in sorted(file.found, key=lambda c: (c.start, c.end, c.operator)):
            if LEFT_OUT.search(c.content):
                continue
            c.occurrence = seen[c.key()] = seen.get(c.key(), -1) + 1
            found.append(c)
    return found, compiled_by
