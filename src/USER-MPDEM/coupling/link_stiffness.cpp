// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Stiffness of the links: its row sums for the added mass, which links count for it, and forces due to small motions of nodes and grains.
#include <algorithm>

#include "../mpm/lane_by_lane.h"
#include "../mpm/stiffness_matrix.h"
#include "free_weights.h"
#include "penalty_links.h"

namespace mpdem {

void PenaltyLinks::add_stiffness(const Grid& grid, const BondEnd* ends, double dt, double* penalty) const {
  if (blocks_.empty()) return;
  FreeWeights free(grid);
  with_basis(basis_, [&](auto type) {
    using Type = decltype(type);
    for (const LinkBlock& b : blocks_) {
      const std::uint8_t counting = link_flags_[number_of(b)].counts_for_added_mass;
      if (!counting) continue;
      const TractionStiffness& bound = p_.law->of_material(b.material).stiffness();
      const double stiffest = p_.stiffest(b.material), k = elastic_ ? elastic_->side[b.side].end.softened(stiffest) : stiffest,
                   damper = 2.0 * std::sqrt(std::max(bound.kn, bound.kt)) / dt;  // counts as a spring, see added_mass.h
      const vd inertia = (1.0 + ends[b.side].mass_ratio) * (dampers_.empty() ? k * b.area : k * b.area + damper * dampers_[number_of(b)]);
      const Weights<Type> w(b.X, b.base, inverse_h_);
      for (int l = 0; l < kLanes; ++l) {
        if (!(counting >> l & 1)) continue;
        free.add_row_sums(columns(b) + columns_of_cell_ * l, w, l, inertia[l], penalty + b.side);
      }
    }
  });
}

bool PenaltyLinks::drop_added_mass(PointStore& points) {
  bool some = false;
  for (std::size_t n = 0; n < blocks_.size(); ++n) {
    LinkFlags& h = link_flags_[n];
    if (h.counts_for_added_mass == h.attached) continue;
    some = true;
    h.counts_for_added_mass = h.attached;
    for (int link : blocks_[n].link)
      if (link >= 0) points.links[link].keeps_added_mass = false;
  }
  return some;
}

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

template <class F, class Then>
void PenaltyLinks::each_attached_by_cell(F f, Then then) const {
  const int support_of_cell = support(basis_);
  std::vector<int> nodes;
  const int* last = nullptr;
  const auto finish = [&] {
    if (!last) return;
    nodes.clear();
    for (int c = 0; c < columns_of_cell_; ++c)
      for (int k = 0; k < support_of_cell; ++k) nodes.push_back(last[c] + k);
    then(nodes);
  };
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (int l = 0; l < kLanes; ++l) {
      if (!(link_flags_[i].attached >> l & 1)) continue;
      const int* of_lane = columns(blocks_[i]) + columns_of_cell_ * l;
      if (last && !std::equal(of_lane, of_lane + columns_of_cell_, last)) finish();
      last = of_lane;
      f(i, l);
    }
  finish();
}

void PenaltyLinks::couple(StiffnessMatrix& matrix) const {
  each_attached_by_cell([](std::size_t, int) {}, [&](const std::vector<int>& nodes) { matrix.couple(nodes); });
}

void PenaltyLinks::add_to(StiffnessMatrix& matrix, const std::vector<Secant>& secants) const {
  std::vector<StiffnessMatrix::Spring> springs;
  with_basis(basis_, [&](auto type) {
    constexpr int S = decltype(type)::kSupport;
    each_attached_by_cell(
        [&](std::size_t i, int l) {
          const LinkBlock& b = blocks_[i];
          const Weights<decltype(type)> w(b.X, b.base, inverse_h_);
          springs.emplace_back();
          double* weight = springs.back().weight.data();
          for (int x = 0; x < S; ++x)
            for (int y = 0; y < S; ++y)
              for (int z = 0; z < S; ++z) *weight++ = w.w[0][x][l] * w.w[1][y][l] * w.w[2][z][l];
          const Secant& s = secants[i];
          const Eigen::Vector3d n(s.n[0][l], s.n[1][l], s.n[2][l]);
          springs.back().stiffness = s.kt[l] * Eigen::Matrix3d::Identity() + (s.kn[l] - s.kt[l]) * n * n.transpose();
        },
        [&](const std::vector<int>& nodes) {
          matrix.add(nodes, springs);
          springs.clear();
        });
  });
}

}  // namespace mpdem
