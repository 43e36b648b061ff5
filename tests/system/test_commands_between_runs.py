# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands and fixes that only look leave a run as it is: grains, their cement, and loads of grains in sub-steps."""
import numpy as np
import pytest
from scenes import NEIGHBOURS, VTI, host, run, thermo

COLUMNS = ["f_cem[24]", "f_bond[1][9]", "f_bond[2][9]", "f_cem[5]", "f_cem[6]"]
ELASTIC = " ".join(f"{e:.15g}" for e in VTI)


def row_of_three(step, words):
    """The first bond is wider, so that it stays condensed while the second is resolved. The grain between them is free, and the last is pulled."""
    grains = "".join(f"create_atoms 1 single 0 0 {z} units box\n" for z in (-0.0102, 0, 0.0102))
    return (
        host()
        + "region box block -0.008 0.008 -0.008 0.008 -0.03 0.03 units box\ncreate_box 2 box\n"
        + grains
        + "set type 1 diameter 0.01 density 2500\ngroup grains type 1\n"
        + NEIGHBOURS
        + "create_cement calcite pair 1 2 shape flat outer 2.2e-3 inner auto spacing 2e-4\ncreate_cement calcite pair 2 3 shape flat outer 1.2e-3 spacing 2e-4\n"
        + f"timestep {step}\nfix cem calcite mpm cell 4e-4 elastic vti {ELASTIC} damage tensor B0 9.6e3 {words}\nfix bond grains mpm/couple cem\n"
        + "group low id 1\ngroup mid id 2\ngroup top id 3\nfix hold low move linear 0 0 0\nfix free mid nve/sphere\n"
        + "variable z equal 2e4*step*dt*step*dt\nvariable w equal 4e4*step*dt\nfix pull top move variable NULL NULL v_z NULL NULL v_w\n"
    )


CONDENSED, SUBCYCLED = (8e-9, "condense yes wake 0.1 subcycle 2", 400, 50), (2e-7, "subcycle 10", 30, 10)
CASES = {
    "bond_stiffness": (CONDENSED, "bond_stiffness k.csv", " pre no"),
    "check/timestep/mpm": (CONDENSED, "fix ts all check/timestep/mpm 1000 cem 0.9", ""),
    "bond_stiffness, ten sub-steps": (SUBCYCLED, "bond_stiffness k.csv", " pre no"),
    "write_restart, ten sub-steps": (SUBCYCLED, "write_restart x.restart", " pre no"),
}


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_only_look(name, ranks, tmp_path, figures):
    """The run goes on as if nobody had looked, up to the rounding of sums that are found anew."""
    (step, words, before, after), command, how = CASES[name]
    text = row_of_three(step, words) + thermo(after // 5, COLUMNS) + f"run {before}\n"
    looked = run(text + f"{command}\nrun {after}{how}\n", tmp_path / "looked", ranks).table()
    plain = run(text + f"run {after}{how}\n", tmp_path / "plain", ranks).table()
    assert len(looked["step"]) == len(plain["step"])
    worst = max(np.abs(looked[column] - plain[column]).max() / np.abs(plain[column]).max() for column in COLUMNS)
    figures.below(f"{name}, {ranks} ranks: difference of any column over its largest value", worst, 1e-10)
