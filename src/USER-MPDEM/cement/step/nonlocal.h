// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nonlocal damage: averages the drive over a length, for bonds that are near the threshold. See mpm/drive_average.h.
#ifndef MPDEM_CEMENT_STEP_NONLOCAL_H
#define MPDEM_CEMENT_STEP_NONLOCAL_H

#include <vector>

#include "../bond/scene.h"

namespace mpdem {

// Finds out whether the points of a bond have to be averaged in the next step.
void find_near_threshold(const Scene& scene, Bond& b);

// Collective. Leaves the averages with the grids, for the pass over the points. Does nothing without nonlocal damage.
// any_bond_is_cut: do ranks cut a bond, on any rank?
void average_drives(Scene& scene, bool any_bond_is_cut);

// Collective. Averages the drives of bonds that ranks cut, by the strain that their points have. rows: the same on all
// ranks.
void average_cut_drives(Scene& scene, const std::vector<int>& rows);

}  // namespace mpdem

#endif
