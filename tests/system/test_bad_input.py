# SPDX-License-Identifier: GPL-2.0-or-later
"""Mistakes in a script end the run with one line that says what is wrong and what to do."""
import pytest
from scenes import NEIGHBOURS, RADIUS, cement, edit, host, launch, pair, pull, restarted

CREATE = "create_cement calcite pair 1 2 shape flat inner 1e-3 outer 2e-3 film grid spacing 0.0001"
FIX, BOND = "fix          cem calcite mpm ", "fix          bond grains mpm/couple cem"
PULLING = pull(1.0, 1e-6)
ELASTIC = "elastic vti 60e9 40e9 0.25 0.2 18e9 axis radial"
FREE = "velocity second set 0 0 0.1\nfix m grains nve/sphere\n"
FREED = FIX + f"cell 2e-4 {ELASTIC} damage tensor B0 1e5"
GOOD = pair(1e-4) + cement(2e-4, 1e-9, axis="radial", damage="damage tensor B0 1e5 cutoff 0.9") + PULLING + "run 10\n"


def with_damage(words):
    return [("damage tensor B0 1e5 cutoff 0.9", words)]


# name: (changes as (old, new), words that the message has to hold)
CASES = {
    "no coupling": ([(f"{BOND} kn auto kt auto\n", "")], ["fix mpm (id cem)", "no fix mpm/couple", "bonds nothing;", "define one", "'coupling none'"]),
    "no coupling any more": ([("run 10\n", "run 10\nunfix bond\nrun 10\n")], ["fix mpm (id cem)", "bonds nothing any more", "define one"]),
    "no coupling after a restart": (
        [("run 10\n", f"run 10\nwrite_restart r\nclear\n{restarted('r')}timestep 1e-9\n{FIX} cell 2e-4 " f"{ELASTIC} damage tensor B0 1e5\nrun 10\n")],
        ["no fix mpm/couple", "bonds nothing any more", "after read_restart too"],
    ),
    "a coupling where there is to be none": ([("axis radial", "axis radial coupling none")], ["fix mpm/couple (id bond)", "'coupling none'", "without that"]),
    "British spelling": ([("axis radial", "axis radial regularisation none")], ["'regularisation'; did you mean 'regularization'?", "known here"]),
    "two letters swapped": ([("kn auto", "cvs 10 b.csv kn auto")], ["'cvs'; did you mean 'csv'?", "known here"]),
    "a value that is similar": ([("axis radial", "axis radiall")], ["'axis radiall'", "did you mean 'radial'?"]),
    # options of the commands
    "fix mpm: unknown keyword": ([("axis radial", "axes radial")], ["fix mpm (id cem)", "axes", "known here", "axis"]),
    "fix mpm: unknown keyword of damage": (with_damage("damage tensor B0 9.6e3 cutof 0.9"), ["fix mpm (id cem)", "cutof", "cutoff"]),
    "fix mpm: a third term of the mass": ([("axis radial", "axis radial mass_order 3")], ["fix mpm (id cem)", "'mass_order 3'", "from 1 to 2"]),
    "fix mpm: no term of the mass": ([("axis radial", "axis radial mass_order 0")], ["fix mpm (id cem)", "mass_order"]),
    "fix mpm: terms of the mass with other kinematics": (
        [("axis radial", "axis radial kinematics updated mass_order 2")],
        ["fix mpm (id cem)", "'mass_order 2' does not go with 'kinematics updated'", "'mass_order 1'", "'kinematics total'"],
    ),
    "fix mpm: terms of the mass with transfers": (
        [("axis radial", "axis radial reproject 10 mass_order 2")],
        ["fix mpm (id cem)", "'mass_order 2' does not go with 'reproject 10'", "without 'reproject'"],
    ),
    "fix mpm: cracks that split with other kinematics": (
        [("axis radial", "axis radial kinematics updated cracks split")],
        ["fix mpm (id cem)", "'cracks split' does not go with 'kinematics updated'", "cracks bonds"],
    ),
    "fix mpm/couple: unknown keyword": ([("kn auto", "k auto")], ["fix mpm/couple (id bond)", "'k'", "known here", "kn"]),
    "create_cement: unknown keyword": ([("outer 2e-3", "outside 2e-3")], ["create_cement", "outside", "known here", "outer"]),
    "compute mpm/atom: unknown quantity": (
        [("run 10\n", "compute d calcite mpm/atom cem damag\nrun 10\n")],
        ["compute mpm/atom (id d)", "damag", "one of", "damage"],
    ),
    "compute mpm/atom: no such fix": ([("run 10\n", "compute d calcite mpm/atom cement damage\nrun 10\n")], ["compute mpm/atom (id d)", "cement", "define"]),
    "fix mpm/couple: no such fix": ([("mpm/couple cem", "mpm/couple cement")], ["fix mpm/couple (id bond)", "cement", "define"]),
    "fix mpm: missing value": (with_damage("damage tensor B0"), ["fix mpm (id cem)", "B0", "missing", "number"]),
    "fix mpm: not a number": (with_damage("damage tensor B0 9.6MPa"), ["fix mpm (id cem)", "B0", "9.6MPa", "number"]),
    "fix mpm/couple: missing value": ([("kt auto", "kt")], ["fix mpm/couple (id bond)", "kt", "missing", "number"]),
    "create_cement: grid that is not a number": (
        [("spacing 0.0001", "spacing 0.0001 grid 0 x 0")],
        ["create_cement", "'grid 0 x': Y is missing", "'grid 0 0 0'"],
    ),
    "create_cement: grid without its third number": ([("spacing 0.0001", "spacing 0.0001 grid 0 0")], ["create_cement", "grid", "missing"]),
    "create_cement: missing value": ([("spacing 0.0001", "spacing")], ["create_cement", "spacing", "missing", "number"]),
    "compute mpm/atom: missing value": ([("run 10\n", "compute d calcite mpm/atom cem\nrun 10\n")], ["compute mpm/atom (id d)", "missing", "one of", "damage"]),
    "fix mpm: no cell": ([("cell 0.0002", "")], ["fix mpm (id cem)", "cell", "missing"]),
    "fix mpm: negative cell": ([("cell 0.0002", "cell -0.0002")], ["fix mpm (id cem)", "-0.0002", "greater than 0"]),
    "fix mpm: word of damage elsewhere": (
        with_damage("damage tensor B0 9.6e3 check 10 viscosity 1e-6"),
        ["fix mpm (id cem)", "'viscosity' belongs to", "damage tensor B0 ... viscosity"],
    ),
    "fix mpm: twice": ([("axis radial", "axis radial cell 2e-4")], ["fix mpm (id cem)", "'cell' is given twice", "once"]),
    "fix mpm: word of damage twice": (with_damage("damage tensor B0 9.6e3 cutoff 0.9 cutoff 0.8"), ["'cutoff' is given twice in damage tensor"]),
    "fix mpm: skip twice": ([("axis radial", "axis radial skip failed yes skip failed no")], ["'skip failed' is given twice"]),
    "fix mpm/couple: twice": ([("kt auto", "kt auto kn 1e12")], ["fix mpm/couple (id bond)", "'kn' is given twice"]),
    "create_cement: twice": ([("outer 2e-3", "outer 2e-3 outer 1.5e-3")], ["create_cement", "'outer' is given twice in shape number 1"]),
    "write_cement: pair twice": ([("run 10\n", "write_cement a.txt pair 1 2 pair 1 2\nrun 10\n")], ["write_cement", "'pair' is given twice"]),
    "create_cement: spacing twice": ([("spacing 0.0001", "spacing 0.0001 spacing 2e-4")], ["create_cement", "'spacing' is given twice"]),
    # method
    "basis": ([("axis radial", "axis radial basis quartic")], ["fix mpm (id cem)", "quartic", "one of", "quadratic"]),
    "kinematics": ([("axis radial", "axis radial kinematics euler")], ["fix mpm (id cem)", "euler", "one of", "updated"]),
    "transfer without reproject": ([("axis radial", "axis radial transfer apic")], ["fix mpm (id cem)", "reproject N", "updated"]),
    "flip with an interval": ([("axis radial", "axis radial transfer flip 1 reproject 10")], ["reproject 10", "reproject 1", "apic"]),
    "flip with a new reference": ([("axis radial", "axis radial transfer flip 1 reproject auto 0.1")], ["transfer flip", "apic"]),
    "flip share": ([("axis radial", "axis radial kinematics updated transfer flip 1.5")], ["flip 1.5", "[0, 1]"]),
    "xpic order": ([("axis radial", "axis radial kinematics updated transfer xpic 0")], ["transfer xpic", "0", "1"]),
    "xpic order that takes days": (
        [("axis radial", "axis radial kinematics updated transfer xpic 2000000000")],
        ["fix mpm (id cem)", "transfer xpic 2000000000", "from 1 to 1000"],
    ),
    "reproject with updated": ([("axis radial", "axis radial kinematics updated reproject 5")], ["'reproject 5' does not go with", "no 'reproject'"]),
    "linear basis with updated": (
        [("axis radial", "axis radial kinematics updated basis linear")],
        ["fix mpm (id cem)", "'basis linear' does not go with 'kinematics updated'", "no time step", "use 'basis quadratic', or 'kinematics total'"],
    ),
    "edge tied with updated": ([("axis radial", "axis radial kinematics updated edge tied")], ["edge tied", "edge free", "updated"]),
    "edge tied with reproject": ([("axis radial", "axis radial reproject 5 edge tied")], ["edge tied", "edge free", "reproject"]),
    "edge": ([("axis radial", "axis radial edge loose")], ["fix mpm (id cem)", "loose", "one of", "tied"]),
    "reproject auto with updated": (
        [("axis radial", "axis radial kinematics updated reproject auto 0.1")],
        ["'reproject auto 0.1' does not go with", "no 'reproject'"],
    ),
    "reproject below 1": ([("axis radial", "axis radial reproject 0")], ["fix mpm (id cem)", "reproject", "0", "1"]),
    "reproject twice": ([("axis radial", "axis radial reproject 5 reproject auto 0.1")], ["'reproject' is given twice", "once"]),
    "skip": ([("axis radial", "axis radial skip everything yes")], ["skip", "everything", "resting"]),
    "timestep auto share": ([("axis radial", "axis radial timestep auto 1.5")], ["timestep auto 1.5", "(0, 1]"]),
    "timestep in the fix": ([("axis radial", "axis radial timestep 1e-9")], ["fix mpm (id cem)", "auto", "command timestep"]),
    "quasistatic": ([("axis radial", "axis radial quasistatic 0.1 0")], ["quasistatic 0.1", "[1, 1e+09]"]),
    "quasistatic far too heavy": ([("axis radial", "axis radial quasistatic 1e300 0.2")], ["fix mpm (id cem)", "quasistatic 1e+300", "[1, 1e+09]"]),
    "quasistatic far too damped": (
        [("axis radial", "axis radial quasistatic 100 1e300")],
        ["fix mpm (id cem)", "quasistatic 100 1e+300", "damping", "[0, 100]"],
    ),
    "one of two numbers": (
        [("kt auto", "kt auto grains elastic 7e10 csv 10 bonds.csv")],
        [
            "fix mpm/couple (id bond): 'grains elastic 7e+10 csv': nu is missing",
            "'csv' is not a finite number",
            "2 numbers, E (Young's modulus, above 0) and nu (Poisson's ratio, from -0.99 to 0.499)",
            "'grains elastic 7e10 0.25'",
        ],
    ),
    "one of two numbers at the end": ([("kt auto", "kt auto grains elastic 7e10")], ["'grains elastic 7e+10': nu is missing", "from -0.99 to 0.499"]),
    "one of two numbers of a type": ([("kt auto", "kt auto grains elastic 7e10 0.2 type 1 7e10 rigid 2")], ["'type 1 7e+10 rigid': nu is missing"]),
    "one of two numbers, quasistatic": (
        [("axis radial", "axis radial quasistatic 100 condense yes")],
        ["'quasistatic 100 condense': Z is missing", "share of critical damping, from 0 to 100", "'quasistatic 100 0.1'"],
    ),
    "two of three numbers, axis": ([("axis radial", "axis global 0 1 condense yes")], ["'axis global 0 1 condense': nz is missing", "'axis global 0 0 1'"]),
    "two of three numbers, grid": ([("spacing 0.0001", "grid 0 1e-5 spacing 0.0001")], ["create_cement", "'grid 0 1e-05 spacing': Z is missing"]),
    "damping far too strong": ([("kt auto", "kt auto damping 1e300")], ["fix mpm/couple (id bond)", "damping 1e+300", "[0, 100]"]),
    "friction far too strong": ([("kt auto", "kt auto friction 1e10")], ["fix mpm/couple (id bond)", "friction 1e+10", "[0, 100]"]),
    "friction below 0": ([("kt auto", "kt auto friction -0.1")], ["fix mpm/couple (id bond)", "friction -0.1", "[0, 100]"]),
    "grid far off": ([("spacing 0.0001", "grid 0 -1e300 0 spacing 0.0001")], ["create_cement", "'grid 0 -1e+300 0'", "1000 spacings, 0.1"]),
    "grid somewhat too far off": ([("spacing 0.0001", "spacing 0.0001 grid 0 0 0.11")], ["create_cement", "'grid 0 0 0.11'", "1000 spacings, 0.1"]),
    "kinetic share of all or more": (
        [("axis radial", "axis radial kinetic_share 1.5")],
        ["fix mpm (id cem)", "'kinetic_share 1.5'", "(0, 1]", "'no'", "0.003"],
    ),
    "kinetic share of nothing": ([("axis radial", "axis radial kinetic_share 0")], ["fix mpm (id cem)", "kinetic_share 0", "greater than 0", "'no'"]),
    "kinetic share as a word": ([("axis radial", "axis radial kinetic_share yes")], ["fix mpm (id cem)", "kinetic_share", "yes", "'no'"]),
    "kinetic share twice": ([("axis radial", "axis radial kinetic_share no kinetic_share 0.1")], ["fix mpm (id cem)", "kinetic_share", "twice"]),
    "quasistatic damping with updated": ([("axis radial", "axis radial quasistatic 10 0.5 kinematics updated")], ["quasistatic", "total"]),
    "quasistatic damping without coupling": (
        [("axis radial", "axis radial quasistatic 10 0.5 coupling none"), ("fix          bond grains mpm/couple cem kn auto kt auto\n", "")],
        ["'quasistatic 10 0.5'", "'coupling none'", "it damps motion relative to the grains"],
    ),
    "check/timestep/mpm: no such fix": (
        [("run 10\n", "fix ts all check/timestep/mpm 5 cement 0.9\nrun 10\n")],
        ["check/timestep/mpm (id ts)", "cement", "define"],
    ),
    "check/timestep/mpm: what to do": ([("run 10\n", "fix ts all check/timestep/mpm 5 cem 0.9 shout\nrun 10\n")], ["shout", "warn", "stop"]),
    # material
    "elastic: not positive definite": ([("0.25 0.2 18", "0.25 0.9 18")], ["fix mpm (id cem)", "elastic", "0.9", "positive definite"]),
    "elastic: negative modulus": ([("vti 60000000000", "vti -60e9")], ["fix mpm (id cem)", "elastic", "-6e+10", "positive"]),
    "B0 negative": (with_damage("damage tensor B0 -1e5"), ["fix mpm (id cem)", "B0", "-100000", "greater than 0"]),
    "B0 zero": (with_damage("damage tensor B0 0"), ["fix mpm (id cem)", "B0 0", "greater than 0"]),
    **{
        f"cutoff {c}": (with_damage(f"damage tensor B0 1e5 cutoff {c}"), ["fix mpm (id cem)", f"cutoff {c}'", "between 0 and 1"])
        for c in ("0", "1", "1.5", "-1")
    },
    "zeta": (with_damage("damage tensor B0 1e5 zeta 0"), ["fix mpm (id cem)", "zeta 0'", "(0, 1]"]),
    "mazars with no strength that is a number": (
        with_damage("damage mazars kappa0 1e300 At 0.9 Bt 1e4"),
        ["fix mpm (id cem)", "'damage mazars'", "kappa0 1e+300", "must be finite"],
    ),
    "mazars that hardly softens": (
        with_damage("damage mazars kappa0 1e-4 At 0.9 Bt 1e-300"),
        ["fix mpm (id cem)", "'damage mazars'", "Bt 1e-300", "must be finite"],
    ),
    "axis without direction": ([("axis radial", "axis global 0 0 0")], ["fix mpm (id cem)", "global 0 0 0", "direction"]),
    "isotropic nu": ([("vti 60000000000 40000000000 0.25 0.2 18000000000", "isotropic 40e9 0.5")], ["fix mpm (id cem)", "0.5", "between"]),
    "time step": ([("timestep     1e-09", "timestep     1e-6")], ["fix mpm (id cem)", "1e-06", "exceeds", "use 'timestep"]),
    **{f"time step {dt}": ([("timestep     1e-09", f"timestep     {dt}")], ["fix mpm (id cem)", f"time step {dt}", "above 0"]) for dt in ("0", "-1e-09")},
    "time step that fix dt/reset makes too long": (
        [(PULLING, FREE + "fix d grains dt/reset 1 1e-9 1e-3 1e-3 units box\n")],
        ["fix mpm (id cem)", "time step 0.001 exceeds the stable step", "use 'timestep"],
    ),
    "check/timestep/mpm: more than the stable step": (
        [("run 10\n", "fix ts all check/timestep/mpm 5 cem 2\nrun 10\n")],
        ["check/timestep/mpm (id ts)", "is 2", "(0, 1]"],
    ),
    # scene
    "no points": ([(CREATE, "group calcite subtract all all")], ["fix mpm (id cem)", "no material points", "create_cement"]),
    **{
        f"shape out of range: {words}": ([("shape flat inner 1e-3 outer 2e-3", f"shape {words} inner 1e-3")], ["create_cement", value])
        for words, value in (
            ("meniscus filling 30 contact 95", "95"),
            ("meniscus filling 120", "120"),
            ("coating thickness 4e-4 cap 200", "200"),
            ("coating thickness 4e-4 cap 1", "1"),
            ("meniscus neck 7e-3", "0.007"),
        )
    },
    "no such shape": ([("shape flat", "shape disc")], ["create_cement", "disc", "one of", "flat"]),
    "a spacing in mm": ([("spacing 0.0001", "spacing 0.1")], ["create_cement pair 1 2", "'spacing 0.1' is more than half the smaller radius, 0.0025"]),
    "grains in the group of the cement": (
        [("create_cement calcite", "create_cement grains")],
        ["create_cement: group 'grains' holds 2 grains", "a group for the cement alone"],
    ),
    "a strength in the place of B0, with an energy": (
        with_damage("damage tensor B0 20e6 regularization nonlocal 2e-4 energy 10"),
        ["fracture energy 10 cannot be spent", "are a tensile strength of 1.06"],
    ),
    "too much cement": (
        [("inner 1e-3 outer 2e-3", "content 5")],
        ["create_cement", "'content 5' must lie between 0 and 0.2", "of density 2710,", "(5 % is 'content 0.05')"],
    ),
    "cement wider than the grain": ([("outer 2e-3", "outer 6e-3")], ["create_cement", "0.006", "0.005", "outer radius"]),
    "spacing far too fine": ([("spacing 0.0001", "spacing 1e-9")], ["create_cement", "1e-09", "memory", "spacing of at least"]),
    "spacing too fine for the memory": ([("spacing 0.0001", "spacing 2e-7")], ["create_cement", "2e-07", "points", "memory", "spacing of at least"]),
    "cell without points": ([("cell 0.0002", "cell 0.00005")], ["fix mpm (id cem)", "cell 5e-05", "spacing 0.0001", "use a cell"]),
    "no stable step": ([("run 10\n", "set group all density 1e-320\nrun 10\n")], ["fix mpm (id cem)", "time step", "densities"]),
    "cement outside the box": ([("-0.006 0.006 -0.006", "-0.0015 0.006 -0.006")], ["create_cement", "outside", "larger box"]),
    "cement thinner than two points": ([("inner 1e-3 outer 2e-3", "inner 0 outer 0.9e-3")], ["fix mpm/couple (id bond)", "0.0002", "film joined", "use"]),
    "cement thinner than the film left out": (
        [("inner 1e-3 outer 2e-3", "outer 0.9e-3")],
        ["create_cement pair 1 2:", "inner radius", "0.0009", "'inner auto' a smaller spacing"],
    ),
    "cell larger than the cement": ([("cell 0.0002", "cell 0.001")], ["fix mpm (id cem)", "cell 0.001", "larger", "use"]),
    "contacts of no group": ([("pair 1 2", "contacts beads gap 0")], ["create_cement", "contacts beads", "no such group", "define"]),
    "contacts without a gap": ([("pair 1 2", "contacts grains")], ["create_cement", "'shape' stands where 'gap' is needed"]),
    "contacts that are none": ([("pair 1 2", "contacts grains gap 1e-5"), ("0 0 0.005", "0 0 0.0051")], ["create_cement", "'grains'", "gap 1e-05", "wider"]),
    "grain missing": ([("pair 1 2", "pair 1 7")], ["create_cement", "grain 7", "does not exist", "create"]),
    "same grain twice": ([("pair 1 2", "pair 2 2")], ["create_cement", "pair 2 2", "different"]),
    "grain is a point": (
        [("spacing 0.0001\n", "spacing 0.0001\ncreate_cement more pair 1 10 shape flat outer 2e-3 inner auto spacing 1e-4\n")],
        ["create_cement", "10", "material point", "not a grain"],
    ),
    "cement there already": ([("spacing 0.0001\n", f"spacing 0.0001\n{CREATE}\n")], ["create_cement", "1 and 2", "already"]),
    "grains not neighbours": ([("0 0 0.005", "0 0 0.0068"), ("0 0 -0.005", "0 0 -0.0068")], ["create_cement", "1 and 2", "not neighbours", "0.0036", "bring"]),
    "cement through a third grain": (
        [
            (
                "group        grains type 1",
                "create_atoms 1 single 0 0.0025 0 units box\ngroup third id 3\n" "set group third diameter 0.002 density 2500\ngroup        grains type 1",
            )
        ],
        ["create_cement", "points of the cement of grains 1 and 2", "inside grain 3", "as deep as", "smaller"],
    ),
    "cement through the periodic image of a grain": (
        [
            ("f f f", "p f f"),
            ("-0.006 0.006 -0.006", "-0.001 0.006 -0.006"),
            ("single 0 0 -0.005 units", "single 0.0025 0 -0.005 units"),
            ("single 0 0 0.005 units", "single 0.0025 0 0.005 units"),
            ("flat inner 1e-3 outer 2e-3", "coating inner 1e-3 thickness 4e-4"),
        ],
        ["create_cement", "of grains 1 and 2", "periodic"],
    ),
    "no box": (
        [
            ("create_box   2 box", "#"),
            ("create_atoms 1 single 0 0 -0.005 units box", "#"),
            ("create_atoms 1 single 0 0 0.005 units box", "#"),
            ("set          type 1 diameter 0.01 density 2500", "#"),
            ("group        grains type 1", "#"),
            (NEIGHBOURS, ""),
        ],
        ["create_cement", "box", "create_box"],
    ),
    "units real": ([("units        si", "units        real")], ["create_cement", "real", "use 'units si'"]),
    "atom_style sphere": ([("atom_style   mpdem", "atom_style   sphere")], ["create_cement", "sphere", "use 'atom_style mpdem'"]),
    "too many types": ([("spacing 0.0001\n", "spacing 0.0001 type 3\n")], ["create_cement", "type 3", "2", "create_box"]),
    # the host recipe
    "none of the three lines": (
        [("map array first grains", "map array"), ("communicate  single vel yes group grains\n", ""), ("neigh_modify include grains", "neigh_modify")],
        ["fix mpm (id cem)", "atom_modify first", "three lines"],
    ),
    "no atom_modify first": ([("map array first grains", "map array")], ["Communicate group", "atom_modify first"]),  # stopped by LIGGGHTS
    "no communicate group": ([("communicate  single vel yes group grains\n", "")], ["fix mpm (id cem)", "communicate ... group", "three lines"]),
    "no neigh_modify include": ([("neigh_modify include grains", "neigh_modify")], ["fix mpm (id cem)", "neigh_modify include", "three lines"]),
    "neighbor multi": ([("0.0005 bin", "0.0005 multi")], ["fix mpm (id cem)", "multi", "use 'neighbor ... bin'"]),
    "no map": ([("map array first grains", "first grains")], ["map", "atom_modify"]),
    # other fixes
    "two fix mpm": (
        [("group        first", FIX.replace("cem", "cem2") + "cell 2e-4 elastic isotropic 40e9 0.2\ngroup        first")],
        ["fix mpm", "cem2", "cem", "unfix"],
    ),
    "two couplings": ([("group        first", BOND.replace("bond", "bond2") + "\ngroup        first")], ["fix mpm/couple", "bond2", "bond", "unfix"]),
    "second integrator": (
        [("group        first", "fix move all nve/sphere\ngroup        first")],
        ["fix mpm (id cem)", "move", "nve/sphere", "give it a group"],
    ),
    "group with grains": ([(FIX, FIX.replace("calcite", "all"))], ["fix mpm (id cem)", "all", "not a material point", "must hold"]),
    "grains in a rigid body": (
        [(PULLING, "fix r grains rigid single\n")],
        ["fix mpm/couple (id bond)", "bonded grain", "fix 'r' (rigid)", "as one body", "nve/sphere"],
    ),
    "velocities changed behind the cement": (
        [(PULLING, FREE + "fix v all momentum 10 linear 1 1 1\n")],
        ["fix mpm/couple (id bond)", "bonded grain 1", "fix 'v' (momentum)", "take it out"],
    ),
    "coupling without the grains": ([(BOND, BOND.replace("grains", "calcite"))], ["fix mpm/couple (id bond)", "grain", "group", "use the group"]),
    "delete_atoms": (
        [
            (
                "run 10\n",
                "run 10\nregion half block -1 1 0 1 -1 1 units box\ngroup half region half\n"
                "group gone subtract half grains\ndelete_atoms group gone compress no\nrun 10\n",
            )
        ],
        ["fix mpm (id cem)", "deleted", "cannot"],
    ),
    "fix mpm removed": ([("run 10\n", "run 10\nunfix cem\nrun 10\n")], ["fix mpm/couple (id bond)", "'cem' is gone", "unfix"]),
    "bonded grain deleted": ([("run 10\n", "run 10\ndelete_atoms group second compress no\nrun 10\n")], ["fix mpm (id cem)", "grain 2", "deleted", "keep"]),
    "atoms renumbered": (
        [
            ("run 10\n", "run 10\ndelete_atoms group third\nrun 10\n"),
            (
                "group        grains type 1",
                "create_atoms 1 single 0 0 0.0175 units box\n" "group third id 3\nset group third diameter 0.005 density 2500\ngroup        grains type 1",
            ),
            ("-0.0125 0.0125", "-0.0125 0.025"),
        ],
        ["fix mpm (id cem)", "delete_atoms", "compress no"],
    ),
    "points displaced before the run": (
        [("run 10\n", "displace_atoms calcite move 0 0 1e-4 units box\nrun 10\n")],
        ["fix mpm (id cem)", "position", "material point", "create_cement"],
    ),
    "points displaced between runs": (
        [("run 10\n", "run 10\ndisplace_atoms calcite move 0 0 1e-4 units box\nrun 10\n")],
        ["fix mpm (id cem)", "changed position", "material point", "before"],
    ),
    "points pushed between runs": (
        [("run 10\n", "run 10\nvelocity calcite set 1 0 0\nrun 10\n")],
        ["fix mpm (id cem)", "velocity", "material point", "before"],
    ),
    "csv every 0 steps": ([("kt auto", "kt auto csv 0 bond.csv")], ["fix mpm/couple (id bond)", "csv 0", "from 1 to"]),
    "csv not writable": ([("kt auto", "kt auto csv 5 nowhere/bond.csv")], ["fix mpm/couple (id bond)", "nowhere/bond.csv", "No such file"]),
    # in the course of a run
    "point leaves the box": (
        [
            ("fix hold first move linear 0 0 0", "fix hold first move linear 300 0 0"),
            ("fix pull second move variable v_dx v_dy v_dz v_vx v_vy v_vz", "fix pull second move linear 300 0 0"),
            ("timestep     1e-09", "timestep     1e-8"),
            ("run 10\n", "velocity calcite set 300 0 0\nrun 1500\n"),
        ],
        ["fix mpm (id cem)", "left the simulation box", "use a larger"],
    ),
    "not a number": (
        [("variable along equal", "variable other equal"), ("run 10\n", 'variable along equal "1e-9*cos(exp(100*step))"\nrun 10\n')],
        ["fix mpm (id cem)", "not finite", "step", "check"],
    ),
    "grain leaves the box": (
        [("variable along equal", "variable other equal"), ("run 10\n", 'variable along equal "1e300*v_t"\nrun 10\n')],
        ["fix mpm (id cem)", "grain 2", "lost", "left the simulation box", "larger box"],
    ),
    # numbers that cannot be meant
    "units lj": ([("units        si", "units        lj")], ["create_cement", "units 'lj'", "use 'units si'"]),
    "grains far from the origin": (
        [("0 0 -0.005 units", "1e9 0 -0.005 units"), ("0 0 0.005 units", "1e9 0 0.005 units"), ("block -0.006 0.006", "block 999999999.994 1000000000.006")],
        ["create_cement", "grains 1 and 2", "1e+09 from the origin", "rounded to 2.2", "nearer to the origin"],
    ),
    "grains too far for the spacing": (
        [("0 0 -0.005 units", "1e5 0 -0.005 units"), ("0 0 0.005 units", "1e5 0 0.005 units"), ("block -0.006 0.006", "block 99999.994 100000.006")],
        ["create_cement", "100000 from the origin", "length of 0.0001", "within 4503.6"],
    ),
    "grains and cement of one type": ([("spacing 0.0001\n", "spacing 0.0001 type 1\n")], ["create_cement", "type 1", "grain 1 too", "atom type of its own"]),
    "grains that get the type of cement": (
        [("run 10\n", "set group first type 2\nrun 10\n")],
        ["fix mpm (id cem)", "type 2", "grain 1 too", "atom type of its own"],
    ),
    "kn beyond rounding": ([("kn auto", "kn 1e30")], ["fix mpm/couple (id bond)", "'kn 1e+30'", "C33", "use 'kn auto'"]),
    "kt beyond rounding": ([("kt auto", "kt 1e30")], ["fix mpm/couple (id bond)", "'kt 1e+30'", "use 'kt auto'"]),
    "length beyond rounding": (
        [("kt auto", "kt auto length 1e-20")],
        ["fix mpm/couple (id bond)", "'kn auto' over 'length 1e-20'", "leave 'length' out", "at least"],
    ),
    "density far too large": (
        [
            ("spacing 0.0001\n", "spacing 0.0001 density 1e15\n"),
            ("timestep     1e-09", "timestep     1e-2"),
            ("cutoff 0.9\n", "cutoff 0.9 timestep auto 0.9\n"),
            (PULLING, "velocity second set 0 0 0.1\nfix m grains nve/sphere\n"),
            ("run 10\n", "run 200\n"),
        ],
        ["fix mpm (id cem)", "grain", "is lost at step", "left the simulation box", "cells a step", "densities"],
    ),
    "damping too strong for light grains": (
        [
            ("diameter 0.01 density 2500", "diameter 0.01 density 25"),
            (PULLING, "fix m grains nve/sphere\n"),
            ("axis radial", "axis radial quasistatic 100 0.2"),
            ("timestep     1e-09", "timestep     1e-7"),
        ],
        ["time step 1e-07", "damping of 'quasistatic 100 0.2'", "from 4.6", "to 1.4", "free grain", "use 'quasistatic 100 0.0013"],
    ),
    # the coupling of the steps before
    "coupling that comes late": (
        [
            (
                "run 10\n",
                f"unfix bond\nunfix cem\n{FREED} coupling none\nrun 10\nwrite_restart r\nclear\n{restarted('r')}timestep 1e-9\n{FREED}\n{BOND}\nrun 10\n",
            )
        ],
        ["fix mpm/couple (id bond)", "'cem' made steps without", "keep one"],
    ),
    "kn changed": (
        [("run 10\n", f"run 10\nunfix bond\n{BOND} kn 1e11\nrun 10\n")],
        ["fix mpm/couple (id bond)", "5e+14", "4.7619e+16 in the steps before", "use 'kn 9.52381e+12 kt 9.52381e+12'"],
    ),
    "kt changed": ([("run 10\n", f"run 10\nunfix bond\n{BOND} kt 1e11\nrun 10\n")], ["fix mpm/couple (id bond)", "5e+14", "in the steps before"]),
    "length changed": ([("run 10\n", f"run 10\nunfix bond\n{BOND} length 1e-3\nrun 10\n")], ["fix mpm/couple (id bond)", "9.52381e+15", "in the steps before"]),
    "at changed": ([("run 10\n", f"run 10\nunfix bond\n{BOND} at points\nrun 10\n")], ["fix mpm/couple (id bond)", "'at points'", "'at surface'", "use that"]),
    "grains in a plane by planeforce": (
        [(PULLING, FREE + "fix p grains planeforce 0 1 0\n")],
        ["fix mpm/couple (id bond)", "bonded grain 1 is in the group of fix 'p' (planeforce)", "'fix setforce' with 0 and NULL"],
    ),
    "a mean force of bonded grains": ([(PULLING, FREE + "fix p grains aveforce 0 0 0.01\n")], ["fix mpm/couple (id bond)", "fix 'p' (aveforce)", "'fix move'"]),
    "grains that a region holds": (
        [(PULLING, FREE + "region r block INF INF INF INF INF 0 units box\nfix p grains setforce 0 0 0 region r\n")],
        ["fix mpm/couple (id bond)", "fix 'p' (setforce)", "in a region only", "no region"],
    ),
    "freeze before the cement": (
        [("fix          cem calcite", "fix p grains freeze\nfix          cem calcite"), (PULLING, FREE)],
        ["fix mpm/couple (id bond)", "held by fix 'p' (freeze), which comes before fix mpm", "define it after"],
    ),
    "condensed bonds without coupling": (
        [("axis radial", "axis radial condense yes"), ("run 10\n", "run 10\nunfix bond\nrun 10\n")],
        ["fix mpm (id cem)", "bond of grains 1 and 2 is condensed", "use 'fix mpm/couple'"],
    ),
    "value of a bond after unfix of the cement": (
        [("run 10\n", 'run 10\nunfix cem\nvariable q equal f_bond[3]\nprint "q $q"\n')],
        ["fix mpm/couple (id bond)", "fix mpm 'cem' is gone", "unfix this one too"],
    ),
    "value of a bond without cement": (
        [(CREATE, "group calcite type 2"), ("run 10\n", 'variable q equal f_bond\nprint "q $q"\n')],
        ["fix mpm/couple (id bond)", "bond 1 was asked for, but there are 0", "use create_cement first"],
    ),
    "variables in a circle": (
        [(PULLING, "variable a equal v_b\nvariable b equal v_a\nfix hold first move variable NULL NULL v_a NULL NULL v_b\nfix pull second nve/sphere\n")],
        ["circular dependency"],
    ),
    "cell of many spacings": (
        [("cell 0.0002", "cell 0.0008"), ("spacing 0.0001", "spacing 4e-5")],
        ["fix mpm (id cem)", "'cell 0.0008' is 20 spacings", "at most 16", "8e-05"],
    ),
    # files
    "csv on a full disk": ([("kt auto", "kt auto csv 5 /dev/full")], ["fix mpm/couple (id bond)", "'csv' file /dev/full", "No space left", "name another"]),
    "events on a full disk": (
        [("cutoff 0.9", "cutoff 0.9 events /dev/full")],
        ["fix mpm (id cem)", "'events' file /dev/full", "No space left", "name another"],
    ),
    "csv and events in one file": (
        [("kt auto", "kt auto csv 5 t.csv"), ("cutoff 0.9", "cutoff 0.9 events ./t.csv")],
        ["fix mpm (id cem)", "./t.csv", "'csv' of fix mpm/couple (id bond)", "name another"],
    ),
    "csv in the file of a dump": (
        [("kt auto", "kt auto csv 5 d.txt"), ("group        first", "dump d all custom 5 ./d.txt id x\ngroup        first")],
        ["fix mpm/couple (id bond)", "d.txt", "dump 'd'", "name another"],
    ),
    "csv in the file of fix ave/time": (
        [("kt auto", "kt auto csv 5 t.csv"), ("group        first", "variable s equal step\nfix a all ave/time 1 1 1 v_s file ./t.csv\ngroup        first")],
        ["fix mpm/couple (id bond)", "t.csv", "another fix or command", "name another"],
    ),
    "events in the file of fix print": (
        [("cutoff 0.9", "cutoff 0.9 events t.csv"), ("group        first", "fix a all print 1 word file ./t.csv screen no\ngroup        first")],
        ["fix mpm (id cem)", "t.csv", "another fix or command", "name another"],
    ),
    "fix ave/time in the file of csv": (
        [("kt auto", "kt auto csv 5 t.csv"), ("run 10\n", "run 10\nvariable s equal step\nfix a all ave/time 1 1 1 v_s file ./t.csv\nrun 10\n")],
        ["fix mpm/couple (id bond)", "t.csv", "another fix or command", "name another"],
    ),
    "print into the file of csv": (
        [("kt auto", "kt auto csv 5 t.csv"), ("run 10\n", "run 10\nprint word append ./t.csv\nrun 10\n")],
        ["fix mpm/couple (id bond)", "t.csv: it changed since its last row", "name another"],
    ),
    "csv in the log": ([("kt auto", "kt auto csv 5 log.liggghts")], ["fix mpm/couple (id bond)", "log.liggghts", "the log"]),
    "cement in the file of csv": (
        [("kt auto", "kt auto csv 5 t.csv"), ("run 10\n", "run 10\nwrite_cement ./t.csv\n")],
        ["write_cement", "./t.csv", "'csv' of fix mpm/couple (id bond)", "name another"],
    ),
}


