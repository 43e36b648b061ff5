# SPDX-License-Identifier: GPL-2.0-or-later
"""Restart files whose seal is right and whose content is not: numbers of the package's own records are changed one at a
time and the seal is renewed.  The run ends by one message that names the content, or is a sane one; it neither crashes
nor hangs."""
import struct

import numpy as np
import pytest
from scenes import cement, edit, launch, pair, restarted, run

SEAL = 40
HEAD, BODY, NODE = 20, 53, 13  # bytes of the head of the bonds but for its mark; numbers of a bond, of a node


def reseal(data):
    """The sum of host/restart_seal.cpp over all but itself: FNV-1a, 64 bits."""
    if data[-SEAL:-SEAL + 8] != b"MPDEMend":
        return data
    value = 0xcbf29ce484222325
    for byte in data[:-8]:
        value = (value ^ byte) * 0x100000001b3 & 0xffffffffffffffff
    return data[:-8] + value.to_bytes(8, "little")


class Record:
    """Where the package's numbers are in a file of one process: offsets of integers and of numbers, by name."""

    def __init__(self, data):
        end = len(data) - (SEAL if data[-SEAL:-SEAL + 8] == b"MPDEMend" else 0)
        style = data.index(b"MPDEMrst") + 8
        self.integers = {"size of a bond": style + 4, "number of bonds": style + 8}
        bodies = struct.unpack_from("<i", data, style + 8)[0]
        self.size_of_body = struct.unpack_from("<i", data, style + 4)[0]
        self.body = style + 16
        fix = data.index(b"cem\0\x04\0\0\0mpm\0") + 12
        size = struct.unpack_from("<i", data, fix)[0]
        self.fix, self.fix_numbers = fix + 4, size // 8
        self.nodes = self.fix + 8 * (17 + 6 * bodies)
        # a process's atoms: how many numbers, these
        self.atoms = next(p for p in range(end - 4, 0, -1) if struct.unpack_from("<i", data, p)[0] * 8 == end - p - 4 > 0) + 4
        self.end = end

    def atoms_from(self, data):
        """Offset and number of numbers of each atom."""
        at = self.atoms
        while at < self.end:
            numbers = int(struct.unpack_from("<d", data, at)[0])
            yield at, numbers
            at += 8 * numbers


def changed(data, at, value):
    return reseal(data[:at] + np.array([value]).tobytes() + data[at + (4 if isinstance(value, np.int32) else 8):])
