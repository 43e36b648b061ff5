// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Keys of the grid (parallel/key.h) as nodes of one part of a bond at a place, and back.
#ifndef MPDEM_CEMENT_FAILURE_NODE_INDEX_H
#define MPDEM_CEMENT_FAILURE_NODE_INDEX_H

#include "../../fracture/phantom_nodes.h"
#include "../../mpm/bond_record.h"
#include "../../parallel/key.h"

namespace mpdem {

// grid_index_of() is the place of a node in the grid of its bond. key_at() is the key of the node of a part at a place.
inline GridIndex grid_index_of(const Key& k) { return k.index(); }
inline Key key_at(int row, int layer, const GridIndex& p) { return {field_of(row, layer), p[0], p[1], p[2]}; }

}  // namespace mpdem

#endif
