// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "relaxation.h"

#include <algorithm>
#include <cmath>

#include "../mpm/block_nodes.h"
#include "rigid_motion.h"

namespace mpdem {

namespace {
constexpr double kReach = 3.0;
}

double Relaxation::rate(const Body& body, double critical_share, double shear_speed) {
  return critical_share * 2.0 * M_PI * shear_speed / body.thickness;
}

std::vector<char> nodes_held(const PointStore& points, Grid& grid) {
  const std::vector<int> row = grid.ties.row_of_each(grid.size());
  // A copy moves as the single node that it is tied to.
  const auto that_moves = [&](int i) {
    int masters = 0, master = i;
    if (row[i] >= 0)
      grid.ties.for_each_master(row[i], [&](int node, double) {
        ++masters;
        master = node;
      });
    return masters > 1 ? i : master;
  };
  std::vector<double> held(2 * grid.size(), 0.0);
  for (const BlockMeta& m : points.meta)
    for (int l = 0; l < kLanes; ++l) {
      const unsigned holds = (m.holds[0] >> l & 1) + 2 * (m.holds[1] >> l & 1);
      if (!((m.occupied & ~m.failed) >> l & 1) || holds == 0) continue;
      for_each_node_of_lane(grid, m, l, [&](int i) {
        const int node = that_moves(i);
        for (int g = 0; g < 2; ++g)
          if (holds >> g & 1) held[2 * node + g] = 1.0;
      });
    }
  grid.halo.sum(held.data(), 2);
  std::vector<char> bits(grid.size());
  for (int i = 0; i < grid.size(); ++i) {
    const double* h = &held[2 * that_moves(i)];
    bits[i] = static_cast<char>((h[0] > 0.0) + 2 * (h[1] > 0.0));
  }
  return bits;
}

std::vector<double> shares_of_second_grain(const Grid& grid, const Body& body, const std::vector<char>& held) {
  std::vector<double> share(grid.size());
  for (int i = 0; i < grid.size(); ++i) {
    double depth[2];
    for (int s = 0; s < 2; ++s) {
      double r2 = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double r = grid.keys[i].at(d) * grid.h - body.centre[s][d];
        r2 += r * r;
      }
      depth[s] = std::max(std::sqrt(r2) - body.radius[s], 0.0);
    }
    const double sum = depth[0] + depth[1];
    share[i] = sum > 0.0 ? depth[0] / sum : 0.5;
    if (!held.empty() && held[i] != kHoldsBoth) share[i] = held[i] - 1.0;  // 0: the first grain, 1: the second, -1: none
  }
  return share;
}

Relaxation::Relaxation(const Grid& grid, const Body& body, const std::vector<char>& held, double critical_share, double shear_speed)
    : rate_(rate(body, critical_share, shear_speed)), share_(shares_of_second_grain(grid, body, held)) {
  for (int s = 0; s < 2; ++s) reach2_[s] = kReach * body.radius[s] * kReach * body.radius[s];
}

template <class F>
void Relaxation::for_each_node(const Grid& grid, const GrainSide* side, F f) const {
  for (int i = 0; i < static_cast<int>(share_.size()); ++i) {
    if (share_[i] < 0.0) continue;
    Node node{i, {1.0 - share_[i], share_[i]}, {}, {}, rate_ * grid.mass[i]};
    for (int s = 0; s < 2; ++s) lever_arm(grid, i, side[s], node.r[s]);
    const auto is_far = [&](int s) {
      const double* r = node.r[s];
      return node.share[s] != 0.0 && r[0] * r[0] + r[1] * r[1] + r[2] * r[2] > reach2_[s];
    };
    if (is_far(0) || is_far(1)) continue;
    std::copy(&grid.velocity[3 * i], &grid.velocity[3 * i] + 3, node.v);
    for (int s = 0; s < 2; ++s) {
      double of_grain[3];
      velocity_at(side[s], node.r[s], of_grain);
      for (int d = 0; d < 3; ++d) node.v[d] -= node.share[s] * of_grain[d];
    }
    f(node);
  }
}

void Relaxation::add_force(Grid& grid, GrainSide* side) const {
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each_node(grid, side, [&](const Node& node) {
    double f[3];
    for (int d = 0; d < 3; ++d) {
      f[d] = -node.scale * node.v[d];
      grid.force[3 * node.at + d] += f[d];
    }
    if (!counts[node.at]) return;
    for (int s = 0; s < 2; ++s) add_to_grain(node.r[s], f, -node.share[s], side[s]);
  });
}

Power Relaxation::power(const Grid& grid, const GrainSide* side) const {
  Power power;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each_node(grid, side, [&](const Node& node) {
    if (!counts[node.at]) return;
    double of_grain[2][3];
    for (int s = 0; s < 2; ++s) acceleration_at(side[s], node.r[s], of_grain[s]);
    for (int d = 0; d < 3; ++d)
      power.add(node.scale * node.v[d], node.v[d], grid.acceleration[3 * node.at + d] - node.share[0] * of_grain[0][d] - node.share[1] * of_grain[1][d]);
  });
  return power;
}

}  // namespace mpdem
