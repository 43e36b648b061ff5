# SPDX-License-Identifier: GPL-2.0-or-later
"""Rooms of src/USER-MPDEM include only rooms below them, and LIGGGHTS is known to the upper two alone."""
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "USER-MPDEM"

CORE = {"coupling", "fracture", "grain", "mpm", "material", "numerics", "parallel"}
ENGINE = CORE | {"geometry", "contact", "cement/creation", "cement/bond", "cement/failure", "cement/layout", "cement/condensed", "cement/step", "cement/engine"}

# What each room may include besides itself.
BELOW = {
    "numerics": set(),
    "parallel": {"numerics"},
    "geometry": {"numerics"},
    "grain": set(),
    "material": {"numerics"},
    "mpm": {"material", "numerics", "parallel"},
    "fracture": {"mpm", "material", "numerics", "parallel"},
    "coupling": {"mpm", "material", "grain", "numerics", "parallel"},
    "contact": {"mpm", "material", "numerics", "parallel"},
    "cement/creation": {"geometry", "mpm", "numerics", "parallel"},
    "cement/bond": CORE,
    "cement/failure": {"cement/bond"} | CORE,
    "cement/layout": {"cement/failure", "cement/bond", "geometry"} | CORE,
    "cement/condensed": {"cement/layout", "cement/failure", "cement/bond"} | CORE,
    "cement/step": {"cement/condensed", "cement/layout", "cement/failure", "cement/bond"} | CORE,
    "cement/engine": {"cement/step", "cement/condensed", "cement/layout", "cement/failure", "cement/bond", "contact"} | CORE,
    "styles/words": ENGINE,
    "styles/atoms": {"styles/words"} | ENGINE,
    "styles/guards": {"styles/atoms", "styles/words"} | ENGINE,
    "styles/fixes": {"styles/guards", "styles/atoms", "styles/words"} | ENGINE,
    "styles/computes": {"styles/fixes", "styles/atoms", "styles/words"} | ENGINE,
    "styles/commands": {"styles/fixes", "styles/guards", "styles/atoms", "styles/words"} | ENGINE,
    "host": {"styles/words", "styles/atoms", "styles/guards", "styles/fixes", "styles/computes", "styles/commands"},
}
KNOW_LIGGGHTS = {room for room in BELOW if room.startswith("styles/")} | {"host"}


def room_of(path):
    """Folder of a file within the package; the package itself for version.h."""
    return path.parent.relative_to(PACKAGE).as_posix()


