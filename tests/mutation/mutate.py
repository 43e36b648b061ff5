#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Plants bugs in a copy of the source and looks whether a test fails with each. See README.md beside this file.

    tests/mutation/mutate.py [--planted] [--folder build/mutation] [--seed 1] [--jobs 2] [--unit] [--fresh] ...

One program holds all mutants as switches (candidates.py, draw.py, mutant.h). First the tests run without a mutant; each
must pass, and tells which mutants it comes to. Then each mutant runs the tests that come to it, from the quickest to the
longest, those of the units first, until one fails. It may be interrupted and started again at any time.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import draw
import planted
from tests_of import SystemTests, UnitTests, end_all

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SOURCE = "src/USER-MPDEM"
EQUIVALENT = HERE / "equivalent.json"
LEAST, TOTAL = 8, 80


def say(text, keep=True):
    """A line; on a terminal one that the next replaces."""
    if keep:
        print(text, flush=True)
    elif sys.stderr.isatty():
        print(f"\r{text}\033[K", end="", flush=True, file=sys.stderr)


def files_of_the_project():
    """All that is not a product."""
    for path, folders, names in os.walk(ROOT):
        folders[:] = sorted(d for d in folders if not d.startswith(("build", ".git", "__pycache__")))
        for name in sorted(names):
            yield (Path(path) / name).relative_to(ROOT)


def digest(paths):
    h = hashlib.sha256()
    for p in sorted(paths):
        h.update(str(p).encode() + b"\0" + p.read_bytes())
    return h.hexdigest()


def write_if_new(path, data):
    if path.exists() and path.read_bytes() == data:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


