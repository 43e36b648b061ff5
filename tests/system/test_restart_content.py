# SPDX-License-Identifier: GPL-2.0-or-later
"""Restart files whose seal is right and whose content is not: numbers of the package's own records are changed one at a
time and the seal is renewed.  The run ends by one message that names the content, or is a sane one; it neither crashes
nor hangs."""
import random
import struct

import numpy as np
import pytest
from scenes import cement, edit, launch, pair, restarted, run, thermo

SEAL = 40
FIX_HEAD, FIX_BOND, NODE = 70, 23, 14  # numbers of the head of fix mpm's data, of a bond in them, and of a node with a point
# Of the numbers of a bond.
BOND = {
    "first": 0,
    "second": 1,
    "origin": 2,
    "turn": 5,
    "radius": 9,
    "centre": 11,
    "orientation": 17,
    "shift": 25,
    "area": 31,
    "grain E": 33,
    "grain nu": 35,
    "patch": 37,
    "box": 41,
    "axis": 44,
    "in motion": 48,
    "condensed": 49,
    "calm": 50,
    "volume": 51,
    "own volume": 52,
    "own mass": 53,
    "spacing": 54,
    "lattice": 55,
    "regular": 58,
    "thickness": 59,
    "points": 60,
    "pattern": 61,
    "material": 62,
    "wants points": 63,
    "home": 64,
    "left": 65,
}
BOND_NUMBERS = 67
FIX = {
    "version": 0,
    "cell": 1,
    "basis": 2,
    "updated": 3,
    "tied": 4,
    "step": 5,
    "started": 6,
    "energy": 7,
    "left": 18,
    "time": 26,
    "coupling": 29,
    "kn": 30,
    "law": 33,
    "bonds": 53,
    "nodes": 54,
    "copies": 63,
}
# Of an atom, after the 17 of one of style sphere: kind of the state, then a point's bond ...
POINT = {
    "kind": 17,
    "bond": 18,
    "layer": 19,
    "failed": 20,
    "checked": 21,
    "connected": 22,
    "film": 23,
    "framed": 24,
    "place": 25,
    "volume": 28,
    "deformation": 29,
    "frame": 38,
    "strain": 42,
    "damage": 48,
    "law": 54,
    "moving": 55,
    "links": 56,
    "grain": 57,
    "foot": 58,
    "area": 61,
    "attached": 62,
    "way": 63,
    "inert": 66,
    "state": 67,
}
# The same of a grain.
GRAIN = {"orientation": 19, "seen": 23, "velocity": 24, "placed": 63}
NAN, HUGE = float("nan"), 1e300


def reseal(data):
    """The sum of host/restart_seal.cpp over all but itself: FNV-1a, 64 bits."""
    if data[-SEAL : -SEAL + 8] != b"MPDEMend":
        return data
    value = 0xCBF29CE484222325
    for byte in data[:-8]:
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return data[:-8] + value.to_bytes(8, "little")


class File:
    """Where the package's numbers are in the bytes of a file that one process wrote."""

    def __init__(self, data):
        self.data = data
        end = len(data) - (SEAL if data[-SEAL : -SEAL + 8] == b"MPDEMend" else 0)
        self.head = data.index(b"MPDEMrst") + 8  # version, numbers of a bond, bonds, templates, whether there is a seal
        size, bonds = self.integer(self.head + 4), self.integer(self.head + 8)
        assert size == BOND_NUMBERS and bonds == 1
        self.bond = self.head + 20
        name = b"cem\0\x04\0\0\0mpm\0"
        self.fix = data.index(name) + len(name) + 4
        assert self.number(self.fix + 8 * FIX["bonds"]) == bonds
        # the atoms: how many numbers, these
        at = next(p for p in range(end - 4, 0, -1) if self.integer(p) * 8 == end - p - 4 > 0) + 4
        self.atoms = []
        while at < end:
            self.atoms.append(at)
            at += 8 * int(self.number(at))
        assert at == end

    def integer(self, at):
        return struct.unpack_from("<i", self.data, at)[0]

    def number(self, at):
        return struct.unpack_from("<d", self.data, at)[0]

    def nodes_of(self, n):
        """How many rows of nodes stand before the state of a point."""
        at = self.atoms[2 + n] + 8 * POINT["kind"]
        return int(self.number(at + 8)) if self.number(at) == 3 else 0

    def point(self, n, name):
        nodes = self.nodes_of(n)
        return self.atoms[2 + n] + 8 * (POINT[name] + (2 + NODE * nodes if nodes else 0))

    def node(self, n, number):
        return self.atoms[2 + n] + 8 * (POINT["kind"] + 2 + number)

    def with_number(self, at, value):
        return reseal(self.data[:at] + struct.pack("<d", value) + self.data[at + 8 :])

    def with_integer(self, at, value):
        return reseal(self.data[:at] + struct.pack("<i", value) + self.data[at + 4 :])