def includes():
    """Room, file and included file of every include with quotes."""
    for path in sorted(PACKAGE.rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        for name in re.findall(r'^\s*#include "([^"]+)"', path.read_text(), re.M):
            yield room_of(path), path, name


def against_the_layers(room, path, name):
    """Why an include is not allowed; empty if it is."""
    target = (path.parent / name).resolve()
    if not target.exists():
        return "" if room in KNOW_LIGGGHTS else f"{path.name} in {room}/ includes {name}, which is not of this package"
    other = room_of(target)
    if target == PACKAGE / "version.h" or other == room or other in BELOW[room]:
        return ""
    return f"{path.name} in {room}/ includes {name}; {room}/ may include {', '.join(sorted(BELOW[room])) or 'nothing else'}"


def test_every_room_is_known():
    rooms = {room_of(path) for path in PACKAGE.rglob("*.h")} - {"."}
    assert rooms == set(BELOW)


def test_includes_go_down():
    found = [why for why in (against_the_layers(*i) for i in includes()) if why]
    assert not found, "\n".join(found)


def test_the_picture_of_the_rooms(tmp_path):
    """tools/rooms.py draws every room of the table, and none includes one that includes it."""
    sys.path.insert(0, str(ROOT / "tools"))
    import rooms

    lines, _, includes = rooms.rooms_of(PACKAGE)
    assert set(lines) == set(BELOW)
    assert not [(a, b) for a in includes for b in includes[a] if a in includes.get(b, {})]
    rooms.draw(PACKAGE, tmp_path / "rooms.svg")
    assert all(room in (tmp_path / "rooms.svg").read_text() for room in ("cement/step", "coupling"))


def test_no_part_knows_the_cement():
    """Parts of the engine know what they are made of; Cement alone knows all of them."""
    who = {path.name for room, path, name in includes() if room.startswith("cement/") and Path(name).name == "cement.h"}
    assert who == {"cement.cpp", "state.cpp", "surfaces.cpp"}


def test_the_table_of_parts_is_in_their_order():
    """Parts refer to those that are made before them, so doc/architecture.md lists them in the order of cement.h."""
    members = re.findall(
        r"^  (?:std::unique_ptr<)?(\w+)>? \w+_(?:\{.*\})?;", (PACKAGE / "cement" / "engine" / "cement.h").read_text().split("private:")[-1], re.M
    )
    text = (PACKAGE.parents[1] / "doc" / "architecture.md").read_text()
    table = re.findall(r"^\| `(\w+)`, `[\w/]+\.h` \|", text, re.M)
    assert len(table) > 10
    assert table == [m for m in members if m in table]


def test_guards_are_unique():
    """Of two headers with the same guard, the second is empty for who includes both."""
    guards = [re.search(r"#ifndef (MPDEM_\w+)", path.read_text()) for path in sorted(PACKAGE.rglob("*.h"))]
    names = [guard[1] for guard in guards if guard]
    assert len(names) > 100
    assert not {name for name in names if names.count(name) > 1}


def test_an_include_upwards_is_found():
    kernel = PACKAGE / "mpm" / "grid.cpp"
    assert "may include" in against_the_layers("mpm", kernel, "../coupling/penalty_links.h")
    assert "not of this package" in against_the_layers("mpm", kernel, "update.h")
    assert not against_the_layers("mpm", kernel, "../parallel/halo_sum.h")


def reaches_private_members(text):
    """Whether code gets at private members of a class that it is no friend of."""
    code = without_words(re.sub(r"\\\n", " ", text))
    instantiation = r"\btemplate\s+(?:struct|class|union)?\s*[\w:]+\s*<[^;{]*&\s*[\w:]+::\w"  # may name private members
    return bool(re.search(instantiation, code) or re.search(r"#\s*define\s+(?:private|protected|class)\b", code))


def test_private_members_have_one_way_in():
    found = {p.relative_to(PACKAGE).as_posix() for p in PACKAGE.rglob("*") if p.suffix in (".h", ".cpp") and reaches_private_members(p.read_text())}
    assert found == {"styles/atoms/private_access.cpp"}


@pytest.mark.parametrize(
    "code",
    [
        "template struct Expose<Tag, &Comm::bordergroup>;",
        "template class A<int Tag::*,\n  &LAMMPS_NS::Comm::x>;",
        "#define OPEN(C, M) \\\n  template struct Expose<C##_##M, &C::M>;",
        "#define private public",
    ],
)
def test_a_way_in_is_found(code):
    assert reaches_private_members(f"namespace n {{\n{code}\n}}\n")
    assert not reaches_private_members(f"// {code.splitlines()[0]}\nint f(int (C::*p)()) {{ return g<A>(&C::f); }}\n".replace("\\\n", "\n"))


def without_words(text):
    """C++ with comments, strings and characters blanked out, as long as it was."""

    def blank(found):
        return re.sub(r"[^\n]", " ", found[0])

    return re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', blank, text, flags=re.S)


def functions(text):
    """Head, first line and number of lines of every function with a body; a lambda belongs to what it stands in."""
    text = re.sub(r"(?m)^\s*#.*$|^\w+Style\(.*\)$", lambda found: " " * len(found[0]), without_words(text))
    text = re.sub(r"(?<=\w)\{[^{};]*\}", lambda found: re.sub(r"[^\n]", " ", found[0]), text)  # of a member
    found, scopes, start = [], [], 0  # scopes: head and place of a function, or None for a room such as a namespace or a class
    for at, letter in enumerate(text):
        if letter == "{":
            head = text[start:at].strip()
            inside = any(s is not None for s in scopes)
            room = re.match(r"(inline )?(namespace|(template <.*> ?)?(class|struct|union)|enum|extern)\b", head) and not re.search(r"\)\s*(const)?$", head)
            scopes.append(None if room and not inside else (head, start + len(text[start:at]) - len(text[start:at].lstrip())))
            start = at + 1
        elif letter == "}":
            scope = scopes.pop()
            if scope is not None and all(s is None for s in scopes) and "(" in scope[0]:
                first = text.count("\n", 0, scope[1])
                found.append((scope[0], first + 1, text.count("\n", 0, at) - first + 1))
            start = at + 1
        elif letter == ";":
            start = at + 1
        elif letter == ":" and text[start:at].strip() in ("public", "private", "protected"):
            start = at + 1
    assert not scopes
    return found


def too_long(text, most=80):
    return [f"{head.split('(')[0].split()[-1]} in line {line} has {lines} lines" for head, line, lines in functions(text) if lines > most]


def test_functions_are_short():
    files = [p for p in sorted(PACKAGE.rglob("*")) if p.suffix in (".h", ".cpp")]
    assert sum(len(functions(p.read_text())) for p in files) > 800
    found = [f"{p.relative_to(PACKAGE)}: {why}" for p in files for why in too_long(p.read_text())]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    "opening",
    [
        "void A::f(int n) const {",
        "template <class T>\nT f(T a,\n   int b) {",
        "A::A(int a) : b_(a), c_{a} {",
        "class B {\n public:\n  bool operator()(int a) override {",
        "auto f() -> std::vector<int> {",
        "CommandStyle(x,X)\n\nclass X {\n  void f() {",
    ],
)
def test_a_long_function_is_found(opening):
    def text(lines):
        body = '  const auto g = [&](int i) { return i; };  // {\n  say("}{");\n' + "  if (a) { b = 1; }\n" * (lines - 4)
        return "namespace n {\n" + opening + "\n" + body + "}\n" + "};\n" * ("class " in opening and "template" not in opening) + "}\n"

    assert not too_long(text(75)), functions(text(75))
    assert len(too_long(text(85))) == 1