class Folder:
    """The copy of the project, what is built from it, and the results."""

    def __init__(self, path, seed, jobs):
        self.path, self.seed, self.jobs = Path(path).resolve(), seed, jobs
        self.tree, self.build = self.path / "tree", self.path / "build"
        self.mutants, self.lock = [], threading.Lock()
        self.state = {}

    def load(self, fresh):
        """What is known, if it is of this source and this seed."""
        source = digest([p for p in (ROOT / SOURCE).rglob("*") if p.is_file()] + [HERE / "candidates.py", HERE / "draw.py"])
        stored = self.path / "state.json"
        if stored.exists() and not fresh:
            self.state = json.loads(stored.read_text())
        if (self.state.get("source"), self.state.get("seed")) != (source, self.seed):
            if self.state:
                say(f"mutate.py: the source or the seed is another one: results of {self.path} are dropped")
            self.state = {"source": source, "seed": self.seed, "refused": [], "tests": {}, "results": {}}

    def save(self):
        with self.lock:
            text = json.dumps(self.state, indent=1)
            new = self.path / "state.json.new"
            new.write_text(text)
            new.replace(self.path / "state.json")

    def copy(self):
        self.path.mkdir(parents=True, exist_ok=True)
        known = set()
        for name in files_of_the_project():
            known.add(name)
            if not str(name).startswith(SOURCE + "/"):
                write_if_new(self.tree / name, (ROOT / name).read_bytes())
                shutil.copymode(ROOT / name, self.tree / name)
        for path in list(self.tree.rglob("*")):
            if path.is_file() and path.relative_to(self.tree) not in known and "__pycache__" not in str(path):
                path.unlink()

    def plant(self, missing=False):
        """The mutated source into the copy, or what is missing there."""
        for name in files_of_the_project():
            if str(name).startswith(SOURCE + "/") and not (missing and (self.tree / name).exists()):
                here = [(n, c) for n, c in enumerate(self.mutants, 1) if c.path == str(name.relative_to(SOURCE))]
                write_if_new(self.tree / name, draw.switched((ROOT / name).read_bytes(), here))

    def configure(self):
        launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        self.run(["cmake", "-S", self.tree, "-B", self.build, f"-DCMAKE_CXX_FLAGS=-include {HERE}/mutant.h"] + launcher)

    def run(self, command):
        done = subprocess.run([str(w) for w in command], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"mutate.py: {' '.join(map(str, command))}:\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
        return done.stdout

    def commands(self):
        """How each file of the package is compiled, once."""
        found = {}
        for c in json.loads((self.build / "compile_commands.json").read_text()):
            if c["file"].startswith(f"{self.tree}/{SOURCE}/") and "fuzz_input" not in c.get("output", c["command"]):
                found.setdefault(c["file"], c)
        return list(found.values())

    def draw(self, least, total, new, since):
        """Mutants that compile, into the copy. new: how many more in lines that are younger than the commit `since`."""
        found, compiled_by = self.candidates()
        young = []
        if new:
            lines = draw.changed_lines(self.run(["git", "-C", ROOT / SOURCE, "diff", "--unified=0", "--relative", since, "--", "."]))
            young = [c for c in found if (c.path, c.line) in lines]
            say(f"mutate.py: {len(young)} candidates in lines that changed since {since}")
        say(f"mutate.py: {len(found)} candidates in {len({c.path for c in found})} files")
        while True:
            refused = set(self.state["refused"])
            self.mutants = draw.draw(found, self.seed, least, total, refused)
            self.mutants += draw.draw(young, self.seed, 1, new, refused, self.mutants)
            self.mutants.sort(key=lambda c: (c.path, c.start))
            self.plant()
            wrong = self.refuse(compiled_by)
            if not wrong:
                break
            self.state["refused"] += [c.key() for c in wrong]
            self.save()

    def plant_listed(self):
        """The mutants of planted.json, into the copy."""
        self.mutants = planted.mutants(ROOT / SOURCE)
        self.plant()

    def candidates(self):
        """From the source itself; reading it takes a minute or two, so the list is kept."""
        stored = self.path / "candidates.json"
        if stored.exists():
            known = json.loads(stored.read_text())
            if known["source"] == self.state["source"]:
                return [draw.Candidate(**c) for c in known["found"]], known["compiled_by"]
        original = [{k: c[k].replace(str(self.tree), str(ROOT)) for k in ("command", "file")} for c in self.commands()]
        import candidates  # needs libclang, planted bugs do not

        found, compiled_by = candidates.find(original, str(ROOT / SOURCE), say_progress)
        stored.write_text(json.dumps({"source": self.state["source"], "found": [vars(c) for c in found], "compiled_by": compiled_by}))
        return found, compiled_by

    def refuse(self, compiled_by):
        """Mutants that do not compile, found without generating code. A file is examined once."""
        seen = self.state.setdefault("compiled", {})
        todo, by_name = {}, {c["file"]: c["command"] for c in self.commands()}
        for n, c in enumerate(self.mutants, 1):
            name = compiled_by[c.path]["file"].replace(str(ROOT), str(self.tree))
            todo.setdefault(name, by_name[name])
        inside = {c.path: sorted(m.key() for m in self.mutants if m.path == c.path) for c in self.mutants}
        mark = hashlib.sha256(json.dumps(inside, sort_keys=True).encode()).hexdigest()
        if seen.get("mark") == mark:
            return []
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            outputs = list(pool.map(compile_only, todo.values()))
        wrong = []
        for output in outputs:
            if "fatal error" in output:
                sys.exit(f"mutate.py: the copy cannot be examined:\n{output[-3000:]}")
            lines = set(re.findall(rf"^{re.escape(str(self.tree / SOURCE))}/(\S+?):(\d+):\d+: (?:fatal )?error:", os_normal(output), re.M))
            here = [c for c in self.mutants for p, n in lines if c.path == p and c.line <= int(n) <= c.line + c.text.count("\n")]
            if lines and not here:
                sys.exit(f"mutate.py: the copy does not compile, for no mutant's sake:\n{output[-3000:]}")
            wrong += here
        if not wrong:
            seen["mark"] = mark
        return wrong

    def compile(self, unit_only):
        say("mutate.py: building")
        targets = [] if not unit_only else ["--target"] + sorted({t.executable.name for t in UnitTests(self).all()})
        self.run(["cmake", "--build", self.build, "--parallel", str(self.jobs)] + targets)


def say_progress(text, keep=False):
    say(text, keep)


def os_normal(text):
    """The same with a/b/../c as a/c."""
    while True:
        shorter = re.sub(r"/[^/\s:]+/\.\./", "/", text)
        if shorter == text:
            return text
        text = shorter


def compile_only(command):
    command = re.sub(r" -o \S+| -c(?= )", "", command).replace("ccache ", "", 1)
    return subprocess.run(command + " -fsyntax-only -w", shell=True, capture_output=True, text=True).stderr


# ------------------------------------------------------------------------ results


class Judge:
    """Runs mutants against the tests."""

    def __init__(self, folder, suites, most):
        self.folder, self.suites, self.most = folder, suites, most
        self.known = folder.state["tests"]
        self.equivalent = json.loads(EQUIVALENT.read_text())

    def without_mutant(self):
        for suite in self.suites:
            broken = suite.measure(self.folder.jobs)
            self.folder.save()
            if broken:
                sys.exit("mutate.py: without a mutant these tests fail; mend them first:\n  " + "\n  ".join(broken))

    def reason(self, c):
        """Why a mutant changes nothing, if somebody showed it."""
        for e in self.equivalent:
            if (e["file"], e["line"], e["change"], e["occurrence"]) == (c.path, c.content, c.change(), c.occurrence):
                return e["reason"]
        return ""

    def judge(self, number, c):
        result = self.folder.state["results"].get(c.key(), {"passed": {}})
        began = time.time()
        # What somebody argued to change nothing is not let off what is cheap: a unit test that fails shows the argument wrong.
        for suite in self.suites[:1] if self.reason(c) else self.suites:
            tests = [
                t
                for t in suite.in_order(c)
                if number in self.known[t]["reached"]
                and result["passed"].get(t) != self.known[t]["mark"]
                and (not self.most or self.known[t]["seconds"] <= self.most)
            ]
            killer, passed = suite.kill(number, tests)
            result["passed"].update({t: self.known[t]["mark"] for t in passed})  # until the test changes
            if killer:
                result = {"killer": killer}
                break
        result["seconds"] = round(time.time() - began, 1)
        with self.folder.lock:
            self.folder.state["results"][c.key()] = result
        self.folder.save()
        return result

    def all(self, only):
        mutants = [(n, c) for n, c in enumerate(self.folder.mutants, 1) if not only or n in only]
        todo = [(n, c) for n, c in mutants if "killer" not in self.folder.state["results"].get(c.key(), {})]
        began, done = time.time(), 0
        with concurrent.futures.ThreadPoolExecutor(self.folder.jobs) as pool:
            waiting = {pool.submit(self.judge, n, c): (n, c) for n, c in todo}
            for future in concurrent.futures.as_completed(waiting):
                n, c = waiting[future]
                result, done = future.result(), done + 1
                left = (time.time() - began) / done * (len(todo) - done) / 60
                end = (
                    f"killed by {result['killer']}"
                    if "killer" in result
                    else "changes nothing"
                    if self.reason(c)
                    else f"SURVIVES {len(result['passed'])} tests"
                )
                say(f"[{done}/{len(todo)}] {n} {c.path}:{c.line} {c.change()}: {end} ({result['seconds']} s; about {left:.0f} min left)")

    def table(self):
        rows = []
        for n, c in enumerate(self.folder.mutants, 1):
            r = self.folder.state["results"].get(c.key(), {})
            outcome = "killed" if "killer" in r else "changes nothing" if self.reason(c) else "survives" if "passed" in r else "not run"
            rows.append(
                {
                    "number": n,
                    "folder": draw.folder(c),
                    "file": c.path,
                    "line": c.line,
                    "content": c.content,
                    "operator": c.operator,
                    "change": c.change(),
                    "outcome": outcome,
                    "seed": self.folder.seed,
                    "by": r.get("killer") or self.reason(c),
                    "reached": sum(n in t["reached"] for t in self.known.values()),
                }
            )
        return rows


def end(by, _):
    end_all()
    say(f"mutate.py: ended by {signal.Signals(by).name}; start it again to go on")
    os._exit(1)


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    p.add_argument("--planted", action="store_true", help="the bugs of planted.json instead of those that are drawn")
    p.add_argument("--folder", help="where it works; build/mutation, or build/planted with --planted")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--jobs", type=int, default=2, help="tests at a time")
    p.add_argument("--least", type=int, default=LEAST, help="mutants of a folder of the source")
    p.add_argument("--total", type=int, default=TOTAL)
    p.add_argument("--new", type=int, default=0, help="so many more in lines that changed since the commit of --since")
    p.add_argument("--since", default="", help="a commit")
    p.add_argument("--unit", action="store_true", help="unit tests alone")
    p.add_argument("--tests", default="", help="of the other tests, those that this pattern finds")
    p.add_argument("--most", type=float, default=0.0, help="leave out tests that take more seconds")
    p.add_argument("--only", type=int, nargs="+", help="numbers of mutants, killed or not")
    p.add_argument("--list", action="store_true", help="draw, list and end")
    p.add_argument("--fresh", action="store_true", help="forget all results")
    p.add_argument("--json", help="build/figures/mutants.json, for tools/reliability.py, or planted.json in the folder with --planted")
    given = p.parse_args()
    if bool(given.new) != bool(given.since):
        p.error("--new and --since need each other")
    if given.new and given.planted:
        p.error("--planted draws no others; leave --new out")
    for by in (signal.SIGTERM, signal.SIGINT):
        signal.signal(by, end)

    folder = Folder(given.folder or ROOT / "build" / ("planted" if given.planted else "mutation"), given.seed, given.jobs)
    table = Path(given.json) if given.json else folder.path / "planted.json" if given.planted else ROOT / "build" / "figures" / "mutants.json"
    folder.load(given.fresh)
    folder.copy()
    folder.plant(missing=True)
    folder.configure()
    if given.planted:
        folder.plant_listed()
    else:
        folder.draw(given.least, given.total, given.new, given.since)
    folder.save()
    if given.list:
        for n, c in enumerate(folder.mutants, 1):
            say(f"{n:3} {c.path}:{c.line} {c.operator}: {c.change()}\n      {c.content}")
        return
    folder.compile(given.unit)
    suites = [UnitTests(folder)] + ([] if given.unit else [SystemTests(folder, given.tests)])
    judge = Judge(folder, suites, given.most)
    judge.without_mutant()
    judge.all(given.only)
    rows = judge.table()
    table.parent.mkdir(parents=True, exist_ok=True)
    table.write_text(json.dumps(rows, indent=1))
    count = {o: sum(r["outcome"] == o for r in rows) for o in ("killed", "changes nothing", "survives", "not run")}
    say("mutate.py: " + ", ".join(f"{n} {o}" for o, n in count.items()) + f"; {table}")
    for r in rows:
        if r["outcome"] == "survives":
            say(f"  {r['number']} {r['file']}:{r['line']} {r['change']}; {r['reached']} tests come to it\n      {r['content']}")
    sys.exit(1 if count["survives"] or count["not run"] else 0)


if __name__ == "__main__":
    main()
