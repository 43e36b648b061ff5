// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_sums.h"

#include <algorithm>

#include "../../mpm/material_runs.h"
#include "../../mpm/point_state.h"

namespace mpdem {

namespace {

template <class L>
void add_points(const PointStore& points_of, int first, int n, const L& law, bool with_energy, PointSums& sums) {
  constexpr int kAhead = 8;
  for (int b = first; b < n; ++b) {
    // Without energies, only one cache line of each block is read. That is cheap enough for every step.
    if (with_energy && b + 1 < n) points_of.prefetch(b + 1);
    if (!with_energy && b + kAhead < n) __builtin_prefetch(&points_of.blocks[b + kAhead].volume);
    const PointBlock& p = points_of.blocks[b];
    const BlockMeta& m = points_of.meta[b];
    sums.points += __builtin_popcount(m.occupied);
    sums.failed += __builtin_popcount(m.failed);
    sums.volume += sum_lanes(p.volume);
    if (with_energy) {
      const vd alive = select(lanes(m.failed), vd{}, p.volume);
      sums.elastic += sum_lanes(0.5 * alive * contract(stress_of(points_of, b, law), p.strain));
    }
    if (!m.damaged) continue;
    const vd d = largest_damage_of(points_of, b, law);
    sums.damaged_volume += sum_lanes(p.volume * d);
    for (int l = 0; l < kLanes; ++l)
      if (m.occupied >> l & 1) sums.largest_damage = std::max(sums.largest_damage, d[l]);
  }
}

}  // namespace

void PointSums::add(const PointStore& points_of, const Law& of_any_kind, bool with_energy) {
  for_each_material(points_of, of_any_kind,
                    [&](const auto& law, int first, int last) { add_points(points_of, first, last, law, with_energy, *this); });
}

void PointSums::add(const PointSums& other) {
  points += other.points;
  failed += other.failed;
  volume += other.volume;
  damaged_volume += other.damaged_volume;
  elastic += other.elastic;
  largest_damage = std::max(largest_damage, other.largest_damage);
}

}  // namespace mpdem
