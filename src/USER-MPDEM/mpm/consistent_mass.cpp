// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "consistent_mass.h"

#include "block_nodes.h"
#include "gather.h"
#include "scatter.h"

namespace mpdem {

namespace {

vd mass_of(const PointBlock& p, const BlockMeta& m, MassOf which, const CementDensity& density) {
  const vd mass = density.of(m.material) * p.volume;
  return which == MassOf::all_points ? mass : select(lanes(m.failed), vd{}, mass);
}

}  // namespace

void add_consistent_mass(const PointStore& points, const Grid& grid, const CementDensity& density, MassOf which, double scale,
                         const std::vector<double>& field, std::vector<double>& out) {
  std::vector<double> completed;
  if (!grid.constraints.empty()) {
    completed = field;
    grid.constraints.mean_of_mass_receivers(completed.data(), 3);
  }
  const double* of_nodes = completed.empty() ? field.data() : completed.data();
  const double inverse_h = 1.0 / grid.h;
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const PointBlock& p = points.blocks[b];
      const BlockMeta& m = points.meta[b];
      if (which == MassOf::unfailed_points && m.failed == m.occupied) continue;
      with_weights<decltype(type)>(p, m, inverse_h, [&](const auto& s) {
        const vd mass = scale * mass_of(p, m, which, density);
        vd v[3];
        with_values<3>(grid, m, of_nodes, [&](const double* values, const int* column) { gather_value(values, column, s, v); });
        for (int i = 0; i < 3; ++i) v[i] *= mass;
        with_sums<3>(grid, m, out.data(), [&](double* sums, const int* column) { scatter_value(sums, column, s, v); });
      });
    }
  });
  grid.constraints.add_to_mass_receivers(out.data(), 3);
}

void ConsistentMass::find_inertial_force(const PointStore& points, Grid& grid, const CementDensity& density) {
  if (row_sums_.empty()) {
    row_sums_.assign(grid.size(), 0.0);
    with_basis(grid.basis, [&](auto type) {
      for (std::size_t b = 0; b < points.blocks.size(); ++b) {
        const BlockMeta& m = points.meta[b];
        if (m.failed == m.occupied) continue;
        with_weights<decltype(type)>(points.blocks[b], m, 1.0 / grid.h, [&](const auto& s) {
          scatter_scalar(row_sums_.data(), m.column, s, mass_of(points.blocks[b], m, MassOf::unfailed_points, density));
        });
      }
    });
    grid.constraints.add_to_mass_receivers(row_sums_.data(), 1);
  }
  std::vector<double>& force = grid.inertial_force;
  force.resize(grid.acceleration.size());
  for (int i = 0; i < grid.size(); ++i)
    for (int d = 0; d < 3; ++d) force[3 * i + d] = -row_sums_[i] * grid.acceleration[3 * i + d];
  add_consistent_mass(points, grid, density, MassOf::unfailed_points, 1.0, grid.acceleration, force);
  for (double& f : force) f = -f;
}

}  // namespace mpdem
