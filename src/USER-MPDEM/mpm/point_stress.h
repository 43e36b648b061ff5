// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Stress of blocks of points at the end of a step, for the passes of advance_points.cpp and advance_updated.cpp. The
// code for damage is not inlined, since most blocks do not need it in most steps.
#ifndef MPDEM_MPM_POINT_STRESS_H
#define MPDEM_MPM_POINT_STRESS_H

#include <algorithm>

#include "advance_points.h"
#include "drive_average.h"
#include "point_state.h"
#include "strain_norm.h"

namespace mpdem {

// Returns -V P with P = tau F^-T, from which nodes get their internal force. s: Kirchhoff stress tau in the axes of the
// material frame q. volume: V, of the reference.
inline Mat3<vd> weighted_piola(const Mat3<vd>& F, const Frame& q, const Sym3<vd>& s, vd volume) {
  const Sym3<vd> t = rotate(rotation_matrix(q), s);
  const Mat3<vd> cof = cofactor(F);
  const vd J = F.a[0][0] * cof.a[0][0] + F.a[0][1] * cof.a[0][1] + F.a[0][2] * cof.a[0][2];
  const Sym3<vd> g = (-volume / J) * t;
  Mat3<vd> T;
  for (int j = 0; j < 3; ++j) {
    const vd a = cof.a[0][j], b = cof.a[1][j], c = cof.a[2][j];
    T.a[0][j] = g.xx * a + g.xy * b + g.xz * c;
    T.a[1][j] = g.xy * a + g.yy * b + g.yz * c;
    T.a[2][j] = g.xz * a + g.yz * b + g.zz * c;
  }
  return T;
}

// Returns -V tau, which is the same for F = 1: the reference is the present configuration.
inline Mat3<vd> weighted_kirchhoff(const Frame& q, const Sym3<vd>& s, vd volume) {
  const Sym3<vd> g = (-1.0 * volume) * rotate(rotation_matrix(q), s);
  return {{{g.xx, g.xy, g.xz}, {g.xy, g.yy, g.yz}, {g.xz, g.yz, g.zz}}};
}

// a in the lanes of m, b in the others.
inline Mat3<vd> blend(vmask m, const Mat3<vd>& a, const Mat3<vd>& b) {
  Mat3<vd> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.a[i][j] = select(m, a.a[i][j], b.a[i][j]);
  return r;
}

// Stress and damage of one block after the other. Few points of a block have growing damage, 3 of 8 where a crack opens. So
// these points are queued, with their blocks, until they fill whole vectors. The damage step of a lane does not depend
// on the others. Block by block:
//   operator()                    elastic stress, unless a bound shows that damage may grow
//   stress_with_damage()          stress with the present damage; queues points whose damage grows
//   flush() when full(), at end   return mapping of queued points (grow()), then the stress of their blocks
// B: threshold of the driving force Yeq, see material/law.h.
template <class L>
class PointStress {
 public:
  static constexpr int kMost = 8 * kLanes;  // most blocks in the queue

  PointStress(PointStore& points, const L& law, double dt, const AdvanceOptions& options, const std::vector<vd>& limit,
              AdvanceResult& result)
      : points_(points),
        law_(law),
        result_(result),
        limit_(limit.empty() ? nullptr : limit.data()),
        scatter_(points.scatter.empty() ? nullptr : points.scatter.data()),
        always_(!options.skip_undamaged),
        nonlocal_(options.nonlocal) {
    if constexpr (L::kFields > 0) {
      B_ = law.threshold();
      weakest_ = B_ * std::min(1.0, law.interface());
      const double near = kNearThreshold * law.lowest_threshold() * std::min(1.0, law.interface());
      square_near_ = near * near;
      root_B_ = root_of_drive<L>(splat(law.lowest_threshold()))[0];
      root_weakest_ = root_of_drive<L>(splat(law.lowest_threshold() * std::min(1.0, law.interface())))[0];
      growth_ = law.growth(dt);
    }
  }

