// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Chooses the mechanisms (mpm/bond_mechanism.h) that act in the step of a bond, by the options of the scene.
#ifndef MPDEM_CEMENT_LAYOUT_MECHANISMS_H
#define MPDEM_CEMENT_LAYOUT_MECHANISMS_H

#include "../bond/scene.h"
#include "../failure/node_splitting.h"

namespace mpdem {

// Makes the mechanisms of a bond that has a layout, in the order in which they act.
Bond::Mechanisms mechanisms_of(const Scene& scene, const Bond& b, const NodeSplitting& splits);

}  // namespace mpdem

#endif
