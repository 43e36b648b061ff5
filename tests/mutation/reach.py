# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Plug-in of pytest: how long each test takes, how it ends, and which mutants it comes to.

Into the file MPDEM_REACH_RECORDS, a line of JSON a test; the folder is that of mutant.h.
"""
import json
import os
import shutil
import tempfile

import pytest

_outcome = {}


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    records = os.environ.get("MPDEM_REACH_RECORDS")
    if not records:
        yield
        return
    folder = os.environ["MPDEM_MUTANTS_REACHED"] = tempfile.mkdtemp()
    _outcome.clear()
    yield
    with open(records, "a") as f:
        print(json.dumps({"test": item.nodeid, "reached": sorted(map(int, os.listdir(folder))), **_outcome}), file=f)
    shutil.rmtree(folder)


def pytest_runtest_logreport(report):
    _outcome["seconds"] = _outcome.get("seconds", 0.0) + report.duration
    if report.when == "call" or report.outcome != "passed":
        _outcome["outcome"] = report.outcome
