// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Blocks, links and grid of bonds whose points are made later. Such bonds have the points of a template
// (mpm/point_template.h), and all bonds of a template have the same layout. It is made for the first of them, with both
// grains where they were at its creation.
#ifndef MPDEM_CEMENT_CONDENSED_TEMPLATE_LAYOUTS_H
#define MPDEM_CEMENT_CONDENSED_TEMPLATE_LAYOUTS_H

#include <vector>

#include "condensed_bonds.h"
#include "../bond/scene.h"

namespace mpdem {

// Numbers (from 1) of the templates whose bonds have a grain on this rank, ascending.
std::vector<int> templates_of_owned_grains(const Scene& scene);

// Makes the layouts of the templates that this rank needs. Collective, but no layout is shared: each rank makes all
// points and nodes of its own. templates: their numbers, ascending; the result has the same order. penalty: parameters
// of the links; null: no links. If any rank finds the state of a point wrong, throws BadState on all ranks.
std::vector<CondensedBonds::TemplateBond> layouts_of_templates(const Scene& scene, const std::vector<int>& templates,
                                                               const PenaltyParameters* penalty);

}  // namespace mpdem

#endif
