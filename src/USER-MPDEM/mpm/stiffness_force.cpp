// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "stiffness_force.h"

#include "../material/laws.h"
#include "block_nodes.h"
#include "gather.h"
#include "material_runs.h"
#include "point_stress.h"
#include "scatter.h"

namespace mpdem {

namespace {

template <class W>
Sym3<vd> small_strain(const PointBlock& p, const int* column, const W& weights, const double* x) {
  const Mat3<vd> G = product(gather_gradient(x, column, weights), inverse(p.F));
  const Sym3<vd> e{
      G.a[0][0], G.a[1][1], G.a[2][2], 0.5 * (G.a[1][2] + G.a[2][1]), 0.5 * (G.a[0][2] + G.a[2][0]), 0.5 * (G.a[0][1] + G.a[1][0])};
  return rotate_back(rotation_matrix(p.q), e);
}

template <class Type, class L>
void add_products(const PointStore& points, int first, int last, const Grid& grid, const L& law, const StiffPoints& which, const double* x,
                  double* out) {
  const int count = which.blocks ? static_cast<int>(which.blocks->size()) : last - first;
  for (int n = 0; n < count; ++n) {
    const int b = which.blocks ? (*which.blocks)[n] : first + n;
    if (b < first || b >= last) continue;
    const BlockMeta& m = points.meta[b];
    if (m.failed == m.occupied && !which.failed_as_undamaged) continue;
    const PointBlock& p = points.blocks[b];
    with_gradient_weights<Type>(p, m, 1.0 / grid.h, [&](const auto& s) {
      const Sym3<vd> strain = small_strain(p, m.column, s, x);
      Sym3<vd> t = m.damaged ? law.stress(strain, state_of<L>(points, b)) : law.elasticity().stress(strain);
      if (which.failed_as_undamaged) t = blend(lanes(m.failed), law.elasticity().stress(strain), t);
      if (!points.scatter.empty()) t = points.scatter[b].stiffness * t;
      const vd live = which.failed_as_undamaged ? p.volume : select(lanes(m.failed), vd{}, p.volume);
      scatter_gradient(out, m.column, s, weighted_piola(p.F, p.q, t, live));
    });
  }
}

// Adds to each node the sum over the points of stiffness |grad N|^2.
template <class W>
void add_squares(const W& s, const int* column, vd stiffness, double* diagonal) {
  for (int i = 0; i < W::kI; ++i)
    for (int j = 0; j < W::kJ; ++j)
      for (int k = 0; k < W::kK; ++k) {
        const vd x = s.dw[0][i] * s.w[1][j] * s.w[2][k], y = s.w[0][i] * s.dw[1][j] * s.w[2][k], z = s.w[0][i] * s.w[1][j] * s.dw[2][k];
        diagonal[column[W::kJ * i + j] + k] += sum_lanes(stiffness * (x * x + y * y + z * z));
      }
}

}  // namespace

void add_stiffness_diagonal(const PointStore& points, const Grid& grid, const Law& law, double* diagonal) {
  std::vector<double> own(grid.size(), 0.0);
  for_each_material(points, law, [&](const auto& l, int first, int last) {
    const double most = l.elasticity().largest_stiffness();
    with_basis(grid.basis, [&](auto type) {
      for (int b = first; b < last; ++b) {
        const BlockMeta& m = points.meta[b];
        if (m.failed == m.occupied) continue;
        vd stiffness = most * select(lanes(m.failed), vd{}, points.blocks[b].volume);
        if (!points.scatter.empty()) stiffness *= points.scatter[b].stiffness;
        if (m.damaged) {
          const vd left = 1.0 - largest_damage_of(points, b, l);
          stiffness *= left * left;
        }
        with_weights<decltype(type)>(points.blocks[b], m, 1.0 / grid.h,
                                     [&](const auto& s) { add_squares(s, m.column, stiffness, own.data()); });
      }
    });
  });
  grid.constraints.scale_by_weight_sums(own.data());  // |sum w x|^2 <= sum |w| sum |w| x^2
  grid.constraints.gather_sizes_to_masters(own.data());
  for (int i = 0; i < grid.size(); ++i) diagonal[i] += own[i];
}

void add_stiffness_force(const PointStore& points, const Grid& grid, const Law& law, const double* x, double* out,
                         const StiffPoints& which) {
  for_each_material(points, law, [&](const auto& l, int first, int last) {
    with_basis(grid.basis, [&](auto type) { add_products<decltype(type)>(points, first, last, grid, l, which, x, out); });
  });
}

std::vector<Sym3<vd>> strain_by(const PointStore& points, const Grid& grid, const double* x) {
  std::vector<Sym3<vd>> strain(points.blocks.size());
  with_basis(grid.basis, [&](auto type) {
    for (std::size_t b = 0; b < strain.size(); ++b)
      with_values<3>(grid, points.meta[b], x, [&](const double* values, const int* column) {
        with_gradient_weights<decltype(type)>(points.blocks[b], points.meta[b], 1.0 / grid.h,
                                              [&](const auto& s) { strain[b] = small_strain(points.blocks[b], column, s, values); });
      });
  });
  return strain;
}

}  // namespace mpdem
