// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "shared_impulse.h"

#include "relaxation.h"

namespace mpdem {

namespace {

void lever_arm(const Grid& grid, int node, const GrainSide& s, double* r) {
  for (int d = 0; d < 3; ++d) r[d] = grid.keys[node][1 + d] * grid.h + grid.displacement[3 * node + d] - s.x[d];
}

void acceleration_at(const GrainSide& s, const double* r, double* a) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    a[d] = s.a[d] + s.alpha[e] * r[g] - s.alpha[g] * r[e];
  }
}

void take_from_grain(const double* r, const double* f, double scale, GrainSide& s) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    const double force = scale * f[d], torque = scale * (r[e] * f[g] - r[g] * f[e]);
    s.force[d] -= force;
    s.torque[d] -= torque;
    s.impulse[d] -= force;
    s.impulse[3 + d] -= torque;
  }
}

}  // namespace

SharedImpulse::SharedImpulse(const Grid& grid, const Body& body, const std::vector<char>& held) : share_(shares_of_second_grain(grid, body, held)) {}

void SharedImpulse::add_moments(const Grid& grid, const GrainSide* side, SideMoments* of_sides) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for (int i = 0; i < grid.size() && !empty(); ++i) {
    if (share_[i] < 0.0 || !counts[i] || grid.mass[i] == 0.0) continue;
    const double share[2] = {1.0 - share_[i], share_[i]};
    for (int s = 0; s < 2; ++s) {
      double r[3];
      lever_arm(grid, i, side[s], r);
      MassMoments::add(grid.mass[i] * share[s] * share[s], r, of_sides[s].own.m.data());
      MassMoments::add(grid.mass[i] * share[0] * share[1], r, of_sides[s].shared.m.data());
    }
  }
}

void SharedImpulse::push(Grid& grid, GrainSide* side, const AddedMass& added) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  auto extra = added.shares().begin();
  for (int i = 0; i < grid.size() && !empty(); ++i) {
    while (extra != added.shares().end() && extra->node < i) ++extra;
    if (share_[i] < 0.0) continue;
    const double share[2] = {1.0 - share_[i], share_[i]};
    double r[2][3], of_grain[2][3], a[3], *f = &grid.force[3 * i];
    for (int s = 0; s < 2; ++s) {
      lever_arm(grid, i, side[s], r[s]);
      acceleration_at(side[s], r[s], of_grain[s]);
    }
    for (int d = 0; d < 3; ++d) {
      a[d] = share[0] * of_grain[0][d] + share[1] * of_grain[1][d];
      f[d] += grid.mass[i] * a[d];
    }
    for (int s = 0; s < 2 && counts[i]; ++s) take_from_grain(r[s], a, share[s] * grid.mass[i], side[s]);
    if (extra == added.shares().end() || extra->node != i) continue;
    for (int s = 0; s < 2; ++s) {
      double relative[3];
      for (int d = 0; d < 3; ++d) {
        relative[d] = a[d] - of_grain[s][d];
        f[d] += extra->mass[s] * relative[d];
      }
      if (counts[i]) take_from_grain(r[s], relative, extra->mass[s], side[s]);
    }
  }
}

}  // namespace mpdem
