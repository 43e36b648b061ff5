// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Added mass of eight nodes side by side. Loops over all added mass in every step use these.
#ifndef MPDEM_EIGHT_SHARES_H
#define MPDEM_EIGHT_SHARES_H

#include "../numerics/simd.h"
#include "added_mass.h"

namespace mpdem {

struct EightShares {
  const AddedMass::EightNodes& nodes;
  vd inertia;  // of the nodes, with added mass
  vd x[3];     // of the nodes

  EightShares(const AddedMass::EightMasses& masses, const AddedMass::EightNodes& nodes, const Grid& grid) : nodes(nodes) {
    const double* m = grid.mass.data();
    const int* n = nodes.node;
    inertia = vd{m[n[0]], m[n[1]], m[n[2]], m[n[3]], m[n[4]], m[n[5]], m[n[6]], m[n[7]]} + masses.added;
    vd u[3];
    take(grid.displacement.data(), u);
    for (int d = 0; d < 3; ++d) x[d] = nodes.X[d] + u[d];
  }

  // Vectors from the centre of a grain.
  void lever_arm(const GrainSide& s, vd* r) const {
    for (int d = 0; d < 3; ++d) r[d] = x[d] - s.x[d];
  }
  // Reads values of the nodes, three numbers each. put() writes them.
  void take(const double* values, vd* out) const {
    const double* p[kLanes];
    for (int l = 0; l < kLanes; ++l) p[l] = values + 3 * static_cast<long>(nodes.node[l]);
    for (int d = 0; d < 3; ++d) out[d] = vd{p[0][d], p[1][d], p[2][d], p[3][d], p[4][d], p[5][d], p[6][d], p[7][d]};
  }
  void put(const vd* in, double* values) const {
    for (int l = 0; l < nodes.count; ++l)
      for (int d = 0; d < 3; ++d) values[3 * static_cast<long>(nodes.node[l]) + d] = in[d][l];
  }
};

}  // namespace mpdem

#endif
