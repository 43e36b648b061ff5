# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/tidy.py with a program in place of clang-tidy, which `make test` does not install: it says one thing of each file and one of a header."""
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEADER = ROOT / "src" / "USER-MPDEM" / "mpm" / "grid.h"
STUB = f"""#!/bin/sh
for file; do :; done
case $file in *{{words}}*) echo "$file:7:1: warning: use of it [some-check]";; esac
echo "{HEADER}:3:1: warning: a finding of a header [some-check]"
"""


def tidy(folder, words, *arguments):
    (folder / "build").mkdir(parents=True)
    (folder / "build" / "compile_commands.json").touch()
    (folder / "clang-tidy").write_text(STUB.format(words=words) if words else "#!/bin/sh\n")
    (folder / "clang-tidy").chmod(0o755)
    command = [sys.executable, "-B", str(ROOT / "tools" / "tidy.py"), str(folder / "build"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})
    return done.returncode, done.stdout.splitlines(), done.stderr


def test_findings_are_listed_once(tmp_path):
    status, lines, said = tidy(tmp_path, "/")
    files = {p.relative_to(ROOT).as_posix() for p in (ROOT / "src" / "USER-MPDEM").rglob("*.cpp")}
    assert status == 1 and f"{len(files) + 1} findings in {len(files)} files" in said
    assert sorted(lines) == sorted([f"{f}:7: use of it [some-check]" for f in files] + [f"{HEADER.relative_to(ROOT)}:3: a finding of a header [some-check]"])


def test_parts_make_the_whole(tmp_path):
    parts = [set(tidy(tmp_path / str(k), "/", "--part", str(k), "3")[1]) for k in (1, 2, 3)]
    assert all(parts) and set.union(*parts) == set(tidy(tmp_path / "all", "/")[1])


def test_nothing_found(tmp_path):
    assert tidy(tmp_path, "")[:2] == (0, [])


def test_bad_arguments(tmp_path):
    status, _, said = tidy(tmp_path, "", "--part", "4", "3")
    assert status == 2 and "must lie between 1 and the second" in said
    (tmp_path / "build" / "compile_commands.json").unlink()
    done = subprocess.run([sys.executable, "-B", str(ROOT / "tools" / "tidy.py"), str(tmp_path / "build")], capture_output=True, text=True)
    assert done.returncode == 1 and "cmake -S . -B" in done.stderr
