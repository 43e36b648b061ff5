# SPDX-License-Identifier: GPL-2.0-or-later
"""One style: clang-format for C++, black and flake8 for Python, mypy for the tools. `tools/setup.sh tests` installs them."""
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def files(*patterns):
    return subprocess.run(["git", "ls-files", *patterns], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()


CHECKS = {
    "clang-format": (["clang-format", "--dry-run", "-Werror", "--style=file"], ("*.cpp", "*.h")),
    "black": (["/usr/bin/python3", "-m", "black", "--check", "-q"], ("*.py",)),
    "flake8": (["/usr/bin/python3", "-m", "flake8"], ("*.py",)),
    "mypy": (["/usr/bin/python3", "-m", "mypy", "--ignore-missing-imports", "--cache-dir=/dev/null"], ("tools/*.py", "tools/mpdem/*.py")),
}


@pytest.mark.parametrize("tool", CHECKS)
def test_style(tool):
    command, patterns = CHECKS[tool]
    assert shutil.which(tool), f"{tool} is missing: tools/setup.sh tests"
    names = [name for name in files(*patterns) if (ROOT / name).is_file()]
    assert len(names) > 15
    result = subprocess.run([*command, *names], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, (result.stdout + result.stderr)[-3000:]


@pytest.mark.parametrize(
    "tool, name, text",
    [
        ("clang-format", "a.cpp", "int f( ) {return 1 ; }\n"),
        ("black", "a.py", "a = [1,2]\n"),
        ("flake8", "a.py", "import os\n"),
        ("mypy", "a.py", "a: int = ''\n"),
    ],
)
def test_a_slip_is_found(tool, name, text, tmp_path):
    path = tmp_path / name
    path.write_text(text)
    command = [f"--style=file:{ROOT / '.clang-format'}" if word == "--style=file" else word for word in CHECKS[tool][0]]
    assert subprocess.run([*command, str(path)], cwd=ROOT, capture_output=True).returncode != 0