FIXES = cement(6e-4, 2e-9, axis="radial", damage="damage tensor B0 9.6e3 cutoff 0.9", couple="kn 2e12 kt 3e11")
MOVING = "fix motion grains nve/sphere\n"
AGAIN = restarted("bad.restart") + FIXES + MOVING + thermo(1, ["f_bond", "f_cem[5]", "f_cem[6]", "f_cem[7]"]) + "run 0\n"


def updated(script):
    return edit(script, "cell 0.0006", "cell 0.0006 kinematics updated")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """With total and updated kinematics: some points are damaged, some have failed."""
    found = {}
    for kinematics in ("total", "updated"):
        first = pair(3e-4, gap=6e-4) + FIXES + "velocity second set 0.5 0.1 3\nset group second omegaz 300\n" + MOVING + "run 150\nwrite_restart good.restart\n"
        result = run(first if kinematics == "total" else updated(first), tmp_path_factory.mktemp(kinematics))
        found[kinematics] = File((result.directory / "good.restart").read_bytes())
    return found


def attempt(directory, data, ranks=1, script=AGAIN):
    """Ends by one message, or well, with numbers in the table; the time that `launch` gives is a minute here."""
    (directory / "bad.restart").write_bytes(data)
    result = launch(script, directory, ranks, minutes=1)
    if result.status == 0:
        assert not result.errors() and all(np.isfinite(c).all() for c in result.table().values()), result.output[-2000:]
        return ""
    assert len(result.errors()) == 1, (result.status, result.output[-2000:])
    return result.errors()[0]


def test_unchanged(tmp_path, files):
    for kinematics, script in (("total", AGAIN), ("updated", updated(AGAIN))):
        file = files[kinematics]
        assert attempt(tmp_path, file.with_number(file.fix, file.number(file.fix)), script=script) == ""


@pytest.mark.parametrize(
    "part, name, value, needed",
    [
        ("head", "size", 44, "44 numbers"),
        ("head", "bonds", 0, "0 bonds, which is not how many it has"),
        ("head", "bonds", 2, "2 bonds, which is not how many it has"),
        ("head", "bonds", -1, "-1 bonds"),
        ("head", "bonds", 1 << 20, "truncated"),
        ("bond", "first", -7.0, "first grain is -7"),
        ("bond", "first", 0.5, "first grain is 0.5"),
        ("bond", "second", 1.0, "from 2"),
        ("bond", "second", NAN, "second grain"),
        ("bond", "orientation", 7.0, "orientation"),
        ("bond", "turn", 7.0, "axes"),
        ("bond", "radius", -5e-3, "radius"),
        ("bond", "axis", 4.0, "axis is 4"),
        ("bond", "in motion", 0.5, "motion' is 0.5"),
        ("bond", "condensed", 0.5, "condensed' is 0.5"),
        ("bond", "calm", -1e-6, "pieces were at rest"),
        ("bond", "area", 1.0, "attached area"),
        ("bond", "grain E", -1.0, "Young's modulus of a grain"),
        ("bond", "grain nu", 0.6, "Poisson's ratio of a grain"),
        ("bond", "patch", 4.0, "angle of an attached surface"),
        ("bond", "origin", NAN, "origin"),
        ("bond", "spacing", 1e-300, "spacing"),
        ("bond", "lattice", HUGE, "lattice"),
        ("bond", "points", NAN, "number of points"),
        ("bond", "pattern", 7.0, "is to have template 7"),
        ("bond", "pattern", -1.0, "its template is -1"),
        ("bond", "wants points", 0.5, "points' is 0.5"),
        ("bond", "home", -1.0, "rank that has its points"),
        ("bond", "home", 0.5, "rank that has its points"),
        ("fix", "cell", NAN, "cell"),
        ("fix", "basis", 3.0, "basis is 3"),
        ("fix", "basis", -1.0, "basis is -1"),
        ("fix", "basis", NAN, "basis is nan"),
        ("fix", "updated", 2.0, "'kinematics updated' is 2"),
        ("fix", "tied", -1.0, "'edge tied' is -1"),
        ("fix", "started", 2.0, "bonds that have moved"),
        ("fix", "bonds", 2.0, "number of bonds is 2"),
        ("fix", "bonds", -1.0, "number of bonds is -1"),
        ("fix", "bonds", HUGE, "number of bonds"),
        ("fix", "nodes", -1.0, "number of nodes is -1"),
        ("fix", "nodes", 1e9, "of 1e+09 nodes"),
        ("fix", "nodes", NAN, "number of nodes is nan"),
        ("fix", "copies", -1.0, "number of copies of nodes is -1"),
        ("fix", "copies", 1e9, "1000000000 copies of nodes take"),
        ("bond", "left", 0.5, "has left' of a grain is 0.5"),
        ("fix", "left", -1.0, "number of points that left"),
        ("fix", "time", NAN, "time"),
        ("fix", "coupling", 3.0, "kind of coupling is 3"),
        ("fix", "kn", NAN, "kn of the coupling"),
        ("node", 0, 1048576.0, "the bond of a node"),
        ("node", 1, -1.0, "layer of a node"),
        ("node", 2, 1e12, "grid index of a node"),
        ("node", 5, NAN, "velocity of a node"),
        ("node", 13, NAN, "acceleration of a node"),
        ("node", -1, 1e9, "number of nodes"),
        ("node", -1, 0.0, "number of nodes"),
        ("bond row", 1, 0.5, "separated' of a bond is 0.5"),
        ("point", "kind", 4.0, "state is of kind 4"),
        ("point", "kind", 2.0, "of a bonded grain"),
        ("point", "bond", 1.0, "its bond is 1"),
        ("point", "bond", -1.0, "its bond is -1"),
        ("point", "layer", 1e9, "layer"),
        ("point", "film", 1.0, "it is film, and has no link to either grain"),
        ("point", "film", 0.5, "'is film'"),
        ("point", "moving", 1.0, "ends before its number of contact points"),
        ("point", "links", 0.0, "of a contact point"),
        ("point", "attached", 2.0, "'is attached' of a link is 2"),
        ("point", "place", 1e9, "position"),
        ("point", "volume", 0.0, "volume"),
        ("point", "deformation", NAN, "deformation"),
        ("point", "frame", 2.0, "frame"),
        ("point", "damage", 1.5, "damage is 1.5"),
        ("point", "law", 100.0, "law of damage is 100"),
        ("point", "links", 3.0, "links"),
        ("point", "state", 1.5, "the state of a link is 1.5"),
        ("point", "state", -0.1, "the state of a link is -0.1"),
        ("point", "state", NAN, "the state of a link is nan"),
        ("point", "grain", 3.0, "grain of a link"),
        ("grain", "orientation", 7.0, "orientation of a bonded grain"),
        ("grain", "seen", 2.0, "'velocities are known' of a bonded grain is 2"),
        ("grain", "velocity", NAN, "velocity of a bonded grain is nan"),
        ("grain", "placed", 0.5, "'position is known'"),
        ("atom", 0, 0.0, "number of numbers"),
        ("atom", 0, HUGE, "number of numbers"),
        ("atom", 11, NAN, "radius"),
        ("atom", 12, 0.0, "mass"),
    ],
)
def test_named(tmp_path, files, part, name, value, needed):
    """A number out of its range is named, with its value."""
    f = files["total"]
    linked = next(n for n in range(len(f.atoms) - 2) if f.number(f.point(n, "links")) == 1)
    with_node = next(n for n in range(len(f.atoms) - 2) if f.nodes_of(n) > 0)
    if part == "head":
        data = f.with_integer(f.head + {"size": 4, "bonds": 8}[name], value)
    else:
        at = {
            "bond": lambda: f.bond + 8 * BOND[name],
            "fix": lambda: f.fix + 8 * FIX[name],
            "bond row": lambda: f.fix + 8 * (FIX_HEAD + name),
            "node": lambda: f.node(with_node, name),
            "point": lambda: f.point(linked, name),
            "atom": lambda: f.atoms[1] + 8 * name,
            "grain": lambda: f.atoms[1] + 8 * GRAIN[name],
        }[part]()
        data = f.with_number(at, value)
    error = attempt(tmp_path, data)
    who = "fix mpm (id cem)" if part in ("fix", "bond row") else "read_restart"
    assert who in error and needed in error, error
    assert "use another restart file" in error or "truncated" in error, error