  // Finds the stress of block b in its material frame, zero in failed lanes. Returns false if the block is queued for flush(). A
  // block that is undamaged stays so if a bound of Yeq is below B; the cheapest bound is tried first. With nonlocal
  // damage the average decides instead. strain_start: the strain before the step. average(): returns the average that
  // drives nonlocal damage, of the root of the norm of strain (drive_average.h).
  template <class Average>
  bool operator()(int b, const Sym3<vd>& strain_start, const Average& average, Sym3<vd>& stress) {
    const PointBlock& p = points_.blocks[b];
    if constexpr (L::kFields == 0) {
      stress = law_.elasticity().stress(p.strain);
      if (scatter_) stress = scatter_[b].stiffness * stress;
    } else {
      const BlockMeta& m = points_.meta[b];
      if (m.damaged || always_) return stress_with_damage(b, strain_start, nonlocal_ ? average() : vd{}, stress);
      stress = law_.elasticity().stress(p.strain);
      if (scatter_) return stress_with_scatter(b, strain_start, average, stress);
      const double B = m.linked ? weakest_ : B_;
      const vd rough = L::rough_bound(stress, p.strain);
      if (!nonlocal_)
        return !any(rough > B * B) || !any(L::square_bound(stress, p.strain) > B * B) || stress_with_damage(b, strain_start, vd{}, stress);
      if (!result_.near_threshold) {
        const vd limit = limit_ ? limit_[b] : splat(square_near_);
        if (any(rough > limit)) note_near_threshold(L::square_bound(stress, p.strain), lanes(m.occupied), limit);
      }
      const vd of_drive = average();
      if (any(lanes(m.occupied) & (of_drive > (m.linked ? root_weakest_ : root_B_))))
        return stress_with_damage(b, strain_start, of_drive, stress);
    }
    return true;
  }

  bool full() const { return queued_points_ >= kMost; }

  // Updates the damage of the queued points. Then calls then(block, stress) for their blocks, in the order of the
  // queue.
  template <class Then>
  void flush(PassClock& clock, Then&& then) {
    if (queued_blocks_ == 0) return;
    clock.start_queue();
    if constexpr (L::kFields > 0)
      for (int first = 0; first < queued_points_; first += kLanes) grow(first);
    clock.queue_stressed();
    for (int i = 0; i < queued_blocks_; ++i) then(queue_[i].block, queue_[i].stress);
    clock.queue_scattered();
    queued_blocks_ = queued_points_ = 0;
  }

 private:
  using State = typename L::State;
  static constexpr int kVectors = kMost / kLanes + 1;

  // Does what operator() does, for an undamaged block with drawn factors. `stress` is that without factors. With nonlocal damage a
  // strong point may raise the average at a weak one, so averages are always needed.
  template <class Average>
  __attribute__((noinline)) bool stress_with_scatter(int b, const Sym3<vd>& strain_start, const Average& average, Sym3<vd>& stress) {
    const PointBlock& p = points_.blocks[b];
    const BlockMeta& m = points_.meta[b];
    if constexpr (L::kFields > 0) {
      const vd strength = scatter_[b].strength * select(lanes(m.linked), splat(law_.interface()), splat(1.0));
      if (nonlocal_) {
        result_.near_threshold = true;
        const vd of_drive = average();
        if (any(lanes(m.occupied) & (of_drive > root_of_drive<L>(law_.lowest_threshold() * strength))))
          return stress_with_damage(b, strain_start, of_drive, stress);
      } else {
        const vd B = B_ * strength;
        if (any(L::rough_bound(stress, p.strain) > B * B) && any(L::square_bound(stress, p.strain) > B * B))
          return stress_with_damage(b, strain_start, vd{}, stress);
      }
    }
    stress = scatter_[b].stiffness * stress;
    return true;
  }

  // Does what operator() does, for a block that has damage or may get some. average: of the root of the norm of strain, if nonlocal.
  __attribute__((noinline)) bool stress_with_damage(int b, const Sym3<vd>& strain_start, vd average, Sym3<vd>& stress) {
    const PointBlock& p = points_.blocks[b];
    const BlockMeta& m = points_.meta[b];
    const vmask active = lanes(m.occupied & ~m.failed);
    vd strength = select(lanes(m.linked), splat(law_.interface()), splat(1.0));
    const LawTrial t = law_.trial(p.strain, state_of<L>(points_, b), softening_of(points_, b, law_));
    stress = blend(active, t.stress, Sym3<vd>{});
    if (scatter_) {
      strength *= scatter_[b].strength;
      stress = scatter_[b].stiffness * stress;
    }
    if (nonlocal_) {
      if (!result_.near_threshold)
        note_near_threshold(L::square_bound(law_.elasticity().stress(p.strain), p.strain), active, splat(square_near_));
      const vd root = root_of_norm(law_, p.strain);
      // A block with damage comes here in each step, so the root that is kept never belongs to an older strain.
      if (m.damaged) points_.keep_root_of_norm(b, root);
      const vd a = drive_factor<L>(average / max(root, splat(1e-100)));  // amplification of the drive, see drive_average.h
      strength /= min(max(a, splat(1e-100)), splat(kMostAmplification));
    }
    const vd threshold = strength * t.least_threshold;
    const std::uint8_t growing = bits(active & (t.square_bound > threshold * threshold));
    if (growing == 0) return true;
    queue_[queued_blocks_] = {b, stress};
    for (int l = 0; l < kLanes; ++l)
      if (growing >> l & 1) enqueue(kLanes * queued_blocks_ + l, strain_start, strength);
    ++queued_blocks_;
    return false;
  }

