// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Which grains are near each other.
#ifndef MPDEM_CEMENT_CONTACTS_H
#define MPDEM_CEMENT_CONTACTS_H

#include <utility>
#include <vector>

#include "scene_box.h"

namespace mpdem {

// Pairs of tags, each and all ascending, of spheres no farther apart than `gap`; in a periodic box of their nearest images.
std::vector<std::pair<int, int>> contacts(const std::vector<Sphere>& spheres, const SceneBox& box, double gap);

}  // namespace mpdem

#endif
