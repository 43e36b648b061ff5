# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Reading what a run leaves as pandas tables: tables of bonds, events and curves, text dumps, point files, the log.

A run may still be writing: a last line without an end is left out. What cannot be read raises Trouble, one line with the file and the cure."""
import csv
import glob
import io
import os
import re
from typing import Any, Dict, Iterator, List, Tuple

import numpy as np
import pandas as pd

TEXTS = ("mode", "mode_ahead", "shape", "parameters", "test", "kind", "label")  # columns that are no numbers
WHOLE = ("step", "bond", "point", "grain", "grain1", "grain2")


class Trouble(Exception):
    """One line for the user: the file and the cure."""


def whole_lines(path: str) -> str:
    """The text of a file up to its last whole line."""
    try:
        with open(path, newline="", errors="replace") as f:
            text = f.read()
    except OSError as e:
        raise Trouble(f"{path}: {e.strerror}; check the folder, or run again") from None
    return text[: text.rfind("\n") + 1]


def read(path: str, texts: Tuple[str, ...] = TEXTS) -> pd.DataFrame:
    """A table with a line of columns, separated by commas. It may have no rows yet. texts: columns that are no numbers."""
    lines = csv.reader(whole_lines(path).replace("\0", "?").splitlines())
    head = [h.strip() for h in next(lines, [])]
    if not any(head):
        raise Trouble(f"{path}: empty; let the run get past its setup, or run again")
    rows = []
    for row in lines:
        if len(row) != len(head):
            raise Trouble(f"{path}: line {lines.line_num} is not a row of {len(head)} values; delete that line or run again")
        rows.append(row)
    columns = dict(zip(head, zip(*rows))) if rows else {name: () for name in head}
    return pd.DataFrame({name: column_of(path, name, values, texts) for name, values in columns.items()}, columns=head)


def column_of(path: str, name: str, values: Tuple[str, ...], texts: Tuple[str, ...]) -> Any:
    """Numbers, or texts where there are some; an empty number is nan."""
    if name in texts:
        return np.array([v.strip() for v in values], dtype=object)
    try:
        found = np.array([v or "nan" for v in values], dtype=float)
    except ValueError:
        line = next(n for n, v in enumerate(values, 2) if v and not is_number(v))
        raise Trouble(f"{path}: line {line} is not a row of numbers: {name} is '{values[line - 2]}'; delete that line or run again") from None
    whole = name in WHOLE and bool(np.isfinite(found).all())
    return found.astype(int) if whole else found


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def pieces(folder: str, name: str) -> Iterator[Tuple[int, pd.DataFrame]]:
    """The tables of a loading that went on from checkpoints, and the step at which each begins; the first one has step 0."""
    paths = {0: os.path.join(folder, f"{name}.csv")}
    for path in glob.glob(os.path.join(glob.escape(folder), f"{name}_from_*.csv")):
        paths[int(path.rsplit("_", 1)[1][:-4])] = path
    for begin in sorted(paths):
        try:
            table = read(paths[begin])
        except Trouble:
            if not begin:
                raise
            continue  # a later one may have no rows yet
        if not begin or len(table):
            yield begin, table


def whole(folder: str, name: str) -> pd.DataFrame:
    """All rows of `name`.csv and of name_from_STEP.csv. What was written after a checkpoint from which the loading went on is left out; and, of
    curve.csv, the first row after one, which is no mean of all its steps."""
    found: List[pd.DataFrame] = []
    for begin, table in pieces(folder, name):
        found = [old[old["step"] <= begin] for old in found]
        found.append(table.iloc[1:] if begin and name == "curve" else table)
    return pd.concat(found, ignore_index=True)[list(found[0])] if len(found) > 1 else found[0]


def dump_paths(folder: str) -> Dict[str, Dict[int, str]]:
    """Names NAME.STEP.txt of the text dumps in a folder, by NAME and by step."""
    found: Dict[str, Dict[int, str]] = {}
    for path in glob.glob(os.path.join(glob.escape(folder), "*.txt")):
        match = re.fullmatch(r"(.+)\.(\d+)\.txt", os.path.basename(path))
        if match:
            found.setdefault(match[1], {})[int(match[2])] = path
    return {name: dict(sorted(steps.items())) for name, steps in sorted(found.items())}


def dump_step(path: str) -> int:
    """The step of the first snapshot of a text dump."""
    try:
        with open(path, errors="replace") as f:
            if f.readline().strip() == "ITEM: TIMESTEP":
                return int(f.readline())
    except OSError as e:
        raise Trouble(f"{path}: {e.strerror}; check the path") from None
    except ValueError:
        pass
    raise Trouble(f"{path}: not a LIGGGHTS text dump; name the files of 'dump custom' or 'dump local'")


def read_dump(path: str) -> Tuple[int, pd.DataFrame]:
    """Step and columns of the first snapshot of a text dump, of atoms or of local entries."""
    step, count, names = dump_step(path), -1, []
    with open(path, errors="replace") as f:
        for line in f:
            if line.startswith("ITEM: NUMBER OF"):
                text = f.readline().strip()
                count = int(text) if text.isdigit() else -1
            elif line.startswith(("ITEM: ATOMS", "ITEM: ENTRIES")):
                names = line.split()[2:]
                break
        lines = [f.readline() for _ in range(max(count, 0))]
    cut = Trouble(f"{path}: cut short, {count if count >= 0 else 'no'} lines announced; delete this dump or run again")
    if not names or count < 0 or lines and not lines[-1].endswith("\n"):
        raise cut
    try:
        rows = np.array("".join(lines).split(), dtype=float).reshape(count, len(names))
    except ValueError:
        raise cut from None
    return step, pd.DataFrame(rows, columns=names)


def read_points(path: str) -> pd.DataFrame:
    """A point file, as write_cement writes and create_cement reads it."""
    lines = [line for line in whole_lines(path).splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines or not re.match(r"[A-Za-z]", lines[0].lstrip()):
        raise Trouble(f"{path}: not a point file: its first line does not name columns; name one of write_cement")
    try:
        table = pd.read_csv(io.StringIO("\n".join(lines)), sep=r"\s+", dtype=float)
    except (ValueError, pd.errors.ParserError) as e:
        raise Trouble(f"{path}: not a point file ({' '.join(str(e).split())}); write it again with write_cement") from None
    lacking = [c for c in ("x", "y", "z", "volume") if c not in table]
    if lacking:
        raise Trouble(f"{path}: no column {', '.join(lacking)}; name a point file, as write_cement writes it")
    return table


def read_thermo(log: str) -> pd.DataFrame:
    """All rows of thermo output in a log; of a step that is printed twice, at the end of a run and the start of the next one, the first."""
    parts: List[pd.DataFrame] = []
    for match in re.finditer(r"^ *(Step\b[^\n]*)\n((?: *[-+\d][^\n]*\n|WARNING[^\n]*\n|\n)*)", log, re.M):
        names = match[1].split()
        rows: List[Any] = [line.split() for line in match[2].splitlines()]
        rows = [r for r in rows if len(r) == len(names)]
        try:
            parts.append(pd.DataFrame([[float(v) for v in r] for r in rows], columns=names))
        except ValueError:
            continue
    if not parts:
        return pd.DataFrame()
    found = pd.concat(parts, ignore_index=True)
    return found.drop_duplicates("Step", ignore_index=True)


def read_result(log: str) -> Dict[str, Any]:
    """What the last line RESULT of a script tells, by its words."""
    lines = re.findall(r"^RESULT (.*)$", log, re.M)
    words = lines[-1].split() if lines else []
    if len(words) % 2:
        return {"stage": " ".join(words)}
    return {k: _number(v) for k, v in zip(words[::2], words[1::2])}


def _number(text: str) -> Any:
    try:
        return int(text) if re.fullmatch(r"[-+]?\d+", text) else float(text)
    except ValueError:
        return text
