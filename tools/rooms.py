#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Draws the rooms of the source, which are the folders of src/USER-MPDEM, from their includes.

    tools/rooms.py rooms.png                 of this source tree
    tools/rooms.py before.png OLD/src        of another one

A box is a room, with its number of lines and files. An arrow leads from a room to one that it includes. Arrows that follow from others
are left out: what a room may use through another needs no arrow of its own. An arrow upwards is red: then two rooms include each other.
"""
import argparse
import re
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CODE = (".h", ".cpp")


def rooms_of(package):
    """Lines and files of each room, and how many includes lead from one to another."""
    lines, files, includes = defaultdict(int), defaultdict(int), defaultdict(lambda: defaultdict(int))
    for path in sorted(package.rglob("*")):
        room = path.parent.relative_to(package).as_posix()
        if path.suffix not in CODE or room == ".":
            continue
        text = path.read_text()
        lines[room] += len(text.splitlines())
        files[room] += 1
        for name in re.findall(r'^\s*#include "([^"]+)"', text, re.M):
            target = (path.parent / name).resolve()
            other = target.parent.relative_to(package).as_posix() if target.exists() else "."
            if other not in (".", room):
                includes[room][other] += 1
    return lines, files, includes


def levels_of(rooms, includes):
    """The longest path down from each room. Rooms that include each other stay on one level."""
    level = dict.fromkeys(rooms, 0)
    for _ in rooms:
        for room in rooms:
            level[room] = max([level[room]] + [level[o] + 1 for o in includes[room] if room not in includes[o]])
    return level


def reaches(start, goal, includes, without):
    """Whether includes lead from one room to another, without this one."""
    seen, open_rooms = {start}, [start]
    while open_rooms:
        room = open_rooms.pop()
        for other in includes[room]:
            if (room, other) == without or other in seen:
                continue
            if other == goal:
                return True
            seen.add(other)
            open_rooms.append(other)
    return False


def draw(package, picture):
    try:
        import matplotlib

        matplotlib.use("Agg")
        matplotlib.rcParams["svg.fonttype"] = "none"
        matplotlib.rcParams["svg.hashsalt"] = "rooms"
        import matplotlib.pyplot as plt
    except ImportError as missing:
        sys.exit(f"rooms.py: {missing}; apt-get install python3-matplotlib and run with /usr/bin/python3")
    lines, files, includes = rooms_of(package)
    level = levels_of(list(lines), includes)
    by_level = defaultdict(list)
    for room in sorted(lines):
        by_level[level[room]].append(room)
    width = max(len(of_level) for of_level in by_level.values())
    figure, axes = plt.subplots(figsize=(2.7 * width + 1.0, 1.25 * len(by_level) + 0.8))
    at = {}
    for height, of_level in by_level.items():
        for n, room in enumerate(of_level):
            at[room] = (n - 0.5 * (len(of_level) - 1) + (0.16 if height % 2 else -0.16), height)
    colours = {"cement": "#f6d9b0", "styles": "#cfe3f5", "host": "#cfe3f5"}
    boxes = {}
    for room, (x, y) in at.items():
        text = f"{room}\n{lines[room]} lines, {files[room]} files"
        boxes[room] = axes.text(
            x,
            y,
            text,
            ha="center",
            va="center",
            fontsize=9,
            zorder=3,
            bbox={"boxstyle": "round,pad=0.45", "facecolor": colours.get(room.split("/")[0], "#e2ecd9"), "edgecolor": "#555555"},
        )
    axes.set_title(
        "Rooms of src/USER-MPDEM; an arrow leads to a room that is included\n"
        "green: method, orange: engine, blue: what knows LIGGGHTS; thicker: more includes",
        fontsize=10,
    )
    axes.set_xlim(-0.5 * width - 0.2, 0.5 * width + 0.2)
    axes.set_ylim(-0.6, len(by_level) - 0.4)
    axes.axis("off")
    figure.tight_layout()
    figure.canvas.draw()  # arrows end at the boxes, whose sizes are known now
    for room in lines:
        for other, count in includes[room].items():
            mutual = room in includes[other]
            if not mutual and reaches(room, other, includes, (room, other)):
                continue
            axes.annotate(
                "",
                xy=at[other],
                xytext=at[room],
                zorder=1,
                arrowprops={
                    "arrowstyle": "-|>",
                    "color": "#c0392b" if mutual else "#777777",
                    "shrinkA": 0,
                    "shrinkB": 1,
                    "patchA": boxes[room].get_bbox_patch(),
                    "patchB": boxes[other].get_bbox_patch(),
                    "linewidth": 0.7 + 0.03 * min(count, 60),
                    "connectionstyle": "arc3,rad=0.08" if mutual else "arc3",
                },
            )
    figure.savefig(picture, dpi=110, metadata={"Date": None} if picture.suffix == ".svg" else None)
    print(f"{len(lines)} rooms on {len(by_level)} levels, {sum(lines.values())} lines: {picture}")


def main():
    p = argparse.ArgumentParser(description="Draws the rooms of the source from their includes.")
    p.add_argument("picture", type=Path, help="picture to write, .png or .svg")
    p.add_argument("source", type=Path, nargs="?", default=ROOT / "src", help="folder src of a source tree (default: of this one)")
    args = p.parse_args()
    package = (args.source / "USER-MPDEM").resolve()
    if not package.is_dir():
        sys.exit(f"rooms.py: {args.source} has no folder USER-MPDEM; give the folder src of a source tree")
    draw(package, args.picture)


if __name__ == "__main__":
    main()
