// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Meniscus: a neck whose outline is a circular arc that meets both spheres at the contact angle t. b is the filling
// angle on the first grain, P1 the point on this sphere where the arc ends, and c2 the centre of the second grain. The
// direction m from P1 to the centre O of the arc is at b + t from the line of centres. The radius rho of the arc follows from
// |O - c2|^2 = R2^2 + rho^2 + 2 R2 rho cos t:
//   rho = (|P1 - c2|^2 - R2^2) / (2 (R2 cos t - m.(P1 - c2))).
// The volume is that of the solid of revolution under the arc, less the caps of the spheres in it.
#ifndef MPDEM_GEOMETRY_MENISCUS_H
#define MPDEM_GEOMETRY_MENISCUS_H

#include "shape.h"

namespace mpdem {

class Meniscus : public Shape {
 public:
  // Angles in radians. Throws ShapeError.
  Meniscus(const GrainPair& pair, double filling_angle, double contact_angle, double inner);

  // Filling angle on the first grain that gives this volume outside `inner`. Throws ShapeError.
  static double filling_for_volume(const GrainPair& pair, double volume, double contact_angle, double inner);

  // Filling angle on the first grain that gives this neck radius. Throws ShapeError.
  static double filling_for_neck(const GrainPair& pair, double neck, double contact_angle, double inner);

  double neck() const;
  double filling_angle(int side) const { return b_[side]; }

  double volume() const override;
  double top(double z) const override;
  double top_clearance(double r, double z) const override;
  double lowest() const override { return z_[0]; }
  double highest() const override { return z_[1]; }
  double widest() const override;
  double covered_angle(int side) const override { return b_[side]; }
  double largest_thickness() const override;
  std::string describe() const override;
  double spans() const override { return neck(); }
  bool ends_where_it_spans() const override { return true; }
  std::unique_ptr<Shape> with_inner(double inner) const override { return std::make_unique<Meniscus>(pair(), b_[0], contact_, inner); }

 private:
  double profile_integral(double from, double to) const;

  double b_[2];           // filling angles
  double contact_;        // contact angle
  double rho_, r0_, z0_;  // arc: radius, centre
  double waist_;          // r0 - rho
  double z_[2];           // heights at which it meets the spheres
};

}  // namespace mpdem

#endif
