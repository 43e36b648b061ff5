// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "reproject.h"

#include "gather.h"
#include "scatter.h"

namespace mpdem {

void reproject_velocity(const PointStore& points, Grid& grid, double density, std::vector<double>& jump) {
  std::vector<double>& momentum = jump;
  momentum.assign(grid.velocity.size(), 0.0);
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const PointBlock& p = points.blocks[b];
    const BlockMeta& m = points.meta[b];
    const Weights s(p.X, m.base, 1.0 / grid.h);
    // The first moments of the weights take the place of their gradients.
    Weights moment(s);
    for (int d = 0; d < 3; ++d)
      for (int i = 0; i < kSupport; ++i) moment.dw[d][i] = s.w[d][i] * ((m.base[d] + i) * grid.h - p.X[d]);
    const vd mass = density * p.volume;
    vd v[3];
    gather_value(grid.velocity.data(), m.column, s, v);
    Mat3<vd> C = gather_gradient(grid.velocity.data(), m.column, moment);
    for (int i = 0; i < 3; ++i) {
      v[i] *= mass;
      for (int j = 0; j < 3; ++j) C.a[i][j] *= mass * (4.0 / (grid.h * grid.h));
    }
    scatter_value(momentum.data(), m.column, s, v);
    scatter_gradient(momentum.data(), m.column, moment, C);
  }
  grid.halo.sum(momentum.data(), 3);
  for (int i = 0; i < grid.size(); ++i) {
    const double inertia = grid.mass[i] + grid.added_mass[i];
    for (int d = 0; d < 3; ++d) {
      double& v = grid.velocity[3 * i + d];
      const double before = v;
      if (inertia > 0.0) v = (momentum[3 * i + d] + grid.added_mass[i] * v) / inertia;
      jump[3 * i + d] = v - before;
    }
  }
}

}  // namespace mpdem
