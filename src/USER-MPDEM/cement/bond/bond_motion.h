// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Motion of a bond as a whole. It is kept where mass goes from one node to another.
#ifndef MPDEM_CEMENT_BOND_BOND_MOTION_H
#define MPDEM_CEMENT_BOND_BOND_MOTION_H

#include "../../mpm/grid.h"

namespace mpdem {

// Sums over the nodes of a bond: mass, its first and second moments, momentum, angular momentum and kinetic energy.
struct BondMotion {
  double mass, first[3], second[6], momentum[3], angular[3], kinetic;
};

// Sums over the nodes that this rank counts. Velocities are ahead of the stored ones by `kick` times the acceleration.
BondMotion sums_of_motion(const Grid& grid, double kick);
// Adds the rigid motion that takes momentum, and angular momentum about the centre of mass, from `now` to what they were.
// The centre of mass goes along with mass that changes its node. So about any other place the angular momentum would
// depend on the velocity at which all that there is flies.
void give_back_motion(Grid& grid, const BondMotion& before, const BondMotion& now);

}  // namespace mpdem

#endif
