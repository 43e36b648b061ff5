# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""The tests of the copy: which there are, what they come to without a mutant, and whether one fails with a mutant."""
import concurrent.futures
import hashlib
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MEMORY, DISK = 12 << 30, 1 << 30  # of a process, bytes: a mutant may ask for anything
HURRY = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_pml": "ob1",
    "OMPI_MCA_btl": "self,vader",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "GTEST_COLOR": "no",
}


RUNNING = set()  # processes, each the first of a group


def end_all():
    """What was started ends what it started itself, which is in sessions of its own, when it is interrupted."""
    for process in list(RUNNING):
        try:
            os.killpg(process.pid, signal.SIGINT)
        except ProcessLookupError:
            pass


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (DISK, DISK))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def execute(command, folder, seconds, **environment):
    """Status (None: it had to be ended) and output."""
    with tempfile.TemporaryFile("w+", errors="replace") as out:
        process = subprocess.Popen(
            list(map(str, command)),
            cwd=folder,
            stdout=out,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            env={**os.environ, **HURRY, **environment},
            start_new_session=True,
            preexec_fn=limits,
        )
        RUNNING.add(process)
        try:
            status = process.wait(seconds)
        except subprocess.TimeoutExpired:
            status = None
            for by in (signal.SIGINT, signal.SIGKILL):  # pytest ends what it started when it is interrupted
                try:
                    os.killpg(process.pid, by)
                    process.wait(20)
                    break
                except (ProcessLookupError, subprocess.TimeoutExpired):
                    continue
        RUNNING.discard(process)
        out.seek(0)
        return status, out.read()


class Unit:
    def __init__(self, name, command, executable):
        self.name, self.command, self.executable = name, command, executable


class UnitTests:
    """Programs of GoogleTest."""

    def __init__(self, folder):
        self.folder, self.known = folder, folder.state["tests"]
        self.made = {}

    def all(self):
        if not self.made:
            shown = json.loads(self.folder.run(["ctest", "--test-dir", self.folder.build, "--show-only=json-v1"]))
            for t in shown["tests"]:
                name = re.sub(r"_NOT_BUILT$", "", t["name"])
                labels = [p["value"] for p in t.get("properties", []) if p["name"] == "LABELS"]
                if "command" in t and (["unit"] in labels):
                    program = next(Path(w) for w in t["command"] if "/tests/unit/" in w and not w.startswith("-"))
                    alone = Path(t["command"][0]) == program
                    name = program.name if alone else name
                    self.made[name] = Unit(name, [str(program)] if alone else t["command"], program)
                elif name.startswith("test_"):  # not built yet: gtest_discover_tests
                    self.made[name] = Unit(name, [], self.folder.build / "tests/unit" / name)
        return list(self.made.values())

    def measure(self, jobs):
        self.made = {}  # they are built now
        broken = []
        for t in self.all():
            mark = hashlib.sha256(t.executable.read_bytes()).hexdigest()
            if self.known.get(t.name, {}).get("mark") == mark:
                continue
            folder = tempfile.mkdtemp()
            began = time.time()
            status, output = execute(t.command, self.folder.build, 1200, MPDEM_MUTANTS_REACHED=folder)
            if status != 0:
                broken.append(f"{t.name}: {output[-500:]}")
                continue
            self.known[t.name] = {"seconds": time.time() - began, "reached": sorted(map(int, os.listdir(folder))), "mark": mark}
            shutil.rmtree(folder)
        return broken

    def in_order(self, candidate):
        return sorted((t.name for t in self.all()), key=lambda n: self.known[n]["seconds"])

    def kill(self, number, tests):
        passed = []
        for name in tests:
            t = self.made[name]
            status, output = execute(t.command + ["--gtest_fail_fast"], self.folder.build, 30 + 8 * self.known[name]["seconds"], MPDEM_MUTANT=str(number))
            if status != 0:
                failed = re.search(r"\[  FAILED  \] ([\w./]+)", output)
                started = re.findall(r"\[ RUN      \] ([\w./]+)", output)
                what = failed[1] if failed else started[-1] if started else "at its start"
                how = "" if failed else ", which does not end" if status is None else ", which crashes"
                return f"{name}: {what}{how}", passed
            passed.append(name)
        return "", passed


