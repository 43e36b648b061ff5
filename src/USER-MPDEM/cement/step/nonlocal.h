// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nonlocal damage (mpm/drive_average.h): averages the driving force in bonds near the threshold.
#ifndef MPDEM_CEMENT_STEP_NONLOCAL_H
#define MPDEM_CEMENT_STEP_NONLOCAL_H

#include <vector>

#include "../bond/scene.h"

namespace mpdem {

// Finds whether the driving force in a bond has to be averaged in the next step.
void find_near_threshold(const Scene& scene, Bond& b);

// Collective. Leaves the averages on the grids, for the pass over the points. Does nothing without nonlocal damage.
// any_bond_is_cut: whether ranks share the nodes of any bond of the scene.
void average_drives(Scene& scene, bool any_bond_is_cut);

// Collective. Averages the driving forces of bonds that ranks cut, from the present strain of their points. rows: the
// same on all ranks.
void average_cut_drives(Scene& scene, const std::vector<int>& rows);

}  // namespace mpdem

#endif
