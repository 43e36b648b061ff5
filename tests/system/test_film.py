# SPDX-License-Identifier: GPL-2.0-or-later
"""Films: what is too thin for cells is columns that the grains move. The bond is the same at every spacing."""
import csv
import re

import numpy as np
import pytest
from scenes import CALCITE, CONTACT, MOMENTA, MOMENTUM_COLUMNS, SPINNING, cement, edit, launch, pair, pull, restarted, run, thermo
from test_stiffness_command import rows_of

NU, E = 0.25, 60e9
ISOTROPIC = (E, E, NU, NU, E / 2 / (1 + NU))
ALL_FILM = "content 0.006 film joined"
SMALL = dict(radius=1.7e-3, half_box=(4e-3, 4e-3, 6e-3))
BREAKS = "damage tensor B0 9.6e3"
COHESIVE = "kn auto kt auto interface cohesive tn 5e6 tt 7e6 Gn 1 Gt 2"
COMPONENTS = ("tension", "torsion", "shear_min", "bending_min")


def bond(spacing, words=ALL_FILM, shape="flat", axis="bond", damage="", couple="kn auto kt auto", timestep=1e-8, elastic=ISOTROPIC, **options):
    return pair(spacing, cement=words, shape=shape, **{**SMALL, **options}) + cement(2 * spacing, timestep, elastic, axis, damage, couple)


def said(output):
    """Volume, content and attached areas that create_cement printed."""
    return [float(x) for x in re.search(r"^  volume (\S+), content .* grains\) (\S+), attached area (\S+) \+ (\S+),", output, re.M).groups()]


def stiffness(script, directory, ranks=1):
    run(script + "bond_stiffness k.csv\n", directory, ranks)
    (row,) = rows_of(directory / "k.csv")
    return np.array([row[c] for c in COMPONENTS])


@pytest.mark.parametrize("shape, words", [("flat", "content 0.03"), ("meniscus", "content 0.03 contact 20"), ("hourglass", "content 0.03 waist 0.98")])
def test_geometry_is_that_of_the_bond(shape, words, tmp_path):
    """Inner radius, volume, content and attached areas do not depend on the spacing."""
    found = [run(pair(s, cement=words + " film joined", shape=shape), tmp_path / str(s)).output for s in (2e-4, 3e-4)]
    assert said(found[0])[1] == pytest.approx(0.03, rel=1e-6)
    assert said(found[0]) == pytest.approx(said(found[1]), rel=1e-5)
    assert all("inner radius 0.001," in text for text in found)
    assert re.search(r"in cells of two points up to \S+ thick and \S+ wide; film carries \S+ % of the attached area", found[0])
    # a zone of a sphere by its height: from the inner radius of 1 mm to where the gap is two spacings, and so each grain a spacing high
    R = 5e-3
    zone = 2 * np.pi * R * (2e-4 - (R - np.sqrt(R**2 - 1e-3**2)))
    share = float(re.search(r"film carries (\S+) % of the attached area", found[0])[1])
    assert share == pytest.approx(100 * 2 * zone / sum(said(found[0])[2:4]), rel=1e-4)


def test_small_bond_does_not_know_the_spacing(tmp_path):
    """A bond that is all film has one stiffness, that of columns between rigid grains."""
    found = [stiffness(bond(s), tmp_path / str(s)) for s in (2e-4, 1.5e-4)]
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    output = (tmp_path / "0.0002" / "in.test.out").read_text()
    assert "all of it is film" in output and " 64 points" in output or " 80 points" in output
    inner, outer = (float(x) for x in re.search(r"flat, inner radius (\S+), outer radius (\S+),", output).groups())
    R = SMALL["radius"]
    r = np.linspace(inner, outer, 20001)
    r, dr = (r[1:] + r[:-1]) / 2, r[1] - r[0]
    t = 2 * (R - np.sqrt(R**2 - r**2))
    C33, G = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU)), ISOTROPIC[4]
    columns = [2 * np.pi * np.sum(r * c / t) * dr for c in (C33, G * r**2, G, C33 * r**2 / 2)]
    assert found[0] == pytest.approx(columns, rel=1e-4)


