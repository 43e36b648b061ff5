// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "drive_average.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../material/laws.h"
#include "material_runs.h"
#include "point_state.h"
#include "strain_norm.h"

namespace mpdem {

SmoothingPasses smoothing_passes_for(double length, double cell, Basis basis) {
  const double ratio = length / cell, degree_plus_1 = support(basis);
  const double passes = (ratio * ratio - degree_plus_1 / 12.0) / (degree_plus_1 / 6.0);
  // A tiny remainder is rounding.
  const int whole = static_cast<int>(passes * (1.0 + 1e-9));
  const double rest = passes - whole;
  if (whole == 0) return {1, 1.0};  // L equals the cell, up to rounding
  return rest > 1e-6 * passes ? SmoothingPasses{whole + 1, rest} : SmoothingPasses{whole, 1.0};
}

bool is_near_threshold(const PointStore& points, const Law& law) {
  if (!points.scatter.empty()) return true;  // a strong point may raise the average at a weak one at any strain
  bool found = false;
  for_each_material(points, law, [&](const auto& l, int first, int last) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0) {
      const double near = kNearThreshold * l.lowest_threshold() * std::min(1.0, l.interface());
      for (int b = first; b < last && !found; ++b) {
        const BlockMeta& m = points.meta[b];
        const Sym3<vd>& strain = points.blocks[b].strain;
        const vmask active = lanes(m.occupied & ~m.failed);
        if (any(active & (L::square_bound(l.elasticity().stress(strain), strain) > near * near))) found = true;
      }
    }
  });
  return found;
}

namespace {

int count_intact(const PointStore& points) {
  int count = 0;
  for (const BlockMeta& m : points.meta) count += __builtin_popcount(m.occupied & ~m.failed);
  return count;
}

}  // namespace

bool DriveAverage::start(const PointStore& points, Grid& grid, const Law& law, const Imperfection& imperfection) {
  const int count = count_intact(points);
  const bool anew = !points_fixed_ || grid.drive_average.empty() || count != intact_at_start_;
  if (anew) {
    of_points_.find(points, grid);
    counted_volumes_.resize(points.blocks.size());
    for (std::size_t b = 0; b < counted_volumes_.size(); ++b)
      counted_volumes_[b] = points.blocks[b].volume * imperfection.factor_on_root(points.created_at(static_cast<int>(b)));
  }
  intact_at_start_ = count;
  sum_.assign(grid.size() + ScalarSums::kRoom, 0.0);
  with_law(law_of_bond(points, law), [&](const auto& l) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0)
      of_points_.add_values(
          [&](int b) {
            return counted_volumes_[b] * (points.knows_root_of_norm(b) ? points.root_of_norm[b] : root_of_norm(l, points.blocks[b].strain));
          },
          sum_.data());
  });
  grid.constraints.add_to_mass_receivers(sum_.data(), 1);
  mean_.assign(sum_.size(), 0.0);
  return anew;
}

void DriveAverage::find_volumes(const Grid& grid) {
  volume_.assign(grid.size() + ScalarSums::kRoom, 0.0);
  of_points_.add_volumes(volume_.data());
  grid.constraints.add_to_mass_receivers(volume_.data(), 1);
  volume_is_new_ = true;
}

void DriveAverage::smooth(Grid& grid, const SmoothingPasses& passes, int k) {
  const std::size_t nodes = grid.size();
  if (volume_is_new_) {
    inverse_volume_.resize(nodes);
    for (std::size_t i = 0; i < nodes; ++i) inverse_volume_[i] = volume_[i] > 0.0 ? 1.0 / volume_[i] : 0.0;
    volume_is_new_ = false;
  }
  const double weight = passes.weight(k);
  for (std::size_t i = 0; i < nodes; ++i) mean_[i] = (1.0 - weight) * mean_[i] + weight * sum_[i] * inverse_volume_[i];
  grid.constraints.mean_of_mass_receivers(mean_.data(), 1);
  if (passes.is_last(k)) {
    grid.drive_average.assign(mean_.begin(), mean_.begin() + nodes);
    return;
  }
  std::fill(sum_.begin(), sum_.end(), 0.0);
  of_points_.add_means(mean_.data(), sum_.data());
  grid.constraints.add_to_mass_receivers(sum_.data(), 1);
}

double DriveAverage::largest(const PointStore& points, const Grid& grid) {
  if (std::any_of(points.meta.begin(), points.meta.end(), [](const BlockMeta& m) { return m.damaged; }))
    return std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (double mean : grid.drive_average) most = std::max(most, mean);
  return most;
}

double DriveAverage::largest_to_come(const PointStore& points, const Grid& grid) const {
  return points_fixed_ ? largest(points, grid) : std::numeric_limits<double>::infinity();
}

void DriveAverage::find_limits(const PointStore& points, Grid& grid, const Law& law, double largest) {
  constexpr double kRounding = 1e-9;
  grid.drive_limit.clear();
  if (!points.scatter.empty()) return;
  with_law(law_of_bond(points, law), [&](const auto& l) {
    using L = std::decay_t<decltype(l)>;
    if constexpr (L::kFields > 0) {
      const double threshold = root_of_drive<L>(splat(l.lowest_threshold() * std::min(1.0, l.interface())))[0];
      const double lacking = (1.0 - kRounding) * threshold - largest;
      if (!(lacking > 0.0)) return;
      grid.drive_limit.reserve(points.blocks.size());
      for (const PointBlock& p : points.blocks) {
        const vd drive = drive_factor<L>(root_of_norm(l, p.strain) + lacking);
        grid.drive_limit.push_back(drive * drive);
      }
      grid.drive_average.clear();
    }
  });
}

}  // namespace mpdem
