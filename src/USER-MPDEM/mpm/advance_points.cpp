// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "advance_points.h"

#include "../material/laws.h"
#include "gather.h"
#include "point_stress.h"
#include "scatter.h"

namespace mpdem {

namespace {

template <class Type, class L>
void advance(PointStore& points, int first, int last, Grid& grid, const L& law, double dt,
             const AdvanceOptions& options, AdvanceResult& result) {
  const double inverse_h = 1.0 / grid.h;
  const double* velocity = grid.velocity.data();
  double* force = grid.force.data();
  PointStress<L> stress_at_end(points, law, dt, options, result);
  PassClock clock(result.ticks);
  const auto scatter_waiting = [&](int b, const Sym3<vd>& stress) {
    const PointBlock& p = points.blocks[b];
    const BlockMeta& m = points.meta[b];
    scatter_gradient(force, m.column, Weights<Type>(p.X, m.base, inverse_h), weighted_piola(p.F, p.q, stress, p.volume));
  };
  for (int b = first; b < last; ++b) {
    BlockMeta& m = points.meta[b];
    if (m.failed == m.occupied && options.skip_failed) continue;
    clock.start(b);
    PointBlock& p = points.blocks[b];
    const Weights<Type> s(p.X, m.base, inverse_h);
    Mat3<vd> dF = gather_gradient(velocity, m.column, s);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) dF.a[i][j] *= dt;
    clock.gathered();

    const Sym3<vd> strain_start = p.strain;
    // The debris of a crack may turn inside out; its state is frozen.
    if (m.failed) dF = keep(lanes(m.failed), Mat3<vd>{}, dF);
    advance_strain(p.F, dF, p.q, p.strain);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) p.F.a[i][j] += dF.a[i][j];
    Sym3<vd> stress;
    if (stress_at_end(b, strain_start, stress)) {
      clock.stressed();
      scatter_gradient(force, m.column, s, weighted_piola(p.F, p.q, stress, p.volume));
      clock.scattered();
    } else {
      clock.stressed();
      if (stress_at_end.full()) stress_at_end.settle(clock, scatter_waiting);
    }
  }
  stress_at_end.settle(clock, scatter_waiting);
}

template <class Type, class L>
void add_force(const PointStore& points, Grid& grid, const L& law) {
  const double inverse_h = 1.0 / grid.h;
  const int n = static_cast<int>(points.blocks.size());
  for (int b = 0; b < n; ++b) {
    const BlockMeta& m = points.meta[b];
    if (m.failed == m.occupied) continue;
    const PointBlock& p = points.blocks[b];
    const Weights<Type> s(p.X, m.base, inverse_h);
    scatter_gradient(grid.force.data(), m.column, s, weighted_piola(p.F, p.q, stress_of(points, b, law), p.volume));
  }
}

}  // namespace

void advance_points(PointStore& points, int first, int last, Grid& grid, const Law& law, double dt,
                    const AdvanceOptions& options, AdvanceResult& result) {
  with_law(law, [&](const auto& l) {
    with_basis(grid.basis, [&](auto type) { advance<decltype(type)>(points, first, last, grid, l, dt, options, result); });
  });
}

void add_internal_force(const PointStore& points, Grid& grid, const Law& law) {
  with_law(law, [&](const auto& l) {
    with_basis(grid.basis, [&](auto type) { add_force<decltype(type)>(points, grid, l); });
  });
}

}  // namespace mpdem
