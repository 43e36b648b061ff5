// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Eight nodes of a grid, one per lane, for loops over many nodes of a bond in every step.
#ifndef MPDEM_COUPLING_EIGHT_NODES_H
#define MPDEM_COUPLING_EIGHT_NODES_H

#include "../mpm/grid.h"
#include "../numerics/simd.h"
#include "bond_ends.h"

namespace mpdem {

struct EightNodes {
  vd counted;               // 1 where this rank counts the node, 0 where not and in the lanes beyond the last node
  vd X[3];                  // reference
  int node[kLanes], count;  // lanes beyond the last node have the first one
  int unused[7] = {};       // pads the struct: lists of it are compared byte by byte

  EightNodes() = default;
  // of: `count` nodes, at least 1.
  EightNodes(const Grid& grid, const int* of, int count) : count(count) {
    for (int l = 0; l < kLanes; ++l) {
      node[l] = of[l < count ? l : 0];
      counted[l] = l < count ? grid.halo.counts_here()[node[l]] : 0.0;
      for (int d = 0; d < 3; ++d) X[d][l] = grid.keys[node[l]].at(d) * grid.h;
    }
  }

  // Reads values of the nodes, three numbers each. put() writes them, and add() adds to them. take_scalar() reads values of
  // one number each. find_places() finds the present positions.
  void take(const double* values, vd* out) const {
    const double* p[kLanes];
    for (int l = 0; l < kLanes; ++l) p[l] = values + 3 * static_cast<long>(node[l]);
    for (int d = 0; d < 3; ++d) out[d] = vd{p[0][d], p[1][d], p[2][d], p[3][d], p[4][d], p[5][d], p[6][d], p[7][d]};
  }
  void put(const vd* in, double* values) const {
    for (int l = 0; l < count; ++l)
      for (int d = 0; d < 3; ++d) values[3 * static_cast<long>(node[l]) + d] = in[d][l];
  }
  void add(const vd* in, double* values) const {
    for (int l = 0; l < count; ++l)
      for (int d = 0; d < 3; ++d) values[3 * static_cast<long>(node[l]) + d] += in[d][l];
  }
  vd take_scalar(const double* v) const {
    const int* n = node;
    return vd{v[n[0]], v[n[1]], v[n[2]], v[n[3]], v[n[4]], v[n[5]], v[n[6]], v[n[7]]};
  }
  void find_places(const Grid& grid, vd* x) const {
    vd u[3];
    take(grid.displacement.data(), u);
    for (int d = 0; d < 3; ++d) x[d] = X[d] + u[d];
  }
};

// Force and moment on a grain, summed over nodes in the lanes.
struct EightLoads {
  vd force[3] = {}, torque[3] = {};

  void add(const vd* r, const vd* f) {
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      force[d] += f[d];
      torque[d] += r[e] * f[g] - r[g] * f[e];
    }
  }
  void add_to(BondEnd& s) const {
    for (int d = 0; d < 3; ++d) {
      s.force[d] += sum_lanes(force[d]);
      s.torque[d] += sum_lanes(torque[d]);
    }
  }
};

}  // namespace mpdem

#endif
