// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds grains that are near each other.
#ifndef MPDEM_CEMENT_CREATION_CONTACTS_H
#define MPDEM_CEMENT_CREATION_CONTACTS_H

#include <utility>
#include <vector>

#include "scene_box.h"

namespace mpdem {

// Returns pairs of tags, each and all ascending, of spheres whose gap is at most `gap`. In a periodic box the nearest
// images count.
std::vector<std::pair<int, int>> contacts(const std::vector<Sphere>& spheres, const SceneBox& box, double gap);
// Number of these pairs of which further images are within that gap, too.
int contacts_twice(const std::vector<Sphere>& spheres, const std::vector<std::pair<int, int>>& pairs, const SceneBox& box, double gap);

}  // namespace mpdem

#endif
