// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "starting_motion.h"

#include <Eigen/Dense>
#include <algorithm>

#include "../../mpm/block_nodes.h"
#include "../../mpm/scatter.h"

namespace mpdem {

void start_velocities(Scene& scene, const std::vector<BondLayout>& layouts) {
  const int first = scene.rows_started, rows = static_cast<int>(scene.bonds().table.size()) - first;
  if (rows == 0) return;
  // Normal equations of the linear field v = (1, X/cell) A: matrix 4 x 4 and right-hand side 4 x 3 for each bond.
  constexpr int kNormal = 28;
  std::vector<double> sums(static_cast<std::size_t>(kNormal) * rows, 0.0);
  struct New {
    Bond* bond;
    const std::vector<char>* fresh;
    std::vector<double> velocity;  // velocities of the slots
  };
  std::vector<New> fresh;
  for (const BondLayout& l : layouts) {
    if (l.row < first) continue;
    fresh.push_back({scene.bonds().find(l.row), &l.fresh, {}});
    const PointStore& points = fresh.back().bond->points;
    std::vector<double>& velocity = fresh.back().velocity;
    velocity.assign(3 * kLanes * points.blocks.size(), 0.0);
    double* s = &sums[static_cast<std::size_t>(kNormal) * (l.row - first)];
    const Mat3<double> axes = axes_of(scene.bonds().table[l.row]);
    for (std::size_t b = 0; b < points.blocks.size(); ++b)
      for (int lane = 0; lane < kLanes; ++lane) {
        if (!(points.meta[b].occupied >> lane & 1)) continue;
        const std::array<double, 3> v = turned_back(axes, scene.host().initial_velocity(points.tags[b][lane]).data());
        std::copy(v.begin(), v.end(), &velocity[3 * (kLanes * b + lane)]);
        const double V = points.blocks[b].volume[lane];
        double y[4] = {1.0, 0, 0, 0};
        for (int d = 0; d < 3; ++d) y[1 + d] = points.blocks[b].X[d][lane] / scene.options.cell;
        for (int r = 0; r < 4; ++r) {
          for (int c = 0; c < 4; ++c) s[4 * r + c] += V * y[r] * y[c];
          for (int d = 0; d < 3; ++d) s[16 + 3 * r + d] += V * y[r] * v[d];
        }
      }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, scene.comm);
  for (New& n : fresh) {
    const double* s = &sums[static_cast<std::size_t>(kNormal) * (n.bond->row - first)];
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> M(s);
    const Eigen::Map<const Eigen::Matrix<double, 4, 3, Eigen::RowMajor>> y(s + 16);
    const Eigen::Matrix<double, 4, 3> A = M.completeOrthogonalDecomposition().solve(y);
    const PointStore& points = n.bond->points;
    Grid& grid = n.bond->grid;
    std::vector<double> momentum(3 * grid.size(), 0.0);
    with_basis(scene.options.basis, [&](auto type) {
      for (std::size_t b = 0; b < points.blocks.size(); ++b) {
        const PointBlock& p = points.blocks[b];
        vd rest[3];
        for (int d = 0; d < 3; ++d) {
          vd v;
          for (int l = 0; l < kLanes; ++l) v[l] = n.velocity[3 * (kLanes * b + l) + d];
          rest[d] = scene.inertia().of(points.meta[b].material) * p.volume *
                    (v - (A(0, d) + (A(1, d) * p.X[0] + A(2, d) * p.X[1] + A(3, d) * p.X[2]) / scene.options.cell));
        }
        with_weights<decltype(type)>(p, points.meta[b], 1.0 / scene.options.cell, [&](const auto& w) {
          with_sums<3>(grid, points.meta[b], momentum.data(),
                       [&](double* sums, const int* column) { scatter_value(sums, column, w, rest); });
        });
      }
    });
    grid.constraints.add_to_mass_receivers(momentum.data(), 3);
    grid.halo.sum(momentum.data(), 3);
    const std::vector<char>& is_fresh = *n.fresh;
    for (int i = 0; i < grid.size(); ++i) {
      if (!is_fresh[i]) continue;
      for (int d = 0; d < 3; ++d) {
        double v = A(0, d);
        for (int e = 0; e < 3; ++e) v += A(1 + e, d) * grid.keys[i].at(e);
        if (grid.mass[i] > 0.0) v += momentum[3 * i + d] / grid.mass[i];
        grid.velocity[3 * i + d] = v;
      }
    }
    // Only fresh nodes: for the others the extrapolation would change nothing but rounding.
    std::vector<double> extended(grid.velocity);
    grid.constraints.extend(extended.data());
    for (std::size_t i = 0; i < extended.size(); ++i)
      if (is_fresh[i / 3]) grid.velocity[i] = extended[i];
    scene.formulation->start(*n.bond);
  }
}

}  // namespace mpdem
