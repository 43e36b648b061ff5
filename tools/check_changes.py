#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Builds and tests a copy of this tree that has the changes of tests/changes, all of them together.

    tools/check_changes.py [--build build] [--jobs 2]

Each patch there is a whole small feature, as a user would add it: source, registration, page and test. The copy is
build/changes/tree, with a build of its own, in which little is compiled when it is called again. CMake takes the compiler's launcher
from CMAKE_CXX_COMPILER_LAUNCHER, ccache for instance. tests/system/test_changes.py looks at the patches without a build.
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CHANGES = ROOT / "tests" / "changes"
RULES = ["test_docs.py", "test_option_table.py", "test_layers.py"]  # what all trees have to pass


class Touched:
    """What a patch does to a file: is it new, how many lines it adds and removes."""

    def __init__(self, new):
        self.new, self.added, self.removed = new, 0, 0


def touched(patch):
    """{path: Touched} of the files of a patch that git wrote."""
    found = {}
    for part in re.split(r"^diff --git ", Path(patch).read_text(), flags=re.M)[1:]:
        head, _, body = part.partition("\n@@")
        of_file = found[re.search(r"^\+\+\+ b/(.*)$", head, re.M)[1]] = Touched("\nnew file mode" in head)
        of_file.added = len(re.findall(r"^\+", body, re.M))
        of_file.removed = len(re.findall(r"^-", body, re.M))
    return found


def apply(patch, folder):
    """Changes the files of a folder, which need not be of a repository. The message of git if the patch does not fit, else an empty text."""
    alone = {**os.environ, "GIT_CEILING_DIRECTORIES": str(Path(folder).resolve().parent)}  # a repository around it is none of its own
    done = subprocess.run(["git", "apply", "--whitespace=error-all", str(Path(patch).resolve())], cwd=folder, env=alone, capture_output=True, text=True)
    return done.stderr if done.returncode else ""


def copy_tree(root, folder, left_out):
    """The files of a tree without builds and what git keeps."""

    def ignored(directory, names):
        here = Path(directory)
        return [n for n in names if n in (".git", "__pycache__") or here == root and n.startswith("build") or here / n == left_out]

    shutil.copytree(root, folder, ignore=ignored)


def bring(source, target):
    """Makes the files of `target` those of `source`, its build aside. Files that are equal keep their time, so they are not compiled again."""
    wanted = {p.relative_to(source) for p in source.rglob("*") if p.is_file()}
    for name in sorted(wanted):
        to = target / name
        if not to.exists() or to.read_bytes() != (source / name).read_bytes():
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source / name, to)
            to.touch()
    for path in [p for p in target.rglob("*") if p.is_file()]:
        name = path.relative_to(target)
        if name not in wanted and name.parts[0] != "build":
            path.unlink()


def changed_tree(build, patches):
    """The copy with all patches. Ends the program if one does not fit."""
    fresh, tree = build / "changes" / "fresh", build / "changes" / "tree"
    shutil.rmtree(fresh, ignore_errors=True)
    copy_tree(ROOT, fresh, build)
    for patch in patches:
        trouble = apply(patch, fresh)
        if trouble:
            sys.exit(f"check_changes.py: {patch.relative_to(ROOT)} does not fit this tree; write it anew with 'git diff -U1':\n{trouble}")
    bring(fresh, tree)
    shutil.rmtree(fresh)
    return tree


def call(what, command, **options):
    print(f"{what}: {' '.join(map(str, command))}", flush=True)
    if subprocess.run(command, **options).returncode:
        sys.exit(f"check_changes.py: {what} failed")


def main():
    p = argparse.ArgumentParser(description="Builds and tests a copy of this tree that has the changes of tests/changes.")
    p.add_argument("--build", default="build", help="folder for the copy and its build (build)")
    p.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time (number of cores)")
    args = p.parse_args()
    patches = sorted(CHANGES.glob("*.patch"))
    tests = [Path(name).name for patch in patches for name, of_file in touched(patch).items() if of_file.new and name.startswith("tests/system/")]
    tree = changed_tree((ROOT / args.build).resolve(), patches)
    set_up = ["cmake", "-S", tree, "-B", tree / "build", "-DMPDEM_TESTS=OFF"]
    if "CMAKE_CXX_COMPILER_LAUNCHER" in os.environ:  # a cache of objects knows none that were made with precompiled headers
        set_up.append("-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON")
    call("set-up", set_up, stdout=subprocess.DEVNULL)
    call("build", ["cmake", "--build", tree / "build", "--parallel", str(args.jobs), "--target", "liggghts-mpdem"], stdout=subprocess.DEVNULL)
    call(
        "tests",
        [sys.executable, "-B", "-m", "pytest", "-q", "-p", "no:cacheprovider", f"--basetemp={tree / 'build' / 'tests'}", *tests, *RULES],
        cwd=tree / "tests" / "system",
        env={**os.environ, "MPDEM_EXE": str(tree / "build" / "liggghts-mpdem")},
    )
    print(f"check_changes.py: {', '.join(patch.stem for patch in patches)} fit, build and pass")


if __name__ == "__main__":
    main()
