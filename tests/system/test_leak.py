# SPDX-License-Identifier: GPL-2.0-or-later
"""Memory of a process that makes and takes down cement again and again."""
import os
import re
from pathlib import Path

from scenes import cement, executable, pair, point_quantities, pull, run

TIMES = 50
ALLOWED = 200e3  # bytes a round: the allocator keeps now more, now less, up to 5 MB; the cement of a round takes 3.4 MB
CELL, DT = 2e-4, 2e-9
# The process is the first above the shell that has its name.
NOTE_RESIDENT = """\
p=$$
while [ $p -gt 1 ] && ! grep -q ^NAME$ /proc/$p/comm; do p=$(sed -n 's/^PPid:[^0-9]*//p' /proc/$p/status); done
grep VmRSS /proc/$p/status >> resident.txt
"""


def rounds(lines):
    # Variables outlive `clear` and cannot be defined twice.
    lines = "".join(line if not line.startswith("variable") else f"variable {line.split()[1]} delete\n{line}" for line in lines.splitlines(True))
    return f"label again\nvariable round loop {TIMES}\n{lines}shell sh resident.sh\nclear\nnext round\njump SELF again\n"


def lost(directory, script):
    """Bytes a round between the 5th round and the last, and the whole before the last `clear`."""
    directory.mkdir()
    (directory / "resident.sh").write_text(NOTE_RESIDENT.replace("NAME", Path(executable()).name[:15]))
    run(script, directory)
    resident = [1024.0 * int(kb) for kb in re.findall(r"VmRSS:\s*(\d+) kB", (directory / "resident.txt").read_text())]
    assert len(resident) == TIMES
    return (resident[-1] - resident[4]) / (TIMES - 5), resident[-1]


def test_create_run_clear(tmp_path, figures, monkeypatch):
    # AddressSanitizer keeps what was freed, 256 MB if not told otherwise.
    monkeypatch.setenv("ASAN_OPTIONS", os.environ.get("ASAN_OPTIONS", "") + ":quarantine_size_mb=4:thread_local_quarantine_size_kb=64")
    scene = (
        pair(1e-4)
        + cement(CELL, DT, damage="damage tensor B0 9.6e3 events events.csv", couple="kn auto kt auto csv 10 bond.csv")
        + pull(0.05, 1e-6)
        + point_quantities(["damage", "stress_zz"])
        + "fix ts all check/timestep/mpm 10 cem 0.9 warn\nrun 20\n"
    )
    host = scene[: scene.index("create_cement")]
    per_round, resident = lost(tmp_path / "cement", rounds(scene))
    # LIGGGHTS' own share: the same without the cement.
    own, _ = lost(tmp_path / "host", rounds(host + "timestep 1e-9\nfix move grains nve/sphere\nrun 20\n"))
    figures.note("leak", f"LIGGGHTS alone: {own / 1e3:.3g} kB a round of create, run, clear; resident {resident / 1e6:.3g} MB")
    figures.below(f"create, run, clear, {TIMES} times: growth of resident memory a round, kB", per_round / 1e3, ALLOWED / 1e3)


def test_grains_that_come_and_go(tmp_path, figures):
    """A pair that moves from rank to rank leaves no memory in use where it was."""
    speed = 2e5  # passes a rank in three steps
    script = pair(2e-4, boundary="p f f", processors="* 1 1", cement="outer 1.6e-3")
    script = script.replace("include grains delay 0", "include grains every 1 delay 0 check no") + cement(4e-4, 1e-8)
    script += f"velocity all set {speed} 0 0\nfix on grains move linear {speed} 0 0\nthermo 1000\n" "run 200\nrun 1500\nrun 0\n"
    done = run(script, tmp_path, 2)
    used = [float(m) for m in re.findall(r"Memory usage per processor = (\S+) Mbytes", done.output)]
    assert len(used) == 3
    figures.below("memory of a rank through which a pair goes 250 times: growth, bytes", 1048576 * (used[2] - used[1]), 5e3)
