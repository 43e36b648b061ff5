# SPDX-License-Identifier: GPL-2.0-or-later
"""What doc/limits.md calls possible runs, what it calls impossible stops or has no effect; messages of doc/troubleshooting.md are those of
the source."""
import re
from pathlib import Path

import numpy as np
import pytest
from scenes import CALCITE, cement, edit, host, launch, pair, pull, run
from thin_layer import formula

ROOT = Path(__file__).parents[2]
FREE = "fix m grains nve/sphere\n"
GLASS = """\
fix g1 all property/global youngsModulus peratomtype 7e10 7e10
fix g2 all property/global poissonsRatio peratomtype 0.22 0.22
fix g3 all property/global coefficientRestitution peratomtypepair 2 0.5 0.5 0.5 0.5
fix g4 all property/global coefficientFriction peratomtypepair 2 0.3 0.3 0.3 0.3
"""
HERTZ = GLASS + "pair_style gran model hertz tangential history\npair_coeff * *\n"
LIQUID = (
    GLASS
    + """\
fix l1 all property/global surfaceLiquidContentInitial scalar 1.0
fix l2 all property/global surfaceTension scalar 0.073
fix l3 all property/global fluidViscosity scalar 0.001
fix l4 all property/global contactAngle peratomtype 0.3 0.3
fix l5 all property/global minSeparationDistanceRatio scalar 1.01
fix l6 all property/global maxSeparationDistanceRatio scalar 1.1
pair_style gran model hertz tangential history cohesion easo/capillary/viscous
pair_coeff * *
"""
)
CREATE = re.compile(r"create_cement .*\n")


def scene(more="", **options):
    return edit(pair(2e-4, **options), "units        si\n", "units        si\nhard_particles yes\n").replace(
        "neigh_modify include grains", more + "neigh_modify include grains"
    )


def literals():
    text = []
    for file in sorted((ROOT / "src/USER-MPDEM").rglob("*")):
        if file.suffix in (".h", ".cpp"):
            code = re.sub(r'(?m)//[^\n"]*$', "", file.read_text())
            text.append(re.sub(r'"\s*\n?\s*"', "", code).replace('\\"', '"'))
    return "\n".join(text)


def test_messages_are_those_of_the_source():
    source, page = literals(), (ROOT / "doc/troubleshooting.md").read_text().split("## Messages")[1]
    of_liggghts = ("Communicate group", "youngsModulus", "Could not find fix", "It is heavily", "Not all nodes")
    quotes = [q for q in re.findall(r"^\| `([^`]+)`", page, re.M) if not q.startswith(of_liggghts)]
    parts = [part.strip() for q in quotes for part in q.split("…") if part.strip()]
    assert len(quotes) > 50 and not [p for p in parts if p not in source]


def test_rigid_grains(tmp_path):
    """The table of limits.md against bond_stiffness and the formula below it; elastic grains for the smallest bond."""
    page = (ROOT / "doc/limits.md").read_text()
    columns = r"^\| ([\d.]+) % \| ([\d.]+) mm \| ([\d.]+) GN/m \| ([\d.]+) GN/m \| ([\d.]+) \| ([\d.]+) GN/m \|$"
    rows = [[float(x) for x in r] for r in re.findall(columns, page, re.M)]
    assert len(rows) == 3
    for content, outer, rigid, elastic, ratio, theory in rows:
        for grains, expected in {"rigid": rigid, "elastic 70e9 0.22": elastic}.items():
            if grains != "rigid" and content > 0.1:
                continue
            made = f"create_cement calcite pair 1 2 shape flat content {content / 100} film grid spacing 1e-4\n"
            script = CREATE.sub(made, pair(1e-4)) + "timestep 1e-9\nfix cem calcite mpm cell 2e-4 elastic isotropic 60e9 0.25\n"
            folder = tmp_path / f"{content}_{grains.split()[0]}"
            output = run(script + f"fix bond grains mpm/couple cem grains {grains}\nbond_stiffness k.csv\n", folder).output
            a = float(re.search(r"outer radius ([\d.e-]+)", output)[1])
            k = float(np.genfromtxt(folder / "k.csv", delimiter=",", names=True)["tension"])
            assert a * 1e3 == pytest.approx(outer, abs=6e-3) and k / 1e9 == pytest.approx(expected, rel=5e-3)
        assert formula(5e-3, outer * 1e-3, (60e9, 0.25), (70e9, 0.22)) / 1e9 == pytest.approx(theory, rel=6e-3)
        assert rigid / elastic == pytest.approx(ratio, abs=0.06)


