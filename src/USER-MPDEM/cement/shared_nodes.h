// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nodes that ranks share, of all bonds that are awake: one message to each rank sums them. Numbers are those of the nodes, in their units.
#ifndef MPDEM_CEMENT_SHARED_NODES_H
#define MPDEM_CEMENT_SHARED_NODES_H

#include <vector>

#include "../parallel/halo_sum.h"
#include "scene.h"

namespace mpdem {

class SharedNodes {
 public:
  explicit SharedNodes(const Scene& scene) : scene_(scene) {}

  // Collective. After a layout, or when bonds wake or are condensed.
  void bind();
  // Collective. Numbers of the nodes, `width` a node, of all bonds that ranks cut.
  void sum(double* (*values)(Grid&), int width);
  // The same of bonds that have such numbers, ascending.
  void sum(const std::vector<double*>& of_bonds, int width) { sums_.sum(of_bonds, width); }
  // Do ranks cut any bond, on any rank? Known with nonlocal damage only.
  bool any_bond_is_cut() const { return any_bond_is_cut_; }

 private:
  const Scene& scene_;
  HaloSums sums_;
  bool any_bond_is_cut_ = false;
};

}  // namespace mpdem

#endif
