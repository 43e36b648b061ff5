// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "advance_points.h"

#include "../material/laws.h"
#include "gather.h"
#include "material_runs.h"
#include "point_stress.h"
#include "scatter.h"

namespace mpdem {

namespace {

constexpr int kAhead = 2;  // blocks to prefetch ahead; their compute time is about that of a memory access

// Advances one block with its weights s. Finds the strain at the end of the step. Scatters the force unless the stress
// is deferred (point_stress.h).
template <class L, class W>
inline void advance_block(PointStore& points, int b, const W& s, const Grid& grid, double* force, double dt, PointStress<L>& stress_at_end,
                          PassClock& clock) {
  const BlockMeta& m = points.meta[b];
  PointBlock& p = points.blocks[b];
  Mat3<vd> dF = gather_gradient(grid.velocity.data(), m.column, s);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) dF.a[i][j] *= dt;
  clock.gathered();

  const Sym3<vd> strain_start = p.strain;
  // A failed point may be turned inside out, so its state is frozen.
  if (m.failed) dF = blend(lanes(m.failed), Mat3<vd>{}, dF);
  advance_strain(p.F, dF, p.q, p.strain);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) p.F.a[i][j] += dF.a[i][j];
  Sym3<vd> stress;
  const bool known = stress_at_end(
      b, strain_start, [&] { return average_at(grid, m, s); }, stress);
  clock.stressed();
  if (!known) return;
  scatter_gradient(force, m.column, s, weighted_piola(p.F, p.q, stress, p.volume));
  clock.scattered();
}

template <class Type, class L>
void advance(PointStore& points, int first, int last, Grid& grid, const L& law, double dt, const AdvanceOptions& options,
             AdvanceResult& result) {
  const double inverse_h = 1.0 / grid.h;
  double* force = grid.force.data();
  PointStress<L> stress_at_end(points, law, dt, options, grid.drive_limit, result);
  PassClock clock(result.ticks);
  const auto scatter_deferred = [&](int b, const Sym3<vd>& stress) {
    const PointBlock& p = points.blocks[b];
    const BlockMeta& m = points.meta[b];
    with_gradient_weights<Type>(p, m, inverse_h,
                                [&](const auto& s) { scatter_gradient(force, m.column, s, weighted_piola(p.F, p.q, stress, p.volume)); });
  };
  const int blocks = static_cast<int>(points.blocks.size());
  const auto skips = [&](int b) { return options.skip_failed && points.meta[b].failed == points.meta[b].occupied; };
  for (int b = first; b < last; ++b) {
    if (b + kAhead < blocks && !skips(b + kAhead)) points.prefetch(b + kAhead);
    if (skips(b)) continue;
    const BlockMeta& m = points.meta[b];
    clock.start();
    with_gradient_weights<Type>(points.blocks[b], m, inverse_h,
                                [&](const auto& s) { advance_block(points, b, s, grid, force, dt, stress_at_end, clock); });
    if (stress_at_end.full()) stress_at_end.flush(clock, scatter_deferred);
  }
  stress_at_end.flush(clock, scatter_deferred);
}

template <class Type, class L>
void add_force(const PointStore& points, int first, int last, Grid& grid, const L& law) {
  const double inverse_h = 1.0 / grid.h;
  for (int b = first; b < last; ++b) {
    const BlockMeta& m = points.meta[b];
    if (m.failed == m.occupied) continue;
    const PointBlock& p = points.blocks[b];
    with_gradient_weights<Type>(p, m, inverse_h, [&](const auto& s) {
      scatter_gradient(grid.force.data(), m.column, s, weighted_piola(p.F, p.q, stress_of(points, b, law), p.volume));
    });
  }
}

}  // namespace

void advance_points(PointStore& points, int first, int last, Grid& grid, const Law& law, double dt, const AdvanceOptions& options,
                    AdvanceResult& result) {
  for_each_material(points, law, first, last, [&](const auto& l, int from, int to) {
    with_basis(grid.basis, [&](auto type) { advance<decltype(type)>(points, from, to, grid, l, dt, options, result); });
  });
}

void add_internal_force(const PointStore& points, Grid& grid, const Law& law) {
  for_each_material(points, law, [&](const auto& l, int first, int last) {
    with_basis(grid.basis, [&](auto type) { add_force<decltype(type)>(points, first, last, grid, l); });
  });
}

}  // namespace mpdem