def run_changed(case, folder):
    """Runs the good script with the changes of a case; the result, and the words that the message has to hold."""
    changes, needed = case
    script = GOOD
    for old, new in changes:
        script = edit(script, old, new)
    return launch(script, folder, 2), needed


def expect_one(messages, needed, result):
    assert len(messages) == 1, result.output[-1500:]
    missing = [word for word in needed if word not in messages[0]]
    assert not missing, messages[0]


@pytest.mark.parametrize("name", CASES)
def test_message(tmp_path, name):
    result, needed = run_changed(CASES[name], tmp_path)
    assert result.status != 0, result.output[-1500:]
    expect_one(result.errors(), needed, result)


def test_the_unchanged_script_runs(tmp_path):
    result = launch(GOOD, tmp_path, 2)
    assert result.status == 0 and not result.errors(), result.output[-2000:]
    assert not warnings(result)


def test_thin_film(tmp_path):
    result = launch(edit(GOOD, "inner 1e-3", "inner 5e-4"), tmp_path, 2)
    assert result.status == 0 and not result.errors(), result.output[-2000:]
    thin = [line for line in result.output.splitlines() if "thin at its inner rim" in line]
    assert len(thin) == 1 and all(w in thin[0] for w in ("WARNING", "pair 1 2", "less than two spacings", "use 'film joined', 'inner auto' or a")), thin


