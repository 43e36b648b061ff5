// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Moves places that let go of the grains (coupling/debonded_contact.h) to other points, which may be on other ranks. The energy
// that a place stores when it moves is taken from the released energy of the books.
// Places matter only where they touch, Scene::touches().
#ifndef MPDEM_CEMENT_STEP_CONTACT_REMAPPING_H
#define MPDEM_CEMENT_STEP_CONTACT_REMAPPING_H

#include <vector>

#include "../bond/scene.h"

namespace mpdem {

// Call at the start of a run. Opens places of new bonds that were cracked in their file.
void open_contacts_of_files(Scene& scene);
// Collective, at the start of a step. Places whose points failed go on to the nearest points that hold, in steps in
// which the scene watches. Nodes and grains are where they were at the end of the last step. Returns the bonds of
// this rank where some did, ascending.
std::vector<int> remap_contacts(Scene& scene);

}  // namespace mpdem

#endif
