# SPDX-License-Identifier: GPL-2.0-or-later
"""What tools/option_conditions.py counts, and that one option asks about another no more often than it does now."""
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import option_conditions  # noqa: E402

# Of this tree. They go down with each change that spares a condition. Contact with condensed bonds and films took ten, elastic grains six.
MOST, MOST_OF_SEVERAL = 222, 18

TREE = {
    "cement/bond/options.h": """\
struct CementOptions {
  bool split = false, updated = false;  // if (split) is no condition here
  int mass_order = 1;
  bool tears() const { return split; }
  bool hard() const { return tears() && size > 1; }
  double bound() const { return (updated ? 2.0 : 4.0) / size; }
};
""",
    "cement/use.cpp": """\
void use(const CementOptions& o) {
  if (o.split) f(o.updated, "o.updated ? 1 : 2");
  const bool apart = o.split;
  g(o.mass_order, o.split);
  while (!done && apart) h();
  for (int i = 0; i < 3; ++i) k(o.hard() ? 1 : 2, o.bound());
  for (const Bond& b : bonds.resolved()) m(b);
  const double x = o.updated && o.mass_order > 1 ? 1.0 : 2.0;
}
bool other(const CementOptions& o) {
  return o.unilateral;
}
bool apart(bool apart) { return apart; }
bool wide(const CementOptions& o) { return o.tied; }
void local(const CementOptions& o) { if (wide(o)) f(); }
""",
    "cement/elsewhere.cpp": "void local(const Wide& w) {\n  if (wide(w)) f();  // another function of that name\n}\n",
    "cement/failure/node_splitting.cpp": "void own(const CementOptions& o) {\n  if (o.split) f();\n}\n",
}


def test_the_count(tmp_path):
    for name, text in TREE.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    found, _ = option_conditions.conditions(tmp_path)
    lines = {name: sorted((Path(file).name, line) for file, line in of_option) for name, of_option in found.items() if of_option}
    assert lines == {
        "split": [("options.h", 4), ("options.h", 5), ("use.cpp", 2), ("use.cpp", 5), ("use.cpp", 6)],
        "updated, transfers, reprojects": [("options.h", 6), ("use.cpp", 6), ("use.cpp", 8)],
        "unilateral": [("use.cpp", 11)],
        "mass_order": [("use.cpp", 8)],
        "tied": [("use.cpp", 14), ("use.cpp", 15)],
    }
    assert {line for _, line in option_conditions.of_several(found)} == {6, 8}


def test_options_ask_no_more():
    found, _ = option_conditions.conditions(ROOT / "src")
    counts = {name: len(lines) for name, lines in found.items()}
    assert min(counts.values()) > 0, counts  # each pattern finds something
    assert sum(counts.values()) <= MOST, counts
    assert len(option_conditions.of_several(found)) <= MOST_OF_SEVERAL


def test_the_command(tmp_path):
    def command(*words):
        return subprocess.run([sys.executable, str(ROOT / "tools" / "option_conditions.py"), *words], capture_output=True, text=True)

    rows = command("--csv").stdout.splitlines()
    assert rows[0] == "option,conditions,files" and rows[-1].startswith("lines of several,")
    assert "styles/" in command("-v").stdout
    assert "name the folder" in command(str(tmp_path)).stderr
