// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds nodal velocities of new bonds from the velocities of their points. The least-squares linear field of each bond
// is transferred exactly, so a rigid motion starts without strain. The rest is transferred by lumped projection.
#ifndef MPDEM_CEMENT_LAYOUT_STARTING_MOTION_H
#define MPDEM_CEMENT_LAYOUT_STARTING_MOTION_H

#include <vector>

#include "layout.h"
#include "../bond/scene.h"

namespace mpdem {

// Collective. Sets the velocities of fresh nodes (BondLayout::fresh) of bonds that have not moved yet. layouts: the
// layouts of the bonds of the scene.
void start_velocities(Scene& scene, const std::vector<BondLayout>& layouts);

}  // namespace mpdem

#endif
