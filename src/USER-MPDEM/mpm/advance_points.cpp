// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "advance_points.h"

#include <algorithm>

#include "gather.h"
#include "scatter.h"

namespace mpdem {

namespace {

// -V P = -V tau F^-T for the Kirchhoff stress s in the material frame q.
inline Mat3<vd> weighted_piola(const Mat3<vd>& F, const Frame& q, const Sym3<vd>& s, vd volume) {
  const Sym3<vd> g = rotate(rotation_matrix(q), s);
  const Mat3<vd> cof = cofactor(F);
  const vd J = F.a[0][0] * cof.a[0][0] + F.a[0][1] * cof.a[0][1] + F.a[0][2] * cof.a[0][2];
  const vd scale = -volume / J;
  Mat3<vd> T;
  for (int j = 0; j < 3; ++j) {
    const vd a = scale * cof.a[0][j], b = scale * cof.a[1][j], c = scale * cof.a[2][j];
    T.a[0][j] = g.xx * a + g.xy * b + g.xz * c;
    T.a[1][j] = g.xy * a + g.yy * b + g.yz * c;
    T.a[2][j] = g.xz * a + g.yz * b + g.zz * c;
  }
  return T;
}

inline Mat3<vd> keep(vmask m, const Mat3<vd>& a, const Mat3<vd>& b) {
  Mat3<vd> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.a[i][j] = select(m, a.a[i][j], b.a[i][j]);
  return r;
}

// Damage of one block, kept out of line: most steps of most blocks never come here.
__attribute__((noinline)) Sym3<vd> damaged_stress(const TensorDamage& law, const Sym3<vd>& strain_start,
                                                  const PointBlock& p, PointStore::Damage& d, BlockMeta& m, int block,
                                                  double growth, AdvanceResult& result) {
  const vmask active = lanes(m.occupied & ~m.failed);
  const vd strength = select(lanes(m.linked), splat(law.parameters().interface), splat(1.0));
  const TensorDamage::Update u = law.update(strain_start, p.strain, d.D, active, strength, growth);
  const std::uint8_t grown = bits(u.grown);
  if (grown) {
    m.damaged = true;
    result.dissipated += sum_lanes(u.dissipated * p.volume);
    const std::uint8_t failed = bits(u.failed);
    if (failed) {
      result.released += sum_lanes(u.released * p.volume);
      m.failed |= failed;
      for (int l = 0; l < kLanes; ++l)
        if (failed >> l & 1) result.failed.push_back(kLanes * block + l);
    }
  }
  return u.stress;
}

}  // namespace

void advance_points(PointStore& points, Grid& grid, const TensorDamage& law, double dt, AdvanceResult& result) {
  const double inverse_h = 1.0 / grid.h;
  const double* velocity = grid.velocity.data();
  double* force = grid.force.data();
  const double B0 = law.parameters().B0;
  const double weakest = std::min(1.0, law.parameters().interface);
  const double growth = dt / (law.parameters().viscosity + dt);
  const int n = static_cast<int>(points.blocks.size());
  for (int b = 0; b < n; ++b) {
    BlockMeta& m = points.meta[b];
    if (m.failed == m.occupied) continue;
    PointBlock& p = points.blocks[b];
    const Weights s(p.X, m.base, inverse_h);
    Mat3<vd> dF = gather_gradient(velocity, m.column, s);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) dF.a[i][j] *= dt;

    const Sym3<vd> strain_start = p.strain;
    if (m.failed == 0) {
      advance_strain(p.F, dF, p.q, p.strain);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) p.F.a[i][j] += dF.a[i][j];
    } else {
      // The debris of a crack may turn inside out; its state is frozen.
      const vmask dead = lanes(m.failed);
      dF = keep(dead, Mat3<vd>{}, dF);
      advance_strain(p.F, dF, p.q, p.strain);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) p.F.a[i][j] += dF.a[i][j];
    }

    Sym3<vd> stress;
    if (!m.damaged) {
      stress = law.elasticity().stress(p.strain);
      const double B = m.linked ? weakest * B0 : B0;
      if (B0 > 0.0 && any(TensorDamage::bound_undamaged(stress, p.strain) > B * B))
        stress = damaged_stress(law, strain_start, p, points.damage[b], m, b, growth, result);
    } else {
      stress = damaged_stress(law, strain_start, p, points.damage[b], m, b, growth, result);
    }
    scatter_gradient(force, m.column, s, weighted_piola(p.F, p.q, stress, p.volume));
  }
}

void add_internal_force(const PointStore& points, Grid& grid, const TensorDamage& law) {
  const double inverse_h = 1.0 / grid.h;
  const int n = static_cast<int>(points.blocks.size());
  for (int b = 0; b < n; ++b) {
    const BlockMeta& m = points.meta[b];
    if (m.failed == m.occupied) continue;
    const PointBlock& p = points.blocks[b];
    const Weights s(p.X, m.base, inverse_h);
    Sym3<vd> stress = m.damaged ? law.stress(p.strain, points.damage[b].D) : law.elasticity().stress(p.strain);
    const vmask dead = lanes(m.failed);
    const vd zero{};
    stress = {select(dead, zero, stress.xx), select(dead, zero, stress.yy), select(dead, zero, stress.zz),
              select(dead, zero, stress.yz), select(dead, zero, stress.xz), select(dead, zero, stress.xy)};
    scatter_gradient(grid.force.data(), m.column, s, weighted_piola(p.F, p.q, stress, p.volume));
  }
}

}  // namespace mpdem
