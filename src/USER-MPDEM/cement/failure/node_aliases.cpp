// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "node_aliases.h"

#include <algorithm>
#include <stdexcept>

#include "../../mpm/block_nodes.h"

namespace mpdem {

NodeAliases::NodeAliases(const CementOptions& options, const PenaltyParameters* penalty)
    : allowed_(options.split && options.advance.skip_failed && !options.unilateral && !(penalty && penalty->friction >= 0.0)),
      residue_(penalty && penalty->law->leaves_residue()) {}

namespace {

int node_for(const Grid& grid, const Key& standing) {
  const int node = grid.node_at(standing);
  if (node < 0) throw std::logic_error("failed points whose nodes have no representative");
  return node;
}

// Writes the aliases of a block into its list.
void add_aliases(const BlockMeta& m, Grid& grid, const NodeSplitting& splits) {
  int* to = &grid.aliases[m.aliases];
  for (const Key& k : splits.representatives_of(m, support(grid.basis))) *to++ = node_for(grid, k);
}

// Finds those aliases of a block again that are marked in `touched`.
void find_aliases_anew(const BlockMeta& m, Grid& grid, const NodeSplitting& splits, const std::vector<char>& touched) {
  int* to = &grid.aliases[m.aliases];
  for (int i = 0, n = count_of_nodes(m, support(grid.basis)); i < n; ++i)
    if (touched[to[i]]) to[i] = node_for(grid, splits.representative_of(grid.keys[to[i]].with_field(field_of(m.row, m.layer))));
}

}  // namespace

void NodeAliases::copy_motion_of_representatives(Grid& grid, const NodeSplitting& splits, const std::vector<Key>& more,
                                                 const std::map<Key, Key>& source) const {
  std::map<Key, Key> stands;
  for (const Key& k : more)
    if (const Key s = splits.representative_of(k); s != k && !source.count(k)) stands.emplace_hint(stands.end(), k, s);
  grid.copy_motion(stands);
}

void NodeAliases::copy_motion_of_representatives(Grid& grid, const NodeSplitting& splits, std::vector<char>& fresh) const {
  std::map<Key, Key> stands;
  for (int i = 0; i < grid.size(); ++i) {
    if (!fresh[i]) continue;
    const Key s = splits.representative_of(grid.keys[i]);
    const int from = s == grid.keys[i] ? -1 : grid.node_at(s);
    if (from < 0 || fresh[from]) continue;
    stands.emplace_hint(stands.end(), grid.keys[i], s);
    fresh[i] = 0;
  }
  grid.copy_motion(stands);
}

void NodeAliases::find(PointStore& points, Grid& grid, const NodeSplitting& splits) const {
  grid.aliases.clear();
  for (BlockMeta& m : points.meta) m.aliases = BlockMeta::kOwn;
  find_anew(points, grid, splits, {});
}

void NodeAliases::find_anew(PointStore& points, Grid& grid, const NodeSplitting& splits, const std::vector<int>& nodes) const {
  if (!allowed_) return;
  // Blocks whose points moved to other layers leave their lists unused in grid.aliases. If most are unused, all are made anew.
  std::size_t used = 0;
  for (const BlockMeta& m : points.meta)
    if (may_alias(m)) used += count_of_nodes(m, support(grid.basis));
  if (grid.aliases.size() > 2 * used) return find(points, grid, splits);
  std::vector<char> touched(grid.size(), 0);
  for (int i : nodes) touched[i] = 1;
  for (BlockMeta& m : points.meta) {
    if (!may_alias(m)) continue;
    if (m.aliases != BlockMeta::kOwn) {
      find_aliases_anew(m, grid, splits, touched);
      continue;
    }
    m.aliases = static_cast<int>(grid.aliases.size());
    grid.aliases.resize(grid.aliases.size() + count_of_nodes(m, support(grid.basis)));
    add_aliases(m, grid, splits);
  }
}

}  // namespace mpdem
