// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "reproject.h"

#include "consistent_mass.h"
#include "gather.h"
#include "scatter.h"

namespace mpdem {

namespace {

// out += sum over the points of m_p N_I (v_p + C_p (X_I - X_p)), with v_p and C_p interpolated from the field.
void add_affine(const PointStore& points, const Grid& grid, const CementDensity& density, const std::vector<double>& field,
                std::vector<double>& out) {
  with_basis(grid.basis, [&](auto type) {
    using Type = decltype(type);
    for (std::size_t b = 0; b < points.blocks.size(); ++b) {
      const PointBlock& p = points.blocks[b];
      const BlockMeta& m = points.meta[b];
      with_weights<Type>(p, m, 1.0 / grid.h, [&](const auto& s) {
        const vd mass = density.of(m.material) * p.volume;
        vd v[3];
        gather_value(field.data(), m.column, s, v);
        for (int i = 0; i < 3; ++i) v[i] *= mass;
        // The first moments of the weights replace their gradients.
        const auto moment = with_moments(s, p.X, m.base, grid.h);
        Mat3<vd> C = gather_gradient(field.data(), m.column, Type::kAffine > 0.0 ? moment : s);
        const vd scale = mass * (Type::kAffine > 0.0 ? Type::kAffine / (grid.h * grid.h) : 1.0);
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) C.a[i][j] *= scale;
        scatter_affine(out.data(), m.column, moment, v, C);
      });
    }
  });
}

// Collective. out = y field with the map y of the header, or with `affine` the velocity that apic makes of the field.
void project(const PointStore& points, Grid& grid, const SharedList<double>& added_mass, const CementDensity& density, bool affine,
             const std::vector<double>& field, std::vector<double>& out) {
  out.assign(field.size(), 0.0);
  if (affine) add_affine(points, grid, density, field, out);
  else add_consistent_mass(points, grid, density, MassOf::all_points, 1.0, field, out);
  grid.halo.sum(out.data(), 3);
  for (int i = 0; i < grid.size(); ++i) {
    const double c = added_mass.empty() ? 0.0 : added_mass[i], inertia = grid.mass[i] + c;
    for (int d = 0; d < 3; ++d) {
      double& y = out[3 * i + d];
      y = inertia > 0.0 ? (y + c * field[3 * i + d]) / inertia : field[3 * i + d];
    }
  }
}

}  // namespace

void reproject_velocity(const PointStore& points, Grid& grid, const SharedList<double>& added_mass, const CementDensity& density,
                        const Transfer& transfer, double dt, std::vector<double>& jump) {
  const std::size_t n = grid.velocity.size();
  std::vector<double>& v = grid.velocity;
  jump.resize(n);
  if (transfer.method == Transfer::flip) {
    const double A = transfer.flip_share;
    std::vector<double> rest(n);  // the field that is projected
    for (std::size_t i = 0; i < n; ++i) rest[i] = (1.0 - A) * v[i] + dt * grid.acceleration[i];
    project(points, grid, added_mass, density, false, rest, jump);
    for (std::size_t i = 0; i < n; ++i) jump[i] -= rest[i];
  } else if (transfer.method == Transfer::xpic) {
    std::vector<double> r(v), y;
    for (int k = 0; k < transfer.order; ++k) {
      project(points, grid, added_mass, density, false, r, y);
      for (std::size_t i = 0; i < n; ++i) r[i] -= y[i];
    }
    for (std::size_t i = 0; i < n; ++i) jump[i] = -r[i];
  } else {
    project(points, grid, added_mass, density, true, v, jump);
    for (std::size_t i = 0; i < n; ++i) jump[i] -= v[i];
  }
  for (std::size_t i = 0; i < n; ++i) v[i] += jump[i];
}

void filter_velocity(const PointStore& points, Grid& grid, const SharedList<double>& added_mass, const CementDensity& density, int order) {
  // q(y) = (1 - (1 - y)^m)/y = sum over k < m of (1 - y)^k
  std::vector<double> r(grid.velocity), y;
  for (int k = 1; k < order; ++k) {
    project(points, grid, added_mass, density, false, r, y);
    for (std::size_t i = 0; i < r.size(); ++i) {
      r[i] -= y[i];
      grid.velocity[i] += r[i];
    }
  }
}

}  // namespace mpdem
