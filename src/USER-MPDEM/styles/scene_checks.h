// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Checks of a scene for create_cement and fix mpm. Each returns a complaint without the name of the command, the same
// on all ranks, or an empty text.
#ifndef MPDEM_SCENE_CHECKS_H
#define MPDEM_SCENE_CHECKS_H

#include <string>

#include "atom_vec_mpdem.h"
#include "lammps.h"

namespace mpdem {

std::string trouble_with_units(LAMMPS_NS::LAMMPS* lmp);

// 2710 kg/m3 in the units of the script. 0 in units of which this is not known.
double density_of_calcite(LAMMPS_NS::LAMMPS* lmp);

// Collective. `type`: type of points that are about to be made, or 0.
std::string trouble_with_types(LAMMPS_NS::LAMMPS* lmp, const LAMMPS_NS::AtomVecMpdem& cement, int type);

}  // namespace mpdem

#endif
