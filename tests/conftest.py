# SPDX-License-Identifier: GPL-2.0-or-later
"""Figures that the tests measure are listed, beside their limits, at the end of a run.

With MPDEM_FIGURES=FOLDER they go into FOLDER/<name of the test file>.json too, from which
tools/reliability.py makes the table of doc/reliability.md. --long runs the tests at full length.
"""
import json
import os
import sys
from pathlib import Path

import pytest

sys.dont_write_bytecode = True
for folder in ("system", "verification"):
    sys.path.insert(0, str(Path(__file__).parent / folder))

# Open MPI refuses to start as root, which a container may well be, without the first two.
OPEN_MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
# Looking for a network takes two thirds of the time in which a program starts, and mpirun waits a second
# between telling the other ranks of an abort and killing them.
IN_A_HURRY = {"OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self,vader", "OMPI_MCA_odls_base_sigkill_timeout": "0"}
for _name, _value in {**OPEN_MPI, **IN_A_HURRY}.items():
    os.environ.setdefault(_name, _value)

_records = []


def pytest_addoption(parser):
    parser.addoption("--long", action="store_true", help="run what `make stress` runs")


@pytest.fixture
def long(request):
    return request.config.getoption("--long")


@pytest.fixture
def as_installed(monkeypatch):
    """Open MPI without the choices above."""
    for name in IN_A_HURRY:
        monkeypatch.delenv(name)


@pytest.fixture
def figures(request):
    """figures.below(name, value, limit) reports and asserts, figures.note(name, value) reports."""
    return Figures(request.node)


class Figures:
    def __init__(self, node):
        doc = (node.function.__doc__ or "").strip().split("\n\n")[0]
        self.test = {"file": node.path.stem, "test": node.originalname, "case": node.name, "what": " ".join(doc.split())}

    def _add(self, name, value, limit, met):
        line = sys._getframe(2).f_lineno  # figures of one line of the test have one limit
        _records.append({**self.test, "line": line, "figure": name, "value": value, "limit": limit, "met": met})

    def note(self, name, value):
        self._add(name, value, None, True)

    def below(self, name, value, limit):
        value = float(value)
        self._add(name, value, float(limit), value <= limit)
        assert value <= limit, _line(_records[-1])


def _line(r):
    if r["limit"] is None:
        return f"{r['figure']}: {r['value']}"
    return f"{r['figure']}: {r['value']:.3g} (limit {r['limit']:g})"


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: takes most of a minute")
    config.addinivalue_line("markers", "long: runs with --long only")


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--long"):
        skip = pytest.mark.skip(reason="runs with --long only")
        for item in items:
            if "long" in item.keywords:
                item.add_marker(skip)


def pytest_terminal_summary(terminalreporter):
    if _records:
        terminalreporter.section("figures")
        for r in _records:
            terminalreporter.line(_line(r))
    folder = os.environ.get("MPDEM_FIGURES")
    if folder and _records:
        os.makedirs(folder, exist_ok=True)
        for file in {r["file"] for r in _records}:
            of_file = [r for r in _records if r["file"] == file]
            Path(folder, f"{file}.json").write_text(json.dumps(of_file, indent=0, default=str))