  void note_near_threshold(vd square, vmask active, vd limit) { result_.near_threshold = any(active & (square > limit)); }

  // Copies lane k of `from` to lane l of `to`. Blocks, tensors and states are arrays of vectors, so a lane is every
  // eighth number.
  template <class To, class From>
  static void copy(To* to, int l, const From* from, int k, int vectors) {
    double* t = reinterpret_cast<double*>(to) + l;
    const double* f = reinterpret_cast<const double*>(from) + k;
    for (int i = 0; i < vectors; ++i) t[kLanes * i] = f[kLanes * i];
  }

  // Queues a point of a queued block. place: eight times the index of the block in queue_ plus the lane.
  void enqueue(int place, const Sym3<vd>& strain_start, vd strength) {
    const int l = place % kLanes, b = queue_[place / kLanes].block, to = queued_points_ % kLanes;
    Points& v = vectors_[queued_points_ / kLanes];
    if (to == 0) v = Points{};
    copy(&v.strain_start, to, &strain_start, l, 6);
    copy(&v.strain, to, &points_.blocks[b].strain, l, 6);
    copy(&v.state, to, points_.state(b), l, L::kFields);
    v.strength[to] = strength[l];
    v.softening[to] = softening_of(points_, b, law_)[l];
    place_[queued_points_++] = place;
  }

  // Return mapping of up to eight queued points, from index `first` on. Stress, damage and energies go to their blocks.
  void grow(int first) {
    const int count = std::min(kLanes, queued_points_ - first);
    Points& v = vectors_[first / kLanes];
    const LawUpdate u = law_.update(v.strain_start, v.strain, v.state, lanes(static_cast<std::uint8_t>((1u << count) - 1)), v.strength,
                                    growth_, v.softening);
    for (int k = 0; k < count; ++k) {
      if (!u.grown[k]) continue;
      QueuedBlock& w = queue_[place_[first + k] / kLanes];
      const int b = w.block, l = place_[first + k] % kLanes;
      double volume = points_.blocks[b].volume[l];
      copy(&w.stress, l, &u.stress, k, 6);
      if (scatter_) {
        const double stiffness = scatter_[b].stiffness[l];
        for (int i = 0; i < 6; ++i) reinterpret_cast<double*>(&w.stress)[kLanes * i + l] *= stiffness;
        volume *= stiffness;  // counts for the energies below
      }
      copy(points_.change_state(b), l, &v.state, k, L::kFields);
      points_.meta[b].damaged = true;
      result_.near_threshold = true;
      result_.dissipated += u.dissipated[k] * volume;
      if (!u.failed[k]) continue;
      result_.released += u.released[k] * volume;
      points_.meta[b].failed |= static_cast<std::uint8_t>(1u << l);
      result_.failed.push_back(kLanes * b + l);
    }
  }

  PointStore& points_;
  const L& law_;
  AdvanceResult& result_;
  const vd* limit_;               // Grid::drive_limit of each block; null: square_near_ for all
  const PointScatter* scatter_;   // null without scatter
  double B_, weakest_;            // B of points that touch no grain; least B of a block with points that touch one
  double root_B_, root_weakest_;  // the same for averages: least root of the norm of strain with which damage grows
  double square_near_;            // Yeq^2 at kNearThreshold times the lowest threshold
  double growth_;                 // share of the growth of damage that a step allows (viscosity)
  bool always_, nonlocal_;        // always_: bounds are not used

  struct QueuedBlock {
    int block;
    Sym3<vd> stress;
  };
  // Eight queued points. strain_start: strain before the step. strength: factor on B.
  struct Points {
    Sym3<vd> strain_start, strain;
    State state;
    vd strength, softening;
  };
  int queued_blocks_ = 0, queued_points_ = 0;
  QueuedBlock queue_[kMost];
  Points vectors_[kVectors];
  int place_[kVectors * kLanes];  // place of each queued point, see enqueue()
};

}  // namespace mpdem

#endif
