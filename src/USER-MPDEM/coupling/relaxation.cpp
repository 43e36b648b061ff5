// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "relaxation.h"

#include <algorithm>
#include <cmath>

#include "../mpm/block_nodes.h"

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
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 3; ++d)
        node.r[s][d] = grid.keys[i].at(d) * grid.h + grid.displacement[3 * i + d] - side[s].x[d];
    const auto is_far = [&](int s) {
      const double* r = node.r[s];
      return node.share[s] != 0.0 && r[0] * r[0] + r[1] * r[1] + r[2] * r[2] > reach2_[s];
    };
    if (is_far(0) || is_far(1)) continue;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      node.v[d] = grid.velocity[3 * i + d];
      for (int s = 0; s < 2; ++s)
        node.v[d] -= node.share[s] * (side[s].v[d] + side[s].omega[e] * node.r[s][g] - side[s].omega[g] * node.r[s][e]);
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
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        side[s].force[d] -= node.share[s] * f[d];
        side[s].torque[d] -= node.share[s] * (node.r[s][e] * f[g] - node.r[s][g] * f[e]);
      }
  });
}

Power Relaxation::power(const Grid& grid, const GrainSide* side) const {
  Power power;
  const std::vector<char>& counts = grid.halo.counts_here();
  for_each_node(grid, side, [&](const Node& node) {
    if (!counts[node.at]) return;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, g = (d + 2) % 3;
      double a = grid.acceleration[3 * node.at + d];
      for (int s = 0; s < 2; ++s)
        a -= node.share[s] * (side[s].a[d] + side[s].alpha[e] * node.r[s][g] - side[s].alpha[g] * node.r[s][e]);
      power.add(node.scale * node.v[d], node.v[d], a);
    }
  });
  return power;
}

}  // namespace mpdem