DATA = """\
several spheres

3 atoms
2 atom types

-0.006 0.006 xlo xhi
-0.006 0.006 ylo yhi
-0.0125 0.0225 zlo zhi

Atoms

1 1 0.01 2500 0 0 -0.005
2 1 0.01 2500 0 0 0.005
2 1 0.01 2500 0 0 0.0152
"""


@pytest.mark.parametrize("which", ["pair 1 2", "contacts grains gap 1e-5"])
def test_grains_of_one_id(tmp_path, which):
    """A data file may give an ID to two atoms, and LIGGGHTS does not mind."""
    (tmp_path / "scene.data").write_text(DATA)
    script = host() + "read_data scene.data\ngroup grains type 1\n" + NEIGHBOURS + CREATE.replace("pair 1 2", which) + "\n"
    result = launch(script, tmp_path, 2)
    assert result.status != 0
    expect_one(result.errors(), ["create_cement", "several atoms of ID 2", "ID of its own", "data file"], result)


def warnings(result):
    return [line for line in result.output.splitlines() if "WARNING" in line and "thin at its inner rim" not in line]


# name: (changes, words that the warning has to hold)
WARN = {
    "much added mass": (
        [("kn auto", "kn 1e17"), ("timestep     1e-09", "timestep     1e-8")],
        ["fix mpm (id cem)", "links need", "mass of all grains", "'kn auto'", "'length cell'"],
    ),
    "length beyond the bond": (
        with_damage("damage tensor B0 1e5 cutoff 0.9 regularization nonlocal 0.01"),
        ["fix mpm (id cem)", "nonlocal 0.01'", "width of the widest bond, 0.003", "units of the box"],
    ),
    "a band wider than the bond": (
        with_damage("damage tensor B0 1e5 cutoff 0.9 regularization nonlocal 6e-4"),
        ["fix mpm (id cem)", "nonlocal 0.0006'", "1 of 1 bonds are thinner, the thinnest 0.0008", "counts as debonding", "a length of"],
    ),
    "steps of very different length": (
        [(PULLING, FREE.replace("0.1", "0.02")), ("run 10\n", "run 100\ntimestep 2e-8\nrun 20\n")],
        ["fix mpm (id cem)", "energy of the cement was made", "of the largest work or energy at step 120", "use one 'timestep'"],
    ),
    "steps of a grain that are limited": (
        [
            (PULLING, "velocity second set 0 0 0.05\nfix m grains nve/limit absolute 1e-10\n"),
            ("timestep     1e-09", "timestep     1e-8"),
            ("run 10\n", "run 500\n"),
        ],
        ["fix mpm (id cem)", "energy of the cement was made", "fix 'm' (nve/limit)", "use 'fix nve/sphere'"],
    ),
    "a ring that its inner radius makes narrow": (
        [("inner 1e-3 outer 2e-3 film grid", "inner 1.7e-3 outer 2e-3")],
        ["pair 1 2", "cells of two points across", "use a spacing of at most", ", or a smaller 'inner', to resolve it"],
    ),
    "wide cell": ([("cell 0.0002", "cell 0.00041")], ["'cell 0.00041'", "4.1 spacings", "two spacings"]),
    "a threshold as a strength": (
        with_damage("damage tensor B0 20e6"),
        ["fix mpm (id cem)", "tensile strength of the cement is 1.06", "Pa", "not a strength", "'units si'"],
    ),
    "damping that costs half the step": (
        [
            ("diameter 0.01 density 2500", "diameter 0.01 density 25"),
            (PULLING, "fix m grains nve/sphere\n"),
            ("axis radial", "axis radial quasistatic 100 0.2"),
        ],
        ["damping of 'quasistatic 100 0.2'", "from 4.6", "to 1.4", "use 'quasistatic 100 0.0013"],
    ),
}


