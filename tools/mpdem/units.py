# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Units of the columns, of scripts with `units si`. "1" is a number or a share, "" a column whose unit is not known, or a text."""
from typing import Dict

import pandas as pd

UNITS: Dict[str, Dict[str, str]] = {
    "bonds": {
        "m": "gap",
        "s": "time",
        "N": "fx1 fy1 fz1 fx2 fy2 fz2 tension peak_tension",
        "N m": "mx1 my1 mz1 mx2 my2 mz2",
        "J": "elastic_energy kinetic_energy coupling_energy dissipated_energy released_energy damped_energy external_work friction_energy",
        "1": "step bond grain1 grain2 points attached debonded failed largest_damage mean_damage separated share_grain1 share_grain2 energy_imbalance "
        "attached_grain1 attached_grain2 touching_grain1 touching_grain2 broken kinetic_share unbalanced_force material strength_factor moduli_factor",
    },
    "events": {"s": "time", "m": "r z", "rad": "theta", "1": "step point bond grain damage1 damage2 damage3 direction_x direction_y direction_z"},
    "dump": {"m": "x y z radius", "m/s": "vx vy vz", "rad/s": "omegax omegay omegaz", "N": "fx fy fz", "kg": "mass", "1": "id type"},
    "contacts": {"m": "slip_x slip_y slip_z overlap", "N": "fx fy fz", "1": "grain1 grain2"},
    "points": {
        "m": "x y z foot_ix foot_iy foot_iz foot_jx foot_jy foot_jz",
        "m2": "area_i area_j",
        "m3": "volume",
        "1": "grain_i grain_j ax ay az dxx dyy dzz dyz dxz dxy d1 d2 d3 v1x v1y v1z v2x v2y v2z failed attached_i attached_j damage_i damage_j material",
    },
    "load": {"s": "time", "m": "way", "N": "load", "1": "step"},
    "turn": {"s": "time", "rad": "way", "N m": "load", "1": "step"},
    "curve": {
        "s": "time",
        "m": "way height wide_x wide_y",
        "N": "force sideways",
        "J": "kinetic_beads kinetic elastic coupling dissipated released damped work",
        "m/s": "speed",
        "1": "step stage lateral imbalance failed awake broken debonding internal mixed kinetic_share unbalanced",
    },
    "response": {
        "s": "time",
        "m": "height",
        "m2": "section",
        "Pa": "axial_stress side_stress q p",
        "m/s": "speed",
        "1": "step axial_strain volume_strain broken debonding internal mixed failed awake kinetic_share unbalanced",
    },
    "fabric": {
        "Pa": "stress_inside",
        "1": "step axial_strain volume_strain beads contacts old_contacts new_contacts lost_contacts coordination bonds coordination_with_bonds pieces single "
        "largest mean_size",
    },
    "fragments": {"1": "step axial_strain grains pieces"},
    "waves": {"m/s": "shear compression", "1": "strain shear_off compression_off"},
    "specimen": {
        "Pa": "pressure stiffness stiffness_of_ends strength q_peak q_at_end",
        "J": "work in_contacts",
        "s": "wall",
        "1": "content content_of_all bonds points strain_at_peak strain_at_end load_at_end awake_at_peak broken_at_peak awake_most broken debonding internal "
        "mixed kinetic_at_half kinetic_at_first_failure kinetic_at_peak imbalance steps beyond_cap springs_at_peak rubbed_at_first_failure rubbed_at_peak "
        "load_when_calm kinetic_share_at_first_failure unbalanced_at_first_failure pressure_off_to_peak pressure_off_after_peak load_at_first_failure "
        "axial_strain_at_q_peak volume_strain_at_end coordination_at_end pieces_at_end largest_piece_at_end",
    },
    # Of torsion and bending: peak in N m, stiffness in N m/rad, ways in rad.
    "table": {
        "m": "dimension way_at_peak way_at_failure inner spacing",
        "m2": "section",
        "m3": "volume",
        "N": "peak",
        "N/m": "stiffness",
        "J": "energy dissipated",
        "Pa": "stress_section stress_grain",
        "s": "duration wall",
        "1": "content left share_grain1 share_grain2 share_inside imbalance points failed let_go attached steps",
    },
    "thermo": {"s": "Time time", "1": "Step"},
}
QUANTITIES = {"stress": "Pa", "pressure": "Pa", "volume": "m3"}  # of compute mpm/atom; others are numbers


def of_quantity(quantity: str) -> str:
    return QUANTITIES.get(quantity.split("_")[0], "1")


def attach(table: pd.DataFrame, kind: str, more: Dict[str, str], style: str = "si") -> pd.DataFrame:
    """Writes the units of the columns into table.attrs["units"]. more: units of single columns; style: that of the script's `units`."""
    known = {name: unit for unit, names in UNITS[kind].items() for name in names.split()}
    known.update(more)
    table.attrs["units"] = {str(c): (known.get(c, "") if style == "si" or known.get(c) == "1" else "") for c in table}
    table.attrs["unit_style"] = style
    return table


def unit(table: pd.DataFrame, column: str) -> str:
    """The unit of a column: "N", "1" for a number, "" if it is not known or a text."""
    return str(table.attrs.get("units", {}).get(column, ""))


def label(table: pd.DataFrame, column: str) -> str:
    """The column in words with its unit, for an axis."""
    known, words = unit(table, column), column[2:] if column.startswith("c_") else column
    return words.replace("_", " ") + (f" ({known})" if known not in ("", "1") else "")
