# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenes in which cement breaks and pieces leave, fall and are dropped. They end by themselves, and tell what left: unconfined compression
past the peak, a drum, a hopper, and the rain of the examples."""
import math

import numpy as np
import pytest
from scenes import NEIGHBOURS, host, run, thermo

R = 1e-3
COLUMNS = ["atoms", "f_cem[1]", "f_cem[2]", "f_cem[12]", "f_cem[19]", "f_cem[27]", "f_cem[28]", "f_cem[35]", "c_mass", "c_pieces[2]"]
ATOMS, POINTS, FAILED, IMBALANCE, SEPARATED, LEFT, MASS_LEFT, DROPPED, MASS, JOINED = COLUMNS
MODEL = """\
fix          m1 all property/global youngsModulus peratomtype 1e8 1e8
fix          m2 all property/global poissonsRatio peratomtype 0.25 0.25
fix          m3 all property/global coefficientRestitution peratomtypepair 2 0.3 0.3 0.3 0.3
fix          m4 all property/global coefficientFriction peratomtypepair 2 0.4 0.4 0.4 0.4
pair_style   gran model hertz tangential history
pair_coeff   * *
"""
CEMENT = "fix cem calcite mpm cell 4e-4 elastic isotropic 2e8 0.25 quasistatic 1 0.05 damage tensor B0 {} condense yes timestep auto 0.7 check 50 {}\n"
COUPLE = "fix bond grains mpm/couple cem\n"


def stl(path, name, triangles):
    text = f"solid {name}\n"
    for corners in triangles:
        text += "facet normal 0 0 1\nouter loop\n" + "".join("vertex " + " ".join(f"{c:.9g}" for c in p) + "\n" for p in corners) + "endloop\nendfacet\n"
    (path / f"{name}.stl").write_text(text + f"endsolid {name}\n")


def shell(rings, sides=16):
    """Triangles of a shell of revolution about z through rings (radius, height)."""
    for (r0, z0), (r1, z1) in zip(rings, rings[1:]):
        for n in range(sides):
            a, b = (2 * math.pi * k / sides for k in (n, n + 1))
            p, q, s, t = ((r * math.cos(x), r * math.sin(x), z) for r, z, x in ((r0, z0, a), (r0, z0, b), (r1, z1, a), (r1, z1, b)))
            yield p, q, t
            yield p, t, s


def square(half, z):
    return [((-half, -half, z), (half, -half, z), (half, half, z)), ((-half, -half, z), (half, half, z), (-half, half, z))]


def block(nx, ny, nz, low, staggered=False):
    """Beads in a cubic arrangement from `low` on, a little apart and out of line, all joined to their neighbours by cement. staggered: every
    second layer lies in the valleys of those below and above it."""
    rng = np.random.default_rng(5)
    shift, rise = (0.5, 0.75**0.5) if staggered else (0.0, 1.0)
    cells = [(i + shift * (k % 2), j, rise * k) for k in range(nz) for j in range(ny) for i in range(nx)]
    places = [np.array(low) + 2.02 * R * np.array(c) + 0.01 * R * rng.uniform(-1, 1, 3) for c in cells]
    return "".join("create_atoms 1 single " + " ".join(f"{c:.9g}" for c in p) + " units box\n" for p in places)


def scene(beads, box, walls, B0, words, more="", gravity=0.0):
    return (
        host()
        + f"region box block {box} units box\ncreate_box 2 box\n{beads}"
        + f"set type 1 diameter {2 * R} density 2500\ngroup grains type 1\n"
        + NEIGHBOURS
        + "create_cement calcite contacts grains gap 1e-4 shape flat outer 7.5e-4 inner auto spacing 2e-4\n"
        + MODEL
        + "timestep 1e-6\n"
        + CEMENT.format(B0, words)
        + COUPLE
        + walls
        + (f"fix weight all gravity {gravity} vector 0 0 -1\n" if gravity else "")
        + more
        + "fix motion grains nve/sphere\nvariable mass atom mass\ncompute mass calcite reduce sum v_mass\ncompute pieces grains mpm/fragment\n"
        + thermo(500, COLUMNS)
        + "thermo_modify lost ignore\n"
    )


def check(result, figures, name, imbalance):
    """What left is missing, and is told. Returns the table."""
    t = result.table()
    left = t[LEFT][-1]
    assert t[POINTS][0] - t[POINTS][-1] == left > 0
    assert f"{left:g} points of cement with a mass of" in result.output
    figures.below(f"{name}: mass that left against mass that is missing", abs(t[MASS_LEFT][-1] / (t[MASS][0] - t[MASS][-1]) - 1), 1e-12)
    figures.below(f"{name}: imbalance of the energy", max(abs(t[IMBALANCE])), imbalance)
    assert t[SEPARATED][-1] > 0
    return t


COMPRESSED = """\
fix          floor all mesh/surface file plate.stl type 2 move 0 0 -3.7e-3
fix          lid all mesh/surface/stress file plate.stl type 2 move 0 0 3.7e-3
fix          wall grains wall/gran model hertz tangential history mesh n_meshes 2 meshes floor lid
fix          press all move/mesh mesh lid linear 0 0 -1
"""


@pytest.mark.parametrize("words", ["fragments drop age 1e-4 outside drop", "fragments drop bonds age 2e-4 outside drop", "outside drop"])
def test_unconfined_compression(tmp_path, figures, words):
    """A block is crushed by 40 %. Weight and damping settle what flies, and pieces leave a narrow box over its sides."""
    stl(tmp_path, "plate", square(0.0044, 0.0))
    beads = block(3, 3, 4, (-2.5 * R, -2.01 * R, -2.63 * R), staggered=True)
    calm = "fix calm grains viscous 0.005\n"
    script = scene(beads, "-0.0045 0.0045 -0.0045 0.0045 -0.006 0.006", COMPRESSED, 2e4, words, calm, gravity=50)
    t = check(run(script + "run 4000\n", tmp_path), figures, words, 0.03)
    assert t[JOINED][0] == 1


DRUM = """\
fix          drum all mesh/surface file drum.stl type 2 rotate axis 1 0 0 angle 90
fix          front all mesh/surface file plate.stl type 2 rotate axis 1 0 0 angle 90 move 0 -4e-3 0
fix          back all mesh/surface file plate.stl type 2 rotate axis 1 0 0 angle 90 move 0 4e-3 0
fix          wall grains wall/gran model hertz tangential history mesh n_meshes 3 meshes drum front back
fix          turn all move/mesh mesh drum rotate origin 0 0 0 axis 0 1 0 period 0.05
"""


def test_drum(tmp_path, figures):
    """A cemented block tumbles in a drum that turns, and comes apart. Loose cement is dropped."""
    stl(tmp_path, "drum", shell([(6e-3, -5e-3), (6e-3, 5e-3)]))
    stl(tmp_path, "plate", square(0.01, 0.0))
    beads = block(3, 2, 3, (-2.01 * R, -1.005 * R, -3 * R))
    script = scene(beads, "-0.008 0.008 -0.008 0.008 -0.008 0.008", DRUM, 1e3, "fragments drop age 5e-4 outside drop", gravity=200)
    t = check(run(script + "run 20000\n", tmp_path), figures, "drum", 0.02)
    assert t[DROPPED][-1] > 0 and t[JOINED][0] == 1


HOPPER = """\
fix          hopper all mesh/surface file hopper.stl type 2
fix          wall grains wall/gran model hertz tangential history mesh n_meshes 1 meshes hopper
"""


@pytest.mark.parametrize("ranks", [1, 2])
def test_hopper(tmp_path, figures, ranks):
    """Cemented beads break on the cone of a hopper, and leave through its opening and the floor of the box, joined or not."""
    stl(tmp_path, "hopper", shell([(7e-3, 9e-3), (7e-3, 0.0), (3e-3, -4e-3), (3e-3, -5e-3)]))
    beads = block(3, 3, 3, (-2.01 * R, -2.01 * R, 1.5 * R))
    script = scene(beads, "-0.009 0.009 -0.009 0.009 -0.009 0.01", HOPPER, 1e3, "fragments drop age 5e-4 outside drop", gravity=500)
    t = check(run(script + "run 12000\n", tmp_path, ranks), figures, f"hopper, {ranks} ranks", 0.02)
    grains = t[ATOMS] - t[POINTS]
    assert grains[0] == 27 and grains[-1] < 27 and np.all(np.diff(grains) <= 0)
