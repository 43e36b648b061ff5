# SPDX-License-Identifier: GPL-2.0-or-later
"""Rooms of src/USER-MPDEM include only rooms below them, and LIGGGHTS is known to the upper two alone."""
import re
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "USER-MPDEM"

# What each room may include besides itself.
BELOW = {
    "numerics": set(),
    "parallel": {"numerics"},
    "geometry": {"numerics"},
    "material": {"numerics"},
    "mpm": {"material", "numerics", "parallel"},
    "fracture": {"mpm", "material", "numerics", "parallel"},
    "coupling": {"mpm", "material", "numerics", "parallel"},
    "cement": {"coupling", "fracture", "geometry", "mpm", "material", "numerics", "parallel"},
    "styles": {"cement", "coupling", "fracture", "geometry", "mpm", "material", "numerics", "parallel"},
    "host": {"styles"},
}
KNOW_LIGGGHTS = {"styles", "host"}


def includes():
    """Room, file and included file of every include with quotes."""
    for path in sorted(PACKAGE.rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        for name in re.findall(r'^\s*#include "([^"]+)"', path.read_text(), re.M):
            yield path.parent.name, path, name


def against_the_layers(room, path, name):
    """Why an include is not allowed; empty if it is."""
    target = (path.parent / name).resolve()
    if not target.exists():
        return "" if room in KNOW_LIGGGHTS else f"{path.name} in {room}/ includes {name}, which is not of this package"
    other = target.parent.name
    if target == PACKAGE / "version.h" or other == room or other in BELOW[room]:
        return ""
    return f"{path.name} in {room}/ includes {name}; {room}/ may include {', '.join(sorted(BELOW[room])) or 'nothing else'}"


def test_every_room_is_known():
    rooms = {path.name for path in PACKAGE.iterdir() if path.is_dir()}
    assert rooms == set(BELOW)


def test_includes_go_down():
    found = [why for why in (against_the_layers(*i) for i in includes()) if why]
    assert not found, "\n".join(found)


def test_an_include_upwards_is_found():
    kernel = PACKAGE / "mpm" / "grid.cpp"
    assert "may include" in against_the_layers("mpm", kernel, "../coupling/penalty_links.h")
    assert "not of this package" in against_the_layers("mpm", kernel, "update.h")
    assert not against_the_layers("mpm", kernel, "../parallel/halo_sum.h")
