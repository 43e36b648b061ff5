// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes of blocks whose points have all failed. Such points carry nothing. Where nodes split (fracture/phantom_nodes.h)
// many of these points are in parts of their own, and the nodes of these parts would be most of the grid of a bond that
// breaks. So these blocks have no nodes. They borrow the nodes that stand for theirs. Borrowed nodes tell where the
// points are, and have their mass. Nodes that a block had before its last point failed stay until the next layout.
#ifndef MPDEM_CEMENT_FAILURE_NODE_ALIASES_H
#define MPDEM_CEMENT_FAILURE_NODE_ALIASES_H

#include <map>
#include <vector>

#include "../../coupling/penalty_links.h"
#include "../../mpm/grid.h"
#include "../bond/options.h"
#include "node_splitting.h"

namespace mpdem {

class NodeAliases {
 public:
  // penalty: null without links. No block borrows where points that failed may carry something again, or touch.
  NodeAliases(const CementOptions& options, const PenaltyParameters* penalty);

  bool may_alias(const BlockMeta& m) const {
    return allowed_ && m.layer != 0 && m.occupied != 0 && m.failed == m.occupied && !(residue_ && m.linked);
  }
  // A block that borrowed gets nodes of its own when a point that holds joins it. Of these new nodes, those without a
  // source move as the nodes that stand for them.
  void copy_motion_of_representatives(Grid& grid, const NodeSplitting& splits, const std::vector<Key>& more,
                                      const std::map<Key, Key>& source) const;
  // Does the same for nodes that are not known from before, and clears their mark in `fresh`.
  void copy_motion_of_representatives(Grid& grid, const NodeSplitting& splits, std::vector<char>& fresh) const;
  // Finds the borrowed nodes of all blocks, on a new grid.
  void find(PointStore& points, Grid& grid, const NodeSplitting& splits) const;
  // Finds the borrowed nodes of blocks that may borrow and do not yet, and of blocks that borrowed one of these nodes.
  void find_anew(PointStore& points, Grid& grid, const NodeSplitting& splits, const std::vector<int>& nodes) const;

 private:
  bool allowed_, residue_;
};

}  // namespace mpdem

#endif
