# SPDX-License-Identifier: GPL-2.0-or-later
"""Text of the scripts that the system tests run, and how they are run.

A script is put together from the parts below, in their order; a test that needs
something else replaces words of the text with `edit`.  SI units throughout.
"""
import math
import os
import re
import signal
import subprocess
from pathlib import Path

import numpy as np

RADIUS = 5e-3
VTI = (60e9, 40e9, 0.25, 0.2, 18e9)  # Ep, Ez, nu_p, nu_zp, Gzp
CALCITE = (50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9)
RING = "inner 1e-3 outer 2e-3"
PATIENCE = float(os.environ.get("MPDEM_TEST_PATIENCE", 1))  # with sanitizers a run takes many times as long


def C33(Ep, Ez, nu_p, nu_zp, Gzp):
    """Stiffness along the axis with the strain across it held at zero."""
    return Ez * (1 - nu_p) / (1 - nu_p - 2 * nu_zp**2 * Ep / Ez)


def uncoupled(script):
    """The script without fix mpm/couple, which fix mpm has to be told."""
    return edit(edit(script, "fix          bond grains mpm/couple cem kn auto kt auto\n", ""), "calcite mpm ", "calcite mpm coupling none ")


def edit(text, old, new):
    """The text with `old`, which has to occur once, replaced."""
    assert text.count(old) == 1, f"{text.count(old)} times in the script, not once: {old!r}"
    return text.replace(old, new)


# ------------------------------------------------------------------------ the scripts


def host(boundary="f f f", processors="* * *"):
    return f"""\
units        si
atom_style   mpdem
atom_modify  map array first grains
boundary     {boundary}
newton       off
communicate  single vel yes
processors   {processors}
"""


# Keep the points out of LIGGGHTS' neighbour lists and ghosts, with `atom_modify first`.
NEIGHBOURS = """\
communicate  single vel yes group grains
neighbor     0.0005 bin
neigh_modify include grains delay 0
"""


def in_cells(words):
    """Options of create_cement with those that leave all of the bond to cells: no film."""
    return words + ("" if "film" in words else " film grid" if "inner" in words else " inner auto")


def pair(spacing, gap=0.0, direction=(0, 0, 1), cement=RING, half_box=(6e-3, 6e-3, 12.5e-3), shape="flat", radius=RADIUS, **options):
    """Two grains, 1 and 2, on `direction` through the origin, and their cement."""
    n = np.array(direction) / np.linalg.norm(direction)
    box = " ".join(f"{-b:.15g} {b:.15g}" for b in half_box)
    text = host(**options) + f"region       box block {box} units box\ncreate_box   2 box\n"
    for side in (-1, 1):
        centre = side * (radius + gap / 2) * n + 0.0  # no minus before a zero
        text += f"create_atoms 1 single {' '.join(f'{c:.15g}' for c in centre)} units box\n"
    return (
        text
        + f"set          type 1 diameter {2 * radius} density 2500\ngroup        grains type 1\n"
        + NEIGHBOURS
        + f"create_cement calcite pair 1 2 shape {shape} {in_cells(cement)} spacing {spacing:.15g}\n"
    )


def restarted(file, **options):
    """What replaces `pair` when the atoms come from a restart file."""
    return host(**options) + f"read_restart {file}\n" + NEIGHBOURS


CONTACT = """\
fix          c1 all property/global kn peratomtypepair 2 9.6e9 9.6e9 9.6e9 9.6e9
fix          c2 all property/global kt peratomtypepair 2 0.96e9 0.96e9 0.96e9 0.96e9
fix          c3 all property/global gamman peratomtypepair 2 0 0 0 0
fix          c4 all property/global gammat peratomtypepair 2 0 0 0 0
fix          c5 all property/global coefficientFriction peratomtypepair 2 0.3 0.3 0.3 0.3
pair_style   gran model hertz/stiffness tangential history
pair_coeff   * *
"""


def cement(cell, timestep, elastic=VTI, axis="global 0 0 1", damage="", couple="kn auto kt auto"):
    """The fixes `cem` and `bond`."""
    return f"""\
timestep     {timestep:.15g}
fix          cem calcite mpm cell {cell:.15g} elastic vti {" ".join(f"{e:.15g}" for e in elastic)} axis {axis} {damage}
fix          bond grains mpm/couple cem {couple}
group        first id 1
group        second id 2
"""


