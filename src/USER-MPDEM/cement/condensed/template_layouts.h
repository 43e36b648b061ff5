// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Layouts of bonds whose points are not made yet (mpm/point_template.h). The first bond of a pattern stands for all of
// it, and is laid out at its creation.
#ifndef MPDEM_CEMENT_CONDENSED_TEMPLATE_LAYOUTS_H
#define MPDEM_CEMENT_CONDENSED_TEMPLATE_LAYOUTS_H

#include <vector>

#include "condensed_bonds.h"
#include "../bond/scene.h"

namespace mpdem {

// Numbers of patterns, from 1 on, whose bonds have a grain on this rank; ascending.
std::vector<int> patterns_of_owned_grains(const Scene& scene);

// Collective. Each rank asks for the patterns that it needs, ascending, and has them as a whole. penalty: parameters of
// their links; null: no links. Throws BadState on all ranks.
std::vector<CondensedBonds::OfPattern> layouts_of_patterns(const Scene& scene, const std::vector<int>& patterns,
                                                           const PenaltyParameters* penalty);

}  // namespace mpdem

#endif
