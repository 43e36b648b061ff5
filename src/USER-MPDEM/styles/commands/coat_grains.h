// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Gives grains coats (coupling/coat.h), by `create_cement ID coat ...` or by the pattern `coating`.
#ifndef MPDEM_STYLES_COMMANDS_COAT_GRAINS_H
#define MPDEM_STYLES_COMMANDS_COAT_GRAINS_H

#include <vector>

#include "../../cement/creation/scene_box.h"
#include "../words/arguments.h"

namespace mpdem {

// A grain without its coat, if it has one.
struct BareGrain {
  int tag = 0;
  double x[3] = {0, 0, 0}, radius = 0, mass = 0;
};
// Collective. Returns the grains of a group, of all ranks, ascending in ID, so that sums do not depend on the ranks.
std::vector<BareGrain> bare_grains(LAMMPS_NS::LAMMPS* lmp, int groupbit);

// 2710 kg/m3 in the units of the script. Stops in units without a default.
double density_of_calcite(LAMMPS_NS::LAMMPS* lmp, const Arguments& args);

struct CoatRequest {
  double thickness = 0, density = 0;
  bool at_walls = true;
};
// Collective. Coats these grains, as bare_grains() returned them. Returns the number of pairs that go on to touch with
// their bare surfaces. Throws BadState if a grain has a coat, or the shells are too thick.
int coat(LAMMPS_NS::LAMMPS* lmp, const std::vector<BareGrain>& grains, const CoatRequest& request, const SceneBox& box);

// Collective. Reads and executes the rest of `create_cement ID coat`.
void coat_grains(LAMMPS_NS::LAMMPS* lmp, Arguments& args, const SceneBox& box);

}  // namespace mpdem

#endif
