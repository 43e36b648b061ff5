// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sums nodal values over the ranks that share nodes, for all resolved bonds, with one message to each of these ranks.
// Sums have the units of the values.
#ifndef MPDEM_CEMENT_BOND_SHARED_NODES_H
#define MPDEM_CEMENT_BOND_SHARED_NODES_H

#include <vector>

#include "../../parallel/halo_sum.h"
#include "scene.h"

namespace mpdem {

class SharedNodes {
 public:
  explicit SharedNodes(Scene& scene) : scene_(scene) {}

  // Collective. Call after a layout, or when bonds are activated or condensed.
  void bind();
  // Collective. Sums nodal values, `width` per node, of all resolved bonds that several ranks share.
  void sum(double* (*values)(Bond&), int width);
  // Resolved bonds of this rank whose nodes other ranks share, ascending in row.
  const std::vector<Bond*>& cut_bonds() const { return cut_bonds_; }
  // Is any resolved bond of the scene shared by ranks? Only nonlocal damage needs this; without it the answer is false.
  bool any_bond_is_cut() const { return any_bond_is_cut_; }

 private:
  Scene& scene_;
  HaloSums sums_;
  std::vector<Bond*> cut_bonds_;
  bool any_bond_is_cut_ = false;
};

}  // namespace mpdem

#endif
