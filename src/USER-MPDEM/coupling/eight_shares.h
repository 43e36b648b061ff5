// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Added mass of eight nodes side by side: loops over all of it, in every step, are on these.
#ifndef MPDEM_EIGHT_SHARES_H
#define MPDEM_EIGHT_SHARES_H

#include <algorithm>

#include "../numerics/simd.h"
#include "added_mass.h"

namespace mpdem {

struct EightShares {
  vd mass[2];  // at either side; 0 in the lanes beyond the last share
  vd inertia;  // of the nodes, with added mass
  vd counted;  // 1 where this rank counts the node, else 0
  vd x[3];     // of the nodes

  EightShares(const std::vector<AddedMass::Share>& shares, std::size_t first, const Grid& grid, const std::vector<double>& added)
      : count_(static_cast<int>(std::min<std::size_t>(kLanes, shares.size() - first))) {
    const std::vector<char>& counts = grid.halo.counts_here();
    double m[2][kLanes] = {}, of_node[kLanes], of_added[kLanes], count[kLanes], key[3][kLanes];
    for (int l = 0; l < kLanes; ++l) {
      const AddedMass::Share& a = shares[first + (l < count_ ? l : 0)];
      node_[l] = a.node;
      if (l < count_)
        for (int n = 0; n < 2; ++n) m[n][l] = a.mass[n];
      of_node[l] = grid.mass[a.node];
      of_added[l] = added[a.node];
      count[l] = counts[a.node];
      for (int d = 0; d < 3; ++d) key[d][l] = grid.keys[a.node][1 + d];
    }
    for (int n = 0; n < 2; ++n) mass[n] = lanes_of(m[n]);
    inertia = lanes_of(of_node) + lanes_of(of_added);
    counted = lanes_of(count);
    vd u[3];
    take(grid.displacement.data(), u);
    for (int d = 0; d < 3; ++d) x[d] = lanes_of(key[d]) * grid.h + u[d];
  }

  // Vectors from the centre of a grain.
  void lever_arm(const GrainSide& s, vd* r) const {
    for (int d = 0; d < 3; ++d) r[d] = x[d] - s.x[d];
  }
  // Values of the nodes, three numbers each.
  void take(const double* values, vd* out) const {
    const double* p[kLanes];
    for (int l = 0; l < kLanes; ++l) p[l] = values + 3 * static_cast<long>(node_[l]);
    for (int d = 0; d < 3; ++d) out[d] = vd{p[0][d], p[1][d], p[2][d], p[3][d], p[4][d], p[5][d], p[6][d], p[7][d]};
  }
  void put(const vd* in, double* values) const {
    for (int l = 0; l < count_; ++l)
      for (int d = 0; d < 3; ++d) values[3 * static_cast<long>(node_[l]) + d] = in[d][l];
  }

 private:
  static vd lanes_of(const double* a) { return vd{a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7]}; }
  int count_, node_[kLanes];  // those beyond the last share are its first
};

}  // namespace mpdem

#endif