@pytest.mark.parametrize("name", WARN)
def test_warning(tmp_path, name):
    result, needed = run_changed(WARN[name], tmp_path)
    assert result.status == 0 and not result.errors(), result.output[-1500:]
    expect_one(warnings(result), needed, result)


GPA = ("vti 60000000000 40000000000 0.25 0.2 18000000000", "vti 60 40 0.25 0.2 18")
# name: (changes, words of each warning)
UNITS = {
    "moduli in GPa": ([GPA], [["compressional waves", "m/s; solids like cement have 500 to 10000", "'elastic' (Pa)"], ["strain of 1", "Pa, not GPa"]]),
    "all in GPa": ([GPA, ("B0 1e5", "B0 1e-5")], [["compressional waves"], ["tensile strength", "1000 to 8e+07"]]),
    "density in g/cm3": ([("spacing 0.0001", "spacing 0.0001 density 2.71")], [["density of the cement is 2.71 kg/m3"], ["compressional waves"]]),
}


@pytest.mark.parametrize("name", UNITS)
def test_warnings_of_units(tmp_path, name):
    """They come before a message that the step is too long, which such numbers often bring about."""
    changes, needed = UNITS[name]
    script = GOOD
    for old, new in changes:
        script = edit(script, old, new)
    result = launch(script, tmp_path, 2)
    found = [line for line in warnings(result) if "check the units" in line or "strain of" in line]
    assert len(found) == len(needed) and all(word in line for line, words in zip(found, needed) for word in words), result.output[-2000:]