def test_capillary_bridge(tmp_path):
    """A pair with cement has the bridge of one without."""
    close = edit(edit(scene(), "0 0 -0.005 ", "0 0 -0.0049999 "), "0 0 0.005 ", "0 0 0.0049999 ")
    rest = "fix hold grains move linear 0 0 0\ngroup up id 2\ncompute f grains property/atom fz\ncompute s up reduce sum c_f\nthermo_style custom step c_s\nrun 2\n"
    with_cement = run(close + LIQUID + cement(4e-4, 1e-9) + rest, tmp_path / "with").output
    without = run(CREATE.sub("", close) + LIQUID + "timestep 1e-9\n" + rest, tmp_path / "without").output
    forces = [float(re.search(r"^ +2 +(\S+) *$", o, re.M)[1]) for o in (with_cement, without)]
    assert forces[0] > 0.1 and forces[0] == pytest.approx(forces[1], rel=1e-12)


def test_bonds_made_during_a_run(tmp_path):
    third = "create_atoms 1 single 0 0 0.015 units box\nset type 1 diameter 0.01 density 2500\ngroup grains type 1\n"
    start = scene(third, half_box=(6e-3, 6e-3, 22.5e-3)) + HERTZ + cement(4e-4, 1e-9) + FREE
    again = "create_cement calcite contacts grains gap 1e-5 shape flat inner 1e-3 outer 2e-3 film grid spacing 2e-4"
    output = run(start + f'run 4 every 2 "{again}"\nrun 2\n', tmp_path).output
    assert "Cement at 1 contacts of group 'grains' of a gap of at most 1e-05; 1 had cement before" in output


def test_healing(tmp_path):
    """A separated bond loses its cement, and the pair gets new cement."""
    script = scene(half_box=(6e-3, 6e-3, 2e-2)) + cement(4e-4, 3e-8, elastic=CALCITE, damage="damage tensor B0 9.6e3") + pull(0.2, 2e-6)
    made = CREATE.search(script)[0]
    output = run(
        script + f'run 500\nprint "Q $(f_bond[22])"\ndelete_atoms group calcite compress no\nrun 0\n{made}run 20\nprint "P $(f_cem[1])"\n', tmp_path
    ).output
    assert re.search(r"^Q 1$", output, re.M) and float(re.search(r"^P (\d+)", output, re.M)[1]) > 500


def test_grain_on_a_large_sphere(tmp_path):
    script = edit(scene(half_box=(6e-3, 6e-3, 0.11)), "0 0 -0.005 ", "0 0 -0.1 ").replace("group        grains", "set atom 1 diameter 0.2\ngroup        grains")
    run(script + cement(4e-4, 1e-8) + pull(0.1, 1e-6) + "run 20\n", tmp_path)


DATA = "x\n\n2 atoms\n2 atom types\n1 bonds\n1 bond types\n-1 1 xlo xhi\n-1 1 ylo yhi\n-1 1 zlo zhi\n\nAtoms\n\n1 1 0.01 2500 0 0 0\n2 1 0.01 2500 0 0 0.01\n\nBonds\n\n1 1 1 2\n"


def test_data_file_with_bonds(tmp_path):
    (tmp_path / "scene.data").write_text(DATA)
    result = launch(host() + "read_data scene.data\n", tmp_path)
    assert result.status != 0 and "No bonds allowed with this atom style" in result.output


def test_heat_does_not_go_through_cement(tmp_path):
    heat = "fix h1 all property/global thermalConductivity peratomtype 1 1\nfix h2 all property/global thermalCapacity peratomtype 800 800\n"
    script = scene() + GLASS + heat + "pair_style gran model hertz tangential history\npair_coeff * *\n" + cement(4e-4, 1e-8)
    script += "fix hold grains move linear 0 0 0\nfix ht grains heat/gran initial_temperature 300\nrun 0\nset atom 1 property/atom Temp 400.\nrun 50\n"
    output = run(script + 'print "Q $(f_Temp[1]) $(f_Temp[2]) $(f_bond)"\n', tmp_path).output
    assert re.search(r"^Q 400 300 0$", output, re.M), output[-300:]
