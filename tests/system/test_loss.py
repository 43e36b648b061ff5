# SPDX-License-Identifier: GPL-2.0-or-later
"""What is lost stops the run: exit status not 0, and one message on the screen, which is a file here, and
in the log, on one rank and on two."""
import pytest
from scenes import cement, edit, hosted, launch, pair, pull, restarted, run, thermo, uncoupled

GOOD = pair(2e-4) + cement(4e-4, 1e-9, axis="radial", damage="damage tensor B0 9.6e6 cutoff 0.9 check 5") + pull(1.0, 1e-6) + "run 20\n"
RUN = "run 20\n"
HOLD, PULL = "fix hold first move linear 0 0 0\n", "fix pull second move variable v_dx v_dy v_dz v_vx v_vy v_vz\n"
FREE = [(HOLD + PULL, "fix motion grains nve/sphere\n")]
UPDATED = [("axis radial", "axis radial kinematics updated")]
# infinite from the second step on, so that its cosine is no number
BAD = 'variable bad equal "cos(exp(400*step))"\n'
FLY = [(HOLD + PULL, "velocity all set 300 0 0\nfix motion grains nve/sphere\n"), ("timestep     1e-09", "timestep     1e-8")]
THIRD = [
    (
        "group        grains type 1",
        "create_atoms 1 single 0 0 0.0175 units box\n" "group third id 3\nset group third diameter 0.005 density 2500\ngroup        grains type 1",
    ),
    ("-0.0125 0.0125", "-0.0125 0.025"),
]


def after(text):
    return [(RUN, RUN + text + RUN)]


def before(text):
    return [(RUN, text + RUN)]


def with_force(words):
    return FREE + [(RUN, BAD + f"fix load second addforce {words}\n" + RUN)]


