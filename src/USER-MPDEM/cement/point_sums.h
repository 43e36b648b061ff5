// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// What the points of bonds on one rank tell of themselves, for reports. One pass over the points finds all of it.
#ifndef MPDEM_POINT_SUMS_H
#define MPDEM_POINT_SUMS_H

#include "../material/law.h"
#include "../mpm/point_store.h"

namespace mpdem {

struct PointSums {
  double points = 0, failed = 0;
  double volume = 0, damaged_volume = 0;  // the latter with the largest eigenvalue of the damage as weight
  double elastic = 0;                     // energy, if asked for
  double largest_damage = 0;

  // with_energy: the stress of every point is found.
  void add(const PointStore& points_of, const Law& law, bool with_energy);
  void add(const PointSums& other);
};

}  // namespace mpdem

#endif
