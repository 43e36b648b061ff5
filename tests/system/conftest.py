# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures that the tests measure are listed, beside their limits, at the end of a run."""
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parent.parent / "verification"))

_figures = []


@pytest.fixture
def figures():
    """figures.below(name, value, limit) reports and asserts, figures.note(name, value) reports."""
    return Figures()


class Figures:
    def note(self, name, value):
        _figures.append(f"{name}: {value}")

    def below(self, name, value, limit):
        _figures.append(f"{name}: {value:.3g} (limit {limit:g})")
        assert value <= limit, _figures[-1]


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: takes most of a minute")


def pytest_terminal_summary(terminalreporter):
    if _figures:
        terminalreporter.section("figures")
        for line in _figures:
            terminalreporter.line(line)
