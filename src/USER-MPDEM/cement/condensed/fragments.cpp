// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fragments.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "../../mpm/block_nodes.h"
#include "../../numerics/sort_unique.h"
#include "../../parallel/gather_ranks.h"
#include "rigid_pieces.h"

namespace mpdem {

namespace {

// Sets of numbers that are merged.
class Sets {
 public:
  explicit Sets(int size) : parent_(static_cast<std::size_t>(size)) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int n) {
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }
  void join(int a, int b) {
    a = of(a);
    b = of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

// A node of a clump. clump: number on its rank. points: of the clump on its rank, at one node of it, 0 at the others. grain:
// that of attached cement at the node, or kNone.
struct NodeOfClump {
  int row, rank, clump, points, grain;
  Key node;
};

// Adds the nodes of the clumps of a bond on this rank. grain: of each node.
void add_clumps(const Bond& b, const std::vector<signed char>& grain, int rank, int& clumps, std::vector<NodeOfClump>& nodes) {
  const Grid& grid = b.grid;
  Sets sets(grid.size());
  const std::vector<int> constraint = grid.constraints.row_of_each(grid.size());
  for (int i = 0; i < grid.size(); ++i)
    if (constraint[i] >= 0) grid.constraints.for_each_master(constraint[i], [&](int master, double) { sets.join(i, master); });
  std::vector<int> a_node_of_each;
  for (const BlockMeta& m : b.points.meta)
    for (int l = 0; l < kLanes; ++l) {
      if (!((m.occupied & ~m.failed & ~m.connected[0] & ~m.connected[1]) >> l & 1)) continue;
      int first = -1;
      for_each_node_of_lane(grid, m, l, [&](int i) {
        if (first < 0) first = i;
        sets.join(first, i);
      });
      a_node_of_each.push_back(first);
    }
  std::vector<int> points(grid.size(), 0), clump(grid.size(), -1);
  for (int i : a_node_of_each) ++points[sets.of(i)];
  for (int i = 0; i < grid.size(); ++i) {
    const int root = sets.of(i);
    if (points[root] == 0) continue;
    if (clump[root] < 0) clump[root] = clumps++;
    nodes.push_back({b.row, rank, clump[root], i == root ? points[root] : 0, grain[i], grid.keys[i]});
  }
}

}  // namespace

int Fragments::side_of(const Bond& b, int slot) const {
  const BlockMeta& m = b.points.meta[slot / kLanes];
  const int connected = b.points.has_failed(slot) ? 0 : b.points.connected(slot);
  if (connected == 1 || connected == 2) return connected - 1;
  const std::vector<int>& sides = side_of_node.at(b.row);
  int side = kNone;
  bool first = true, same = true;
  for_each_node_of_lane(b.grid, m, slot % kLanes, [&](int i) {
    same = same && (first || side == sides[i]);
    side = sides[i];
    first = false;
  });
  return same ? side : kNone;
}

Fragments find_fragments(MPI_Comm comm, Bonds& bonds, const std::vector<int>& rows) {
  Fragments found;
  std::vector<NodeOfClump> nodes;
  int clumps = 0;
  for (int row : rows) {
    Bond* b = bonds.find(row);
    if (!b) continue;
    const std::vector<signed char> grain = attached_grains_of_nodes(*b);
    found.side_of_node[row].assign(grain.begin(), grain.end());
    add_clumps(*b, grain, rank_in(comm), clumps, nodes);
  }
  nodes = gather_all(comm, nodes);
  // clumps of ranks that share a node are one
  std::vector<std::pair<int, int>> known;
  for (const NodeOfClump& n : nodes) known.emplace_back(n.rank, n.clump);
  sort_unique(known);
  const auto number_of = [&](const NodeOfClump& n) {
    return static_cast<int>(std::lower_bound(known.begin(), known.end(), std::make_pair(n.rank, n.clump)) - known.begin());
  };
  std::sort(nodes.begin(), nodes.end(), [](const NodeOfClump& a, const NodeOfClump& b) {
    return std::make_tuple(a.row, a.node, a.rank) < std::make_tuple(b.row, b.node, b.rank);
  });
  Sets sets(static_cast<int>(known.size()));
  for (std::size_t n = 1; n < nodes.size(); ++n)
    if (nodes[n].node == nodes[n - 1].node) sets.join(number_of(nodes[n]), number_of(nodes[n - 1]));
  std::vector<int> points(known.size(), 0), side(known.size(), Fragments::kNone);
  for (const NodeOfClump& n : nodes) {
    const int set = sets.of(number_of(n));
    points[set] += n.points;
    side[set] = std::max(side[set], n.grain);
  }
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (n > 0 && nodes[n].node == nodes[n - 1].node) continue;
    const int set = sets.of(number_of(nodes[n])), row = nodes[n].row;
    std::vector<std::vector<Key>>& of_row = found.nodes[row];
    if (side[set] == Fragments::kNone && points[set] >= kLeastBody) {
      side[set] = Fragments::kFirst + static_cast<int>(of_row.size());
      of_row.emplace_back();
    }
    if (side[set] >= Fragments::kFirst) of_row[side[set] - Fragments::kFirst].push_back(nodes[n].node);
    const Bond* b = bonds.find(row);
    const int i = b ? b->grid.node_at(nodes[n].node) : -1;
    if (i >= 0) found.side_of_node[row][i] = side[set];
  }
  return found;
}

}  // namespace mpdem
