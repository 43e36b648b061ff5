// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Stress, damage and cracks of the points of a store by its law of damage, a block at a time. The templates are for
// loops inside with_law() of material/laws.h.
#ifndef MPDEM_MPM_POINT_STATE_H
#define MPDEM_MPM_POINT_STATE_H

#include <array>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "../numerics/eigen3.h"
#include "point_store.h"

namespace mpdem {

// State of a block, in the State type of the law.
template <class L>
typename L::State state_of(const PointStore& points, int b) {
  typename L::State s{};
  if constexpr (L::kFields > 0) {
    static_assert(sizeof s == L::kFields * sizeof(vd) && L::kFields <= kMostStateFields);
    std::memcpy(&s, points.state(b), sizeof s);
  }
  return s;
}

// Softening of the points of a block, a number that only the law interprets (material/law.h).
template <class L>
vd softening_of(const PointStore& points, int b, const L& law) {
  return points.softening.empty() ? splat(law.softening()) : points.softening[b];
}

// Stress of a block in its present state, with its drawn factor of the moduli, zero in failed lanes.
template <class L>
Sym3<vd> stress_of(const PointStore& points, int b, const L& law) {
  const PointBlock& p = points.blocks[b];
  const BlockMeta& m = points.meta[b];
  const Sym3<vd> s = m.damaged ? law.stress(p.strain, state_of<L>(points, b)) : law.elasticity().stress(p.strain);
  return blend(lanes(m.failed), Sym3<vd>{}, points.scatter.empty() ? s : points.scatter[b].stiffness * s);
}

// Largest damage of each point of a block that has damage, from 0 to 1.
template <class L>
vd largest_damage_of(const PointStore& points, int b, const L& law) {
  return law.largest_damage(state_of<L>(points, b));
}

// Largest damage of each point, from 0 to 1, for all blocks. The store must know its law.
std::vector<vd> largest_damages(const PointStore& points);

// Principal values of the damage of a point, in falling order, and the normal of its crack in the axes of its bond. The
// sign of the normal is that of without_sign(). The store must know its law.
struct CrackOfPoint {
  double damage[3], normal[3];
};
// Damage and crack normals of the points of a block.
struct CracksOfBlock {
  vd damage[3], normal[3];
};
// A normal has no sign, so its largest component is made positive.
std::array<double, 3> without_sign(std::array<double, 3> normal);
CrackOfPoint crack_of(const PointStore& points, int slot);
CracksOfBlock cracks_of(const PointStore& points, int block);

// Damage tensor of a point in its material frame (xx yy zz yz xz xy). Throws std::domain_error if the state belongs to
// a law that the store does not know.
std::array<double, 6> damage_tensor_of(const PointStore& points, int slot);

// Converts the states with which points arrived to states of the law, and sets the law of the store. A state without
// the number of a law is the damage tensor that a file gave. Returns an empty string, or a text that begins with
// "material point" if the law cannot start from a state.
std::string read_point_states(PointStore& points, const std::shared_ptr<const Law>& law);

}  // namespace mpdem

#endif
