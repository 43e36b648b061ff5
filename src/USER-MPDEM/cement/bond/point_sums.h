// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sums over the points of bonds on one rank, for reports. One pass over the points finds all sums.
#ifndef MPDEM_CEMENT_BOND_POINT_SUMS_H
#define MPDEM_CEMENT_BOND_POINT_SUMS_H

#include "../../material/law.h"
#include "../../mpm/point_store.h"

namespace mpdem {

struct PointSums {
  double points = 0, failed = 0;
  double volume = 0, damaged_volume = 0;  // damaged_volume: sum of volume times largest eigenvalue of the damage
  double elastic = 0;                     // elastic energy, if asked for
  double largest_damage = 0;

  // with_energy: also find the elastic energy, which needs the stress of every point.
  void add(const PointStore& points_of, const Law& law, bool with_energy);
  void add(const PointSums& other);
};

}  // namespace mpdem

#endif