UNCOUPLED = [("fix          bond grains mpm/couple cem kn auto kt auto\n", ""), ("calcite mpm ", "calcite mpm coupling none ")]
# name: (changes as (old, new), words that the message has to hold)
CASES = {
    # out of the box or the grid
    "points leave the box": (FLY + [(RUN, "run 3000\n")], ["fix mpm (id cem)", "left the simulation box", "larger"]),
    "points leave the box, updated": (UPDATED + FLY + [(RUN, "run 3000\n")], ["fix mpm (id cem)", "left the simulation box", "larger"]),
    "points leave the box, unstable": (
        [*UNCOUPLED, (RUN, "velocity calcite set 1e6 0 0\n" + RUN)],
        ["fix mpm (id cem)", "left the simulation box", "moves 2.5 cells a step", "smaller time step"],
    ),
    "points leave the grid": (
        UPDATED + [(HOLD + PULL, "fix motion grains nve/sphere\n"), (RUN, 'variable v atom "1e6*z/0.0005"\nvelocity calcite set v_v 0 0\n' + RUN)],
        ["fix mpm (id cem)", "more than two cells", "check"],
    ),
    "bonded grain leaves the box": (
        [(HOLD + PULL, "fix motion grains move linear 0 0 1e4\nvelocity all set 0 0 1e4\n"), (RUN, "run 2000\n")],
        ["fix mpm (id cem)", "grain 2", "lost", "larger box"],
    ),
    "a data file, which has no cement": (
        after("write_data scene.data\n"),
        ["write_data", "would lose the cement", "grains 1 and 2", "write_restart", "write_cement"],
    ),
    "a compute outlives its fix": (
        after("compute d calcite mpm/atom cem damage\nunfix bond\nunfix cem\nwrite_dump calcite custom last.txt id c_d\n"),
        ["compute mpm/atom (id d)", "fix mpm 'cem' is gone"],
    ),
    # not finite
    "force of a grain": (with_force("v_bad 0 0"), ["fix mpm (id cem)", "not finite"]),
    "force of a grain, updated": (UPDATED + with_force("v_bad 0 0"), ["fix mpm (id cem)", "not finite"]),
    "velocity of a grain": (
        FREE + [(RUN, 'variable bad atom "cos(exp(400*(z>0)*10))"\nvelocity second set v_bad 0 0\n' + RUN)],
        ["fix mpm (id cem)", "not finite"],
    ),
    "velocity of points": ([(RUN, 'variable bad atom "cos(exp(4000*(x>0)))"\nvelocity calcite set v_bad 0 0\n' + RUN)], ["fix mpm (id cem)", "not finite"]),
    "place of a moved grain": (
        [("variable along equal", "variable other equal"), (RUN, 'variable along equal "1e-9*cos(exp(400*step))"\n' + RUN)],
        ["fix mpm (id cem)", "not finite", "check"],
    ),
    "a grain without cement": (
        THIRD + [(RUN, BAD + "fix alone third nve/sphere\nfix load third addforce v_bad 0 0\n" + RUN)],
        ["fix mpm (id cem)", "grain 3", "not finite"],
    ),
    "without the coupling": (
        [
            *UNCOUPLED,
            (RUN, 'variable bad atom "cos(exp(4000*(x>0)))"\nvelocity calcite set v_bad 0 0\n' + RUN),
        ],
        ["fix mpm (id cem)", "not finite"],
    ),
    # deleted
    "a bonded grain is deleted": (after("delete_atoms group second compress no\n"), ["fix mpm (id cem)", "grain 2", "deleted", "keep"]),
    "a bonded grain is deleted before the run": (before("delete_atoms group second compress no\n"), ["fix mpm (id cem)", "grain 2", "deleted", "keep"]),
    "a bonded grain is deleted, updated": (UPDATED + after("delete_atoms group second compress no\n"), ["fix mpm (id cem)", "grain 2", "deleted", "keep"]),
    "points are deleted before write_cement": (
        after("delete_atoms group calcite compress no\nwrite_cement cement.csv\n"),
        ["write_cement", "960 of 960 material points were deleted"],
    ),
    "some points are deleted": (
        after("region half block -1 1 0 1 -1 1 units box\ngroup half region half\n" "group gone subtract half grains\ndelete_atoms group gone compress no\n"),
        ["fix mpm (id cem)", "deleted", "cannot"],
    ),
    "all points are deleted": (after("delete_atoms group calcite compress no\n"), ["fix mpm (id cem)", "deleted", "cannot"]),
    "all points are deleted before the run": (before("delete_atoms group calcite\n"), ["fix mpm (id cem)", "deleted", "cannot"]),
    "IDs change": (
        THIRD + [(HOLD, HOLD + "fix rest third freeze\n"), *after("delete_atoms group third\n")],
        ["fix mpm (id cem)", "delete_atoms", "compress no"],
    ),
    "points are replicated": (
        [("f f f", "p p p"), ("timestep     1e-09", "replicate 2 1 1 offset 0.012 0.012 0.025 shift 0 0 0\ntimestep     1e-09")],
        ["fix mpm (id cem)", "IDs of atoms", "replicate"],
    ),
    # bonded grains that move where nothing in the scene moves them, or change size
    "a grain is displaced before the run": (
        before("displace_atoms second move 0 0 1e-6 units box\n"),
        ["fix mpm (id cem)", "moved bonded grain 2 by 1e-06", "cement was made", "create_cement"],
    ),
    "a grain is displaced between runs": (
        after("displace_atoms second move 0 1e-9 0 units box\n"),
        ["fix mpm (id cem)", "moved bonded grain 2 by 1e-09", "last run", "displace_atoms"],
    ),
    "a grain is set elsewhere": (FREE + after("set group second x 1e-8\n"), ["fix mpm (id cem)", "moved bonded grain 2", "'set'"]),
    "a grain is displaced without a setup": (
        [(HOLD + PULL, "fix motion grains nve/sphere\n"), (RUN, RUN + "displace_atoms second move 0 0 1e-7 units box\nrun 20 pre no\n")],
        ["fix mpm (id cem)", "moved bonded grain 2 by 1e-07", "last run", "displace_atoms"],
    ),
    "cement is made without a setup": (
        THIRD
        + [
            ("0 0 0.0175", "0 0 0.0125"),
            ("group        first id 1", "fix grown third nve/sphere\ngroup        first id 1"),
            (RUN, RUN + "create_cement calcite pair 2 3 shape flat outer 1.6e-3 inner 1e-3 film grid spacing 2e-4\nrun 20 pre no\n"),
        ],
        ["run ... pre no", "2 bonds", "1 in the last run", "leave 'pre no' out"],
    ),
    "points are deleted without a setup": (
        [(RUN, RUN + "delete_atoms group calcite compress no\nrun 20 pre no\n")],
        ["run ... pre no", "material points", "were deleted"],
    ),
    "a grain is deleted without a setup": (
        THIRD
        + [
            ("0 0 0.0175", "0 0 0.0125"),
            ("group        first id 1", "fix grown third nve/sphere\ngroup        first id 1"),
            (RUN, RUN + "delete_atoms group third compress no\nrun 20 pre no\n"),
        ],
        ["run ... pre no", "962 atoms", "963 at the end of the last run", "leave 'pre no' out"],
    ),
    "a restart file in parts of a run": (
        [(RUN, RUN + 'run 20 pre no every 10 "write_restart r"\n')],
        ["run ... pre no every", "'write_restart'", "leave 'pre no' out"],
    ),
    "another time step without a setup": (
        [(RUN, RUN + "timestep 2e-9\nrun 20 pre no\n")],
        ["run ... pre no", "2e-09", "1e-09 in the last run", "leave 'pre no' out"],
    ),
    "another density of points without a setup": ([(RUN, RUN + "set group calcite density 3000\nrun 20 pre no\n")], ["density of the points", "2710"]),
    "another fix mpm/couple without a setup": (
        [(RUN, RUN + "fix bond grains mpm/couple cem kn auto kt auto csv 5 b.csv\nrun 20 pre no\n")],
        ["run ... pre no", "fix mpm/couple (id bond)", "since the last run"],
    ),
    "another gravity without a setup": (
        [(RUN, "fix weight all gravity 9.81 vector 0 0 -1\n" + RUN + "unfix weight\nfix load grains gravity 1e9 vector 0 1 0\nrun 20 pre no\n")],
        ["run ... pre no", "fix gravity (id load)", "defined since the last run", "leave 'pre no' out"],
    ),
    "gravity of the same name without a setup": (
        [(RUN, "fix weight all gravity 9.81 vector 0 0 -1\n" + RUN + "fix weight all gravity 9.81 vector 1 0 0\nrun 20 pre no\n")],
        ["run ... pre no", "fix gravity (id weight)", "defined since the last run"],
    ),
    "no gravity any more without a setup": (
        [(RUN, "fix weight all gravity 9.81 vector 0 0 -1\n" + RUN + "unfix weight\nrun 20 pre no\n")],
        ["run ... pre no", "fix gravity (id weight)", "removed since the last run"],
    ),
    "no gravity any more in parts of a run": (
        [(RUN, "fix weight all gravity 9.81 vector 0 0 -1\n" + RUN + 'run 20 pre no every 10 "unfix weight"\n')],
        ["run ... pre no", "fix gravity (id weight)", "removed since the last run"],
    ),
    "no fix mpm without a setup": (
        [(RUN, "fix limit all check/timestep/mpm 10 cem 0.9\n" + RUN + "unfix bond\nunfix cem\nrun 20 pre no\n")],
        ["atom_style mpdem", "no fix mpm"],
    ),
    "a time integrator without forces of whole steps": ([(RUN, "run_style respa 1\n" + RUN)], ["fix mpm (id cem)", "'run_style respa'", "run_style verlet"]),
    "a minimization": (
        [(HOLD + PULL, "fix motion grains nve/sphere\n"), (RUN, "compute thermo_pe all pe\nminimize 0 0 50 50\n")],
        ["fix mpm (id cem)", "'minimize'", "use 'run'", "quasistatic"],
    ),
    "the coupling comes before": (
        [(RUN, "unfix cem\nfix cem calcite mpm cell 4e-4 elastic isotropic 6e10 0.2\n" + RUN)],
        ["fix mpm (id cem)", "fix mpm/couple (id bond)", "has to come after it"],
    ),
    "a coupling is replaced by one of another cement": (
        after("fix bond grains mpm/couple cement kn auto kt auto\n"),
        ["fix mpm/couple (id bond)", "'cement' is not a fix mpm"],
    ),
    "gravity of the step before": (
        [(RUN, "variable g equal 9.81*step\nfix weight all gravity v_g vector 0 0 -1\n" + RUN)],
        ["fix mpm (id cem)", "fix 'weight' (gravity)", "define it before"],
    ),
    "gravity of a part of the cement": (
        [(RUN, "group part id 3:500\nfix weight part gravity 9.81 vector 0 0 -1\n" + RUN)],
        ["fix mpm (id cem)", "fix 'weight' (gravity)", "group 'part'", "'all'"],
    ),
    "gravity of a part of the cement, points made later": (
        [
            ("-0.0125 0.0125", "-0.0125 0.0225"),
            ("group        grains type 1", "create_atoms 1 single 0 0 0.015 units box\nset type 1 diameter 0.01 density 2500\ngroup        grains type 1"),
            ("timestep     1e-09", "create_cement calcite pair 2 3 shape flat inner 1e-3 outer 2e-3 film grid spacing 2e-4 points later\ntimestep     1e-09"),
        ]
        + FREE
        + [("check 5", "check 5 condense yes"), (RUN, "group made subtract all grains\nfix weight made gravity 9.81 vector 0 0 -1\n" + RUN)],
        ["fix mpm (id cem)", "fix 'weight' (gravity)", "group 'made'", "'all'"],
    ),
    "a grain of the type of cement": (
        FREE + [(RUN, RUN + "create_atoms 2 single 0 0 0.011 units box\nset atom 963 diameter 1e-3 density 2500\ngroup grains id 963\n" + RUN)],
        ["type 2 is that of grain 963 too", "atom_type"],
    ),
    "points are deleted after no steps": (
        [(RUN, RUN + "run 0\ndelete_atoms group calcite compress no\nrun 20 pre no\n")],
        ["run ... pre no", "material points", "were deleted"],
    ),
    "points are displaced without a setup": (
        [(RUN, RUN + "displace_atoms calcite move 0 0 1e-6 units box\nrun 20 pre no\n")],
        ["fix mpm (id cem)", "changed position or velocity of material point"],
    ),
    "points grow before the run": (before("set type 2 diameter 1e-3\n"), ["fix mpm (id cem)", "changed the diameter of material point", "create_cement"]),
    "points grow": (after("set type 2 diameter 1e-3\n"), ["fix mpm (id cem)", "changed the diameter of material point"]),
    "points get heavier": (after("set type 2 density 5000\n"), ["fix mpm (id cem)", "density of the points is 5000, and was 2710", "before the first run"]),
    "points get heavier after a restart": (
        after("write_restart r\nclear\n" + restarted("r") + GOOD[GOOD.index("timestep") :].replace(RUN, "set type 2 density 5000\n")),
        ["fix mpm (id cem)", "density of the points is 5000, and was 2710"],
    ),
    "a restart file without fix mpm": (
        after(f"write_restart r\nclear\n{restarted('r')}write_restart r\n"),
        ["write_restart", "grains 1 and 2", "in motion", "no fix mpm", "'run 0'"],
    ),
    "a restart file after unfix": (
        after("unfix bond\nunfix cem\nwrite_restart r\n"),
        ["write_restart", "grains 1 and 2", "in motion", "no fix mpm", "'unfix' it later"],
    ),
    "a grain grows": (
        after("set group second diameter 0.0101\n"),
        ["fix mpm (id cem)", "bonded grain 2 has radius 0.00505", "made for 0.005", "create_cement"],
    ),
    "a grain grows in the run": (
        [(RUN, "variable d equal 0.01*(1+1e-6*step)\nfix grow second adapt 1 atom diameter v_d\n" + RUN)],
        ["fix mpm (id cem)", "bonded grain 2 has radius", "step 1", "fix adapt"],
    ),
    "the box scales": (after("change_box grains z scale 1.01 remap units box\n"), ["fix mpm (id cem)", "moved bonded grain", "change_box"]),
    "the periodic box changes": (
        [("f f f", "f f p"), *before("change_box grains z delta 0 1e-3 units box\n")],
        ["fix mpm (id cem)", "periodic in z with length 0.026", "0.025", "change_box", "before create_cement"],
    ),
    "the periodic box changes without a setup": (
        [("f f f", "f f p"), (RUN, RUN + "change_box grains z delta 0 1e-3 units box\nrun 20 pre no\n")],
        ["fix mpm (id cem)", "periodic in z with length 0.026", "at step 21"],
    ),
    "the box is deformed": (
        [("f f f", "f f p"), *before("fix squeeze grains deform 1 z erate -1 remap x\n")],
        ["fix mpm (id cem)", "'squeeze' (deform)", "walls"],
    ),
    "the time step changes under a formula": (
        [(HOLD + PULL, "fix hold first move linear 0 0 0\nfix pull second move linear 0 0 1\n"), ("run 20\n", "run 200\ntimestep 5e-10\nrun 20\n")],
        ["fix mpm (id cem)", "bonded grain 2 jumped by", "step 201", "'timestep'", "anew"],
    ),
    "the step is reset under a formula": (
        [(RUN, "run 500\nreset_timestep 0\nrun 20\n")],
        ["fix mpm (id cem)", "bonded grain 2 jumped by", "step 1,", "'reset_timestep'"],
    ),
    # the fix that has the motion
    "no fix mpm": (
        [
            ("fix          cem calcite", "fix other calcite property/atom a scalar no no no 0 #"),
            ("fix          bond grains mpm/couple cem kn auto kt auto\n", ""),
        ],
        ["atom_style mpdem", "no fix mpm", "define", "mpm/couple"],
    ),
    "the fix is deleted and defined again": (
        after("unfix bond\nunfix cem\nfix cem calcite mpm cell 4e-4 elastic isotropic 4e10 0.2\nfix bond grains mpm/couple cem\n"),
        ["fix mpm (id cem)", "grains 1 and 2", "in motion", "'unfix'", "keep that fix"],
    ),
    "other axis": (
        [
            (
                RUN,
                "run 0\nunfix bond\nunfix cem\nfix cem calcite mpm cell 4e-4 elastic isotropic 4e10 0.2 axis global 1 0 0\n"
                "fix bond grains mpm/couple cem\n" + RUN,
            )
        ],
        ["fix mpm (id cem)", "'axis global 1 0 0'", "by 'axis radial'", "use that"],
    ),
    # moved by two or by nothing
    "two fix mpm": (
        [("group        first", "fix cem2 calcite mpm cell 4e-4 elastic isotropic 40e9 0.2\ngroup        first")],
        ["fix mpm", "cem2", "cem", "unfix"],
    ),
    "calcite moved by nve/sphere": (before("fix other calcite nve/sphere\n"), ["fix mpm (id cem)", "other", "nve/sphere", "give it a group"]),
    "calcite moved by move": (before("fix other calcite move linear 0 0 1\n"), ["fix mpm (id cem)", "other", "move", "give it a group"]),
    "a grain moved by two": (
        before("fix other second nve/sphere\n"),
        ["fix mpm/couple (id bond)", "grain 2", "'pull' (move)", "'other' (nve/sphere)", "unfix one"],
    ),
    "a grain moved by nothing": ([(HOLD, "")], ["fix mpm/couple (id bond)", "grain 1", "no fix", "fix freeze", "move linear 0 0 0"]),
    "a grain held with a velocity": (
        [(HOLD, "fix hold first freeze\nset group first omegax 10\n")],
        ["fix mpm/couple (id bond)", "grain 1", "velocity", "set"],
    ),
}


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_message(tmp_path, name, ranks):
    changes, needed = CASES[name]
    script = GOOD
    for old, new in changes:
        script = edit(script, old, new)
    result = launch(script, tmp_path, ranks)
    assert result.status != 0, result.output[-1500:]
    errors = result.errors()
    assert len(errors) == 1, result.output[-1500:]
    missing = [word for word in needed if word not in errors[0]]
    assert not missing, errors[0]
    in_log = [line for line in (tmp_path / "log.liggghts").read_text(errors="replace").splitlines() if line.startswith("ERROR")]
    assert in_log == errors


