// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_GEOMETRY_BOND_AXES_H
#define MPDEM_GEOMETRY_BOND_AXES_H

#include <Eigen/Geometry>
#include <cmath>

namespace mpdem {

// Axes for the lattice and the grid of a bond along the unit vector n. They are those of the box after the smallest
// rotation that takes the axis of the box nearest to n, in its nearer sense, to n. Of axes equally near, up to kAlike, it
// is the first. n and -n give the same axes. For a bond along an axis of the box they are exactly those of the box.
struct BondAxes {
  Eigen::Quaterniond turn;  // rotation from these axes to those of the box
  Eigen::Vector3d n;        // the vector in these axes: one component is 1 or -1, the others are 0
};

inline BondAxes bond_axes(const Eigen::Vector3d& n) {
  constexpr double kAlike = 1e-3;  // so that a bond along a diagonal keeps its axes when it is strained
  int nearest = 0;
  for (int d = 1; d < 3; ++d)
    if (std::fabs(n[d]) > std::fabs(n[nearest]) + kAlike) nearest = d;
  const Eigen::Vector3d axis = std::copysign(1.0, n[nearest]) * Eigen::Vector3d::Unit(nearest), around = axis.cross(n);
  const double sine = around.norm();
  if (sine == 0.0) return {Eigen::Quaterniond::Identity(), axis};
  return {Eigen::Quaterniond(Eigen::AngleAxisd(std::atan2(sine, axis.dot(n)), around / sine)), axis};
}

}  // namespace mpdem

#endif
