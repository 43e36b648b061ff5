// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_BLOCK_NODES_H
#define MPDEM_BLOCK_NODES_H

#include "basis.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

// Calls f(node) for the nodes of a block, of all cells that it has in a row.
template <class F>
void for_each_node(const Grid& grid, const BlockMeta& m, F f) {
  const int S = support(grid.basis), columns = nodes_along(m, 0, S) * nodes_along(m, 1, S), length = nodes_along(m, 2, S);
  for (int c = 0; c < columns; ++c)
    for (int k = 0; k < length; ++k) f(m.column[c] + k);
}

}  // namespace mpdem

#endif