@pytest.mark.parametrize("shape, words", [("flat", "content 0.03"), ("meniscus", "content 0.03 contact 20")])
def test_stiffness_at_other_spacings(shape, words, tmp_path, figures):
    big = dict(radius=5e-3, half_box=(6e-3, 6e-3, 12.5e-3))
    found = [stiffness(bond(s, words + " film joined", shape, **big), tmp_path / str(s)) for s in (2e-4, 1.5e-4)]
    figures.below(f"{shape}: stiffness at three quarters of the spacing", abs(found[1] / found[0] - 1).max(), 0.03)


def pulled(
    directory,
    spacing,
    words=ALL_FILM,
    shape="flat",
    damage=BREAKS,
    couple="kn auto kt auto",
    steps=4000,
    speed=0.1,
    ranks=1,
    more="",
    timestep=1e-8,
    way=(0, 0, 1),
    **options,
):
    script = bond(spacing, words, shape, "radial", damage, couple, timestep, CALCITE, **options)
    script += (
        pull(speed, 2e-6, way)
        + thermo(10, ["f_bond[7]", "f_bond[9]", "f_bond[14]", "f_cem[12]", "f_cem[2]", "f_cem[19]", "f_cem[8]"])
        + more
        + f"run {steps}\n"
    )
    return run(script, directory, ranks).table()


def test_breaks_and_keeps_the_balance(tmp_path, figures):
    """A bond that is all film: its peak is that of other spacings, its energy balances, and it is separated once all of it failed."""
    table = [pulled(tmp_path / str(s), s) for s in (2e-4, 1.5e-4)]
    for t in table:
        assert t["f_bond[14]"].max() > 5 and abs(t["f_bond[14]"][-1]) < 1e-9
        assert t["f_cem[19]"][-1] == 1 and t["f_cem[8]"][-1] > 0
        figures.below("imbalance of the energy of a film that breaks", abs(t["f_cem[12]"]).max(), 7e-7)
    figures.below("peak at another spacing", abs(table[0]["f_bond[14]"].max() / table[1]["f_bond[14]"].max() - 1), 1e-6)


@pytest.mark.parametrize("words, energy", [("nonlocal 2e-4 energy 10.6", 10.6), ("crackband 10.6", 10.6), ("nonlocal 4e-4 energy 30", 30.0)])
def test_takes_the_energy_of_a_crack(words, energy, tmp_path, figures):
    """Columns soften by their thickness: each takes that energy by its area, whatever their number and place."""
    spacing = 1e-4 if "2e-4" in words else 2e-4
    script = bond(spacing, damage=f"{BREAKS} regularization {words}", axis="radial", elastic=CALCITE)
    done = run(script + pull(0.1, 2e-6) + thermo(10, ["f_bond", "f_bond[13]", "f_cem[19]"]) + "run 6000\n", tmp_path)
    t = done.table()
    gap, force = t["f_bond[13]"], t["f_bond"]
    assert t["f_cem[19]"][-1] == 1
    under_curve = ((gap[1:] - gap[:-1]) * (force[1:] + force[:-1])).sum() / 2
    figures.below(f"{words}: area under force and opening by attached area", abs(under_curve / said(done.output)[2] / energy - 1), 0.1)


@pytest.mark.parametrize("way", [(0, 0, 1), (1, 0, 0), (0.6, 0, 0.8)], ids=["tension", "shear", "mixed"])
def test_cohesive_faces(way, tmp_path, figures):
    """Faces of columns are askew to them, and under shear some are closed while they soften."""
    t = pulled(tmp_path, 2e-4, damage="", couple=COHESIVE, steps=16000, speed=0.03, way=way)
    force = np.sqrt(t["f_bond[7]"] ** 2 + t["f_bond[9]"] ** 2)
    assert force.max() > 1 and force[-1] < 1e-9 and t["f_cem[19]"][-1] == 1
    figures.below(f"imbalance with cohesive faces, pulled along {way}", abs(t["f_cem[12]"]).max(), 1.5e-6)
    output = (tmp_path / "in.test.out").read_text()
    assert "debonding" in output