def body_at(text, opening):
    """What stands between the brace at `opening` and its own closing one."""
    depth, at = 0, opening
    while True:
        depth += {"{": 1, "}": -1}.get(text[at], 0)
        if depth == 0:
            return text[opening + 1 : at]
        at += 1


def statements(body):
    """Statements of the body of a class, each with what stands in its braces, which are {} in it. Functions with a body are left out."""
    found, words, blocks, at = [], "", [], 0
    while at < len(body):
        if body[at] == "{":
            blocks.append(body_at(body, at))
            at += len(blocks[-1]) + 1
            words += "{}"
            is_type = re.match(r"\s*((public|private|protected)\s*:\s*)*(template\s*<.*>\s*)?(class|struct|union|enum)\b", words)
            if "(" in without_templates(words).split("=")[0] and not is_type:
                words, blocks = "", []
        elif body[at] == ";":
            found.append((re.sub(r"\b(public|private|protected)\s*:(?!:)", "", words).strip(), blocks))
            words, blocks = "", []
        else:
            words += body[at]
        at += 1
    return found


def without_templates(words):
    before = None
    while before != words:
        before, words = words, re.sub(r"<[^<>]*>", "", words)
    return words


def data_members(body):
    """Names of the data members of a class. Those of a type that is declared in it, and of which it has a member, are members too: `a_`, `a_.x`."""
    names, nested = [], {}
    for words, blocks in statements(body):
        words = without_templates(words)
        if re.match(r"(using|friend|typedef|static|template|enum|virtual|explicit|constexpr)\b", words):
            continue
        inner = re.match(r"(?:class|struct|union)\b\s*(\w*)[^{]*\{\}(.*)", words, re.S)
        kind = inner[1] if inner else ""
        if inner:
            nested[kind] = data_members(blocks[0])
            words = f"unnamed {inner[2]}"
            if not kind and not inner[2].strip():
                names += nested[kind]
        first = words.split("=")[0]
        if "(" in first or "operator" in first:
            continue
        words = re.sub(r"\[[^\]]*\]|\{\}|\([^()]*\)", "", words)
        declared = [re.findall(r"\w+", piece.split("=")[0]) for piece in words.split(",")]
        if len(declared[0]) < 2:
            continue
        for piece in declared:
            names.append(piece[-1])
            of_type = kind if inner else declared[0][-2]
            names += [f"{piece[-1]}.{name}" for name in nested.get(of_type, [])]
    return names


def members(text):
    """Data members of every class and struct, by its name."""
    text = without_words(text)
    return {head[1]: data_members(body_at(text, head.end() - 1)) for head in re.finditer(r"\b(?:class|struct) (\w+)[^;{}()]*\{", text)}


