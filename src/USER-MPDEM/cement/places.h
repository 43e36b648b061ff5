// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Places that let go of the grains (coupling/freed_places.h): when they open, and when they go on to other points, which may be on
// other ranks. What opens gives up energy, which is booked as released. Only where places touch, Scene::touches().
#ifndef MPDEM_CEMENT_PLACES_H
#define MPDEM_CEMENT_PLACES_H

#include <vector>

#include "scene.h"

namespace mpdem {

// Of a bond: places of points that failed, and of links that let go of points that hold; both by slot, ascending.
void open_places(Scene& scene, Bond& b, const std::vector<int>& failed, const std::vector<int>& links);
// At the start of a run: those of bonds that are new and failed in a file.
void open_places_of_files(Scene& scene);
// Collective, at the start of a step. Places whose points failed go on to the nearest that hold, where the scene watches. Nodes and grains are where
// they were at the end of the last step. Answers the bonds where some did, ascending, the same on all ranks.
std::vector<int> move_places(Scene& scene);

}  // namespace mpdem

#endif