def test_events_are_at_the_columns(tmp_path):
    """A bond that is all film writes each column that fails once, at its place: in rings between the radii of the bond, in the middle of the gap."""
    t = pulled(tmp_path, 2e-4, damage=f"{BREAKS} events events.csv")
    output = (tmp_path / "in.test.out").read_text()
    inner, outer = (float(x) for x in re.search(r"flat, inner radius (\S+), outer radius (\S+),", output).groups())
    with open(tmp_path / "events.csv", newline="") as f:
        events = list(csv.DictReader(f))
    assert len(events) == len({e["point"] for e in events}) == t["f_cem[2]"][-1] > 50
    rings = {}
    for e in events:
        assert inner < float(e["r"]) < outer and abs(float(e["z"])) < 1e-9 and e["mode"] == "internal"
        rings.setdefault(round(float(e["r"]) * 1e8), []).append(float(e["theta"]))
    for angles in rings.values():  # 16 columns in a ring, alike in angle
        assert len(angles) == 16 and np.diff(sorted(angles)) == pytest.approx(np.full(15, np.pi / 8), abs=1e-6)


@pytest.mark.parametrize("ranks", [1, 2])
def test_what_debonds_is_said_of_its_grain(ranks, tmp_path):
    """Of two equal faces those at the grain with the smaller coordinate debond; the surface of the crack is there, whichever rank has the columns."""
    t = pulled(tmp_path, 2e-4, damage="", couple=COHESIVE, steps=16000, speed=0.03, ranks=ranks, processors=f"{ranks} 1 1")
    assert t["f_cem[19]"][-1] == 1
    output = (tmp_path / "in.test.out").read_text()
    assert re.search(r"debonding.*of the fracture surface 100 % at the first grain, 0 % at the second, 0 % inside", output)


def test_places_of_columns(tmp_path):
    """Atoms of columns are where both grains have them on average: a column moves by half of the way of the grain that is pulled."""
    script = bond(2e-4) + pull(0.1, 2e-6) + "dump all calcite custom 500 p.*.txt id z x y\n"
    script += 'dump_modify all format "%d %.17g %.17g %.17g"\n' + thermo(500, ["f_bond[13]"]) + "run 1000\n"
    t = run(script, tmp_path).table()
    start, end = (np.loadtxt(tmp_path / f"p.{n}.txt", skiprows=9) for n in (0, 1000))
    start, end = start[start[:, 0].argsort()], end[end[:, 0].argsort()]
    gap = t["f_bond[13]"][-1] - t["f_bond[13]"][0]
    assert len(start) > 60 and gap > 1e-7
    inner, outer = (float(x) for x in re.search(r"flat, inner radius (\S+), outer radius (\S+),", (tmp_path / "in.test.out").read_text()).groups())
    for rows in (start, end):
        r = np.hypot(rows[:, 2], rows[:, 3])
        assert inner < r.min() and r.max() < outer
    assert end[:, 1] - start[:, 1] == pytest.approx(np.full(len(start), gap / 2), rel=1e-6)


def test_film_and_cells_break_together(tmp_path, figures):
    t = pulled(tmp_path, 2e-4, "content 0.02 film joined", damage=BREAKS, steps=2000, speed=0.5, timestep=5e-9)
    assert 0 < t["f_cem[2]"][-1]
    figures.below("imbalance of film and cells", abs(t["f_cem[12]"]).max(), 1e-6)


def test_free_pair_that_spins(tmp_path, figures):
    """Momentum and angular momentum of a free pair with a film stay, and the bond is not strained by a rotation."""
    script = pair(2e-4, gap=2e-5, cement="content 0.002 film joined", half_box=(0.05, 0.05, 0.05)) + CONTACT
    script += cement(4e-4, 1e-8, CALCITE, "radial") + SPINNING + MOMENTA + thermo(100, MOMENTUM_COLUMNS + ["f_cem[12]"]) + "run 10000\n"
    t = run(script, tmp_path).table()
    size = max(abs(t[c]).max() for c in MOMENTUM_COLUMNS[3:])
    for c in MOMENTUM_COLUMNS:
        scale = size if c.startswith("v_L") else abs(t["v_Px"]).max()
        figures.below(f"drift of {c[2:]}", abs(t[c] - t[c][0]).max() / scale, 1e-12)


