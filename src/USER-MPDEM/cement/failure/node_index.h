// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Converts keys of grid nodes (parallel/key.h) to grid indices of a bond, and back.
#ifndef MPDEM_CEMENT_FAILURE_NODE_INDEX_H
#define MPDEM_CEMENT_FAILURE_NODE_INDEX_H

#include "../../fracture/phantom_nodes.h"
#include "../../mpm/bond_record.h"
#include "../../parallel/key.h"

namespace mpdem {

// Indices count in the grid of the bond. key_at() gives the node of one layer.
inline GridIndex grid_index_of(const Key& k) { return k.index(); }
inline Key key_at(int row, int layer, const GridIndex& p) { return {field_of(row, layer), p[0], p[1], p[2]}; }

}  // namespace mpdem

#endif
