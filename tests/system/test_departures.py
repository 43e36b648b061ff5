# SPDX-License-Identifier: GPL-2.0-or-later
"""What may leave the scene: debris that holds to no grain, and grains whose bonds are separated, with their cement. It is counted,
its mass, momentum and energy are booked, and the run goes on. What is joined stops the run."""
import numpy as np
import pytest
from scenes import edit, host, launch, run, thermo

DENSITY = 2710.0
COLUMNS = ["atoms", "f_bond[13]", "f_bond[16]", "f_bond[22]", "f_cem[1]", "f_cem[2]", "f_cem[12]", "f_cem[15]", "f_cem[27]", "f_cem[28]", "f_cem[31]",
           "f_cem[32]", "c_mass"]


def scene(low=-0.012, high=0.0046, pull=2.0, B0=1e5, more="cracks split", columns=(), boundary="f f f"):
    """The upper bead of a pair flies up at `pull`, and takes a part of the cement along, since the bond comes off the lower one."""
    return (host(boundary) + f"""\
region       box block -0.012 0.012 -0.012 0.012 {low} {high} units box
create_box   2 box
create_atoms 1 single 0 0 -0.0036 units box
create_atoms 1 single 0 0 0.0036 units box
set          type 1 diameter 0.0072 density 2500
group        grains type 1
communicate  single vel yes group grains
neighbor     0.001 bin
neigh_modify include grains delay 0
create_cement calcite pair 1 2 shape flat outer 1.5e-3 spacing 2e-4
timestep     4e-7
fix          cem calcite mpm cell 4e-4 elastic isotropic 1e8 0.25 damage tensor B0 {B0} check 10 {more}
fix          bond grains mpm/couple cem csv 100 bond.csv
group        lower id 1
group        upper id 2
fix          motion grains nve/sphere
velocity     upper set 0 0 {pull}
variable     mass atom mass
compute      mass calcite reduce sum v_mass
""" + thermo(50, [*COLUMNS, *columns]))


def test_grain_leaves(tmp_path):
    run(scene() + "run 2000\n", tmp_path)
