// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bond_motion.h"

#include <Eigen/Dense>

namespace mpdem {

BondMotion sums_of_motion(const Grid& grid, double kick) {
  BondMotion s{};
  for (int i = 0; i < grid.size(); ++i) {
    if (!grid.halo.counts_here()[i] || grid.mass[i] == 0.0) continue;
    double x[3], v[3];
    for (int d = 0; d < 3; ++d) {
      x[d] = grid.keys[i].at(d) * grid.h + grid.displacement[3 * i + d];
      v[d] = grid.velocity[3 * i + d] + kick * grid.acceleration[3 * i + d];
    }
    const double m = grid.mass[i];
    s.mass += m;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      s.first[d] += m * x[d];
      s.second[d] += m * x[d] * x[d];
      s.second[3 + d] += m * x[e] * x[g];
      s.momentum[d] += m * v[d];
      s.angular[d] += m * (x[e] * v[g] - x[g] * v[e]);
      s.kinetic += 0.5 * m * v[d] * v[d];
    }
  }
  return s;
}

// Solves M (V, omega) = missing momentum and angular momentum about the origin. Lengths are in cells, so entries are of similar size.
void restore_rigid_motion(Grid& grid, const BondMotion& before, const BondMotion& now) {
  if (!(now.mass > 0.0) || !(before.mass > 0.0)) return;
  const double h = grid.h;
  Eigen::Matrix<double, 6, 6> M = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> missing;
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    M(d, d) = now.mass;
    M(d, 3 + e) = M(3 + e, d) = now.first[g] / h;
    M(d, 3 + g) = M(3 + g, d) = -now.first[e] / h;
    M(3 + d, 3 + d) = (now.second[e] + now.second[g]) / (h * h);
    M(3 + e, 3 + g) = M(3 + g, 3 + e) = -now.second[3 + d] / (h * h);
    missing[d] = before.momentum[d] - now.momentum[d];
    const auto moved = [&](int c) { return now.first[c] / now.mass - before.first[c] / before.mass; };
    missing[3 + d] = (before.angular[d] + moved(e) * before.momentum[g] - moved(g) * before.momentum[e] - now.angular[d]) / h;
  }
  const Eigen::Matrix<double, 6, 1> r = M.ldlt().solve(missing);
  for (int i = 0; i < grid.size(); ++i)
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      const auto x = [&](int c) { return grid.keys[i].at(c) + grid.displacement[3 * i + c] / h; };
      grid.velocity[3 * i + d] += r[d] + r[3 + e] * x(g) - r[3 + g] * x(e);
    }
}

}  // namespace mpdem
