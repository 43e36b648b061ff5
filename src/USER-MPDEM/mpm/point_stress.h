// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Stress of one block of points at the end of a step, for the passes of advance_points.cpp and
// advance_updated.cpp. Damage is kept out of line: most steps of most blocks never come there.
#ifndef MPDEM_POINT_STRESS_H
#define MPDEM_POINT_STRESS_H

#include <algorithm>

#include "advance_points.h"

namespace mpdem {

// tau F^-T scaled by -V, for the Kirchhoff stress s in the material frame q.
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

// The same where the reference is the present: -V tau.
inline Mat3<vd> weighted_kirchhoff(const Frame& q, const Sym3<vd>& s, vd volume) {
  const Sym3<vd> g = (-1.0 * volume) * rotate(rotation_matrix(q), s);
  return {{{g.xx, g.xy, g.xz}, {g.xy, g.yy, g.yz}, {g.xz, g.yz, g.zz}}};
}

inline Mat3<vd> keep(vmask m, const Mat3<vd>& a, const Mat3<vd>& b) {
  Mat3<vd> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.a[i][j] = select(m, a.a[i][j], b.a[i][j]);
  return r;
}

class PointStress {
 public:
  PointStress(PointStore& points, const TensorDamage& law, double dt, const AdvanceOptions& options,
              AdvanceResult& result)
      : points_(points), law_(law), result_(result), B0_(law.parameters().B0),
        weakest_(B0_ * std::min(1.0, law.parameters().interface)), growth_(dt / (law.parameters().viscosity + dt)),
        always_(!options.skip_undamaged && B0_ > 0.0) {}

  // Stress of block b in its material frame, zero in failed lanes. strain_start is that before
  // the step.
  Sym3<vd> operator()(int b, const Sym3<vd>& strain_start) {
    const PointBlock& p = points_.blocks[b];
    const BlockMeta& m = points_.meta[b];
    if (m.damaged || always_) return damaged(b, strain_start);
    const Sym3<vd> stress = law_.elasticity().stress(p.strain);
    if (B0_ > 0.0) {
      const double B = m.linked ? weakest_ : B0_;
      if (any(TensorDamage::bound_undamaged(stress, p.strain) > B * B)) return damaged(b, strain_start);
    }
    return stress;
  }

 private:
  __attribute__((noinline)) Sym3<vd> damaged(int b, const Sym3<vd>& strain_start) {
    const PointBlock& p = points_.blocks[b];
    BlockMeta& m = points_.meta[b];
    const vmask active = lanes(m.occupied & ~m.failed);
    const vd strength = select(lanes(m.linked), splat(law_.parameters().interface), splat(1.0));
    const TensorDamage::Update u = law_.update(strain_start, p.strain, points_.damage[b].D, active, strength, growth_);
    const std::uint8_t grown = bits(u.grown);
    if (grown) {
      m.damaged = true;
      result_.dissipated += sum_lanes(u.dissipated * p.volume);
      const std::uint8_t failed = bits(u.failed);
      if (failed) {
        result_.released += sum_lanes(u.released * p.volume);
        m.failed |= failed;
        for (int l = 0; l < kLanes; ++l)
          if (failed >> l & 1) result_.failed.push_back(kLanes * b + l);
      }
    }
    return u.stress;
  }

  PointStore& points_;
  const TensorDamage& law_;
  AdvanceResult& result_;
  double B0_, weakest_, growth_;
  bool always_;
};

// Stress of a block in its present state, changing nothing.
inline Sym3<vd> stress_of(const PointStore& points, int b, const TensorDamage& law) {
  const PointBlock& p = points.blocks[b];
  const BlockMeta& m = points.meta[b];
  const Sym3<vd> s = m.damaged ? law.stress(p.strain, points.damage[b].D) : law.elasticity().stress(p.strain);
  const vmask dead = lanes(m.failed);
  const vd zero{};
  return {select(dead, zero, s.xx), select(dead, zero, s.yy), select(dead, zero, s.zz),
          select(dead, zero, s.yz), select(dead, zero, s.xz), select(dead, zero, s.xy)};
}

}  // namespace mpdem

#endif
