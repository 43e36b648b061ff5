// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Hourglass: a cylinder about the line of centres with a waist. Its outline is a hyperbola that meets both spheres
// at the radius a and is narrowest, w, half-way between these two circles, which are L apart:
//   r(z)^2 = w^2 + (a^2 - w^2) (2 u/L)^2,  u: height from the waist,  L = thickness(a).
// The solid under it has the volume pi L (2 w^2 + a^2)/3, which is (2 pi/3) L (a^2 - w^2) less than the cylinder's.
// The outline leaves the spheres outwards as long as 2 (a^2 - w^2)/L <= sqrt(R^2 - a^2), R of the smaller grain.
#ifndef MPDEM_GEOMETRY_HOURGLASS_H
#define MPDEM_GEOMETRY_HOURGLASS_H

#include "equal_rims.h"

namespace mpdem {

class Hourglass : public EqualRims {
 public:
  // waist: w/a, in (0, 1]; 1 is the cylinder of `flat`. Throws ShapeError.
  Hourglass(const GrainPair& pair, double outer, double waist, double inner);

  // Outer radius that gives this volume outside `inner`. Throws ShapeError.
  static double outer_for_volume(const GrainPair& pair, double volume, double waist, double inner);

  double neck() const { return neck_; }

  double volume() const override;
  double top(double z) const override;
  double top_clearance(double r, double z) const override;
  // This is the thickness at the neck. Further out the surfaces of the grains face the outline, not each other.
  double largest_thickness() const override { return pair().thickness(neck_); }
  std::string describe() const override;
  double spans() const override { return neck_; }
  bool ends_where_it_spans() const override { return false; }
  std::unique_ptr<Shape> with_inner(double inner) const override {
    return std::make_unique<Hourglass>(pair(), outer_, neck_ / outer_, inner);
  }

 private:
  double neck_;
  double middle_;  // height of the neck
  double k2_;      // (a^2 - w^2)/(L/2)^2
};

}  // namespace mpdem

#endif
