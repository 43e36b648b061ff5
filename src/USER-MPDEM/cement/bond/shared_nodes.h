// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sums numbers of nodes that ranks share, for all bonds that are awake, by one message to each rank. Numbers are in the
// units of the nodes.
#ifndef MPDEM_CEMENT_BOND_SHARED_NODES_H
#define MPDEM_CEMENT_BOND_SHARED_NODES_H

#include <vector>

#include "../../parallel/halo_sum.h"
#include "scene.h"

namespace mpdem {

class SharedNodes {
 public:
  explicit SharedNodes(Scene& scene) : scene_(scene) {}

  // Collective. Call after a layout, or when bonds wake or are condensed.
  void bind();
  // Collective. Sums numbers of the nodes, `width` a node, of all bonds that ranks cut.
  void sum(double* (*values)(Bond&), int width);
  // Awake bonds of this rank that others cut, too, ascending.
  const std::vector<Bond*>& cut_bonds() const { return cut_bonds_; }
  // Do ranks cut any bond, on any rank? Known with nonlocal damage only.
  bool any_bond_is_cut() const { return any_bond_is_cut_; }

 private:
  Scene& scene_;
  HaloSums sums_;
  std::vector<Bond*> cut_bonds_;
  bool any_bond_is_cut_ = false;
};

}  // namespace mpdem

#endif
