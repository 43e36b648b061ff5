# SPDX-License-Identifier: GPL-2.0-or-later
"""tools/parameters.py: its lines run, and what they ask for is what fix mpm and create_cement print and what a pair carries; bad words."""
import math
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scenes import NEIGHBOURS, PATIENCE, edit, host, launch, pull, run

ROOT = Path(__file__).parents[2]
TOOL = ROOT / "tools" / "parameters.py"
SAND = {"ucs": "3e5", "calcite": "0.03", "diameter": "3e-4", "void-ratio": "0.7"}
DENSITY = 2650


def tool(words):
    arguments = [w for k, v in words.items() for w in (f"--{k}", *v.split())]
    return subprocess.run(["/usr/bin/python3", TOOL, *arguments], capture_output=True, text=True, timeout=60 * PATIENCE)


def lines(**words):
    """What the tool prints, and the values of its variables."""
    done = tool({**SAND, **{k.replace("_", "-"): v for k, v in words.items()}})
    assert done.returncode == 0 and not done.stderr, done.stderr
    return done.stdout, {k: float(v) for k, v in re.findall(r"^variable +(\w+) +index (\S+)", done.stdout, re.M)}


def told(text, name):
    """The numbers of a comment."""
    line = re.search(rf"^#   {name} +(.*)$", text, re.M)[1]
    return [float(v) for v in re.findall(r"\d[.\d]*(?:e[-+]?\d+)?", line)]


def grains(positions, diameters):
    """Grains in a box of 8 of the largest diameter to each side."""
    half = 8 * max(diameters)
    text = host() + f"region box block {-half} {half} {-half} {half} {-half} {half} units box\ncreate_box 2 box\n"
    for n, (x, d) in enumerate(zip(positions, diameters)):
        text += f"create_atoms 1 single {' '.join(f'{c:.15g}' for c in x)} units box\nset atom {n + 1} diameter {d:.15g} density {DENSITY}\n"
    return text + "group grains type 1\n" + edit(NEIGHBOURS, "0.0005", f"{0.2 * max(diameters)}")


def pulled(text, diameter, folder, opening=2.5e-5):
    """A pair with these lines, pulled apart by `opening` diameters; the run and the largest tension."""
    d, steps = float(diameter), 4000
    time = 3e-6 * d * steps
    script = (
        grains([(0, 0, -d / 2), (0, 0, d / 2)], [d, d])
        + f"timestep {3e-6 * d}\n{text}group first id 1\ngroup second id 2\n{pull(opening * d / (0.9 * time), 0.2 * time)}"
        + f"fix rows all ave/time 1 1 2 f_bond file force.txt\nrun {steps}\n"
    )
    result = run(script, folder)
    return result, np.loadtxt(folder / "force.txt")[:, 1].max()


@pytest.mark.parametrize(
    "words",
    [{}, {"diameter": "3.7e-3"}, {"isotropic": "7e10 0.3"}, {"energy": "0.05"}, {"ucs": "1e6", "calcite": "0.05", "measured": "8e5", "zeta": "1"}],
    ids=["sand", "beads", "isotropic", "energy", "measured"],
)
def test_pair(words, tmp_path, figures):
    """Strength, content and radii are those that the program prints; the bond breaks at the tension that the tool names."""
    text, values = lines(**words)
    result, force = pulled(text, words.get("diameter", SAND["diameter"]), tmp_path)
    printed = {where.strip(): float(s) for where, s in re.findall(r"implies +(along the axis|in the plane) *: tensile strength (\S+),", result.output)}
    for where, strength in zip(("along the axis", "in the plane"), told(text, "tensile strength")):
        figures.below(f"strength {where} against that of fix mpm", abs(printed[where] / strength - 1), 5e-3)
    found = re.search(r"inner radius (\S+), outer radius (\S+), .*\n.*content \(mass over mass of the grains\) (\S+), attached area (\S+)", result.output)
    figures.below("content against that of create_cement", abs(float(found[3]) / values["content"] - 1), 1e-5)
    for name, radius in zip((1, 2), told(text, "radii of a bond")):
        assert abs(float(found[name]) / radius - 1) < 1e-3
    assert abs(float(found[4]) / told(text, "section, attached area")[1] - 1) < 1e-3 and "all of it is film" in result.output
    figures.below("tension at which the bond breaks", abs(force / told(text, "tension that breaks a bond")[0] - 1), 0.01)
    if "energy" in words:
        assert abs(float(re.search(r"a crack takes (\S+) per area", result.output)[1]) / values["energy"] - 1) < 1e-3
    assert not [line for line in result.output.splitlines() if "WARNING" in line]


