#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Parameters of the cement from a laboratory test, as lines of a script.

    tools/parameters.py --ucs 3e5 --calcite 0.03 --diameter 3e-4 --void-ratio 0.7
    tools/parameters.py --ucs 1e6 --calcite 0.05 --diameter 3e-4 --porosity 0.4 --coordination 4.8 --isotropic 7e10 0.3
    tools/parameters.py --ucs 3e5 --calcite 0.03 --diameter 3e-4 --void-ratio 0.7 --measured 3.6e5

Prints the lines that follow the grains in a script, with a comment on each value: what it is, its unit, and whether the
relation is exact or an estimate. SI units. `include` reads the lines from a file. The last comment is a command that
measures the unconfined strength of examples/specimen with these parameters; --measured takes its result and corrects
B0. Formulas and sources: doc/howto_parameters.md. Needs Debian's python3-numpy.
"""
import argparse
import math
import os
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    import numpy as np
except ImportError as missing:
    sys.exit(f"parameters.py: {missing}; apt-get install python3-numpy, run with /usr/bin/python3")

CALCITE = (50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9)  # Ep, Ez (Pa), nu_p, nu_zp, Gzp (Pa), as in examples/specimen
CUTOFF = 0.9  # critical damage, the default of fix mpm
INNER = 0.2  # of the radius of a grain, the default of create_cement
# UCS over the stress of Rumpf: the mean of the four specimens without side walls in doc/specimen.md. They have 1.16 to 1.69.
UCS_OVER_RUMPF = 1.45
SHARE = 1e-3  # kinetic share of the energy at half of the peak that the speed is chosen for
# Fracture energy over sqrt(2) B0 L with `nonlocal L` at the ends of the range of fix mpm, and without softening of its own (m = 0).
LEAST, PLAIN, MOST = 3.031, 4.516, 36.06
COARSEST = 0.05  # diameter of a grain, m: above, millimetres are taken for metres
STRENGTHS = (1e4, 1e9)  # of cement, Pa: beyond, the words are taken for wrong
# The specimen of 80 beads of examples/specimen: mean diameter (m), porosity, bonds on a bead, density (kg/m3) of beads and cement.
EXAMPLE = {"diameter": 3.7e-3, "porosity": 0.483, "coordination": 4.1, "grain": 2500.0, "cement": 2710.0}


class Trouble(Exception):
    """One line for the user."""


def number(low, high, what):
    """A number above `low` and below `high`; the message says what it is."""

    def read(text):
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low < value < high:
            bounds = f"above {low:g}" if high == math.inf else f"above {low:g} and below {high:g}"
            raise argparse.ArgumentTypeError(f"{text}: {what}, must be {bounds}")
        return value

    return read


def ratio(text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        hint = f"; for {value:g} % give {value / 100:g}" if 1.0 <= value <= 100.0 else ""
        raise argparse.ArgumentTypeError(f"{text}: mass of calcite over mass of all grains, must be above 0 and below 1{hint}")
    return value


def grain(text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < COARSEST:
        hint = f"; for {value:g} mm give {value / 1000:g}" if COARSEST <= value < 1000 * COARSEST else ""
        raise argparse.ArgumentTypeError(f"{text}: mean diameter of the grains in m, must be above 0 and below {COARSEST:g}{hint}")
    return value


class Parser(argparse.ArgumentParser):
    def error(self, message):
        sys.exit(f"parameters.py: {message}")


def arguments():
    p = Parser(description="Parameters of the cement from a laboratory test, as lines of a script. SI units.", allow_abbrev=False)
    above = math.inf
    p.add_argument(
        "--ucs", type=number(0, above, "unconfined compressive strength in Pa"), required=True, metavar="PA", help="unconfined compressive strength, Pa"
    )
    p.add_argument("--calcite", type=ratio, required=True, metavar="C", help="calcite content: mass of calcite over mass of all grains; 0.03 for 3 %%")
    p.add_argument(
        "--inactive",
        type=number(0, 1, "share of the calcite that joins no grains"),
        default=0.0,
        metavar="S",
        help="share of the calcite that joins no grains; it becomes coats (0)",
    )
    p.add_argument("--diameter", type=grain, required=True, metavar="M", help="mean diameter of the grains, m")
    pores = p.add_mutually_exclusive_group(required=True)
    pores.add_argument("--porosity", type=number(0, 1, "volume of pores over all volume"), metavar="N", help="of the packing without cement")
    pores.add_argument("--void-ratio", type=number(0, above, "volume of pores over volume of grains"), metavar="E", help="instead of the porosity")
    p.add_argument("--coordination", type=number(0, 15, "bonds on a grain"), default=4.3, metavar="Z", help="mean number of bonds on a grain (4.3)")
    p.add_argument("--grain-density", type=number(0, above, "density in kg/m3"), default=2650.0, metavar="KG/M3", help="2650, quartz")
    p.add_argument("--cement-density", type=number(0, above, "density in kg/m3"), default=2710.0, metavar="KG/M3", help="2710, calcite")
    moduli = p.add_mutually_exclusive_group()
    moduli.add_argument("--isotropic", type=float, nargs=2, metavar=("E", "NU"), help="Young's modulus of the cement, Pa, and Poisson's ratio")
    moduli.add_argument(
        "--vti", type=float, nargs=5, default=CALCITE, metavar=("EP", "EZ", "NU_P", "NU_ZP", "GZP"), help="transversely isotropic set (that of calcite)"
    )
    p.add_argument(
        "--zeta",
        type=number(0, 1.0000001, "tensile over compressive strength of the cement"),
        default=0.1,
        metavar="Z",
        help="tensile over compressive strength of the cement (0.1)",
    )
    p.add_argument(
        "--energy",
        type=number(0, above, "fracture energy in J/m2"),
        metavar="J/M2",
        help="fracture energy of the cement, with an internal length of a cell (film: none)",
    )
    p.add_argument(
        "--spacing", type=number(0, above, "spacing of the material points in m"), metavar="M", help="of the material points (a twentieth of the diameter)"
    )
    p.add_argument("--strain", type=number(0, 1, "axial strain at the peak"), metavar="S", help="at the peak of the model, for the speed")
    p.add_argument(
        "--measured",
        type=number(0, above, "unconfined compressive strength in Pa"),
        metavar="PA",
        help="strength that the command in the last line gave, as printed without --measured; corrects B0",
    )
    return p.parse_args()


class Cement:
    """Elastic set of the cement."""

    def __init__(self, isotropic, vti):
        if isotropic:
            E, nu = isotropic
            if not (0.0 < E < math.inf and -1.0 < nu < 0.5):
                raise Trouble(f"--isotropic {E:g} {nu:g}: E in Pa must be above 0, Poisson's ratio above -1 and below 0.5")
            self.words, vti = f"isotropic {E:g} {nu:g}", (E, E, nu, nu, E / (2.0 * (1.0 + nu)))
        else:
            self.words = "vti " + " ".join(f"{v:g}" for v in vti)
        self.Ep, self.Ez, nu_p, nu_zp, self.Gzp = vti
        slack = 1.0 - nu_p - 2.0 * nu_zp**2 * self.Ep / self.Ez if min(self.Ep, self.Ez) > 0.0 else 0.0
        if not (min(self.Ep, self.Ez, self.Gzp) > 0.0 and abs(nu_p) < 1.0 and slack > 0.0 and math.isfinite(sum(vti))):
            raise Trouble(f"--vti {' '.join(f'{v:g}' for v in vti)}: this set is not positive definite; Ep Ez nu_p nu_zp Gzp, moduli in Pa")
        self.C33 = self.Ez * (1.0 - nu_p) / slack  # along the axis, strain across it held at zero

    def strength(self, B0, modulus):
        return 2.0**0.25 * math.sqrt(B0 * modulus)


class Bond:
    """Flat bond of two equal grains that touch, without cement inside the radius that create_cement leaves out."""

    def __init__(self, radius, volume):
        self.radius, self.inner = radius, INNER * radius
        if volume > self._volume(radius):
            raise Trouble(
                f"a bond of volume {volume:.3g} m3 does not fit between grains of radius {radius:.3g} m, whose gap holds {self._volume(radius):.3g}: "
                "the calcite content is too large for this mean number of bonds"
            )
        low, high = self.inner, radius
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._volume(middle) < volume else (low, middle)
        self.outer = low
        self.section = math.pi * (self.outer**2 - self.inner**2)
        self.attached = 2.0 * math.pi * radius * (self._height(self.inner) - self._height(self.outer))  # at one grain

    def _height(self, r):
        return math.sqrt((self.radius - r) * (self.radius + r))

    def _volume(self, r):
        """Of the gap between the inner radius and r."""

        def within(x):
            return 2.0 * math.pi * self.radius * x**2 + 4.0 / 3.0 * math.pi * self._height(x) ** 3

        return within(r) - within(self.inner)

    def thickness(self, r):
        return 2.0 * (self.radius - self._height(r))

    def is_film(self, spacing):
        """Whether create_cement makes columns of all of it: the rim outside of what is thinner than a cell is narrower than a cell."""
        cell = 2.0 * spacing
        thin = math.sqrt(max(0.0, self.radius**2 - (self.radius - 0.5 * cell) ** 2))
        return self.outer - thin < cell

    def columns(self):
        """Thickness and section of the rings of columns, as in geometry/film_fill.cpp."""
        low, high = math.log(self.thickness(self.inner)), math.log(self.thickness(self.outer))
        at, weight = np.polynomial.legendre.leggauss(min(8, max(4, math.ceil(3.0 * (high - low)))))
        t = np.exp(low + 0.5 * (1.0 + at) * (high - low))
        section = t * (self.radius - 0.5 * t) * weight
        return t, section * self.section / section.sum()

    def force(self, cement, B0, energy):
        """Largest tension, N: columns in uniaxial strain, pulled by rigid grains, that soften by the law of `damage tensor`. energy: 0 for none."""
        t, section = self.columns()
        m = np.array([exponent(energy / (math.sqrt(2.0) * B0 * thickness)) for thickness in t])
        onset = 2.0**0.25 * math.sqrt(B0 / cement.C33)
        opening = np.concatenate([t, np.geomspace(t.min(), 30.0 * t.max(), 2000)])[:, None]  # over the strain of the onset, also that of each ring
        strain = opening / t
        stress = np.where(strain <= 1.0, strain, strain ** (-(3.0 - m) / (1.0 + m)))
        stress[strain > (1.0 - CUTOFF) ** (-0.5 * (1.0 + m))] = 0.0
        return float(cement.C33 * onset * (stress @ section).max())


def work(m):
    """Energy of a volume that is pulled to failure, over sqrt(2) B0."""
    keep = 1.0 - CUTOFF
    spent = -math.log(keep) if abs(m - 1.0) < 1e-9 else (1.0 - keep ** (1.0 - m)) / (1.0 - m)
    return spent + 0.5 * keep ** (1.0 - m)


def exponent(wanted):
    """Exponent of softening of a layer that takes this energy, 0 to 2.99."""
    low, high = 0.0, 2.99
    if wanted <= work(low) or wanted >= work(high):
        return low if wanted <= work(low) else high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if work(middle) < wanted else (low, middle)
    return low


def rumpf(force, diameter, porosity, coordination):
    """Stress of a packing in which each bond carries this force along the line of centres."""
    return (1.0 - porosity) * coordination * force / (math.pi * diameter**2)


class Parameters:
    def __init__(self, args):
        self.args = args
        self.porosity = args.porosity if args.porosity is not None else args.void_ratio / (1.0 + args.void_ratio)
        self.cement = Cement(args.isotropic, args.vti)
        d = args.diameter
        self.content = args.calcite * (1.0 - args.inactive) / args.coordination
        self.spacing = args.spacing or 0.05 * d
        self.cell = self.length = 2.0 * self.spacing
        mass = args.grain_density * math.pi / 6.0 * d**3
        self.bond = Bond(0.5 * d, self.content * 2.0 * mass / args.cement_density)
        self.film = self.bond.is_film(self.spacing)
        self.ratio = UCS_OVER_RUMPF
        self.B0 = self._threshold()
        if args.measured:
            tension = self.bond.force(self.cement, self.B0, self._given(self.B0))
            self.ratio = args.measured / rumpf(tension, d, EXAMPLE["porosity"], EXAMPLE["coordination"])
            self.B0 = self._threshold()
        self._energy()
        self.force = self.bond.force(self.cement, self.B0, self.energy)
        strength = self.cement.strength(self.B0, self.cement.Ez)
        if not STRENGTHS[0] < strength < STRENGTHS[1]:
            raise Trouble(
                f"--ucs {args.ucs:g}: cement of a tensile strength of {strength:.3g} Pa follows; check that the UCS is in Pa, and the calcite content"
            )
        self.strain = args.strain or 3e-4 * (args.ucs / 3e5) ** (2.0 / 3.0)
        self.bulk = (1.0 - self.porosity) * args.grain_density * (1.0 + args.calcite)
        self.speed = math.sqrt(0.75 * SHARE * args.ucs * self.strain / self.bulk)

    def _unit(self, B0):
        return math.sqrt(2.0) * B0 * self.length

    def _given(self, B0):
        """Fracture energy that the words ask for, up to what the length allows. 0: none, film alone does not need it."""
        if self.args.energy:
            return min(self.args.energy, MOST * self._unit(B0))
        return 0.0 if self.film else PLAIN * self._unit(B0)

    def _threshold(self):
        """B0 with which the stress of Rumpf is the share of the UCS that the ratio says."""
        force = self.args.ucs / self.ratio / rumpf(1.0, self.args.diameter, self.porosity, self.args.coordination)
        low, high = 1e-24 * self.cement.Ez, self.cement.Ez
        for _ in range(70):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if self.bond.force(self.cement, middle, self._given(middle)) < force else (low, middle)
        return low

    def _energy(self):
        self.energy, self.capped = self._given(self.B0), False
        if self.energy == 0.0:
            return
        least, most = LEAST * self._unit(self.B0), MOST * self._unit(self.B0)
        if self.energy < least:
            raise Trouble(
                f"--energy {self.energy:g}: below {least:.3g} J/m2, the least of the length {self.length:.3g} m: a crack would snap back; "
                f"use --spacing {0.99 * self.spacing * self.energy / least:.3g} or less, or more energy"
            )
        self.energy_range = (least, most)
        self.capped = bool(self.args.energy) and self.args.energy > most
        self.energy *= 1.0 - 1e-4 if self.capped else 1.0

    def text(self):
        a, b, c = self.args, self.bond, self.cement
        words = " ".join(["tools/parameters.py"] + sys.argv[1:])
        head = [
            f"Cement of a sand of {1e-6 * a.ucs:g} MPa unconfined strength with {100 * a.calcite:g} % calcite. Units si. Written by",
            f"  {words}",
            "Before these lines: the recipe of doc/atom_style_mpdem.md, the grains (group `grains`), their contacts, and walls or other fixes that push grains,",
            "since fix mpm sees forces of later fixes a step late. After them: what moves grains and walls, fix nve/sphere and fix move or move/mesh.",
            "doc/howto_parameters.md has a whole script.",
            "",
            "exact",
            f"  content of a bond            {self.content:.5g}   {'active ' if a.inactive else ''}calcite content over the mean number of bonds on a grain, {a.coordination:g}, of equal grains",
            f"  radii of a bond              {b.inner:.4g} to {b.outer:.4g} m, thickness {b.thickness(b.inner):.3g} to {b.thickness(b.outer):.3g} m, where equal grains touch",
            f"  section, attached area       {b.section:.4g}, {b.attached:.4g} m2",
            f"  tensile strength             {c.strength(self.B0, c.Ez):.5g} Pa along the axis, {c.strength(self.B0, c.Ep):.5g} Pa in the plane: fix mpm prints both",
            f"  film, strain across held     {c.strength(self.B0, c.C33):.5g} Pa",
        ]
        if self.energy > 0.0:
            head.append(
                f"  fracture energy              {self.energy:.4g} J/m2, from {self.energy_range[0]:.4g} to {self.energy_range[1]:.4g} with this B0 and length"
            )
        if self.capped:
            head.append(f"                               {a.energy:g} J/m2 is above the range: the largest is taken; a bond hardly gets stronger with more")
        head.append(f"  tension that breaks a bond   {self.force:.4g} N" + ("" if self.film else ", if all of it were film; cement in cells carries less"))
        ratio_of = "by the measured strength" if a.measured else "specimens of doc/specimen.md, 1.16 to 1.69"
        ratio_of += " without energy; 2.9 in one run with it" if a.energy and not a.measured else ""
        head += [
            "estimate",
            f"  UCS over the stress of Rumpf {self.ratio:.3g}   {ratio_of}; sets B0",
            f"  strain at the peak           {self.strain:.2g}   of the model, not of the laboratory; sets the speed",
            f"  speed of the plate           {self.speed:.2g} m/s, kinetic share {SHARE:g} at half of the peak. Fix mpm warns at this speed, since it leaves out",
            "                               contacts; one specimen carried 3 % more than under a slow load. See Speed in doc/howto_parameters.md",
            f"  strength of an interface     {self.force / b.attached:.3g} Pa, if bonds debond at the same tension",
        ]
        lines = [f"# {line}".rstrip() for line in head] + [""]
        for name, value, comment in (
            ("content", f"{self.content:.6g}", "mass of the cement of a bond over mass of its two grains"),
            *((("inactive", f"{a.calcite * a.inactive:.6g}", "calcite that coats the grains, over their mass"),) if a.inactive else ()),
            ("spacing", f"{self.spacing:.6g}", "of the material points, m; all of a bond is film" if self.film else "of the material points, m"),
            ("cell", f"{self.cell:.6g}", "of the background grid, m"),
            ("gap", f"{0.005 * a.diameter:.6g}", "between grains that are bonded, m, at most"),
            ("B0", f"{self.B0:.6g}", "threshold of the damage, Pa"),
            ("zeta", f"{a.zeta:g}", "tensile over compressive strength of the cement"),
            *((("length", f"{self.length:.6g}", "internal length, m"), ("energy", f"{self.energy:.6g}", "fracture energy, J/m2")) if self.energy > 0.0 else ()),
            ("step", "0.8", "share of the stable step; 0.1 if servos move walls, as in examples/specimen"),
            ("plate_speed", f"{self.speed:.3g}", "m/s; let it rise from 0, as (1 - cos)/2, while the plate moves by 5e-5 of the height"),
        ):
            lines.append(f"variable     {name:<11} index {value:<12} # {comment}")
        lines += [
            "",
            "# Grains at rest, without spin: motion of grains loads cement at once, and breaks weak cement.",
            "velocity     grains set 0 0 0",
            "set          group grains omegax 0 omegay 0 omegaz 0",
            f"create_cement calcite contacts grains gap ${{gap}} shape flat content ${{content}} spacing ${{spacing}} density {a.cement_density:g} overlap skip",
            *((f"create_cement calcite coat grains calcite ${{inactive}} density {a.cement_density:g} walls bare",) if a.inactive else ()),
            f"fix          cem calcite mpm cell ${{cell}} elastic {c.words} axis radial damage tensor B0 ${{B0}} zeta ${{zeta}} &",
            f"             {self.regularization()}quasistatic 1 0.05 condense yes timestep auto ${{step}}",
            "fix          bond grains mpm/couple cem",
            "",
            "# Measure the UCS with 80 beads, of several packings (--set seed=49979687, 86028121, another prime above 10000), then give --measured PA, their",
            f"# mean. The beads of the example are {EXAMPLE['diameter'] / a.diameter:.4g} times as large as the grains; all lengths, and the energy, are multiplied by that, and stresses stay.",
            f"# Their porosity is {EXAMPLE['porosity']:g}, with {EXAMPLE['coordination']:g} bonds on a bead: expect a mean UCS of {self.expected():.3g} Pa, with which --measured compares.",
            f"#   {self.calibration()}",
        ]
        return "\n".join(lines)

    def regularization(self):
        return "regularization nonlocal ${length} energy ${energy} " if self.energy > 0.0 else ""

    def expected(self):
        """UCS of the specimens of the example with these bonds, Pa: tension over the square of the diameter is the same for grains and beads."""
        return self.ratio * rumpf(self.force, self.args.diameter, EXAMPLE["porosity"], EXAMPLE["coordination"])

    def calibration(self):
        """Command for bonds of this shape and strength between the beads of the example, whose cement has the moduli of calcite."""
        factor = EXAMPLE["diameter"] / self.args.diameter
        stiffer = self.cement.C33 / Cement(None, CALCITE).C33  # stresses in a film scale with sqrt(B0 C33)
        words = [f"strength={self.B0 * stiffer:.4g}", f"zeta={self.args.zeta:g}", f"speed={self.speed:.2g}"]
        if self.energy > 0.0:
            words.append(f"'regularization=nonlocal {factor * self.length:.4g} energy {factor * self.energy * stiffer:.4g}'")
        if self.energy > 0.0 or not self.film:
            words += [f"spacing={factor * self.spacing:.4g}"]
        content = self.content * (self.args.grain_density / self.args.cement_density) / (EXAMPLE["grain"] / EXAMPLE["cement"])
        return f"tools/specimen.py OUT --contents {content:.4g} --pressures '' --tests compression " + " ".join(f"--set {w}" for w in words)


def main():
    print(Parameters(arguments()).text())


if __name__ == "__main__":
    try:
        main()
    except Trouble as trouble:
        sys.exit(f"{os.path.basename(__file__)}: {trouble}")
    except BrokenPipeError:
        sys.exit(1)
