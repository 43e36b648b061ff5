// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Lets LIGGGHTS' contact models touch coats (grain_coats.h): those of a pair style `gran`, and those of walls. Each model is
// wrapped. The wrapper of the pair style calls the model twice, once for pairs that touch with their coats and once for
// bare pairs, with the radii of each. The wrapper of a wall takes the coat off grains whose coat ends at walls.
#ifndef MPDEM_STYLES_ATOMS_COATED_CONTACTS_H
#define MPDEM_STYLES_ATOMS_COATED_CONTACTS_H

#include <string>

#include "lammps.h"

namespace mpdem {

// Wraps the contact models of the script, once each. Returns why that is not possible, or an empty text.
std::string touch_coats(LAMMPS_NS::LAMMPS* lmp);

// Collective. Call it when the forces of a run were found for the first time. Warns of new coats that walls touch at once.
void warn_of_coats_at_walls(LAMMPS_NS::LAMMPS* lmp, const std::string& who);

}  // namespace mpdem

#endif
