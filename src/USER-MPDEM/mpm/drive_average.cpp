// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "drive_average.h"

#include <cmath>

#include "../material/laws.h"
#include "gather.h"
#include "point_state.h"
#include "scatter.h"

namespace mpdem {

namespace {

// What is averaged: the root of a norm of the strain, from the drive of the undamaged material in that strain.
template <class L>
vd root_of_norm(const L& law, const Sym3<vd>& strain) {
  const vd root = sqrt(law.undamaged_drive(strain));
  return L::kDegree == 2 ? sqrt(root) : root;
}

// Factor on the drive if that root changes by a factor.
template <class L>
vd drive_factor(vd root) {
  const vd norm = root * root;
  return L::kDegree == 2 ? norm * norm : norm;
}

}  // namespace

AverageSweeps sweeps_for(double length, double cell, Basis basis) {
  const double sweeps = 6.0 * length * length / (support(basis) * cell * cell);
  // a weight of next to nothing is rounding
  const int whole = static_cast<int>(sweeps * (1.0 + 1e-9));
  const double rest = sweeps - whole;
  return rest > 1e-6 * sweeps ? AverageSweeps{whole + 1, rest} : AverageSweeps{whole, 1.0};
}

bool is_near_threshold(const PointStore& points, const Law& law) {
  return with_law(law, [&](const auto& l) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0) {
      const double near = kNearThreshold * l.lowest_threshold() * std::min(1.0, l.interface());
      for (std::size_t b = 0; b < points.blocks.size(); ++b) {
        const BlockMeta& m = points.meta[b];
        const Sym3<vd>& strain = points.blocks[b].strain;
        const vmask active = lanes(m.occupied & ~m.failed);
        if (any(active & (L::square_bound(l.elasticity().stress(strain), strain) > near * near))) return true;
      }
    }
    return false;
  });
}

void DriveAverage::start(const PointStore& points, const Grid& grid, const Law& law) {
  const std::size_t blocks = points.blocks.size();
  own_.resize(blocks);
  field_.resize(blocks);
  volume_.assign(grid.size(), 0.0);
  sum_.assign(grid.size(), 0.0);
  mean_.resize(grid.size());
  const double inverse_h = 1.0 / grid.h;
  with_law(law, [&](const auto& l) {
    using L [[maybe_unused]] = std::decay_t<decltype(l)>;
    with_basis(grid.basis, [&](auto type) {
      for (std::size_t b = 0; b < blocks; ++b) {
        const PointBlock& p = points.blocks[b];
        const BlockMeta& m = points.meta[b];
        own_[b] = field_[b] = vd{};
        if (m.failed == m.occupied) continue;
        const vmask active = lanes(m.occupied & ~m.failed);
        if constexpr (L::kFields > 0) own_[b] = field_[b] = select(active, root_of_norm(l, p.strain), vd{});
        const Weights<decltype(type)> s(p.X, m.base, inverse_h);
        const vd V = select(active, p.volume, vd{});
        scatter_scalar(volume_.data(), m.column, s, V);
        scatter_scalar(sum_.data(), m.column, s, V * own_[b]);
      }
    });
  });
}

void DriveAverage::find_means() {
  for (std::size_t i = 0; i < sum_.size(); ++i) mean_[i] = volume_[i] > 0.0 ? sum_[i] / volume_[i] : 0.0;
}

void DriveAverage::sweep(const PointStore& points, const Grid& grid, double weight, bool last) {
  find_means();
  if (!last) std::fill(sum_.begin(), sum_.end(), 0.0);
  const double inverse_h = 1.0 / grid.h;
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const PointBlock& p = points.blocks[b];
      const BlockMeta& m = points.meta[b];
      if (m.failed == m.occupied) continue;
      const vmask active = lanes(m.occupied & ~m.failed);
      const Weights<decltype(type)> s(p.X, m.base, inverse_h);
      vd average;
      gather_scalar(mean_.data(), m.column, s, &average);
      field_[b] = select(active, (1.0 - weight) * field_[b] + weight * average, vd{});
      if (!last) scatter_scalar(sum_.data(), m.column, s, p.volume * field_[b]);
    }
  });
}

void DriveAverage::finish(PointStore& points, const Law& law) const {
  points.amplification.resize(own_.size());
  with_law(law, [&](const auto& l) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0)
      for (std::size_t b = 0; b < own_.size(); ++b)
        points.amplification[b] = min(drive_factor<L>(field_[b] / max(own_[b], splat(1e-300))), splat(kMostAmplification));
  });
}

}  // namespace mpdem
