// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Keys of the grid (parallel/key.h) as nodes of one part of a bond at a place, and back.
#ifndef MPDEM_CEMENT_NODE_PLACES_H
#define MPDEM_CEMENT_NODE_PLACES_H

#include "../fracture/node_copies.h"
#include "../mpm/body.h"
#include "../parallel/key.h"

namespace mpdem {

// place_of() is the place of a node in the grid of its bond. key_at() is the key of the node of a part at a place.
inline Place place_of(const Key& k) { return k.place(); }
inline Key key_at(int body, int part, const Place& p) { return {field_of(body, part), p[0], p[1], p[2]}; }

}  // namespace mpdem

#endif
