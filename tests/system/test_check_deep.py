# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/check_deep.py runs what has not passed with the files as they are, and fails if a piece does."""
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import check_deep  # noqa: E402


@pytest.fixture
def repository(tmp_path):
    root = tmp_path / "repository"
    root.mkdir()
    subprocess.run(["git", "init", "-q", root], check=True)
    for name, text in (("a.cpp", "one"), ("page.md", "one"), (".gitignore", "build*/\n")):
        (root / name).write_text(text)
    return root


def test_goes_on(repository, capsys):
    """Pieces that passed are kept while the files are the same; one that fails is run again, and is told."""
    ran, folder = repository.parent / "ran", repository / "build" / "check-deep"
    pieces = {
        name: f"echo {name} >> {ran}; {then}"
        for name, then in (("test", "true"), ("broken", f"echo the reason; test -e {ran}.mended"), ("last", "echo told > build/out"))
    }

    def run():
        ran.write_text("")
        return check_deep.check(repository, folder, pieces), ran.read_text().split()

    assert run() == (["broken"], ["test", "broken", "last"])
    said = capsys.readouterr().out
    assert "the reason" in said and "broken: FAILED" in said and "last: passed" in said
    assert run() == (["broken"], ["broken"])
    Path(f"{ran}.mended").touch()
    assert run() == ([], ["broken"]) and run() == ([], [])
    (repository / "page.md").write_text("two")
    assert run() == ([], ["test"])
    (repository / "a.cpp").write_text("two")
    assert run() == ([], ["test", "broken", "last"])
    (repository / "new.cpp").write_text("three")
    (repository / "a.cpp").unlink()
    assert run() == ([], ["test", "broken", "last"])
    pieces["last"] = "echo four > new.cpp"
    (repository / "page.cpp").write_text("five")
    assert run()[0] == ["last"], "a piece during which the files change is one of no state"


def test_pieces():
    """Every stability test and every test of the preset is in a piece."""
    known = check_deep.pieces(ROOT, "build", 2)
    names = [p.stem[5:] for p in (ROOT / "tests" / "stability").glob("test_*.py")]
    assert {n for n in known if n.startswith("long.")} == {f"long.{n}" for n in names} and len(names) > 5
    strides = [c.split()[-1] for n, c in known.items() if n.startswith("sanitize.") and n != "sanitize.build"]
    assert strides == [f"{k + 1},,{len(strides)}" for k in range(len(strides))]


def call(*words):
    return subprocess.run([ROOT / "tools" / "check_deep.py", "--build", *words], capture_output=True, text=True)


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="git tells which files there are")
def test_status(tmp_path):
    """A piece that fails is the status of the program; a piece that does not exist is named."""
    done = call(tmp_path, "sanitize")
    assert done.returncode == 2 and "'sanitize'" in done.stderr and "sanitize.build" in done.stderr
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "test_a.json").write_text("nonsense")
    done = call(tmp_path, "tables")
    assert done.returncode == 1 and "1 of 1 pieces failed: tables" in done.stderr and "holds no figures of tests" in done.stdout, done.stdout + done.stderr


def test_what_it_runs_ends_with_it(tmp_path):
    waits = (
        f"import check_deep, pathlib, signal, sys; signal.signal(signal.SIGTERM, lambda *_: sys.exit(3)); "
        f"check_deep.passes('sleep 100 & echo $! > pid; mv pid there; wait', pathlib.Path({str(tmp_path)!r}), {str(tmp_path / 'out')!r})"
    )
    process = subprocess.Popen([sys.executable, "-c", waits], cwd=ROOT / "tools")
    there = tmp_path / "there"
    for _ in range(200):
        if there.exists():
            break
        time.sleep(0.05)
    pid = int(there.read_text())
    process.send_signal(signal.SIGTERM)
    assert process.wait(30) == 3
    for _ in range(100):
        if not os.path.exists(f"/proc/{pid}") or "State:\tZ" in Path(f"/proc/{pid}/status").read_text():
            return
        time.sleep(0.05)
    raise AssertionError("what it ran goes on")
