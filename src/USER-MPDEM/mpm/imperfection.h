// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A bond between equal grains is symmetric. Damage begins at both grains alike, and which of them debonds is a
// bifurcation. If only rounding errors decide, it comes late, at a force beyond that at which one end alone would
// debond, and the force depends on the number of steps. So a small imperfection decides, as is usual for bifurcations:
// the cement nearer to one grain is stronger by some share.
#ifndef MPDEM_MPM_IMPERFECTION_H
#define MPDEM_MPM_IMPERFECTION_H

#include <cmath>

#include "../numerics/simd.h"
#include "bond_record.h"

namespace mpdem {

// The grain (0 or 1) whose half of the bond is the stronger one. Of unequal grains it is the smaller one: cement debonds from
// the larger one without an imperfection, too. Of equal grains the coordinate along an axis of the bond decides
// (grain_behind()), so that the result does not depend on the order of the grains.
inline int stronger_grain(const BondRecord& record) {
  const double larger = record.radius[0] - record.radius[1];
  if (std::fabs(larger) > rounding_of_positions(record)) return larger > 0.0;
  return 1 - grain_behind(record);
}

// Lanes of the points that were created at X in the stronger half. The middle belongs to the weaker one.
inline vmask nearer_to_stronger_grain(const BondRecord& record, const vd* X) {
  vd distance[2];  // distance of X from the surface of each grain
  for (int side = 0; side < 2; ++side) {
    vd square{};
    for (int d = 0; d < 3; ++d) square += (X[d] - record.centre[side][d]) * (X[d] - record.centre[side][d]);
    distance[side] = sqrt(square) - record.radius[side];
  }
  const int strong = stronger_grain(record);
  return distance[1 - strong] - distance[strong] > rounding_of_positions(record);
}

// Imperfection of a bond. share: the strain at which damage begins is larger in the stronger half by this share; 0: both
// halves are alike.
struct Imperfection {
  const BondRecord* record = nullptr;
  double share = 0.0;

  // Points of the stronger half count a smaller strain for their damage. Nonlocal damage averages the square root of the norm
  // of strain (drive_average.h). Returns the factor on this root for points created at X.
  vd factor_on_root(const vd* X) const {
    if (share == 0.0) return splat(1.0);
    return select(nearer_to_stronger_grain(*record, X), splat(1.0 / std::sqrt(1.0 + share)), splat(1.0));
  }
};

}  // namespace mpdem

#endif
