// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Moves contact points on debonded cement (coupling/debonded_contact.h) to other material points, which may be on other
// ranks. The energy that a contact point stores when it moves is subtracted from the released energy of the balance.
// Contact points are used only with contact and friction, Scene::touches().
#ifndef MPDEM_CEMENT_STEP_CONTACT_REMAPPING_H
#define MPDEM_CEMENT_STEP_CONTACT_REMAPPING_H

#include <vector>

#include "../bond/scene.h"

namespace mpdem {

// Call at the start of a run. Makes contact points in new bonds, where their point file has debonded surface.
void open_contacts_of_files(Scene& scene);
// Collective, at the start of a step. In topology steps (Scene::contacts_move()), contact points whose material points
// failed move to the nearest intact ones. Nodes and grains are where they were at the end of the last step. Returns the
// bonds of this rank whose contact points moved, ascending.
std::vector<int> remap_contacts(Scene& scene);

}  // namespace mpdem

#endif
