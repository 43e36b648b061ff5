// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "relaxation.h"

#include <algorithm>
#include <cmath>

namespace mpdem {

namespace {
constexpr double kReach = 3.0;
}

void Relaxation::build(const Grid& grid, const std::vector<Body>& bodies, const std::vector<char>& apart, double critical_share,
                       double shear_speed) {
  ranges_.clear();
  share_.assign(grid.size(), 0.0);
  for (int i = 0; i < grid.size(); ++i) {
    const int field = grid.keys[i][0];
    const Body& body = bodies[body_of(field)];
    const int piece = piece_of(part_of_field(field));
    const bool is_apart = apart[body_of(field)];
    if (ranges_.empty() || grid.keys[ranges_.back().first][0] != field) {
      const double rate = is_apart && piece > 1 ? 0.0 : critical_share * 2.0 * M_PI * shear_speed / body.thickness;
      const auto reach2 = [&](int s) { return kReach * body.radius[s] * kReach * body.radius[s]; };
      ranges_.push_back({i, i, {-1, -1}, rate, {reach2(0), reach2(1)}, body_of(field)});
    }
    ranges_.back().last = i + 1;
    double depth[2];
    for (int s = 0; s < 2; ++s) {
      double r2 = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double r = grid.keys[i][1 + d] * grid.h - body.centre[s][d];
        r2 += r * r;
      }
      depth[s] = std::max(std::sqrt(r2) - body.radius[s], 0.0);
    }
    const double sum = depth[0] + depth[1];
    share_[i] = is_apart ? std::min(piece, 1) : sum > 0.0 ? depth[0] / sum : 0.5;
  }
}

std::vector<Key> Relaxation::needed_sides() const {
  std::vector<Key> keys;
  for (const Range& r : ranges_)
    for (int s = 0; s < 2; ++s) keys.push_back({r.body, s, 0, 0});
  return keys;
}

void Relaxation::bind(const GrainSides& sides) {
  for (Range& r : ranges_)
    for (int s = 0; s < 2; ++s) r.side[s] = sides.find(r.body, s);
}

double Relaxation::add_force(Grid& grid, GrainSides& sides) const {
  double power = 0.0;
  const std::vector<char>& counts = grid.halo.counts_here();
  for (const Range& range : ranges_) {
    if (range.rate == 0.0) continue;
    GrainSide* side[2] = {&sides.sides[range.side[0]], &sides.sides[range.side[1]]};
    for (int i = range.first; i < range.last; ++i) {
      const double scale = range.rate * grid.mass[i], part[2] = {1.0 - share_[i], share_[i]};
      double r[2][3], v[3], f[3];
      for (int d = 0; d < 3; ++d) {
        v[d] = grid.velocity[3 * i + d];
        for (int s = 0; s < 2; ++s) r[s][d] = grid.keys[i][1 + d] * grid.h + grid.displacement[3 * i + d] - side[s]->x[d];
      }
      const auto is_far = [&](int s) {
        return part[s] != 0.0 && r[s][0] * r[s][0] + r[s][1] * r[s][1] + r[s][2] * r[s][2] > range.reach2[s];
      };
      if (is_far(0) || is_far(1)) continue;
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        for (int s = 0; s < 2; ++s)
          v[d] -= part[s] * (side[s]->v[d] + side[s]->omega[e] * r[s][g] - side[s]->omega[g] * r[s][e]);
      }
      for (int d = 0; d < 3; ++d) {
        f[d] = -scale * v[d];
        grid.force[3 * i + d] += f[d];
      }
      if (!counts[i]) continue;
      power -= f[0] * v[0] + f[1] * v[1] + f[2] * v[2];
      for (int s = 0; s < 2; ++s)
        for (int d = 0; d < 3; ++d) {
          const int e = (d + 1) % 3, g = (d + 2) % 3;
          side[s]->force[d] -= part[s] * f[d];
          side[s]->torque[d] -= part[s] * (r[s][e] * f[g] - r[s][g] * f[e]);
        }
    }
  }
  return power;
}

}  // namespace mpdem
