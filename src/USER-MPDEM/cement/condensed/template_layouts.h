// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Layouts of bonds whose points are made later (mpm/point_template.h). The first bond of a template represents all of
// them, and is laid out in its configuration at creation.
#ifndef MPDEM_CEMENT_CONDENSED_TEMPLATE_LAYOUTS_H
#define MPDEM_CEMENT_CONDENSED_TEMPLATE_LAYOUTS_H

#include <vector>

#include "condensed_bonds.h"
#include "../bond/scene.h"

namespace mpdem {

// Numbers (from 1) of the templates whose bonds have a grain on this rank, ascending.
std::vector<int> templates_of_owned_grains(const Scene& scene);

// Collective. templates: numbers of the templates that this rank needs, ascending. Each layout is whole on this rank.
// penalty: parameters of the links; null: no links. Throws BadState on all ranks.
std::vector<CondensedBonds::TemplateBond> layouts_of_templates(const Scene& scene, const std::vector<int>& templates,
                                                               const PenaltyParameters* penalty);

}  // namespace mpdem

#endif