def test_size_of_the_grains_does_not_matter():
    small, large = (lines(diameter=d)[1] for d in ("3e-4", "3e-3"))
    assert small["B0"] == large["B0"] and small["content"] == large["content"] and abs(large["spacing"] / small["spacing"] / 10 - 1) < 1e-5


def test_strength_and_threshold(figures):
    """B0 = f_t^2/(sqrt(2) E), with E along the axis."""
    text, values = lines()
    figures.below("B0 by the formula", abs(told(text, "tensile strength")[0] ** 2 / (math.sqrt(2) * 28.79e9) / values["B0"] - 1), 2e-4)
    _, stronger = lines(measured="1.5e5")
    _, weaker = lines(measured="6e5")
    figures.below("four times the strength, a sixteenth of B0", abs(stronger["B0"] / weaker["B0"] / 16 - 1), 1e-4)


@pytest.mark.parametrize("words", [{}, {"isotropic": "7e10 0.3"}, {"grain_density": "2400"}], ids=["sand", "isotropic", "density"])
def test_command_of_the_calibration(words):
    """Its bonds carry the same tension over the square of the diameter, whatever moduli and density are asked for."""
    text, _ = lines(**words)
    content, B0 = (float(re.search(rf"{w}[ =](\S+)", text.splitlines()[-1])[1]) for w in ("--contents", "strength"))
    beads, values = lines(diameter="3.7e-3", grain_density="2500", calcite=f"{content * 4.3:.17g}")
    tension = told(beads, "tension that breaks a bond")[0] * math.sqrt(B0 / values["B0"])
    assert abs(tension / told(text, "tension that breaks a bond")[0] / (3.7e-3 / 3e-4) ** 2 - 1) < 1e-3


def test_measured_as_predicted():
    """A specimen that is as strong as the ratio of the tool says leaves B0 as it is."""
    text, values = lines()
    stress = 1.45 * (1 - 0.483) * 4.1 * told(text, "tension that breaks a bond")[0] / (math.pi * 3e-4**2)
    assert abs(lines(measured=f"{stress:.17g}")[1]["B0"] / values["B0"] - 1) < 1e-3


def test_grains_are_stopped(tmp_path):
    """Grains that move and spin are at rest, and carry no load, once there is cement between them."""
    d, (text, _) = float(SAND["diameter"]), lines()
    moving = "velocity grains set 0.01 0.02 0.03\nset group grains omegax 100 omegay 50 omegaz 20\n"
    script = grains([(0, 0, -d / 2), (0, 0, d / 2)], [d, d]) + f"timestep {3e-6 * d}\n{moving}{text}fix motion grains nve/sphere\n"
    said = "compute ke grains ke\ncompute spin grains erotate/sphere\nthermo_style custom step c_ke c_spin f_bond\nthermo 10\nrun 10\n"
    rows = re.findall(r"^ +\d+ +(\S+) +(\S+) +(\S+) *$", run(script + said, tmp_path).output, re.M)
    assert len(rows) == 2 and {float(v) for row in rows for v in row} == {0.0}, rows


