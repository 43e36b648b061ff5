# SPDX-License-Identifier: GPL-2.0-or-later
"""Time step at 0.5 to 1.2 of the limit that fix mpm computes: stable below, stopped above."""
import numpy as np
import pytest
from bonds import bond, stable_step
from scenes import launch, pull, run, thermo

WAYS = ["", "basis linear", "basis cubic", "kinematics updated", "kinematics updated basis linear",
        "kinematics updated transfer flip 0.99", "reproject 1", "quasistatic 100 0.3", "damping 0.1"]


FREE = "fix motion grains nve/sphere\n"  # as in the scene of the limit: grains that are moved have no frequency


def words_of(way):
    return ({"words": "", "couple": "damping 0.1"} if way == "damping 0.1" else {"words": way})


@pytest.mark.parametrize("way", WAYS)
def test_time_step(way, tmp_path, figures, long):
    """A bond pulled with 0.5, 0.9 and 0.98 of the limit stays bounded, with 1.02 and 1.2 it is stopped."""
    limit = stable_step(directory=tmp_path / "limit", **words_of(way))
    force = {}
    for share in (0.5, 0.9, 0.98):
        steps = int((20000 if long else 2000) / share)
        script = bond(**words_of(way), timestep=f"{share * limit:.15g}") + pull(0.01, 40 * limit)
        t = run(script + thermo(steps // 50, ["f_bond", "f_cem[5]", "f_cem[12]"]) + f"run {steps}\n", tmp_path / str(share)).table()
        assert all(np.isfinite(c).all() for c in t.values())
        figures.below(f"{way or 'default'}, {share} of the limit: imbalance of the energy", abs(t["f_cem[12]"][25:]).max(), 0.02)
        force[share] = t["f_bond"][25:].mean()
    for share in (0.9, 0.98):
        figures.below(f"{way or 'default'}, {share} against 0.5 of the limit: mean force", abs(force[share] / force[0.5] - 1), 0.05)
    for share in (1.02, 1.2):
        result = launch(bond(**words_of(way), timestep=f"{share * limit:.15g}") + FREE + "run 10\n", tmp_path / str(share))
        assert result.status != 0 and "exceeds the stable step" in result.errors()[0], result.output[-500:]
