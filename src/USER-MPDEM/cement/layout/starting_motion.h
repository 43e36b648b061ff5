// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds nodal velocities of new bonds from the velocities of their points. The linear field that fits each bond best is
// taken over exactly, so a translation or rotation starts without strain. The rest comes by lumped projection.
#ifndef MPDEM_CEMENT_LAYOUT_STARTING_MOTION_H
#define MPDEM_CEMENT_LAYOUT_STARTING_MOTION_H

#include <vector>

#include "layout.h"
#include "../bond/scene.h"

namespace mpdem {

// Collective. Sets the velocities of fresh nodes of bonds that have not started yet. layouts: layouts by which the
// bonds of the scene were laid out.
void start_velocities(Scene& scene, const std::vector<BondLayout>& layouts);

}  // namespace mpdem

#endif
