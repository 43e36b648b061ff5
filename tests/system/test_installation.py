# SPDX-License-Identifier: GPL-2.0-or-later
"""What `cmake --install` and the Debian package put where (doc/installation.md), tried from there."""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from scenes import RING, cement, executable, launch, pair, pull, run

ROOT = Path(__file__).parents[2]
VERSION = re.search(r'kVersion = "(.*)"', (ROOT / "src/USER-MPDEM/version.h").read_text())[1]
BUILD = Path(executable()).resolve().parent
TWO_STEPS = pair(2e-4, cement=RING) + cement(4e-4, 1e-8, couple="csv 1 bond.csv") + pull(1e-2, 1e-6) + "run 2\n"

pytestmark = pytest.mark.skipif(not (BUILD / "cmake_install.cmake").is_file(), reason="this program is of no build by CMake")


def output_of(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    folder = tmp_path_factory.mktemp("installed")
    output_of("cmake", "--install", BUILD, "--prefix", folder)
    return folder


@pytest.fixture
def alone(prefix, monkeypatch):
    """The environment of one who has the installed files and not the source."""
    (package,) = prefix.glob("lib/python3*/dist-packages")
    monkeypatch.setenv("PATH", f"{prefix / 'bin'}:{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(package))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")


def check_man_page(file):
    """No warning of groff, the version, and in OPTIONS what the program takes."""
    done = subprocess.run(["man", "--warnings", "-E", "UTF-8", "-l", str(file)], capture_output=True, text=True, env={**os.environ, "MANWIDTH": "100"})
    assert done.returncode == 0 and done.stderr == "" and f"USER-MPDEM {VERSION}" in done.stdout
    assert "@" not in done.stdout
    return done.stdout


def test_program_runs_from_there(prefix, tmp_path):
    """The installed program gives the table of the built one, on one rank and on two."""
    run(TWO_STEPS, tmp_path)
    table = (tmp_path / "bond.csv").read_bytes()
    assert [line.split(b",")[0] for line in table.splitlines()] == [b"step", b"0", b"1", b"2"]
    (tmp_path / "bond.csv").unlink()
    run(TWO_STEPS, tmp_path, program=prefix / "bin/liggghts-mpdem")
    assert (tmp_path / "bond.csv").read_bytes() == table
    assert run(TWO_STEPS, tmp_path, ranks=2, program=prefix / "bin/liggghts-mpdem").status == 0


def test_python_package_and_tools(alone, prefix, tmp_path):
    """Outside of the source Python finds the package, the package finds examples and program, and each command begins."""
    script = "import mpdem; from mpdem import runner, specimen; print(mpdem.__file__, specimen.FOLDER, runner.executable('.'))"
    package, folder, program = output_of(sys.executable, "-c", script, cwd=tmp_path).split()
    assert Path(package).is_relative_to(prefix) and program == str(prefix / "bin/liggghts-mpdem")
    assert Path(folder) == (prefix / "share/liggghts-mpdem/examples/specimen").resolve() and (Path(folder) / "in.pour").is_file()
    commands = sorted(prefix.glob("bin/mpdem-*"))
    assert [c.name for c in commands] == ["mpdem-" + name for name in ("movie", "pair-table", "parameters", "picture", "plot", "specimen")]
    for command in commands:
        assert "usage" in output_of(sys.executable, command, "-h", cwd=tmp_path)


def test_a_tool_runs_an_example(alone, prefix, tmp_path):
    """mpdem-pair-table finds script and program by itself, and makes table and figure."""
    words = "--shapes flat --loads tension --contents 0.01 --set spacing=3e-4 --jobs 1".split()
    output_of(sys.executable, prefix / "bin/mpdem-pair-table", tmp_path / "out", *words, cwd=tmp_path)
    assert (tmp_path / "out/table.csv").is_file() and (tmp_path / "out/table.png").is_file()


def test_nothing_leads_to_the_source(prefix):
    """No link leaves the prefix or ends nowhere, no text names the folder of the source, and nothing of Python is compiled."""
    for path in prefix.rglob("*"):
        assert path.resolve().is_relative_to(prefix.resolve()) and path.exists(), path
        assert path.suffix != ".pyc"
        if path.is_file() and path.suffix in (".py", ".in", ".md", ""):
            assert str(ROOT).encode() not in path.read_bytes() or path.name == "liggghts-mpdem", path


@pytest.mark.skipif(not shutil.which("man") or not shutil.which("groff"), reason="man and groff are missing")
def test_man_page(prefix, tmp_path):
    """The page is formatted without a warning, and each of its options is in the program's own list."""
    text = check_man_page(prefix / "share/man/man1/liggghts-mpdem.1.gz")
    listed = launch("", tmp_path, arguments=["-h"]).output
    options = re.findall(r"^ +-(\w+)", text.split("OPTIONS")[1].split("SIGNALS")[0], re.M)
    assert len(options) == 7
    for option in options:
        assert option == "options" or f"-{option}" in listed, option


@pytest.mark.long
@pytest.mark.skipif(not (BUILD / "deb/levels/liggghts-mpdem").is_file(), reason="make deb has not been called")
def test_debian_package(tmp_path):
    """Control data, and that the programs of both instruction sets in the package give the same table."""
    output_of("cpack", "-G", "DEB", "-B", tmp_path / "packed", cwd=BUILD / "deb")
    (package,) = (tmp_path / "packed").glob("*.deb")
    assert package.name == f"liggghts-mpdem_{VERSION.replace('-', '~')}_amd64.deb"
    library, host = output_of("dpkg-query", "-W", "-f", "${Package} ${Version}", "libliggghts3").split()
    depends = output_of("dpkg-deb", "-f", package, "Depends")
    for wanted in (f"{library} (= {host})", "libc6 (>= ", "libopenmpi3 (>= ", "python3-numpy", "python3-pandas", "python3-matplotlib"):
        assert wanted in depends, wanted
    root = tmp_path / "root"
    output_of("dpkg-deb", "-x", package, root)
    check_man_page(root / "usr/share/man/man1/liggghts-mpdem.1.gz")
    assert (root / "usr/share/doc/liggghts-mpdem/copyright").is_file() and (root / "usr/lib/python3/dist-packages/mpdem/__init__.py").is_file()
    program, tables = root / "usr/bin/liggghts-mpdem", []
    for mask in ("x86-64-v3", "x86-64-v4"):
        script = tmp_path / "in.two"
        script.write_text(TWO_STEPS)
        output_of("/lib64/ld-linux-x86-64.so.2", "--glibc-hwcaps-mask", mask, program, "-in", script, cwd=tmp_path)
        tables.append((tmp_path / "bond.csv").read_bytes())
    assert tables[0] == tables[1]