class SystemTests:
    """Tests of pytest, in files whose runs may be interrupted in between."""

    CHUNK = 60.0  # seconds of tests in one start of pytest

    def __init__(self, folder, pattern):
        self.folder, self.known, self.pattern = folder, folder.state["tests"], pattern
        self.environment = {
            "MPDEM_EXE": str(folder.build / "liggghts-mpdem"),
            "MPDEM_FIGURES": "",
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONPATH": str(Path(__file__).parent),
        }

    def pytest(self, arguments, seconds, **environment):
        temporary = tempfile.mkdtemp()
        try:
            return execute(
                [sys.executable, "-B", "-m", "pytest", "-p", "no:cacheprovider", "-p", "reach", f"--basetemp={temporary}/t", *arguments],
                self.folder.tree / "tests",
                seconds,
                **self.environment,
                **environment,
            )
        finally:
            shutil.rmtree(temporary, ignore_errors=True)

    def files(self):
        """Not the tests of this tool, which look at the source as it is."""
        return [f for kind in ("system", "stability") for f in sorted((self.folder.tree / "tests" / kind).glob("test_*.py")) if f.name != "test_mutation.py"]

    def measure(self, jobs):
        """Tests of files that changed. A test that is skipped here is none."""
        marks = self.folder.state.setdefault("files", {})
        program = hashlib.sha256((self.folder.build / "liggghts-mpdem").read_bytes()).hexdigest()
        todo = []
        for f in self.files():
            mark = hashlib.sha256(f.read_bytes() + program.encode() + self.pattern.encode()).hexdigest()
            if marks.get(f.name) != mark:
                todo.append((f, mark))
        broken = []

        def one(f, mark):
            name = str(f.relative_to(self.folder.tree / "tests"))  # as pytest calls it
            _, listed = self.pytest(["--collect-only", "-q", name], 120)
            tests = [line for line in listed.splitlines() if line.startswith(name + "::") and re.search(self.pattern, line)]
            with tempfile.NamedTemporaryFile("r") as records:
                status, output = self.pytest(["-q", *tests], 3600, MPDEM_REACH_RECORDS=records.name) if tests else (0, "")
                rows = [json.loads(line) for line in records]
            if status != 0 or (tests and not rows):
                return [f"{name}: {(output or listed)[-1500:]}"]
            with self.folder.lock:
                for t in [t for t in self.known if t.startswith(name + "::")]:
                    del self.known[t]
                for r in rows:
                    if r["outcome"] == "passed":
                        self.known[r.pop("test")] = {**r, "mark": mark}
                marks[f.name] = mark
            self.folder.save()
            if rows:
                print(f"mutate.py: {name}: {len(rows)} tests pass without a mutant", flush=True)
            return []

        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            for trouble in pool.map(lambda x: one(*x), todo):
                broken += trouble
        return broken

    def in_order(self, candidate):
        """First files that speak of what the source file is called; the quickest first."""
        words = [w for w in re.split(r"[/_.]", candidate.path) if len(w) > 3 and w not in ("styles", "host", "material")]
        text = {f.name: f.read_text() for f in self.files()}
        names = {f: any(w in t for w in words[1:] or words) for f, t in text.items()}

        def rank(test):
            return not names.get(test.split("::")[0].split("/")[-1], False), self.known[test]["seconds"]

        return sorted((t for t in self.known if "::" in t and re.search(self.pattern, t)), key=rank)

    def kill(self, number, tests):
        passed, at = [], 0
        while at < len(tests):
            chunk, length = [], 0.0
            while at < len(tests) and (not chunk or length + self.known[tests[at]]["seconds"] <= self.CHUNK):
                length += self.known[tests[at]]["seconds"]
                chunk.append(tests[at])
                at += 1
            status, output = self.pytest(["-x", "-v", *chunk], 120 + 8 * length, MPDEM_MUTANT=str(number))
            if status != 0:
                failed = re.findall(r"^(?:FAILED|ERROR) (\S+::\S+)", output, re.M) or re.findall(r"^(\S+::.*?) FAILED", output, re.M)
                started = re.findall(r"^(\S+::\S+)", output, re.M)
                killer = next((t for t in (failed or started[-1:]) if t in chunk), chunk[0])
                # A busy machine is no bug: the test passes without the mutant.
                if self.pytest(["-q", killer], 120 + 8 * self.known[killer]["seconds"])[0] == 0:
                    return killer + ("" if failed else ", which does not end"), passed
                print(f"mutate.py: {killer} fails now and then, without a mutant, too", flush=True)
                at -= len(chunk) - chunk.index(killer) - 1
                chunk = chunk[: chunk.index(killer) + 1]
            passed += chunk
        return "", passed
