# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/compare_programs.py: programs that leave nothing to compare do not agree."""
import subprocess
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "compare_programs.py"


@pytest.mark.parametrize("program, expected", [("/bin/true", "left no table with rows"), ("/bin/false", "ended with status 1")])
@pytest.mark.parametrize("words", [[], ["--time", "1"]])
def test_a_program_that_leaves_no_table(program, expected, words):
    done = subprocess.run(["/usr/bin/python3", TOOL, program, program, "--scenes", "pair_flat", "--ranks", "1", *words], capture_output=True, text=True)
    assert done.returncode == 1 and "agree" not in done.stdout, done.stdout
    assert expected in done.stderr and "Traceback" not in done.stderr, done.stderr
