# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Runs of LIGGGHTS side by side, resumed where they were stopped.

A run is an object with

    label       its name, and that of its folder
    arguments   variables of its script, by name; a list is one of several values
    script      path of the script
    includes    paths of the files that the script includes
    cost        about proportional to the time it takes
    needs       the runs that have to be finished before it
    command(exe, ranks)
    results(folder)     what it gave, a dict; raises Trouble
    told(results)       the same in a line
    progress(folder)    how far it is, in a few words
    share(folder)       the share of it that is done
    resumes             whether it goes on from what is in its folder (no, if there is no such attribute)

Each has a folder; `done.json` in it, written last, holds its parameters and results. A run whose `done.json` is of the
same parameters and script, and of the same of all that it needs, is not run again. One that resumes keeps its folder
when it is launched again with what `begun.json` holds.
"""
import argparse
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

from .run import Trouble

EVERY = 15.0  # s between lines of progress


def at_least_one(text):
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a whole number of at least 1")
    return int(text)


def executable(root):
    """That of the build in the folder `root`, the installed one if there is none."""
    built = os.path.join(root, "build", "liggghts-mpdem")
    return built if os.path.exists(built) else shutil.which("liggghts-mpdem") or built


def add_arguments(parser, root):
    """Options of how runs are made: how many at a time, on how many ranks, by which executable."""
    parser.add_argument("--jobs", metavar="N", type=at_least_one, help="runs at a time (default: cores over ranks)")
    parser.add_argument("--ranks", metavar="N", type=at_least_one, default=1, help="ranks of a run (1)")
    parser.add_argument("--exe", metavar="FILE", default=executable(root), help="the executable")


def check_executable(args):
    if not os.access(args.exe, os.X_OK):
        raise Trouble(f"{args.exe}: no such executable; build it (make) or name it with --exe")


def make_runs(args, out, runs):
    """Makes the runs in the folder `out` as the options of `add_arguments` say. The Runner, and whether it was stopped."""
    signal.signal(signal.SIGTERM, stop)
    jobs = args.jobs or max((os.cpu_count() or 1) // args.ranks, 1)
    runner = Runner(os.path.abspath(out), runs, os.path.abspath(args.exe), jobs, args.ranks)
    try:
        runner.go()
    except KeyboardInterrupt:
        return runner, True
    return runner, False


def tell_end(program, runner, stopped):
    """Ends the program with a message if runs were stopped or failed."""
    if stopped:
        sys.exit(f"{program}: stopped; the same command goes on from here")
    if runner.failed:
        raise Trouble(
            f"{len(runner.failed)} of {len(runner.all)} runs failed; correct them and call again: "
            + "; ".join(f"{r.label}: {why}" for r, why in runner.failed[:3])
        )


def stop(*_):
    raise KeyboardInterrupt


def command(exe, script, ranks, arguments):
    words = [exe, "-in", script]
    for k, v in arguments.items():
        words += ["-var", k, *(v if isinstance(v, list) else [v])]
    return (["mpirun", "--oversubscribe", "--bind-to", "none", "-np", str(ranks)] if ranks > 1 else []) + words


def stamp(run):
    digest = hashlib.sha256()
    for path in (run.script, *run.includes):
        with open(path, "rb") as f:
            digest.update(f.read())
    text = {"arguments": run.arguments, "script": digest.hexdigest()[:16]}
    if run.needs:
        text["needs"] = [stamp(n) for n in run.needs]
    return text


def finished(out, run):
    """The results of a run that was finished with these parameters, else None."""
    done = read(os.path.join(out, run.label, "done.json")) or {}
    return done["results"] if done.get("stamp") == stamp(run) else None


def read(path):
    """What is in a file of JSON, None if there is none."""
    try:
        with open(path) as f:
            return json.load(f)
    except (OSError, ValueError):
        return None


def time_left(seconds):
    return f"{seconds / 60:.0f} min" if seconds > 90 else f"{seconds:.0f} s"


class Runner:
    """Keeps `jobs` runs going; `go` returns how many failed. Stopped by SIGINT or SIGTERM, it stops them."""

    def __init__(self, out, runs, exe, jobs, ranks):
        self.out, self.exe, self.jobs, self.ranks = out, exe, jobs, ranks
        self.done = {r.label for r in runs if finished(out, r) is not None}
        self.waiting = [r for r in runs if r.label not in self.done]
        self.skipped = len(runs) - len(self.waiting)
        self.all, self.active, self.failed, self.spent, self.start = runs, [], [], 0.0, time.time()
        self.wake = 0.0

    def go(self):
        say(
            f"{len(self.all)} runs, {self.skipped} finished before, {len(self.waiting)} to do, "
            f"{self.jobs} at a time on {self.ranks} rank{'s' * (self.ranks > 1)} each"
        )
        # the longest first, so that none is left alone at the end
        self.waiting.sort(key=lambda r: -r.cost)
        self.total = sum(r.cost for r in self.waiting)
        try:
            while self.waiting or self.active:
                while len(self.active) < self.jobs and (ready := self.ready()):
                    self.waiting.remove(ready)
                    self.launch(ready)
                if not self.active:
                    break  # what waits needs what failed
                time.sleep(0.1)
                for item in list(self.active):
                    if item["process"].poll() is not None:
                        self.active.remove(item)
                        self.finish(item)
                if self.active and time.time() > self.wake:
                    self.wake = time.time() + EVERY
                    self.progress()
        finally:
            for item in self.active:
                os.killpg(item["process"].pid, signal.SIGKILL)  # it begins anew or from its last checkpoint, so it need not save anything
            for item in self.active:
                item["process"].wait()
                item["out"].close()
        self.failed += [(r, "needs a run that failed") for r in self.waiting]
        return len(self.failed)

    def ready(self):
        return next((r for r in self.waiting if all(n.label in self.done for n in r.needs)), None)

    def launch(self, run):
        folder = os.path.join(self.out, run.label)
        begun = os.path.join(folder, "begun.json")
        if not getattr(run, "resumes", False) or read(begun) != stamp(run):
            shutil.rmtree(folder, ignore_errors=True)
            os.makedirs(folder)
            with open(begun, "w") as f:
                json.dump(stamp(run), f)
        out = open(os.path.join(folder, "out.txt"), "w")
        environment = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", **os.environ}
        process = subprocess.Popen(
            run.command(self.exe, self.ranks),
            cwd=folder,
            stdout=out,
            env=environment,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )
        self.active.append({"run": run, "process": process, "out": out, "folder": folder, "since": time.time()})

    def finish(self, item):
        item["out"].close()
        run, folder, wall = item["run"], item["folder"], time.time() - item["since"]
        self.spent += run.cost
        with open(os.path.join(folder, "out.txt"), errors="replace") as f:
            text = f.read()
        trouble = error_of(text)
        if item["process"].returncode or trouble or "\nRESULT " not in text:
            self.failed.append((run, trouble or f"ended with status {item['process'].returncode}; see {os.path.join(folder, 'out.txt')}"))
            say(f"{self.count()} FAILED {run.label}: {self.failed[-1][1]}")
            return
        try:
            results = run.results(folder)
        except Trouble as t:
            self.failed.append((run, str(t)))
            say(f"{self.count()} FAILED {run.label}: {t}")
            return
        results["wall"] = wall
        text = json.dumps({"stamp": stamp(run), "results": results}, indent=1, default=float)
        with open(os.path.join(folder, "done.tmp"), "w") as f:
            f.write(text)
        os.replace(os.path.join(folder, "done.tmp"), os.path.join(folder, "done.json"))
        self.done.add(run.label)
        say(f"{self.count()} {run.label}: {run.told(results)}, {wall:.0f} s{self.left()}")

    def count(self):
        done = len(self.all) - len(self.waiting) - len(self.active)
        return f"[{done}/{len(self.all)}]"

    def left(self):
        spent = self.spent + sum(item["run"].cost * item["run"].share(item["folder"]) for item in self.active)
        if not self.waiting and not self.active or not spent:
            return ""
        seconds = (time.time() - self.start) * max(self.total / spent - 1, 0.0)
        return f"; about {time_left(seconds)} left"

    def progress(self):
        say(f"{self.count()} running: {'; '.join(i['run'].label + ' ' + i['run'].progress(i['folder']) for i in self.active)}{self.left()}")


def error_of(text):
    """The message of the first error in the output of LIGGGHTS, in one line: up to the file and line of its source if it has several lines."""
    found = re.search(r"^ERROR(?:.*\n){0,12}?.*\([^()\n]*:\d+\) *$", text, re.M) or re.search(r"^ERROR.*$", text, re.M)
    return " ".join(found[0].split()) if found else ""


def say(text):
    print(text, flush=True)