@pytest.mark.parametrize("words", [ALL_FILM, "content 0.02 film joined"])
def test_restart_is_bitwise_identical(words, tmp_path):
    columns = ["f_bond[14]", "f_cem[2]", "f_cem[8]", "f_cem[12]"]
    head = bond(2e-4, words, damage=BREAKS, axis="radial", elastic=CALCITE, timestep=5e-9, couple=COHESIVE)
    tail = pull(0.5, 2e-6) + thermo(10, columns)
    whole = run(head + tail + "run 600\nwrite_restart r.bin\nrun 200\n", tmp_path / "whole").table()
    fixes = cement(4e-4, 5e-9, CALCITE, "radial", BREAKS, COHESIVE)
    part = run(restarted("../whole/r.bin") + fixes + tail + "run 200\n", tmp_path / "part").table()
    n = len(part["step"]) - 1
    assert whole["f_cem[8]"][-1] > 0
    for c in columns:
        assert (whole[c][-n:] == part[c][-n:]).all(), c


def test_restart_of_a_free_pair_on_ranks(tmp_path):
    """Columns go to the ranks of their positions for the file, and are shown before they are laid out there."""
    columns = ["f_bond[14]", "f_cem[5]", "f_cem[6]", "f_cem[7]"]
    fixes = CONTACT + cement(4e-4, 1e-8, CALCITE, "radial") + "fix motion grains nve/sphere\n"
    script = pair(2e-4, gap=2e-5, cement="content 0.002 film joined", half_box=(0.02, 0.02, 0.02)) + CONTACT + cement(4e-4, 1e-8, CALCITE, "radial") + SPINNING
    whole = run(script + thermo(10, columns) + "run 110\nwrite_restart r.bin\nrun 200\n", tmp_path, 2).table()
    part = run(restarted("r.bin") + fixes + thermo(10, columns) + "run 200\n", tmp_path, 2, name="in.again").table()
    for c in columns[:3]:
        assert (whole[c][-len(part["step"]) :] == part[c]).all(), c


@pytest.mark.parametrize("words", [ALL_FILM, "content 0.02 film joined"])
def test_two_ranks(words, tmp_path, figures):
    """Ranks cut the film."""
    one, two = (pulled(tmp_path / str(n), 2e-4, words, steps=800, speed=0.5, ranks=n, timestep=5e-9, processors=f"{n} 1 1") for n in (1, 2))
    assert one["f_cem[2]"][-1] == two["f_cem[2]"][-1]
    figures.below("load on two ranks", abs(one["f_bond[14]"] - two["f_bond[14]"]).max() / one["f_bond[14]"].max(), 6e-15)


@pytest.mark.parametrize("words", [ALL_FILM, "content 0.02 film joined"])
def test_condensed(words, tmp_path, figures):
    """A condensed bond has its film, too: its loads are those of the resolved one, and it is activated and breaks."""
    both = [pulled(tmp_path / w, 2e-4, words, damage=f"{BREAKS} condense {w}", steps=2500, speed=0.1) for w in ("no", "yes")]
    resolved, condensed = (t["f_bond[14]"] for t in both)
    figures.below("condensed against resolved until the peak", abs(condensed - resolved)[: resolved.argmax()].max() / resolved.max(), 5e-3)
    figures.below("peak of a condensed bond", abs(condensed.max() / resolved.max() - 1), 1e-8)
    assert both[1]["f_cem[2]"][-1] == pytest.approx(both[0]["f_cem[2]"][-1], rel=0.05)


def test_axes_of_the_box(tmp_path):
    found = [stiffness(bond(2e-4, direction=d, half_box=(6e-3, 6e-3, 6e-3)), tmp_path / str(n)) for n, d in enumerate([(0, 0, 1), (1, 0, 0), (0.6, 0, 0.8)])]
    assert found[1] == pytest.approx(found[0], rel=1e-9) and found[2] == pytest.approx(found[0], rel=1e-9)


