// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "resting.h"

#include <algorithm>
#include <cstring>

namespace mpdem {

void Resting::bind(const PointStore& points, const Grid& grid) {
  fields_.clear();
  force_.clear();
  asleep_ = 0;
  const int n = static_cast<int>(points.meta.size());
  for (int b = 0; b < n;) {
    const int field = field_of(points.meta[b].body, points.meta[b].part);
    Field f{field, b, b, 0, 0, false};
    while (b < n && field_of(points.meta[b].body, points.meta[b].part) == field) ++b;
    f.last_block = b;
    const auto below = [](const Key& k, int value) { return k[0] < value; };
    f.first_node = static_cast<int>(std::lower_bound(grid.keys.begin(), grid.keys.end(), field, below) - grid.keys.begin());
    f.last_node = static_cast<int>(std::lower_bound(grid.keys.begin(), grid.keys.end(), field + 1, below) - grid.keys.begin());
    fields_.push_back(f);
  }
}

bool Resting::moves(const Field& f, const Grid& grid) const {
  for (int i = 3 * f.first_node; i < 3 * f.last_node; ++i)
    if (grid.velocity[i] != 0.0) return true;
  return false;
}

bool Resting::settle(const Field& f, PointStore& points, Grid& grid, const Law& law, double dt,
                     const AdvanceOptions& options, AdvanceResult& result) {
  const std::size_t n = f.last_block - f.first_block;
  blocks_before_.assign(points.blocks.begin() + f.first_block, points.blocks.begin() + f.last_block);
  const bool had_state = !points.states().empty();
  const std::size_t numbers = had_state ? n * points.state_fields() : 0;
  state_before_.assign(points.state(f.first_block), points.state(f.first_block) + numbers);
  advance_points(points, f.first_block, f.last_block, grid, law, dt, options, result);
  return std::memcmp(blocks_before_.data(), &points.blocks[f.first_block], n * sizeof(PointBlock)) == 0 &&
         had_state == !points.states().empty() &&
         (numbers == 0 || std::memcmp(state_before_.data(), points.state(f.first_block), numbers * sizeof(vd)) == 0);
}

void Resting::advance(PointStore& points, Grid& grid, const Law& law, double dt, const AdvanceOptions& options,
                      AdvanceResult& result) {
  asleep_ = 0;
  for (Field& f : fields_) {
    const auto force = [&](std::vector<double>& v) { return v.begin() + 3 * f.first_node; };
    const long size = 3L * (f.last_node - f.first_node);
    if (!options.skip_resting || moves(f, grid)) {
      f.asleep = false;
      advance_points(points, f.first_block, f.last_block, grid, law, dt, options, result);
    } else if (f.asleep) {
      std::copy(force(force_), force(force_) + size, force(grid.force));
      ++asleep_;
    } else if (settle(f, points, grid, law, dt, options, result)) {
      force_.resize(grid.force.size());
      std::copy(force(grid.force), force(grid.force) + size, force(force_));
      f.asleep = true;
    }
  }
}

}  // namespace mpdem
