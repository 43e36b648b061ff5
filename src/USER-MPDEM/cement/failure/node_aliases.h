// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes of blocks whose points have all failed. Such points carry no stress. Where nodes split
// (fracture/phantom_nodes.h) many of them are in layers of their own, whose nodes would be most of the grid of a
// breaking bond. So these blocks get no nodes. Instead they have aliases: at each place of a node, the representative of
// the node that would be there. It gives the motion of the points and has their mass. Nodes that a block had before its
// last point failed stay until the next layout.
//
// Throws std::logic_error if the grid lacks a representative.
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
  // penalty: null without links. No block has aliases where failed points may carry load again, or have contact.
  NodeAliases(const CementOptions& options, const PenaltyParameters* penalty);

  bool may_alias(const BlockMeta& m) const {
    return allowed_ && m.layer != 0 && m.occupied != 0 && m.failed == m.occupied && !(residue_ && m.linked);
  }
  // A block with aliases gets nodes of its own when an intact point joins it. Those of these new nodes (`more`) that
  // have no source get the motion of their representatives.
  void copy_motion_of_representatives(Grid& grid, const NodeSplitting& splits, const std::vector<Key>& more,
                                      const std::map<Key, Key>& source) const;
  // Does the same for the nodes marked in `fresh`, and clears their mark.
  void copy_motion_of_representatives(Grid& grid, const NodeSplitting& splits, std::vector<char>& fresh) const;
  // Finds the aliases of all blocks, on a new grid.
  void find(PointStore& points, Grid& grid, const NodeSplitting& splits) const;
  // Finds the aliases of blocks that may have them and have none yet, and updates those that refer to one of `nodes`.
  void find_anew(PointStore& points, Grid& grid, const NodeSplitting& splits, const std::vector<int>& nodes) const;

 private:
  bool allowed_, residue_;
};

}  // namespace mpdem

#endif