def test_compression(tmp_path, figures):
    """The script of doc/howto_parameters.md compresses beads past their peak, with the warning that the page announces and no other."""
    page = (ROOT / "doc" / "howto_parameters.md").read_text()
    (script,) = re.findall(r"^```liggghts-compression\n(.*?)^```", page, re.M | re.S)
    here = ["-var", "here", str(ROOT / "examples" / "specimen")]
    pour = launch((ROOT / "examples" / "specimen" / "in.pour").read_text(), tmp_path, name="in.pour", arguments=[*here, "-var", "beads", "80"])
    assert pour.status == 0, pour.output[-2000:]
    words = {"diameter": "3.7e-3", "grain_density": "2500", "coordination": "4.1", "void_ratio": f"{0.483 / 0.517:.17g}"}
    (tmp_path / "cement.in").write_text(lines(**words)[0])
    result = launch(script, tmp_path, name="in.compression", arguments=here)
    assert result.status == 0 and not result.errors(), result.output[-2000:]
    warnings = [line for line in result.output.splitlines() if "WARNING" in line]
    assert len(warnings) == 1 and "('kinetic_share')" in warnings[0], warnings
    strain, stress, broken = np.loadtxt(tmp_path / "ucs.txt", skiprows=1).T
    peak = int(stress.argmax())
    said = float(re.search(r"the largest stress is (\S+) MPa", page)[1])
    figures.below("largest stress against that of the page", abs(1e-6 * stress.max() / said - 1), 0.15)
    assert 10 < peak < len(stress) - 10 and stress[-10:].mean() < 0.3 * stress[peak] and broken[-1] > 50 > broken[peak]
    assert strain[-1] == pytest.approx(6e-4, rel=0.15) and (np.diff(np.diff(strain)[:15]) > 0).all(), "the speed rises smoothly"


def test_interface(tmp_path, figures):
    """An interface of the strength that the tool names has the bond debond at about the tension at which weaker cement breaks inside."""
    text, values = lines()
    (tn,) = told(text, "strength of an interface")[:1]
    text = edit(text, "condense yes ", "").replace(f"index {values['B0']:g}", f"index {100 * values['B0']:g}")
    law = f"interface cohesive tn {tn} tt {tn} Gn 0.01 Gt 0.01"
    result, force = pulled(edit(text, "mpm/couple cem", f"mpm/couple cem {law}"), SAND["diameter"], tmp_path, opening=1e-4)
    assert re.search(r"bond 1 of grains 1 and 2: debonding", result.output)
    figures.below("tension at which the interface debonds", abs(force / told(text, "tension that breaks a bond")[0] - 1), 0.08)


def test_content_of_a_packing(tmp_path, figures):
    """Calcite content over content of a bond: the mean number of bonds on a grain; of unequal grains the mean weighted with their mass."""
    d = float(SAND["diameter"])
    corner = [(0, 0, 0), (d, 0, 0), (d / 2, d * math.sqrt(3) / 2, 0), (d / 2, d * math.sqrt(3) / 6, d * math.sqrt(2 / 3))]
    text, values = lines(coordination="3")  # four equal grains in contact, each with all others
    create = next(line for line in text.splitlines() if line.startswith("create_cement"))
    variables = "".join(line + "\n" for line in text.splitlines() if line.startswith("variable"))
    for name, positions, sizes, bonds in (
        ("tetrahedron", corner, [d] * 4, None),
        ("chain", [(0, 0, 0), (0, 0, 0.75 * d), (0, 0, 1.75 * d)], [d, d / 2, 1.5 * d], (1, 2, 1)),
    ):
        result = run(grains(positions, sizes) + variables + create + "\n", tmp_path / name)
        reported = float(re.search(r"^ *in all .*, content .*\) (\S+)$", result.output, re.M)[1])
        if bonds:
            mass = np.array(sizes) ** 3
            expected = values["content"] * (mass * bonds).sum() / mass.sum()
        else:
            expected = float(SAND["calcite"])
        figures.below(f"{name}: calcite content", abs(reported / expected - 1), 1e-5)


