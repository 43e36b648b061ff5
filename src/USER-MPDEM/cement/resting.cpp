// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "resting.h"

#include <algorithm>
#include <cstring>

namespace mpdem {

bool Resting::settle(PointStore& points, Grid& grid, const Law& law, double dt, const AdvanceOptions& options,
                     AdvanceResult& result) {
  const std::vector<PointBlock> blocks(points.blocks);
  const std::vector<vd> state(points.states());  // empty before the first damage
  advance_points(points, 0, static_cast<int>(points.blocks.size()), grid, law, dt, options, result);
  return std::memcmp(blocks.data(), points.blocks.data(), blocks.size() * sizeof(PointBlock)) == 0 &&
         state.size() == points.states().size() &&
         (state.empty() || std::memcmp(state.data(), points.states().data(), state.size() * sizeof(vd)) == 0);
}

void Resting::advance(PointStore& points, Grid& grid, const Law& law, double dt, const AdvanceOptions& options,
                      AdvanceResult& result) {
  const bool moves = !options.skip_resting || std::any_of(grid.velocity.begin(), grid.velocity.end(), [](double v) { return v != 0.0; });
  if (moves) {
    asleep_ = false;
    advance_points(points, 0, static_cast<int>(points.blocks.size()), grid, law, dt, options, result);
  } else if (asleep_) {
    std::copy(internal_force_.begin(), internal_force_.end(), grid.force.begin());
  } else if (settle(points, grid, law, dt, options, result)) {
    internal_force_ = grid.force;
    asleep_ = true;
  }
}

bool Resting::hand_out_links(Grid& grid, GrainSide* side) {
  rests_ = asleep_;
  bool same = links_kept_;
  for (int n = 0; n < 2 && rests_; ++n) {
    const GrainSide& s = side[n];
    for (int d = 0; d < 3; ++d) rests_ = rests_ && s.v[d] == 0.0 && s.omega[d] == 0.0;  // dampers act on sides that move
    // compares to the bit, so the sign of a zero counts
    same = same && std::memcmp(s.x, side_[n].x, sizeof s.x) == 0 && std::memcmp(&s.R, &side_[n].R, sizeof s.R) == 0;
  }
  if (!rests_ || !same) return false;
  std::copy(force_.begin(), force_.end(), grid.force.begin());
  for (int n = 0; n < 2; ++n) {
    std::copy(side_[n].force, side_[n].force + 3, side[n].force);
    std::copy(side_[n].torque, side_[n].torque + 3, side[n].torque);
  }
  return true;
}

void Resting::keep_links(const Grid& grid, const GrainSide* side) {
  links_kept_ = rests_;
  if (!rests_) return;
  force_ = grid.force;
  for (int n = 0; n < 2; ++n) {
    const GrainSide& s = side[n];
    std::copy(s.x, s.x + 3, side_[n].x);
    side_[n].R = s.R;
    std::copy(s.force, s.force + 3, side_[n].force);
    std::copy(s.torque, s.torque + 3, side_[n].torque);
  }
}

}  // namespace mpdem