def test_a_warning_is_given_once(tmp_path):
    """Each run and each write_restart checks again."""
    script = edit(GOOD, "cell 0.0002", "cell 0.00041") + "run 1\nwrite_restart r\nrun 1\n"
    result = launch(script + "clear\n" + script, tmp_path)
    assert result.status == 0 and len(warnings(result)) == 2, "once in each scene\n" + result.output[-2000:]


def test_lines_that_a_message_shows_can_be_copied(tmp_path):
    result = launch(edit(GOOD, "neigh_modify include grains delay 0", "neigh_modify delay 0"), tmp_path)
    shown = [line.strip() for line in result.output.split("ERROR")[1].splitlines() if line.strip().startswith("neigh_modify")]
    assert shown == ["neigh_modify include grains"]


def test_accelerations_that_are_not_found(tmp_path):
    """Links of both grains share nodes and add a million times the mass of the scene. Said once, in two runs."""
    script = (
        edit(pair(1e-4, cement="inner 5e-4 outer 1.5e-3"), "density 2500", "density 1e-3")
        + cement(2e-4, 2e-8, couple="kn 1e15 kt 1e15")
        + "fix m grains nve/sphere\nrun 1\nrun 1\n"
    )
    result = launch(script, tmp_path, 2)
    found = [line for line in warnings(result) if "links need" not in line]
    expect_one(found, ["fix mpm (id cem)", "accelerations of grains", "far lighter", "'density'"], result)


