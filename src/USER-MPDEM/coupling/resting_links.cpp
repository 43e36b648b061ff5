// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "resting_links.h"

#include <algorithm>
#include <cstring>

namespace mpdem {

void RestingLinks::bind(const PenaltyLinks& links, const Resting& resting, const GrainSides& sides) {
  bonds_.clear();
  force_.clear();
  asleep_ = 0;
  for (const PenaltyLinks::BodyLinks& l : links.bodies()) {
    Bond b{l, {}, {}, false};
    for (int s = 0; s < 2; ++s) b.side[s].at = sides.find(l.body, s);
    bonds_.push_back(b);
  }
  for (int f = 0; f < resting.fields(); ++f) {
    const int body = body_of(resting.all()[f].field);
    const auto at = std::lower_bound(bonds_.begin(), bonds_.end(), body, [](const Bond& b, int value) { return b.links.body < value; });
    if (at != bonds_.end() && at->links.body == body) at->fields.push_back(f);
  }
}

bool RestingLinks::grains_rest(const Bond& b, const GrainSides& sides) {
  for (const Side& mine : b.side)
    for (int d = 0; mine.at >= 0 && d < 3; ++d)
      if (sides.sides[mine.at].v[d] != 0.0 || sides.sides[mine.at].omega[d] != 0.0) return false;
  return true;
}

// To the bit, so that the sign of a zero counts.
bool RestingLinks::grains_are_where_they_were(const Bond& b, const GrainSides& sides) {
  for (const Side& mine : b.side) {
    if (mine.at < 0) continue;
    const GrainSide& s = sides.sides[mine.at];
    if (std::memcmp(s.x, mine.x, sizeof s.x) != 0 || std::memcmp(&s.R, &mine.R, sizeof s.R) != 0) return false;
  }
  return true;
}

void RestingLinks::keep(Bond& b, const Resting& resting, const Grid& grid, const GrainSides& sides) {
  force_.resize(grid.force.size());
  for (int n : b.fields) {
    const Resting::Field& f = resting.all()[n];
    std::copy(grid.force.begin() + 3L * f.first_node, grid.force.begin() + 3L * f.last_node, force_.begin() + 3L * f.first_node);
  }
  for (Side& mine : b.side) {
    if (mine.at < 0) continue;
    const GrainSide& s = sides.sides[mine.at];
    std::copy(s.x, s.x + 3, mine.x);
    mine.R = s.R;
    std::copy(s.force, s.force + 3, mine.force);
    std::copy(s.torque, s.torque + 3, mine.torque);
  }
  b.kept = true;
}

void RestingLinks::hand_out(const Bond& b, const Resting& resting, Grid& grid, GrainSides& sides) const {
  for (int n : b.fields) {
    const Resting::Field& f = resting.all()[n];
    std::copy(force_.begin() + 3L * f.first_node, force_.begin() + 3L * f.last_node, grid.force.begin() + 3L * f.first_node);
  }
  for (const Side& mine : b.side) {
    if (mine.at < 0) continue;
    GrainSide& s = sides.sides[mine.at];
    std::copy(mine.force, mine.force + 3, s.force);
    std::copy(mine.torque, mine.torque + 3, s.torque);
  }
}

void RestingLinks::add_force(const PenaltyLinks& links, const Resting& resting, bool skip_detached, Grid& grid, GrainSides& sides) {
  asleep_ = 0;
  for (Bond& b : bonds_) {
    const bool sleeps = std::all_of(b.fields.begin(), b.fields.end(), [&](int n) { return resting.all()[n].asleep; }) &&
                        grains_rest(b, sides);  // dampers
    if (sleeps && b.kept && grains_are_where_they_were(b, sides)) {
      hand_out(b, resting, grid, sides);
      ++asleep_;
      continue;
    }
    links.add_force(b.links, grid, sides, skip_detached);
    b.kept = false;
    if (sleeps) keep(b, resting, grid, sides);
  }
}

}  // namespace mpdem
