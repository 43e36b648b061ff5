// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "borrowed_nodes.h"

#include <algorithm>
#include <stdexcept>

#include "../mpm/block_nodes.h"

namespace mpdem {

BorrowedNodes::BorrowedNodes(const CementOptions& options, const PenaltyParameters* penalty)
    : allowed_(options.split && options.advance.skip_failed && !options.unilateral && !(penalty && penalty->friction >= 0.0)),
      skins_(penalty && penalty->law->keeps_skins()) {}

namespace {

int node_for(const Grid& grid, const Key& standing) {
  const int node = grid.node_at(standing);
  if (node < 0) throw std::logic_error("points that failed without a node that stands for theirs");
  return node;
}

// Writes the borrowed nodes into the list of the block.
void borrow(const BlockMeta& m, Grid& grid, const Splits& splits) {
  int* to = &grid.borrowed[m.borrowed];
  for (const Key& k : splits.standing_for(m, support(grid.basis))) *to++ = node_for(grid, k);
}

// Finds those of the borrowed nodes of a block anew that are touched.
void borrow_anew(const BlockMeta& m, Grid& grid, const Splits& splits, const std::vector<char>& touched) {
  int* to = &grid.borrowed[m.borrowed];
  for (int i = 0, n = count_of_nodes(m, support(grid.basis)); i < n; ++i)
    if (touched[to[i]]) to[i] = node_for(grid, splits.standing_for(grid.keys[to[i]].with_field(field_of(m.body, m.part))));
}

}  // namespace

void BorrowedNodes::take_motion_of_standing(Grid& grid, const Splits& splits, const std::vector<Key>& more, const std::map<Key, Key>& source) const {
  std::map<Key, Key> stands;
  for (const Key& k : more)
    if (const Key s = splits.standing_for(k); s != k && !source.count(k)) stands.emplace_hint(stands.end(), k, s);
  grid.take_over_motion(stands);
}

void BorrowedNodes::take_motion_of_standing(Grid& grid, const Splits& splits, std::vector<char>& fresh) const {
  std::map<Key, Key> stands;
  for (int i = 0; i < grid.size(); ++i) {
    if (!fresh[i]) continue;
    const Key s = splits.standing_for(grid.keys[i]);
    const int from = s == grid.keys[i] ? -1 : grid.node_at(s);
    if (from < 0 || fresh[from]) continue;
    stands.emplace_hint(stands.end(), grid.keys[i], s);
    fresh[i] = 0;
  }
  grid.take_over_motion(stands);
}

void BorrowedNodes::find(PointStore& points, Grid& grid, const Splits& splits) const {
  grid.borrowed.clear();
  for (BlockMeta& m : points.meta) m.borrowed = BlockMeta::kOwn;
  find_anew(points, grid, splits, {});
}

void BorrowedNodes::find_anew(PointStore& points, Grid& grid, const Splits& splits, const std::vector<int>& nodes) const {
  if (!allowed_) return;
  // Blocks whose points went to other parts left their lists behind.
  std::size_t used = 0;
  for (const BlockMeta& m : points.meta)
    if (may_borrow(m)) used += count_of_nodes(m, support(grid.basis));
  if (grid.borrowed.size() > 2 * used) return find(points, grid, splits);
  std::vector<char> touched(grid.size(), 0);
  for (int i : nodes) touched[i] = 1;
  for (BlockMeta& m : points.meta) {
    if (!may_borrow(m)) continue;
    if (m.borrowed != BlockMeta::kOwn) {
      borrow_anew(m, grid, splits, touched);
      continue;
    }
    m.borrowed = static_cast<int>(grid.borrowed.size());
    grid.borrowed.resize(grid.borrowed.size() + count_of_nodes(m, support(grid.basis)));
    borrow(m, grid, splits);
  }
}

}  // namespace mpdem