MOST_MEMBERS, MOST_LINES = 15, 500
RECORD = "a record or a table: one field a value"
LOOPS = "data of one loop, laid out for it"
# Data members, those of nested types counted, and why there are so many. They go down, not up.
LARGE_CLASSES = {
    "cement/bond/bond.h:Bond": (19, "what a bond has on one rank"),
    "cement/bond/bonded_grains.h:BondedGrains": (24, "to be divided: loads of sub-steps"),
    "cement/bond/fragment_bodies.h:Fragment": (16, "a body: motion, load and response"),
    "cement/bond/options.h:CementOptions": (25, RECORD),
    "cement/bond/scene.h:Scene": (18, "what the components share"),
    "cement/creation/cement_maker.h:CementMaker": (25, "to be divided: batches"),
    "cement/engine/bond_table.h:CementTotals": (26, RECORD),
    "cement/engine/cement.h:Cement": (19, "its components, one each"),
    "cement/layout/cement_restart.h:CementHead": (24, RECORD),
    "cement/step/condensing.h:Condensing": (21, "what changed in a step, and the copies that queries look at"),
    "contact/cement_surface.h:CementPiece": (16, RECORD),
    "coupling/bond_ends.h:BondEnd": (17, RECORD),
    "coupling/condensed_pack.h:Block": (16, LOOPS),
    "coupling/grain.h:Grain": (18, RECORD),
    "coupling/grain_state.h:GrainState": (19, RECORD),
    "coupling/penalty_links.h:PenaltyLinks": (20, LOOPS),
    "fracture/phantom_nodes.h:NodeSplitter": (19, "to be divided: state of one node"),
    "mpm/bond_record.h:BondRecord": (30, RECORD),
    "mpm/extension_constraints.h:ExtensionConstraints": (17, LOOPS),
    "mpm/grid.h:Grid": (20, LOOPS),
    "mpm/point_record.h:PointRecord": (26, RECORD),
    "mpm/point_store.h:BlockMeta": (18, LOOPS),
    "mpm/point_store.h:PointStore": (19, LOOPS),
    "mpm/point_stress.h:L": (25, LOOPS),
    "styles/fixes/cement_report.h:CementReport": (16, "messages that are printed once"),
    "styles/fixes/fix_mpm.h:FixMpm": (21, "its components, one each"),
}
# Lines of files, and why there are so many.
LONG_FILES = {
    "cement/bond/bonded_grains.cpp": (548, "see BondedGrains"),
    "cement/condensed/condensed_bonds.cpp": (650, "to be divided: solutions"),
    "coupling/debonded_contact.cpp": (522, "one class"),
    "coupling/penalty_links.cpp": (632, "one class and its loops"),
    "styles/atoms/atom_vec_mpdem.cpp": (567, "one class of LIGGGHTS"),
    "styles/guards/host_guards.cpp": (545, "one table"),
}


def large_classes():
    """Classes of all headers with more members than that, by file and name."""
    return {
        f"{path.relative_to(PACKAGE).as_posix()}:{name}": of_class
        for path in sorted(PACKAGE.rglob("*.h"))
        for name, of_class in members(path.read_text()).items()
        if len(of_class) > MOST_MEMBERS
    }


def test_classes_are_small():
    """What belongs together is a class of its own, with a header that says what it is for. Exceptions have a number and a reason."""
    found = large_classes()
    assert len(found["cement/engine/cement.h:Cement"]) > 10
    assert set(found) == set(LARGE_CLASSES)
    assert not [f"{name} has {len(found[name])}: {', '.join(found[name])}" for name, (most, _) in LARGE_CLASSES.items() if len(found[name]) > most]


def test_files_are_short():
    lines = {p.relative_to(PACKAGE).as_posix(): len(p.read_text().splitlines()) for p in PACKAGE.rglob("*") if p.suffix in (".h", ".cpp")}
    assert {name for name, n in lines.items() if n > MOST_LINES} == set(LONG_FILES)
    assert not [f"{name} has {lines[name]} lines" for name, (most, _) in LONG_FILES.items() if lines[name] > most]


def test_the_engine_has_no_friends():
    found = [p.name for p in (PACKAGE / "cement").rglob("*.*") if re.search(r"\bfriend\b", without_words(p.read_text()))]
    assert not found


@pytest.mark.parametrize(
    "code, expected",
    [
        (
            "class A : B {\n public:\n  int f() { return a_; }\n  double a_ = 0.0, b_;\n  T c_{1}, d_[3];\n  A() : a_(1) {}\n};\nclass C;",
            ["a_", "b_", "c_", "d_"],
        ),
        ("class A {\n  struct { int x = f(1, 2); T<int, 2> y; } s_;\n  int z_;\n};", ["s_", "s_.x", "s_.y", "z_"]),
        ("class A {\n  struct B { int x, y; };\n  B s_;\n  std::vector<B> many_;\n  std::map<int, B> by_row_;\n};", ["s_", "s_.x", "s_.y", "many_", "by_row_"]),
        ("class A {\n  struct B { struct C { int x; } c; } b_;\n};", ["b_", "b_.c", "b_.c.x"]),
        ("struct A {\n  union { int i; double d; };\n  std::function<int(B&)> f;\n  M m = M::Zero();\n  const T& r;\n};", ["i", "d", "f", "m", "r"]),
        (
            "class A {\n  using B = int;\n  static constexpr int k = 1;\n  enum C { c };\n  friend class D;\n  int f(int a = 1) const;\n  A& operator=(const A&);\n};",
            [],
        ),
    ],
)
def test_members_are_found(code, expected):
    assert members(code + "\n")["A"] == expected