def test_inactive_calcite_coats(tmp_path, figures):
    """A share of the calcite becomes coats; the bonds have the rest."""
    d = float(SAND["diameter"])
    text, _ = lines(coordination="3", inactive="0.4")
    made = "".join(line + "\n" for line in text.splitlines() if line.startswith(("create_cement", "variable")))
    corner = [(0, 0, 0), (d, 0, 0), (d / 2, d * math.sqrt(3) / 2, 0), (d / 2, d * math.sqrt(3) / 6, d * math.sqrt(2 / 3))]
    output = run(grains(corner, [d] * 4) + made, tmp_path).output
    for name, pattern, share in (("bonds", r"^ *in all .*, content .*\) (\S+)$", 0.6), ("coats", r"^Coats .*, content .*\) (\S+);", 0.4)):
        reported = float(re.search(pattern, output, re.M)[1])
        figures.below(f"inactive calcite: content of {name}", abs(reported / (share * float(SAND["calcite"])) - 1), 1e-5)


@pytest.mark.parametrize(
    "words, message",
    [
        ({"inactive": "1.5"}, "--inactive: 1.5: share of the calcite"),
        ({"calcite": "3"}, "--calcite: 3: .*for 3 % give 0.03"),
        ({"calcite": "-0.03"}, "--calcite: -0.03: .*above 0"),
        ({"calcite": "0"}, "--calcite: 0: .*above 0"),
        ({"calcite": "0.9", "coordination": "2"}, "a bond of volume .* does not fit .*the calcite content is too large"),
        ({"ucs": "0"}, "--ucs: 0: unconfined compressive strength in Pa, must be above 0"),
        ({"ucs": "-1"}, "--ucs: -1: .*above 0"),
        ({"ucs": "nan"}, "--ucs: nan: .*above 0"),
        ({"ucs": "0.3MPa"}, "--ucs: 0.3MPa: .*in Pa"),
        ({"ucs": "0.3"}, "--ucs 0.3: cement of a tensile strength of .* Pa follows; check that the UCS is in Pa"),
        ({"ucs": "1e11"}, "--ucs 1e.11: cement of a tensile strength of .* Pa follows; check that the UCS is in Pa"),
        ({"diameter": "0"}, "--diameter: 0: .*in m, must be above 0"),
        ({"diameter": "0.3"}, "--diameter: 0.3: .*in m, must be above 0 and below 0.05; for 0.3 mm give 0.0003"),
        ({"diameter": "100"}, "--diameter: 100: .*in m, must be above 0 and below 0.05$"),
        ({"void-ratio": "-1"}, "--void-ratio: -1: "),
        ({"porosity": "0.4"}, "not allowed with"),
        ({"coordination": "0"}, "--coordination: 0: "),
        ({"isotropic": "7e10 0.6"}, "Poisson's ratio above -1 and below 0.5"),
        ({"isotropic": "-1 0.2"}, "--isotropic"),
        ({"vti": "5e10 1e9 0.9 0.4 1e10"}, "--vti .*not positive definite"),
        ({"energy": "1e-9"}, "--energy 1e-09: below .* snap back; use --spacing"),
        ({"spacing": "0"}, "--spacing: 0: "),
        ({"measured": "0"}, "--measured: 0: "),
        ({"zeta": "1.5"}, "--zeta: 1.5: "),
    ],
)
def test_bad_words(words, message):
    done = tool({**SAND, **words})
    assert done.returncode != 0 and not done.stdout
    assert len(done.stderr.splitlines()) == 1 and done.stderr.startswith("parameters.py: ") and re.search(message, done.stderr), done.stderr


@pytest.mark.parametrize("left_out", ["ucs", "calcite", "diameter", "void-ratio"])
def test_words_that_are_needed(left_out):
    done = tool({k: v for k, v in SAND.items() if k != left_out})
    assert done.returncode != 0 and len(done.stderr.splitlines()) == 1 and f"--{left_out}" in done.stderr