def _motion(direction, position, speed):
    """Grain 1 stays, grain 2 is moved along `direction` by the given formulas."""
    n = np.array(direction) / np.linalg.norm(direction)
    text = f"variable t equal step*dt\nvariable along equal {position}\nvariable speed equal {speed}\n"
    for name, c in zip("xyz", n):
        text += f"variable d{name} equal {c:.17g}*v_along\nvariable v{name} equal {c:.17g}*v_speed\n"
    return text + ("fix hold first move linear 0 0 0\n" "fix pull second move variable v_dx v_dy v_dz v_vx v_vy v_vz\n")


def shift(distance, duration, direction=(0, 0, 1)):
    """Moves grain 2 by `distance`, without a jump in velocity or acceleration."""
    x = f"(v_t/{duration})"
    return _motion(direction, f'"{distance}*({x}-sin(2*PI*{x})/2/PI)"', f'"{distance}/{duration}*(1-cos(2*PI*{x}))"')


def pull(speed, ramp, direction=(0, 0, 1)):
    """Moves grain 2 at `speed`, reached smoothly at time `ramp`."""
    return _motion(
        direction,
        f'"(v_t<{ramp})*0.5*{speed}*(v_t-{ramp}/PI*sin(PI*v_t/{ramp}))+(v_t>={ramp})*{speed}*(v_t-0.5*{ramp})"',
        f'"(v_t<{ramp})*0.5*{speed}*(1-cos(PI*v_t/{ramp}))+(v_t>={ramp})*{speed}"',
    )


# Component of omega of grain 2, and what of the bond is measured, by load.
TURNS = {"torsion": "omegaz", "bending": "omegay"}


def deform(load, amount, duration, timestep, distance, parts=400):
    """Moves grain 2 along z (tension), along x (shear), or rotates it about z (torsion) or about y and the middle of the
    line of centres (bending) by `amount`, m or rad, without a jump in velocity or acceleration, and runs the time this
    takes: `duration`, or a little more.

    The variable `load` is the force or moment that works on it.  distance: of the centres.  Omega, which fix move leaves
    alone, is set in `parts` intervals to its value in their middle; their sum is exact.
    """
    every = max(1, math.ceil(duration / timestep / parts))
    steps = every * parts
    x = f"(v_t/{steps * timestep:.17g})"
    turned, rate = f"{amount}*({x}-sin(2*PI*{x})/2/PI)", f"{amount}/{steps * timestep:.17g}*(1-cos(2*PI*{x}))"
    half = 0.5 * distance
    measured = {"tension": "-f_bond[9]", "shear": "-f_bond[7]", "torsion": "-f_bond[12]", "bending": f"-f_bond[11]-{half}*f_bond[7]"}[load]
    along = {"tension": ("z", 1.0), "shear": ("x", 1.0), "bending": ("x", half), "torsion": ("z", 0.0)}[load]
    d = {"x": "NULL", "y": "NULL", "z": "NULL", along[0]: "v_d"}
    v = {"x": "NULL", "y": "NULL", "z": "NULL", along[0]: "v_v"}
    text = (
        f'variable t equal step*dt\nvariable d equal "{along[1]}*({turned})"\nvariable v equal "{along[1]}*({rate})"\n'
        f"variable load equal {measured}\nfix hold first move linear 0 0 0\n"
        f"fix pull second move variable {' '.join(d.values())} {' '.join(v.values())}\n"
    )
    if load not in TURNS:
        return text + f"run {steps}\n"
    rate = rate.replace("v_t", "v_middle")
    return (
        text + f'variable middle equal v_t+{0.5 * every}*dt\nvariable omega atom "{rate}"\n'
        f"set group second {TURNS[load]} v_omega\n"
        f'run {steps} pre no post no every {every} "set group second {TURNS[load]} v_omega"\nset group second {TURNS[load]} 0\n'
    )


# A free pair that rotates about y and flies; it needs a gap wide enough for no contact.
SPINNING = """\
variable     vx atom "3000*z+1"
variable     vz atom "-3000*x+2"
velocity     all set v_vx 0.5 v_vz
set          group grains omegay 3000
fix          motion grains nve/sphere
"""

