# SPDX-License-Identifier: GPL-2.0-or-later
"""Time step at 0.5 to 1.2 of the limit that fix mpm computes: stable below, stopped above."""
import numpy as np
import pytest
from bonds import bond, stable_step
from scenes import edit, launch, pull, run, thermo

WAYS = ["", "basis linear", "basis cubic", "kinematics updated", "kinematics updated transfer flip 0.99", "reproject 1", "quasistatic 100 0.3", "damping 0.1"]

FREE = "fix motion grains nve/sphere\n"  # as in the scene of the limit: `quasistatic` damps grains that are moved less


def words_of(way):
    return {"words": "", "couple": "damping 0.1"} if way == "damping 0.1" else {"words": way}


@pytest.mark.parametrize("way", WAYS)
def test_time_step(way, tmp_path, figures, long):
    """A bond pulled with 0.5, 0.9 and 0.98 of the limit stays bounded, with 1.02 and 1.2 it is stopped."""
    limit = stable_step(directory=tmp_path / "limit", **words_of(way))
    force = {}
    for share in (0.5, 0.9, 0.98):
        steps = int((20000 if long else 1200) / share)
        script = bond(**words_of(way), timestep=f"{share * limit:.15g}") + pull(0.01, 40 * limit)
        t = run(script + thermo(steps // 50, ["f_bond", "f_cem[5]", "f_cem[12]"]) + f"run {steps}\n", tmp_path / str(share)).table()
        assert all(np.isfinite(c).all() for c in t.values())
        figures.below(f"{way or 'default'}, {share} of the limit: imbalance of the energy", abs(t["f_cem[12]"][25:]).max(), 1e-4)
        force[share] = t["f_bond"][25:].mean()
    for share in (0.9, 0.98):
        figures.below(f"{way or 'default'}, {share} against 0.5 of the limit: mean force", abs(force[share] / force[0.5] - 1), 0.05)
    for share in (1.02, 1.2):
        result = launch(bond(**words_of(way), timestep=f"{share * limit:.15g}") + FREE + "run 10\n", tmp_path / str(share))
        assert result.status != 0 and "exceeds the stable step" in result.errors()[0], result.output[-500:]


# kg/m3, options, limits of the imbalance if the force is defined before fix mpm, and after it
FREE_GRAINS = [
    (100, "", 1e-6, None),
    (500, "", 1e-6, 0.05),
    (1000, "", 1e-6, 0.01),
    (2500, "", 1e-6, 5e-3),
    (500, "basis linear", 1e-6, 0.05),
    (2500, "quasistatic 100 0", 1e-6, None),
    (2500, "quasistatic 100 0.5", 1e-3, None),
]


@pytest.mark.parametrize("density, words, imbalance, later", FREE_GRAINS)
def test_free_grain(density, words, imbalance, later, tmp_path, figures):
    """A bead that follows its own mass, of any weight against its links, is drawn by a growing force. Added mass, here up to
    a thousand times the bead's, moves with it; forces of fixes that come after fix mpm are those of the step before,
    which is too late for beads lighter than their cement."""
    script = (
        bond(words, cement="inner 1e-3 outer 4e-3", gap=2e-4)
        + f"set group second density {density}\n"
        + ("fix hold first move linear 0 0 0\nfix motion second nve/sphere\n")
    )
    draw = "group drawn id 2\nvariable F equal step/500\nfix draw drawn addforce 0 0 v_F\n"
    for limit, where, text in ((imbalance, "former", edit(script, "fix          cem", draw + "fix          cem")), (later, "later", script + draw)):
        if limit is None:
            continue
        t = run(text + thermo(20, ["f_bond", "v_F", "f_cem[12]"]) + "run 2000\n", tmp_path).table()
        name = f"free bead of {density:g} kg/m3, {words or 'default'}, drawn by a {where} fix"
        figures.below(f"{name}: imbalance of the energy", abs(t["f_cem[12]"][5:]).max(), limit)
        figures.below(
            f"{name}: force of the bond against what draws, over its end",
            abs(t["f_bond"] - t["v_F"]).max() / t["v_F"][-1],
            0.05 if "quasistatic" in words else 0.01,
        )


@pytest.mark.parametrize("density, words", [(1000, ""), (2500, "quasistatic 100 0.2")])
def test_free_component(density, words, tmp_path, figures):
    """`fix move` with NULL: what it leaves to the forces counts as free."""
    move = (
        "variable t equal step*dt\nvariable z equal 0.02*v_t*v_t/4e-6\nvariable w equal 0.04*v_t/4e-6\n"
        "fix hold first move linear 0 0 0\nfix draw second move variable {0} {0} v_z {0} {0} v_w\n"
    )
    for given in ("NULL", "v_o"):
        script = bond(words, cement="inner 1e-3 outer 4e-3", gap=2e-4) + f"set group second density {density}\nvariable o equal 0\n"
        t = run(script + move.format(given) + thermo(20, ["f_bond", "f_cem[12]"]) + "run 600\n", tmp_path / given).table()
        figures.below(f"{words or 'default'}, components {given}: imbalance of the energy", abs(t["f_cem[12]"][5:]).max(), 2e-3)


@pytest.mark.parametrize("Z", [0.5, 1, 3])
def test_damped_step(Z, tmp_path, figures):
    """The damping of `quasistatic` has its share of the bound too."""
    script = bond(f"quasistatic 1 {Z}", cell=2e-4, shape="coating", cement="thickness 4e-4 cap 30") + pull(0.05, 4e-6)
    t = run(script + thermo(20, ["f_bond", "f_cem[12]"]) + "run 600\n", tmp_path).table()
    figures.below(f"quasistatic 1 {Z}: imbalance of the energy", abs(t["f_cem[12]"][5:]).max(), 5e-3)