def test_what_is_at_the_limit_is_taken(tmp_path):
    """A gap of half the radius, a cell of four spacings."""
    script = pair(2e-4, gap=RADIUS / 2) + cement(8e-4, 1e-9) + pull(1.0, 1e-6) + "run 1\n"
    result = launch(script, tmp_path)
    assert result.status == 0 and not result.errors() and not warnings(result), result.output[-2000:]


@pytest.mark.parametrize("old, new, needed", [("60e9", "50e9", "'elastic vti 6e+10 4e+10"), (" axis", " quasistatic 10 0 axis", "'quasistatic 1 Z'")])
def test_other_cement_after_a_restart(tmp_path, old, new, needed):
    """The load or the energy would jump."""
    again = restarted("r") + "timestep 1e-9\n" + FIX + f"cell 2e-4 {edit(ELASTIC, old, new)}\n" + BOND + "\nfix m grains nve/sphere\nrun 1\n"
    launch(GOOD + "write_restart r\n", tmp_path)
    result = launch(again, tmp_path, 2)
    assert result.status != 0
    expect_one(result.errors(), ["fix mpm (id cem)", "restart file was written with", needed, "use that"], result)


DAMAGED = "damage tensor B0 1e5 cutoff 0.9"
OTHER_DAMAGE = [
    (DAMAGED, ["'B0' 100000, was 9600", "'regularization nonlocal' 0, was 0.0004", "'energy' 0, was 20", "'imperfection' 0, was 0.002"]),
    ("damage tensor B0 9.6e3 zeta 0.5 regularization nonlocal 4e-4 energy 20", ["'zeta' 0.5, was 1"]),
    ("damage mazars kappa0 1e-4 At 1 Bt 1e4", ["'damage mazars', was 'damage tensor'"]),
    ("damage tensor B0 9600.001 regularization nonlocal 4e-4 energy 20", None),
]


