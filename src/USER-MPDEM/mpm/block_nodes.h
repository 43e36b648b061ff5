// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes of a block, including those of all cells of its row. The nodes of most blocks are columns of neighbours in
// memory. A block with aliased nodes (BlockMeta::aliases) has a list of nodes instead. Their values are copied into
// columns for the kernels of gather.h and scatter.h, and sums are added back.
#ifndef MPDEM_MPM_BLOCK_NODES_H
#define MPDEM_MPM_BLOCK_NODES_H

#include <algorithm>

#include "basis.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

inline int count_of_columns(const BlockMeta& m, int support) { return nodes_along(m, 0, support) * nodes_along(m, 1, support); }
inline int count_of_nodes(const BlockMeta& m, int support) { return count_of_columns(m, support) * nodes_along(m, 2, support); }

// Calls f(node) for each node of all cells of a block.
template <class F>
void for_each_node(const Grid& grid, const BlockMeta& m, F f) {
  const int S = support(grid.basis);
  if (m.aliases != BlockMeta::kOwn) {
    const int* list = &grid.aliases[m.aliases];
    std::for_each(list, list + count_of_nodes(m, S), f);
    return;
  }
  const int columns = count_of_columns(m, S), length = nodes_along(m, 2, S);
  for (int c = 0; c < columns; ++c)
    for (int k = 0; k < length; ++k) f(m.column[c] + k);
}

// Calls f(node) for each node of the cell of the point in a lane.
template <class F>
void for_each_node_of_lane(const Grid& grid, const BlockMeta& m, int lane, F f) {
  const int S = support(grid.basis), J = nodes_along(m, 1, S), K = nodes_along(m, 2, S);
  int first[3], n = 0;
  for (int d = 0; d < 3; ++d) first[d] = cell_of(m, lane, d) - m.base[d];
  for_each_node(grid, m, [&](int i) {
    const int at[3] = {n / (J * K), n / K % J, n % K};
    ++n;
    bool inside = true;
    for (int d = 0; d < 3; ++d) inside = inside && at[d] >= first[d] && at[d] < first[d] + S;
    if (inside) f(i);
  });
}

// Columns with the values of the aliased nodes of a block, kWidth numbers each.
template <int kWidth>
class BlockColumns {
 public:
  BlockColumns(const Grid& grid, const BlockMeta& m) : nodes_(&grid.aliases[m.aliases]), count_(count_of_nodes(m, support(grid.basis))) {
    const int length = nodes_along(m, 2, support(grid.basis));
    for (int c = 0; c < count_ / length; ++c) column[c] = c * length;
  }
  void take(const double* field) {
    for (int n = 0; n < count_; ++n) std::copy_n(field + kWidth * static_cast<long>(nodes_[n]), kWidth, values + kWidth * n);
  }
  void add_to(double* field) const {
    for (int n = 0; n < count_; ++n)
      for (int c = 0; c < kWidth; ++c) field[kWidth * static_cast<long>(nodes_[n]) + c] += values[kWidth * n + c];
  }
  double values[kWidth * kMostColumns * Bases::kMostSupport + kLanes] = {};  // padded by kLanes, since kernels read beyond the nodes
  int column[kMostColumns];

 private:
  const int* nodes_;
  int count_;
};

// Calls f(values, columns) with the values of a nodal field, kWidth numbers per node.
template <int kWidth, class F>
void with_values(const Grid& grid, const BlockMeta& m, const double* field, F f) {
  if (m.aliases == BlockMeta::kOwn) return f(field, m.column);
  BlockColumns<kWidth> own(grid, m);
  own.take(field);
  f(static_cast<const double*>(own.values), static_cast<const int*>(own.column));
}

// Calls f(sums, columns), which adds to the sums of a nodal field, kWidth numbers per node.
template <int kWidth, class F>
void with_sums(const Grid& grid, const BlockMeta& m, double* field, F f) {
  if (m.aliases == BlockMeta::kOwn) return f(field, m.column);
  BlockColumns<kWidth> own(grid, m);
  f(own.values, static_cast<const int*>(own.column));
  own.add_to(field);
}

}  // namespace mpdem

#endif
