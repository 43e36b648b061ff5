// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Material points must never reach LIGGGHTS' neighbour lists and ghosts: a scene of 50 000
// points would take seconds to set up and slow down with their square. Three stock commands
// of the script see to that.
#ifndef MPDEM_HOST_RECIPE_H
#define MPDEM_HOST_RECIPE_H

#include <string>

#include "atom_vec_mpdem.h"

namespace LAMMPS_NS {

// Stops on all ranks, `who` first, with the three lines if they are missing, disagree, or
// name a group that lacks a grain or holds a material point. Collective.
void check_host_recipe(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& cement);

// The complaint about a grain of this rank that is not in the group of `atom_modify first`, so that it
// would have no contacts: inserted during a run, for instance. Empty if there is none.
std::string grain_outside_of_group(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& cement);

}  // namespace LAMMPS_NS

#endif
