// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Flat bond: what a cylinder about the line of centres holds between the two spheres,
// from an inner radius (0: none) to an outer one, at most the smaller grain's.
// With z_i the height of sphere i's surface over its plane of largest girth,
//   V(a) = pi d (a^2 - c^2) - (2 pi/3) sum_i [(R_i^2 - c^2)^3/2 - (R_i^2 - a^2)^3/2],
// c the radius of the circle in which overlapping spheres meet (0 otherwise).
#ifndef MPDEM_FLAT_H
#define MPDEM_FLAT_H

#include "shape.h"

namespace mpdem {

class Flat : public Shape {
 public:
  // Throws ShapeError.
  Flat(const GrainPair& pair, double outer, double inner);

  // Outer radius that encloses `volume` outside `inner`. Throws ShapeError.
  static double outer_for_volume(const GrainPair& pair, double volume, double inner);
  // Radius at which the gap between the spheres is `thickness`; 0 if it is wider all over.
  static double radius_of_thickness(const GrainPair& pair, double thickness);

  bool inside(const Vector3& x) const override;
  double clearance(const Vector3& x) const override;
  Vector3 half_extent() const override;
  double volume() const override;
  double attached_area(int side) const override;
  void attached_band(int side, double& from, double& to) const override;
  double largest_thickness() const override;
  double smallest_thickness() const override;
  std::string describe() const override;

  double outer() const { return outer_; }
  double inner() const { return inner_; }

 private:
  double outer_, inner_;
};

}  // namespace mpdem

#endif