def test_the_step_is_stable_for_the_film(tmp_path):
    """Free grains on a stiff film: what `timestep auto` gives is stable, and a step beyond it is refused."""
    text = edit(bond(2e-4, timestep=1e-8), " axis bond ", " axis bond timestep auto 0.9 ") + "fix motion grains nve/sphere\n" + CONTACT
    text += "velocity grains set 1e-4 0 0\nvelocity second set -1e-4 0 1e-4\n"
    t = run(text + thermo(10, ["f_cem[12]"]) + 'variable dt equal dt\nrun 2000\nprint "STEP ${dt}"\n', tmp_path / "auto")
    step = t.value("STEP")
    assert abs(t.table()["f_cem[12]"]).max() < 0.05
    beyond = edit(text, "timestep auto 0.9 ", "").replace("timestep     1e-08", f"timestep     {1.3 * step / 0.9:.15g}")
    failed = launch(beyond + "run 10\n", tmp_path / "beyond")
    assert failed.status != 0 and "stable" in failed.output


OPEN_AND_CLOSE = """\
variable t equal step*dt
variable a equal "0.5*(1-cos(PI*v_t/4e-5))*(v_t<4e-5)+(v_t>=4e-5)"
variable b equal "0.5*(1-cos(PI*(v_t-4e-5)/4e-5))*(v_t>=4e-5)*(v_t<8e-5)+(v_t>=8e-5)"
variable da equal "0.5*PI/4e-5*sin(PI*v_t/4e-5)*(v_t<4e-5)"
variable db equal "0.5*PI/4e-5*sin(PI*(v_t-4e-5)/4e-5)*(v_t>=4e-5)*(v_t<8e-5)"
variable z equal 4e-6*v_a-5e-6*v_b
variable w equal 4e-6*v_da-5e-6*v_db
fix hold first move linear 0 0 0
fix go second move variable NULL NULL v_z NULL NULL v_w
"""


@pytest.mark.parametrize("words", ["", " unilateral yes"])
def test_broken_film_is_pressed(words, tmp_path):
    """Grains that close by 1 um beyond where the film was made: with friction its columns carry C33/R times their area and this, without it nothing."""
    force = {}
    for couple in ("", " friction 0.3"):
        text = bond(2e-4, damage=BREAKS + " condense yes" + words, couple="kn auto kt auto" + couple) + OPEN_AND_CLOSE
        done = run(text + thermo(500, ["f_bond[14]", "f_bond[22]", "v_z"]) + "run 8500\n", tmp_path / f"with{couple.strip()[:8]}")
        table, area = done.table(), said(done.output)[2]
        assert table["f_bond[14]"].max() > 5 and table["f_bond[22]"][-1] == 1 and table["v_z"][-1] == pytest.approx(-1e-6)
        force[couple] = -table["f_bond[14]"][-1]
    C33 = E * (1 - NU) / (1 + NU) / (1 - 2 * NU)
    assert force[" friction 0.3"] == pytest.approx(C33 / SMALL["radius"] * area * 1e-6, rel=0.2)
    assert abs(force[""]) < 0.01 * force[" friction 0.3"]


@pytest.mark.parametrize(
    "script, words",
    [
        (pair(2e-4, cement="outer 2e-3 inner 0 film joined"), ["create_cement", "inner radius 0", "without bound", "film grid"]),
        (pair(4e-4, cement="thickness 4e-4 film joined", shape="coating"), ["create_cement", "spacing"]),
        (pair(2e-4, cement="outer 2e-3 film some"), ["create_cement", "film some", "joined", "grid"]),
        (pair(2e-4, cement="outer 2e-3 inner share 2 film joined"), ["create_cement", "inner share 2", "0.9"]),
    ],
)
def test_what_is_refused(script, words, tmp_path):
    failed = launch(script + "run 1\n", tmp_path)
    assert failed.status != 0
    message = "\n".join(failed.errors()) or failed.output[-2000:]
    assert all(w in message for w in words), message


def test_explicit_auto_has_no_film(tmp_path):
    output = run(pair(2e-4, cement="content 0.03 inner auto film joined"), tmp_path).output
    assert "film" not in output.split("Cement between")[1]
