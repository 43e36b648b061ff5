# SPDX-License-Identifier: GPL-2.0-or-later
"""One version: what the program prints, the changelog and the citation say the same."""
import re
from pathlib import Path

import pytest
from scenes import RING, hosted, launch, pair, restarted, run

ROOT = Path(__file__).parents[2]
VERSION = re.search(r'kVersion = "(.*)"', (ROOT / "src/USER-MPDEM/version.h").read_text())[1]


def yaml_value(key):
    """Of a top-level key of CITATION.cff, which has one line each for those that are asked for here."""
    return re.search(rf"^{key}: *\"?(.*?)\"?$", (ROOT / "CITATION.cff").read_text(), re.M)[1]


@pytest.mark.skipif(not hosted(), reason="a LIGGGHTS of its own has no list of packages")
def test_help_names_it(tmp_path):
    assert f"USER-MPDEM {VERSION}" in launch("", tmp_path, arguments=["-h"]).output


def test_screen_and_log_name_it_once(tmp_path):
    line = f"USER-MPDEM {VERSION}"
    for script in (pair(1e-4, cement=RING) + "write_restart scene.restart\n", restarted("scene.restart")):
        result = run(script, tmp_path, ranks=2)
        assert result.output.splitlines().count(line) == 1
        assert (tmp_path / "log.liggghts").read_text().splitlines().count(line) == 1


def test_changelog_and_citation_agree():
    heads = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    if VERSION.endswith("-dev"):  # what is to be released as this stands on top
        assert heads[0] == f"Unreleased ({VERSION})", heads
    else:
        assert re.fullmatch(rf"{re.escape(VERSION)} \(\d{{4}}-\d\d-\d\d\)", heads[0]), heads
    assert yaml_value("version") == VERSION
    assert yaml_value("cff-version") == "1.2.0"
    assert yaml_value("license") == "GPL-2.0-or-later"


def test_license_is_the_whole_text():
    text = (ROOT / "LICENSE").read_text()
    assert "GNU GENERAL PUBLIC LICENSE\n                       Version 2, June 1991" in text
    assert text.rstrip().endswith("Public License instead of this License.") and len(text) > 17000