def test_a_fix_before_the_cement_is_removed_without_a_setup(tmp_path):
    """LIGGGHTS calls fixes by their indices, and so would leave out fix mpm."""
    if not hosted():
        pytest.skip("a LIGGGHTS with the package compiled in calls nothing of it then")
    result = launch(edit(GOOD, "fix          cem", "fix weight all gravity 9.81 vector 0 0 -1\nfix          cem") + "unfix weight\nrun 20 pre no\n", tmp_path)
    assert result.status != 0 and len(result.errors()) == 1, result.output[-1500:]
    assert "run ... pre no: fix gravity (id weight) was removed since the last run" in result.errors()[0]


@pytest.mark.parametrize("hold", ["fix hold first freeze\n", HOLD, "fix rest first nve/sphere\nfix hold first freeze\n"])
def test_ways_to_hold_a_grain(tmp_path, hold):
    result = launch(edit(GOOD, HOLD, hold), tmp_path)
    assert result.status == 0 and not result.errors(), result.output[-2000:]


def test_commands_that_leave_grains_where_they_are(tmp_path):
    """Runs in parts, a motion defined anew with its formulas, another time step of free grains: none is a displacement."""
    script = edit(GOOD, "f f f", "p p p") + "run 0\nrun 20 pre no\nunfix pull\nfix pull second move linear 0 0 0\nrun 5\n"
    script += "unfix pull\nunfix hold\nfix motion grains nve/sphere\nvelocity grains set 30 30 30\ntimestep 5e-10\nrun 20\nreset_timestep 0\nrun 20\n"
    result = launch(script, tmp_path, 2)
    assert result.status == 0 and not result.errors(), result.output[-2000:]


