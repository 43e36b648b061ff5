// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Forces of the links due to small motions of nodes and grains.
#include "../mpm/lane_by_lane.h"
#include "penalty_links.h"

namespace mpdem {

void PenaltyLinks::add_small_force(const std::vector<Secant>& secants, const double* x, const double (*motion)[6], double* force,
                                   double (*load)[6]) const {
  with_basis(basis_, [&](auto type) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const LinkBlock& b = blocks_[i];
      const std::uint8_t attached = link_flags_[i].attached;
      if (!attached) continue;
      const Secant& s = secants[i];
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      const double* g = motion[b.side];
      vd u[3], f[3];
      gather_value_by_lane(x, b.taken(), columns(b), w, u);
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, h = (d + 2) % 3;
        u[d] -= g[d] + g[3 + e] * s.arm[h] - g[3 + h] * s.arm[e];
      }
      const vd n = u[0] * s.n[0] + u[1] * s.n[1] + u[2] * s.n[2];
      for (int d = 0; d < 3; ++d) f[d] = -(s.kt * u[d] + (s.kn - s.kt) * n * s.n[d]);
      scatter_value_by_lane(force, attached, columns(b), w, f);
      double* to = load[b.side];
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, h = (d + 2) % 3;
        to[d] -= sum_lanes(f[d]);
        to[3 + d] -= sum_lanes(s.arm[e] * f[h] - s.arm[h] * f[e]);
      }
    }
  });
}

}  // namespace mpdem
