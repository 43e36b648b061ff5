// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rigid motion of a bond. It is conserved when mass moves from one node to another.
#ifndef MPDEM_CEMENT_BOND_BOND_MOTION_H
#define MPDEM_CEMENT_BOND_BOND_MOTION_H

#include "../../mpm/grid.h"

namespace mpdem {

// Sums over the nodes of a bond: mass, its first and second moments (xx, yy, zz, yz, xz, xy), momentum, angular
// momentum about the origin, and kinetic energy.
struct BondMotion {
  double mass, first[3], second[6], momentum[3], angular[3], kinetic;
};

// Sums over the nodes that this rank counts. The velocities are the stored ones plus `kick` times the acceleration.
BondMotion sums_of_motion(const Grid& grid, double kick);
// Call when mass has moved between nodes. before, now: sums of the whole bond before and after that. Adds a rigid motion
// to the velocities that restores momentum, and angular momentum about the centre of mass. This centre shifts with the
// mass, so angular momentum about a fixed point would depend on a uniform velocity of the whole scene.
void restore_rigid_motion(Grid& grid, const BondMotion& before, const BondMotion& now);

}  // namespace mpdem

#endif
