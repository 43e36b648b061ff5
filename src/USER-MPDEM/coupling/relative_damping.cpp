// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "relative_damping.h"

#include <algorithm>
#include <cmath>

#include "../mpm/block_nodes.h"
#include "rigid_motion.h"

namespace mpdem {

namespace {
constexpr double kReach = 3.0;  // largest distance of a damped node from the centre of a grain, in radii
}

double RelativeDamping::rate(double thickness, double critical_share, double shear_speed) {
  return critical_share * 2.0 * M_PI * shear_speed / thickness;
}

std::vector<char> connected_grains_of_nodes(const PointStore& points, Grid& grid) {
  const std::vector<int> row = grid.constraints.row_of_each(grid.size());
  // A copy that is constrained to a single node moves with it.
  const auto that_moves = [&](int i) {
    int masters = 0, master = i;
    if (row[i] >= 0)
      grid.constraints.for_each_master(row[i], [&](int node, double) {
        ++masters;
        master = node;
      });
    return masters > 1 ? i : master;
  };
  std::vector<double> held(2 * grid.size(), 0.0);
  for (const BlockMeta& m : points.meta)
    for (int l = 0; l < kLanes; ++l) {
      const unsigned holds = (m.connected[0] >> l & 1) + 2 * (m.connected[1] >> l & 1);
      if (!(m.occupied >> l & 1) || holds == 0) continue;
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

std::vector<double> shares_of_second_grain(const Grid& grid, const BondRecord& record, const std::vector<char>& connected) {
  std::vector<double> share(grid.size());
  for (int i = 0; i < grid.size(); ++i) {
    double depth[2];
    for (int s = 0; s < 2; ++s) {
      double r2 = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double r = grid.keys[i].at(d) * grid.h - record.centre[s][d];
        r2 += r * r;
      }
      depth[s] = std::max(std::sqrt(r2) - record.radius[s], 0.0);
    }
    const double sum = depth[0] + depth[1];
    share[i] = sum > 0.0 ? depth[0] / sum : 0.5;
    if (!connected.empty() && connected[i] != kConnectedToBoth)
      share[i] = connected[i] - 1.0;  // 0: only grain 0, 1: only grain 1, -1: none
  }
  return share;
}

RelativeDamping::RelativeDamping(const BondRecord& record, double critical_share, double shear_speed)
    : rate_(rate(record.thickness, critical_share, shear_speed)) {
  for (int s = 0; s < 2; ++s) reach2_[s] = kReach * record.radius[s] * kReach * record.radius[s];
}

void RelativeDamping::follow_grains(const Grid& grid, const BondRecord& record, const std::vector<char>& connected) {
  eights_.clear();
  const std::vector<double> share = shares_of_second_grain(grid, record, connected);
  std::vector<int> nodes;
  for (int i = 0; i < grid.size(); ++i)
    if (share[i] >= 0.0) nodes.push_back(i);
  for (std::size_t n = 0; n < nodes.size(); n += kLanes) {
    const EightNodes e(grid, &nodes[n], static_cast<int>(std::min<std::size_t>(kLanes, nodes.size() - n)));
    eights_.push_back({e, e.take_scalar(share.data())});
  }
}

RelativeDamping::Moving RelativeDamping::move(const Eight& e, const Grid& grid, const BondEnd* ends) const {
  Moving m;
  vd x[3];
  e.nodes.find_places(grid, x);
  e.nodes.take(grid.velocity.data(), m.v);
  m.scale = rate_ * e.nodes.take_scalar(grid.mass.data());
  for (int s = 0; s < 2; ++s) {
    m.share[s] = s == 0 ? 1.0 - e.share : e.share;
    for (int d = 0; d < 3; ++d) m.r[s][d] = x[d] - ends[s].x[d];
    const vd* r = m.r[s];
    vd of_grain[3];
    velocity_at(ends[s], r, of_grain);
    for (int d = 0; d < 3; ++d) m.v[d] -= m.share[s] * of_grain[d];
    m.scale = select((m.share[s] != 0.0) & (r[0] * r[0] + r[1] * r[1] + r[2] * r[2] > reach2_[s]), vd{}, m.scale);
  }
  return m;
}

void RelativeDamping::slow_nodes(Grid& grid, BondEnd* ends) const {
  EightLoads loads[2];
  for (const Eight& e : eights_) {
    const Moving m = move(e, grid, ends);
    vd f[3], reaction[3];
    for (int d = 0; d < 3; ++d) f[d] = -m.scale * m.v[d];
    e.nodes.add(f, grid.force.data());
    for (int s = 0; s < 2; ++s) {
      for (int d = 0; d < 3; ++d) reaction[d] = -e.nodes.counted * m.share[s] * f[d];
      loads[s].add(m.r[s], reaction);
    }
  }
  for (int s = 0; s < 2; ++s) loads[s].add_to(ends[s]);
}

Power RelativeDamping::power(const Grid& grid, const BondEnd* ends) const {
  vd stored = {}, growth = {};
  for (const Eight& e : eights_) {
    const Moving m = move(e, grid, ends);
    vd a[3];
    e.nodes.take(grid.acceleration.data(), a);
    for (int s = 0; s < 2; ++s) {
      vd of_grain[3];
      acceleration_at(ends[s], m.r[s], of_grain);
      for (int d = 0; d < 3; ++d) a[d] -= m.share[s] * of_grain[d];
    }
    const vd scale = e.nodes.counted * m.scale;
    for (int d = 0; d < 3; ++d) {
      stored += scale * m.v[d] * m.v[d];
      growth += scale * m.v[d] * a[d];
    }
  }
  Power power;
  power.stored = sum_lanes(stored);
  power.growth = sum_lanes(growth);
  return power;
}

}  // namespace mpdem
