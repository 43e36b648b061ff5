// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Coating: a shell of even thickness t on both grains. Where the shells meet they are the bond. `cap`: the shell ends
// at this polar angle from the contact, seen from the grain.
//   V = sum_i (2 pi/3)(1 - cos cap)[(R_i + t)^3 - R_i^3] - [lens(R1+t, R2+t) - lens(R1, R2)]
// This holds if all of the overlap is within the cap.
#ifndef MPDEM_GEOMETRY_COATING_H
#define MPDEM_GEOMETRY_COATING_H

#include <algorithm>

#include "shape.h"

namespace mpdem {

class Coating : public Shape {
 public:
  // cap in radians, in (0, pi/2] or pi. Throws ShapeError.
  Coating(const GrainPair& pair, double thickness, double cap, double inner);

  // Thickness that gives this volume outside `inner`. Throws ShapeError.
  static double thickness_for_volume(const GrainPair& pair, double volume, double cap, double inner);

  double thickness() const { return t_; }
  // Radius of the ring in which the outer surfaces of the shells meet; 0 if they do not meet.
  double ring() const;

  double volume() const override;
  double top(double z) const override;
  double top_clearance(double r, double z) const override;
  double lowest() const override;
  double highest() const override;
  double widest() const override;
  double covered_angle(int) const override { return cap_; }
  double largest_thickness() const override { return t_; }
  std::string describe() const override;
  double spans() const override { return std::min({ring(), pair().R1, pair().R2}); }
  bool ends_where_it_spans() const override { return false; }
  std::unique_ptr<Shape> with_inner(double inner) const override { return std::make_unique<Coating>(pair(), t_, cap_, inner); }
  void add_breaks(std::vector<double>& at) const override;

 private:
  double t_, cap_;
};

}  // namespace mpdem

#endif
