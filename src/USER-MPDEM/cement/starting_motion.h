// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodal velocities of bonds that are new from the velocities of their points: the linear field that fits each bond
// best is taken over exactly, so a translation or rotation starts without strain, the rest by lumped projection.
#ifndef MPDEM_CEMENT_STARTING_MOTION_H
#define MPDEM_CEMENT_STARTING_MOTION_H

#include <vector>

#include "layout.h"
#include "scene.h"

namespace mpdem {

// Collective. Of bonds that have not started yet, on the nodes that are fresh. layouts: what the bonds of the scene were laid out by.
void start_velocities(Scene& scene, const std::vector<BondLayout>& layouts);

}  // namespace mpdem

#endif