@pytest.mark.parametrize("words, needed", OTHER_DAMAGE)
def test_other_damage_after_a_restart(tmp_path, words, needed):
    """The run goes on, with one warning that has both values."""
    before = f"{ELASTIC} damage tensor B0 9.6e3 cutoff 0.9 regularization nonlocal 4e-4 energy 20"
    again = (
        restarted("r")
        + f"timestep 1e-9\n{FIX} cell 2e-4 {ELASTIC} {words}{'' if 'nonlocal' in words else ' cracks split'}\n{BOND}\nfix m grains nve/sphere\nrun 1\nrun 1\n"
    )
    launch(edit(GOOD, "axis radial damage tensor B0 1e5 cutoff 0.9", before[before.index("axis") :]) + "write_restart r\n", tmp_path)
    result = launch(again, tmp_path, 2)
    found = [line for line in warnings(result) if "other words than in the steps before" in line]
    if needed is None:
        assert result.status == 0 and not found
        return
    expect_one(found, ["fix mpm (id cem)"] + needed, result)


@pytest.mark.parametrize("words", ["kn 1e11", "at points"])
def test_other_coupling_after_a_restart(tmp_path, words):
    again = restarted("r") + "timestep 1e-9\n" + FIX + f"cell 2e-4 {ELASTIC}\n" + BOND + f" {words}\nfix m grains nve/sphere\nrun 1\n"
    launch(GOOD + "write_restart r\n", tmp_path)
    result = launch(again, tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1
    assert "fix mpm/couple (id bond)" in result.errors()[0] and "steps before" in result.errors()[0]