# Momentum and angular momentum of free grains and their cement about the origin.
MOMENTA = f"""\
variable     lx atom "mass*(y*vz-z*vy)+0.4*mass*{RADIUS}^2*omegax"
variable     ly atom "mass*(z*vx-x*vz)+0.4*mass*{RADIUS}^2*omegay"
variable     lz atom "mass*(x*vy-y*vx)+0.4*mass*{RADIUS}^2*omegaz"
variable     px atom "mass*vx"
variable     py atom "mass*vy"
variable     pz atom "mass*vz"
compute      sums grains reduce sum v_px v_py v_pz v_lx v_ly v_lz
variable     Px equal c_sums[1]+f_cem[13]
variable     Py equal c_sums[2]+f_cem[14]
variable     Pz equal c_sums[3]+f_cem[15]
variable     Lx equal c_sums[4]+f_cem[16]
variable     Ly equal c_sums[5]+f_cem[17]
variable     Lz equal c_sums[6]+f_cem[18]
"""
MOMENTUM_COLUMNS = ["v_Px", "v_Py", "v_Pz", "v_Lx", "v_Ly", "v_Lz"]


def thermo(every, columns):
    """Names of the table are those of the columns as written here."""
    return (
        f"thermo_style custom step {' '.join(columns)}\n" f"thermo_modify format float %.17g\nthermo {every}\n" f"print \"COLUMNS step {' '.join(columns)}\"\n"
    )


def point_quantities(names, group="calcite"):
    return "".join(f"compute {n} {group} mpm/atom cem {n}\n" for n in names)


def dump(every, columns, file="points.*.txt", group="calcite"):
    columns = ["id"] + list(columns)
    formats = " ".join(["%d"] + ["%.17g"] * (len(columns) - 1))
    return f"dump points {group} custom {every} {file} {' '.join(columns)}\n" f'dump_modify points sort id format "{formats}"\n'


# ------------------------------------------------------------------------ running them


class Run:
    """What one run left behind."""

    def __init__(self, directory, status, output):
        self.directory, self.status, self.output = directory, status, output

    def errors(self):
        return [line for line in self.output.splitlines() if line.startswith("ERROR")]

    def table(self):
        """Thermo output of all `run` commands that followed `thermo`, by column."""
        names, rows = None, []
        for line in self.output.splitlines():
            words = line.split()
            if words[:1] == ["COLUMNS"]:
                names = words[1:]
            elif names and len(words) == len(names) and re.fullmatch(r"\d+", words[0]):
                rows.append([float(w) for w in words])
        assert rows, self.output[-2000:]
        return {n: np.array(c) for n, c in zip(names, zip(*rows))}

    def value(self, name):
        """Number that the script printed as `name value`."""
        found = re.findall(rf"^{name} (\S+)$", self.output, re.M)
        assert len(found) == 1, f"{name}: {found}\n{self.output[-2000:]}"
        return float(found[0])

    def points(self, step, file="points"):
        """One dump by column, in the order of the IDs."""
        with open(self.directory / f"{file}.{step}.txt") as f:
            head = [next(f) for _ in range(9)]
            rows = np.loadtxt(f, ndmin=2)
        return dict(zip(head[8].split()[2:], rows[np.argsort(rows[:, 0])].T))


def executable():
    path = os.environ.get("MPDEM_EXE")
    assert path, "set MPDEM_EXE to the liggghts-mpdem to be tested"
    return str(Path(path).resolve())


def hosted():
    """Whether the program runs on LIGGGHTS' shared library; else the package is compiled into a LIGGGHTS of its own."""
    libraries = subprocess.run(["ldd", executable()], capture_output=True, text=True, check=True).stdout
    return "libliggghts" in libraries


def start(script, directory, ranks=1, program=None, name="in.test", arguments=()):
    """Begins to run the script in `directory`, in a session of its own; output goes to the file NAME.out."""
    directory = Path(directory)
    directory.mkdir(exist_ok=True)
    (directory / name).write_text(script)
    command = [program or executable(), "-in", name, *arguments]
    if ranks > 1:
        # Waiting ranks yield, or a busy machine would take many times as long.
        command = ["mpirun", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1", "-np", str(ranks), *command]
    with open(directory / f"{name}.out", "w") as out:
        return subprocess.Popen(command, cwd=directory, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, start_new_session=True)


def launch(script, directory, ranks=1, name="in.test", minutes=5, **options):
    """Runs the script in `directory`, whatever comes of it."""
    process = start(script, directory, ranks, name=name, **options)
    try:
        process.wait(60 * minutes * PATIENCE)
    except BaseException:
        os.killpg(process.pid, signal.SIGKILL)
        raise
    # LIGGGHTS follows one error in five with a joke that it has freed already.
    return Run(Path(directory), process.returncode, (Path(directory) / f"{name}.out").read_text(errors="replace"))


def run(script, directory, ranks=1, **options):
    """Runs a script that is expected to work."""
    result = launch(script, directory, ranks, **options)
    assert result.status == 0 and not result.errors(), result.output[-3000:]
    return result
