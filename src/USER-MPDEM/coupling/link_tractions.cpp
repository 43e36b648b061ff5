// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Tractions of the links, for output. Dampers are left out.
#include <algorithm>
#include <cmath>

#include "../mpm/lane_by_lane.h"
#include "penalty_links.h"
#include "traction_laws.h"

namespace mpdem {

// delta: separation of the link, without the motion of an elastic surface.
void PenaltyLinks::put_traction(std::size_t block, const TractionSecant& k, const vd* delta, const vd* n,
                                std::vector<LinkTraction>& of_links) const {
  const LinkBlock& b = blocks_[block];
  const vd apart = delta[0] * n[0] + delta[1] * n[1] + delta[2] * n[2],
           square = delta[0] * delta[0] + delta[1] * delta[1] + delta[2] * delta[2];
  for (int l = 0; l < kLanes; ++l)
    if (link_flags_[block].attached >> l & 1)
      of_links[static_cast<std::size_t>(b.link[l])] = {k.kn[l] * apart[l],
                                                       k.kt[l] * std::sqrt(std::max(square[l] - apart[l] * apart[l], 0.0))};
}

std::vector<PenaltyLinks::LinkTraction> PenaltyLinks::tractions(const PointStore& points, const Grid& grid, const BondEnd* ends) const {
  std::vector<LinkTraction> found(points.links.size());
  if (blocks_.empty()) return found;
  Eigen::VectorXd amplitudes[2];
  for (int side = 0; side < 2 && elastic_; ++side)
    if (const Eigen::VectorXd& q = elastic_->side[static_cast<std::size_t>(side)].amplitudes; q.size() > 0)
      amplitudes[side] = turned_modes(axes_of_patch(side, ends[side]), q);
  with_traction(*p_.law, [&](const auto& law) {
    with_basis(basis_, [&](auto type) {
      for (std::size_t i = 0; i < blocks_.size(); ++i) {
        const LinkBlock& b = blocks_[i];
        vd q[3], delta[3], n[3], u[3] = {};
        find_separation(b, grid, ends[b.side], Weights<decltype(type)>(b.X, b.base, inverse_h_), q, delta, n);
        const TractionSecant k = softened(b.side, law.same_kind(b.material).secant(separation_of(delta, n), state(law, i)));
        if (amplitudes[b.side].size() > 0) {
          const ElasticEnds::Side& e = elastic_->side[b.side];
          e.end.displacement(i - e.first_block, amplitudes[b.side].data(), u);
        }
        for (int d = 0; d < 3; ++d) delta[d] -= u[d];
        put_traction(i, k, delta, n, found);
      }
    });
  });
  return found;
}

std::vector<PenaltyLinks::LinkTraction> PenaltyLinks::small_tractions(const PointStore& points, const std::vector<Secant>& secants,
                                                                      const BondEnd* ends, const double* x, const double (*motion)[6],
                                                                      const std::array<Eigen::VectorXd, 2>& amplitudes) const {
  std::vector<LinkTraction> found(points.links.size());
  with_basis(basis_, [&](auto type) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const LinkBlock& b = blocks_[i];
      const Secant& s = secants[i];
      vd delta[3], u[3] = {};
      gather_value_by_lane(x, b.taken(), columns(b), Weights<decltype(type)>(b.X, b.base, inverse_h_), delta);
      if (const Eigen::VectorXd& q = amplitudes[b.side]; q.size() > 0) {
        const ElasticEnds::Side& e = elastic_->side[b.side];
        e.end.displacement(i - e.first_block, turned_modes(axes_of_patch(b.side, ends[b.side]), q).data(), u);
      }
      const double* g = motion[b.side];
      for (int d = 0; d < 3; ++d) {
        const int e1 = (d + 1) % 3, e2 = (d + 2) % 3;
        delta[d] -= u[d] + g[d] + g[3 + e1] * s.arm[e2] - g[3 + e2] * s.arm[e1];
      }
      const vd area = select(b.area > vd{}, b.area, splat(1.0));
      put_traction(i, {s.kn / area, s.kt / area}, delta, s.n, found);
    }
  });
  return found;
}

}  // namespace mpdem
