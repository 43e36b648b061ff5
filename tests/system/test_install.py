# SPDX-License-Identifier: GPL-2.0-or-later
"""src/USER-MPDEM/Install.sh, with which LIGGGHTS' own make builds the package. `make liggghts-from-source` runs the result."""
import os
import re
import shutil
import subprocess
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "src" / "USER-MPDEM"


def install(mode, package):
    subprocess.run(["sh", "Install.sh", str(mode)], cwd=package, check=True, env={**os.environ, "PWD": str(package)})


def test_every_source_and_every_style(tmp_path):
    """Each source file but those of `host` is compiled once, each style has its header, and uninstalling removes all of it."""
    (tmp_path / "lammps.cpp").touch()
    package = tmp_path / "USER-MPDEM"
    shutil.copytree(PACKAGE, package)
    install(1, package)
    made = {p.name: re.search(r'#include "(.*)"', p.read_text())[1] for p in tmp_path.iterdir() if p.suffix in (".cpp", ".h") and p.name != "lammps.cpp"}
    sources = {p.relative_to(tmp_path).as_posix() for p in package.rglob("*.cpp") if p.relative_to(package).parts[0] != "host"}
    compiled = [included for name, included in made.items() if name.endswith(".cpp")]
    assert len(sources) > 100 and sorted(compiled) == sorted(sources)
    styles = {p.name: p.relative_to(tmp_path).as_posix() for p in package.rglob("*.h") if re.search(r"^#ifdef [A-Z]+_CLASS", p.read_text(), re.M)}
    assert len(styles) >= 7 and {name: included for name, included in made.items() if name.endswith(".h")} == styles
    install(0, package)
    assert [p.name for p in tmp_path.iterdir() if p.suffix in (".cpp", ".h")] == ["lammps.cpp"]
