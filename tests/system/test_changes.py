# SPDX-License-Identifier: GPL-2.0-or-later
"""What a change costs: the patches of tests/changes fit this tree, and touch no file of another mechanism.

Each is a whole small feature. tools/check_changes.py builds and tests a tree that has them all. A patch that does not fit any more is
written anew with `git diff -U1`. One that needs another file shows that the source has a list or a condition too many.
"""
import os
import re
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from check_changes import CHANGES, apply, bring, copy_tree, touched  # noqa: E402

PACKAGE = "src/USER-MPDEM"
# Rooms that the one new file of source may be in, and for each file that registers it the lines that a patch may add and remove there.
# A list on one line is a line that is replaced.
LIST = (2, 1)  # the include, and the list
COSTS = {
    "damage_linear": (["material"], {"material/laws.h": LIST}),
    "interface_brittle": (["coupling"], {"coupling/traction_laws.h": LIST}),
    "shape_notch": (["geometry"], {"geometry/shape_styles.cpp": (1, 0)}),
    # a mechanism of bonds: its field, its row, what it excludes, the include and the line that makes it
    "fix_mpm_drag": (
        ["mpm", "coupling", "cement"],
        {
            "cement/bond/options.h": (1, 0),
            "styles/words/fix_mpm_words.cpp": (1, 0),
            "styles/words/word_rules.cpp": (1, 0),
            "cement/layout/mechanisms.cpp": (2, 0),
        },
    ),
}


def against_the_costs(name, files):
    """What a patch touches besides one new file of source, the lines of its registration, one new test and its pages."""
    rooms, registration = COSTS[name]
    found, sources, tests, pages = [], 0, 0, 0
    for path, t in files.items():
        if t.new and re.fullmatch(rf"{PACKAGE}/({'|'.join(rooms)})/\w+\.(h|cpp)", path):
            sources += 1
        elif t.new and re.fullmatch(r"tests/system/test_\w+\.py", path):
            tests += 1
        elif re.fullmatch(r"doc/\w+\.md", path):
            pages += t.new
        elif path.removeprefix(f"{PACKAGE}/") in registration and not t.new:
            added, removed = registration[path.removeprefix(f"{PACKAGE}/")]
            if t.added > added or t.removed > removed:
                found.append(f"{path}: {t.added} lines more and {t.removed} less, not {added} and {removed}")
        else:
            found.append(f"{path} belongs to others")
    if (sources, tests) != (1, 1) or pages > 1:
        found.append(f"{sources} new files of source, {tests} of tests, {pages} new pages")
    return found


def copy_of(files, folder):
    for path in files:
        if (ROOT / path).exists():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / path, folder / path)
    return folder


def test_each_kind_has_a_patch():
    assert {p.stem for p in CHANGES.glob("*.patch")} == set(COSTS)


@pytest.mark.parametrize("name", COSTS)
def test_a_change_costs_little(name, tmp_path):
    files = touched(CHANGES / f"{name}.patch")
    assert not against_the_costs(name, files)
    folder = copy_of(files, tmp_path)
    assert not [path for path, t in files.items() if t.new == (folder / path).exists()]
    assert apply(CHANGES / f"{name}.patch", folder) == ""
    assert all((folder / path).exists() for path in files)
    pages = {Path(path).name for path, t in files.items() if t.new and path.startswith("doc/")}
    index = folder / "doc" / "index.md"
    linked = set(re.findall(r"\]\((\w+\.md)\)", index.read_text())) if index.exists() else set()
    assert pages <= linked and {page for page in linked if not (ROOT / "doc" / page).exists()} == pages, "the index has the page of this patch alone"


def test_they_go_together(tmp_path):
    for name in COSTS:
        copy_of([path for path in touched(CHANGES / f"{name}.patch") if not (tmp_path / path).exists()], tmp_path)
    for name in COSTS:
        assert apply(CHANGES / f"{name}.patch", tmp_path) == ""


PATCH = """\
diff --git a/src/USER-MPDEM/material/laws.h b/src/USER-MPDEM/material/laws.h
--- a/src/USER-MPDEM/material/laws.h
+++ b/src/USER-MPDEM/material/laws.h
@@ -1,2 +1,2 @@
 the first line
-the second
+another
diff --git a/src/USER-MPDEM/material/new.h b/src/USER-MPDEM/material/new.h
new file mode 100644
--- /dev/null
+++ b/src/USER-MPDEM/material/new.h
@@ -0,0 +1,2 @@
+one
+two
diff --git a/tests/system/test_new.py b/tests/system/test_new.py
new file mode 100644
--- /dev/null
+++ b/tests/system/test_new.py
@@ -0,0 +1 @@
+one
"""


def test_what_costs_more_is_found(tmp_path):
    (tmp_path / "a.patch").write_text(PATCH)
    files = touched(tmp_path / "a.patch")
    assert {path: (t.new, t.added, t.removed) for path, t in files.items()} == {
        f"{PACKAGE}/material/laws.h": (False, 1, 1),
        f"{PACKAGE}/material/new.h": (True, 2, 0),
        "tests/system/test_new.py": (True, 1, 0),
    }
    assert not against_the_costs("damage_linear", files)
    assert len(against_the_costs("interface_brittle", files)) == 3
    files[f"{PACKAGE}/material/laws.h"].added = 3
    files[f"{PACKAGE}/material/law.h"] = files["doc/new.md"] = files[f"{PACKAGE}/material/laws.h"]
    found = against_the_costs("damage_linear", files)
    assert len(found) == 2 and "3 lines more" in found[0] and "law.h belongs to others" in found[1]
    copy = tmp_path / "copy"
    (copy / PACKAGE / "material").mkdir(parents=True)
    (copy / PACKAGE / "material" / "laws.h").write_text("the first line\nyet another\n")
    assert "does not apply" in apply(tmp_path / "a.patch", copy)
    assert not (copy / "tests").exists()


def test_a_copy_is_compiled_only_where_it_changes(tmp_path):
    root, tree = tmp_path / "root", tmp_path / "tree"
    for name in ("src/a.h", "src/b.h", "build/a.o", "other/tree/a.h", ".git/HEAD", "src/build/c.h"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text("one")
    copy_tree(root, tree, root / "other")
    assert {p.relative_to(tree).as_posix() for p in tree.rglob("*") if p.is_file()} == {"src/a.h", "src/b.h", "src/build/c.h"}
    (tree / "build").mkdir()
    (tree / "build/a.o").write_text("one")
    os.utime(tree / "src/a.h", (1, 1))
    os.utime(tree / "src/b.h", (1, 1))
    (root / "src/b.h").write_text("two")
    shutil.rmtree(root / "src/build")
    copy_tree(root, tmp_path / "fresh", root / "other")
    bring(tmp_path / "fresh", tree)
    assert {p.relative_to(tree).as_posix() for p in tree.rglob("*") if p.is_file()} == {"src/a.h", "src/b.h", "build/a.o"}
    assert (tree / "src/a.h").stat().st_mtime == 1 and (tree / "src/b.h").stat().st_mtime > 1 and (tree / "src/b.h").read_text() == "two"
