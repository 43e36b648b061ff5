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

// Collective. Stops on all ranks, with the three lines, if they are missing, disagree, or name a group that lacks a
// grain or holds a material point. The message begins with `who`.
void check_host_recipe(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& cement);

// Returns a complaint about a grain of this rank that is not in the group of `atom_modify first`, or an empty text.
// Such a grain would have no contacts. It may have been inserted during a run, for instance.
std::string grain_outside_of_group(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& cement);

}  // namespace LAMMPS_NS

#endif
