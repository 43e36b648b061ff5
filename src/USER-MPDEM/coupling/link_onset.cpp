// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How near the links of a bond are to the onset of their damage, for small motions.
#include "../mpm/lane_by_lane.h"
#include "penalty_links.h"
#include "traction_laws.h"

namespace mpdem {

// Reduces the separation of cement and undeformed surface to that of the link. amplitudes: of the modes, in the axes of the bond.
void PenaltyLinks::take_share_of_link(std::size_t block, const Secant& s, const Eigen::VectorXd& amplitudes, vd* delta) const {
  const ElasticEnds::Side& e = elastic_->side[blocks_[block].side];
  if (e.end.is_rigid()) return;
  vd u[3];
  e.end.displacement(block - e.first_block, amplitudes.data(), u);
  for (int d = 0; d < 3; ++d) delta[d] -= u[d];
  const vd area = select(blocks_[block].area > 0.0, blocks_[block].area, splat(1.0));
  const TractionSecant share = e.end.share_of_link({s.kn / area, s.kt / area});
  const vd apart = (share.kn - share.kt) * (delta[0] * s.n[0] + delta[1] * s.n[1] + delta[2] * s.n[2]);
  for (int d = 0; d < 3; ++d) delta[d] = share.kt * delta[d] + apart * s.n[d];
}

PenaltyLinks::SmallSeparations PenaltyLinks::small_separations(const std::vector<Secant>& secants,
                                                               const std::array<std::vector<double>, 6>& fields,
                                                               const double (*motions)[2][6], const BondEnd* ends,
                                                               const std::array<std::array<Eigen::VectorXd, 2>, 6>& amplitudes) const {
  SmallSeparations found;
  found.blocks.assign(blocks_.size(), {});
  std::array<std::array<Eigen::VectorXd, 2>, 6> turned;  // amplitudes of elastic grains, in the axes of the bond
  for (std::size_t j = 0; j < 6 && elastic_; ++j)
    for (std::size_t side = 0; side < 2; ++side)
      if (const Eigen::VectorXd& q = amplitudes[j][side]; q.size() > 0)
        turned[j][side] = turned_modes(axes_of_patch(static_cast<int>(side), ends[side]), q);
  with_basis(basis_, [&](auto type) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const LinkBlock& b = blocks_[i];
      const Secant& s = secants[i];
      const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
      std::copy(s.n, s.n + 3, found.blocks[i].n);
      for (int j = 0; j < 6; ++j) {
        const double* g = motions[j][b.side];
        vd u[3];
        gather_value_by_lane(fields[static_cast<std::size_t>(j)].data(), b.taken(), columns(b), w, u);
        for (int d = 0; d < 3; ++d) {
          const int e = (d + 1) % 3, h = (d + 2) % 3;
          found.blocks[i].delta[j][d] = masked(link_flags_[i].attached, u[d] - (g[d] + g[3 + e] * s.arm[h] - g[3 + h] * s.arm[e]));
        }
        if (elastic_) take_share_of_link(i, s, turned[static_cast<std::size_t>(j)][b.side], found.blocks[i].delta[j]);
      }
    }
  });
  return found;
}

double PenaltyLinks::largest_onset_share(const SmallSeparations& separations, const double* d) const {
  vd most{};
  with_traction(*p_.law, [&](const auto& of_first) {
    if constexpr (std::decay_t<decltype(of_first)>::kFields > 0)
      for (std::size_t n = 0; n < separations.blocks.size(); ++n) {
        const SmallSeparations::Block& b = separations.blocks[n];
        const auto& traction = of_first.same_kind(blocks_[n].material);
        vd delta[3] = {};
        for (int j = 0; j < 6; ++j)
          for (int i = 0; i < 3; ++i) delta[i] += splat(d[j]) * b.delta[j][i];
        most = max(most, traction.onset_share(counted(separation_of(delta, b.n), n)));
      }
  });
  return largest_lane(most);
}

void PenaltyLinks::largest_onset_shares(const SmallSeparations& separations, double* of_motion) const {
  for (int j = 0; j < 6; ++j) {
    double d[6] = {};
    of_motion[j] = 0.0;
    for (double sign : {-1.0, 1.0}) {
      d[j] = sign;
      of_motion[j] = std::max(of_motion[j], largest_onset_share(separations, d));
    }
  }
}

}  // namespace mpdem
