// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "rigid_pieces.h"

#include <algorithm>

#include "../../coupling/relative_damping.h"
#include "../../mpm/material_runs.h"
#include "../../mpm/point_state.h"
#include "condensed_fields.h"

namespace mpdem {

BondRecord record_of_piece(const BondRecord& record, int s) {
  BondRecord piece(record);
  const int other = 1 - s;
  piece.grain[other] = record.grain[s];
  piece.radius[other] = record.radius[s];
  std::copy(record.centre[s], record.centre[s] + 3, piece.centre[other]);
  std::copy(record.orientation[s], record.orientation[s] + 4, piece.orientation[other]);
  std::copy(record.shift[s], record.shift[s] + 3, piece.shift[other]);
  return piece;
}

std::array<BondEnd, 2> both_ends_on(const BondEnd& end) { return {end, end}; }

namespace {
int lanes_in_fragments(const BlockMeta& m) { return m.occupied & ~m.failed & ~m.connected[0] & ~m.connected[1]; }
}  // namespace

int points_in_fragments(const PointStore& points) {
  int count = 0;
  for (const BlockMeta& m : points.meta) count += __builtin_popcount(lanes_in_fragments(m));
  return count;
}

double energy_of_fragments(const Bond& bond, const std::vector<signed char>& attached_grain, const Law& of_any_kind, double dt_last) {
  double energy = 0.0;
  for_each_material(bond.points, of_any_kind, [&](const auto& law, int first, int last) {
    for (int b = first; b < last; ++b) {
      const int loose = lanes_in_fragments(bond.points.meta[b]);
      if (loose == 0) continue;
      const PointBlock& p = bond.points.blocks[b];
      energy += sum_lanes(0.5 * select(lanes(loose), p.volume, vd{}) * contract(stress_of(bond.points, b, law), p.strain));
    }
  });
  const Grid& grid = bond.grid;
  for (int i = 0; i < grid.size(); ++i)
    for (int n = 3 * i; n < 3 * i + 3 && attached_grain[i] < 0; ++n)
      energy += 0.5 * grid.mass[i] * grid.velocity[n] * (grid.velocity[n] + dt_last * grid.acceleration[n]);
  return energy;
}

std::vector<signed char> attached_grains_of_nodes(Bond& bond) {
  std::vector<signed char> grain;
  for (char held : connected_grains_of_nodes(bond.points, bond.grid))
    grain.push_back(static_cast<signed char>(held == 1 || held == 2 ? held - 1 : -1));
  return grain;
}

std::vector<signed char> grains_of_nodes(Bond& bond, const BondRecord& record) {
  std::vector<signed char> grain = attached_grains_of_nodes(bond);
  for (std::size_t i = 0; i < grain.size(); ++i) {
    if (grain[i] >= 0) continue;
    const Eigen::Vector3d X = position_of(bond.grid, static_cast<int>(i));
    grain[i] = static_cast<signed char>(nearer_grain(record, nearer_to_first(record, X.data())));
    if (!record.has_grain(grain[i])) grain[i] = static_cast<signed char>(1 - grain[i]);
  }
  return grain;
}

std::vector<CondensedModel> models_of_pieces(const Bond& bond, const std::vector<signed char>& grain_of_node,
                                             const Eigen::Vector3d& middle) {
  std::vector<CondensedModel> models(2);
  for (CondensedModel& m : models) m.middle = middle;
  const Eigen::Matrix<double, 3, 6> at_rest = Eigen::Matrix<double, 3, 6>::Zero();
  const Grid& grid = bond.grid;
  for (int i = 0; i < grid.size(); ++i)
    if (grid.mass[i] > 0.0 && grid.halo.counts_here()[i] && grain_of_node[i] >= 0)
      models[grain_of_node[i]].add_node(grid.mass[i], position_of(grid, i), at_rest);
  return models;
}

Eigen::Matrix<double, 6, 1> momentum_of_node(const Grid& grid, int node, const CondensedMotion& motion) {
  using Vector3 = Eigen::Vector3d;
  const Vector3 p = grid.mass[node] * (motion.axes().transpose() * CondensedMotion::vector(&grid.velocity[3 * node]));
  const Vector3 position = position_of(grid, node) + CondensedMotion::vector(&grid.displacement[3 * node]);
  Eigen::Matrix<double, 6, 1> of_node;
  of_node.head<3>() = p;
  of_node.tail<3>() = Vector3(motion.axes().transpose() * (position - motion.middle())).cross(p);
  return of_node;
}

namespace {

// Calls f(s, motion, ends), which returns the twelve generalized loads of piece s.
template <class F>
GrainLoads loads_of_pieces(const std::vector<CondensedModel>& models, const BondRecord& record, const BondEnd* ends, F f) {
  GrainLoads loads;
  for (int s = 0; s < 2; ++s) {
    const BondRecord piece = record_of_piece(record, s);
    const auto both = both_ends_on(ends[s]);
    const CondensedMotion motion(models[s], piece, both.data());
    const GrainLoads of_piece = motion.loads(f(s, motion, both));
    std::copy(of_piece.of[0], of_piece.of[0] + 6, loads.of[s]);
  }
  return loads;
}

}  // namespace

GrainLoads momentum_of_pieces(const Bond& bond, const std::vector<signed char>& grain_of_node, const std::vector<CondensedModel>& models,
                              const BondRecord& record, const BondEnd* ends) {
  return loads_of_pieces(models, record, ends, [&](int s, const CondensedMotion& motion, const std::array<BondEnd, 2>&) {
    CondensedMotion::Vector12 sum = CondensedMotion::Vector12::Zero();
    for (int i = 0; i < bond.grid.size(); ++i)
      if (bond.grid.mass[i] > 0.0 && bond.grid.halo.counts_here()[i] && grain_of_node[i] == s)
        sum.head<6>() += momentum_of_node(bond.grid, i, motion);
    return sum;
  });
}

GrainLoads momentum_of_rigid_pieces(const std::vector<CondensedModel>& models, const BondRecord& record, const BondEnd* ends, double half) {
  return loads_of_pieces(models, record, ends, [&](int s, const CondensedMotion& motion, const std::array<BondEnd, 2>& both) {
    return motion.momentum_before(models[s], both.data(), half);
  });
}

}  // namespace mpdem
