// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Stress of blocks of points at the end of a step, for the passes of advance_points.cpp and
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

// Points whose damage may grow are few in their blocks, 3 of 8 where a crack opens. They wait, with their
// blocks, until there are vectors full of them: a lane's step of the damage does not depend on the others.
class PointStress {
 public:
  static constexpr int kMost = 8 * kLanes;  // blocks that can wait

  PointStress(PointStore& points, const TensorDamage& law, double dt, const AdvanceOptions& options,
              AdvanceResult& result)
      : points_(points), law_(law), result_(result), B0_(law.parameters().B0),
        weakest_(B0_ * std::min(1.0, law.parameters().interface)), growth_(dt / (law.parameters().viscosity + dt)),
        always_(!options.skip_undamaged && B0_ > 0.0) {}

  // Stress of block b in its material frame, zero in failed lanes; false: the block waits for
  // settle(). strain_start is that before the step.
  bool operator()(int b, const Sym3<vd>& strain_start, Sym3<vd>& stress) {
    const PointBlock& p = points_.blocks[b];
    const BlockMeta& m = points_.meta[b];
    if (m.damaged || always_) return damaged(b, strain_start, stress);
    stress = law_.elasticity().stress(p.strain);
    if (B0_ > 0.0) {
      const double B = m.linked ? weakest_ : B0_;
      if (any(TensorDamage::bound_undamaged(stress, p.strain) > B * B)) return damaged(b, strain_start, stress);
    }
    return true;
  }

  bool full() const { return points_waiting_ >= kMost; }

  // Damage of the points that wait, then then(block, stress) for their blocks, in the order they came.
  template <class Then>
  void settle(PassClock& clock, Then&& then) {
    if (blocks_waiting_ == 0) return;
    clock.start_settling();
    for (int first = 0; first < points_waiting_; first += kLanes) grow(first);
    clock.settled();
    for (int i = 0; i < blocks_waiting_; ++i) then(waiting_[i].block, waiting_[i].stress);
    clock.settled_scattered();
    blocks_waiting_ = points_waiting_ = 0;
  }

 private:
  static constexpr int kVectors = kMost / kLanes + 1;

  __attribute__((noinline)) bool damaged(int b, const Sym3<vd>& strain_start, Sym3<vd>& stress) {
    const PointBlock& p = points_.blocks[b];
    const BlockMeta& m = points_.meta[b];
    const vmask active = lanes(m.occupied & ~m.failed);
    const vd strength = select(lanes(m.linked), splat(law_.parameters().interface), splat(1.0));
    const TensorDamage::Trial t = law_.trial(p.strain, points_.damage[b].D, active, strength);
    stress = blend(active, t.stress, Sym3<vd>{});
    ++result_.work.damaged_blocks;
    const std::uint8_t growing = bits(t.may_grow);
    if (growing == 0) return true;
    ++result_.work.growing_blocks;
    waiting_[blocks_waiting_] = {b, stress};
    for (int l = 0; l < kLanes; ++l)
      if (growing >> l & 1) wait(kLanes * blocks_waiting_ + l, strain_start, strength);
    ++blocks_waiting_;
    return false;
  }

  static double* lane(Sym3<vd>& s, int l) { return reinterpret_cast<double*>(&s) + l; }
  static const double* lane(const Sym3<vd>& s, int l) { return reinterpret_cast<const double*>(&s) + l; }
  static void copy(Sym3<vd>& to, int l, const Sym3<vd>& from, int k) {
    for (int i = 0; i < 6; ++i) lane(to, l)[kLanes * i] = lane(from, k)[kLanes * i];
  }

  // place: eight times the place of the block in waiting_ plus the lane.
  void wait(int place, const Sym3<vd>& strain_start, vd strength) {
    const int l = place % kLanes, b = waiting_[place / kLanes].block, to = points_waiting_ % kLanes;
    Points& v = vectors_[points_waiting_ / kLanes];
    if (to == 0) v = Points{};
    copy(v.strain_start, to, strain_start, l);
    copy(v.strain, to, points_.blocks[b].strain, l);
    copy(v.D, to, points_.damage[b].D, l);
    v.strength[to] = strength[l];
    place_[points_waiting_++] = place;
  }

  void grow(int first) {
    const int count = std::min(kLanes, points_waiting_ - first);
    Points& v = vectors_[first / kLanes];
    const TensorDamage::Update u =
        law_.update(v.strain_start, v.strain, v.D, lanes(static_cast<std::uint8_t>((1u << count) - 1)), v.strength, growth_);
    result_.work.evaluations += u.evaluations;
    for (int k = 0; k < count; ++k) {
      if (!u.grown[k]) continue;
      ++result_.work.growing_points;
      Waiting& w = waiting_[place_[first + k] / kLanes];
      const int b = w.block, l = place_[first + k] % kLanes;
      const double volume = points_.blocks[b].volume[l];
      copy(w.stress, l, u.stress, k);
      copy(points_.damage[b].D, l, v.D, k);
      points_.meta[b].damaged = true;
      result_.dissipated += u.dissipated[k] * volume;
      if (!u.failed[k]) continue;
      result_.released += u.released[k] * volume;
      points_.meta[b].failed |= static_cast<std::uint8_t>(1u << l);
      result_.failed.push_back(kLanes * b + l);
    }
  }

  PointStore& points_;
  const TensorDamage& law_;
  AdvanceResult& result_;
  double B0_, weakest_, growth_;
  bool always_;

  struct Waiting {
    int block;
    Sym3<vd> stress;
  };
  struct Points {
    Sym3<vd> strain_start, strain, D;
    vd strength;
  };
  int blocks_waiting_ = 0, points_waiting_ = 0;
  Waiting waiting_[kMost];
  Points vectors_[kVectors];
  int place_[kVectors * kLanes];
};

// Stress of a block in its present state, changing nothing.
inline Sym3<vd> stress_of(const PointStore& points, int b, const TensorDamage& law) {
  const PointBlock& p = points.blocks[b];
  const BlockMeta& m = points.meta[b];
  const Sym3<vd> s = m.damaged ? law.stress(p.strain, points.damage[b].D) : law.elasticity().stress(p.strain);
  return blend(lanes(m.failed), Sym3<vd>{}, s);
}

}  // namespace mpdem

#endif