@pytest.mark.parametrize("ranks", [1, 2])
def test_gravities_add_up(tmp_path, ranks):
    script = edit(uncoupled(GOOD), HOLD + PULL, "")
    script = edit(
        script,
        RUN,
        "fix motion grains nve/sphere\nfix down all gravity 9.81 vector 0 0 -1\nfix along all gravity 9.81 vector 1 0 0\n"
        "fix across grains gravity 9.81 vector 0 1 0\nfix up grains gravity 9.81 vector 0 -1 0\n" + thermo(20, ["f_cem[13]", "f_cem[14]", "f_cem[15]"]) + RUN,
    )
    table = run(script, tmp_path, ranks).table()
    assert table["f_cem[13]"][-1] > 0 and table["f_cem[15]"][-1] == pytest.approx(-table["f_cem[13]"][-1], rel=1e-9)
    assert abs(table["f_cem[14]"][-1]) < 1e-9 * table["f_cem[13]"][-1]


def test_a_fix_that_reads_forces_acts_on_nothing(tmp_path):
    assert "acts on material points" not in run(edit(GOOD, RUN, "fix last all store/force\n" + RUN), tmp_path).output


# Overlapping grains in the upper half of the box only: too many neighbours for one rank of two.
CROWD = """\
units        si
atom_style   sphere
newton       off
communicate  single vel yes
processors   1 1 2
region       box block 0 1 0 1 0 1 units box
create_box   1 box
region       upper block 0.4 0.6 0.4 0.6 0.7 0.9 units box
lattice      sc 0.04
create_atoms 1 region upper
set          group all diameter 0.1 density 2500
neighbor     0.01 bin
neigh_modify one 10 page 100
fix c1 all property/global youngsModulus peratomtype 5e6
fix c2 all property/global poissonsRatio peratomtype 0.45
fix c3 all property/global coefficientRestitution peratomtypepair 1 0.3
fix c4 all property/global coefficientFriction peratomtypepair 1 0.5
pair_style   gran model hertz tangential history
pair_coeff   * *
timestep     1e-6
fix motion all nve/sphere
"""


@pytest.mark.parametrize("arguments, log", [((), "log.liggghts"), (("-log", "other.log"), "other.log"), (("-screen", "none"), "log.liggghts")])
def test_error_of_one_rank(tmp_path, arguments, log):
    """LIGGGHTS' own Error::one on the second rank, which has no log open."""
    result = launch(CROWD + "run 1\n", tmp_path, 2, arguments=arguments)
    assert result.status != 0
    errors = result.errors()
    assert len(errors) == 1 and "ERROR on proc 1: Neighbor list overflow" in errors[0], result.output[-1500:]
    if not hosted():
        pytest.skip("a LIGGGHTS with the package compiled in shows it on the screen, but only the first rank writes to the log")
    assert (tmp_path / log).read_text().splitlines()[-1] == errors[0]


def test_error_of_one_rank_after_the_command_log(tmp_path):
    result = launch(CROWD + "log second.log\nrun 1\n", tmp_path, 2)
    assert result.status != 0 and len(result.errors()) == 1
    if not hosted():
        pytest.skip("a LIGGGHTS with the package compiled in shows it on the screen, but only the first rank writes to the log")
    assert (tmp_path / "second.log").read_text().splitlines()[-1] == result.errors()[0]