@pytest.mark.parametrize("version", [22, 24])
def test_other_version(tmp_path, files, version):
    """Of the data of fix mpm: named, with the cure."""
    f = files["total"]
    error = attempt(tmp_path, f.with_number(f.fix, float(version)))
    for words in ("fix mpm (id cem)", f"version {version}, this program reads version 23", "go on with the USER-MPDEM that wrote the file", "write_cement"):
        assert words in error


@pytest.mark.parametrize("kinematics, changes", [("total", 16), ("updated", 8)])
def test_anywhere(tmp_path, files, kinematics, changes):
    """Numbers anywhere in the records, the same in every run."""
    f, draw = files[kinematics], random.Random(f"{kinematics} 7")
    places = [f.bond + 8 * n for n in range(BOND_NUMBERS)]
    places += [f.fix + 8 * n for n in range(1, FIX_HEAD + FIX_BOND)]
    for n in (0, 1, 2, len(f.atoms) // 2, len(f.atoms) - 1):
        places += [f.atoms[n] + 8 * k for k in range(int(f.number(f.atoms[n])))]
    kinds = [lambda v: -v or -1.0, lambda v: HUGE, lambda v: 1e9, lambda v: NAN, lambda v: v + 1, lambda v: v - 1, lambda v: 0.0, lambda v: 1e-300]
    for _ in range(changes):
        at, kind = draw.choice(places), draw.choice(kinds)
        attempt(tmp_path, f.with_number(at, kind(f.number(at))), script=AGAIN if kinematics == "total" else updated(AGAIN))


def test_on_two_ranks(tmp_path, files):
    """Whether all ranks see it or one does."""
    f = files["total"]
    for at, needed in ((f.fix + 8 * FIX["nodes"], "number of nodes"), (f.bond + 8 * BOND["spacing"], "spacing"), (f.point(0, "volume"), "volume")):
        assert needed in attempt(tmp_path, f.with_number(at, -1.0), 2)
