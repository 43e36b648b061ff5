// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A shape that meets both spheres in circles about the line of centres with one radius, the outer radius. Between the
// circles the outline is nowhere wider.
#ifndef MPDEM_GEOMETRY_EQUAL_RIMS_H
#define MPDEM_GEOMETRY_EQUAL_RIMS_H

#include <algorithm>
#include <cmath>

#include "shape.h"

namespace mpdem {

class EqualRims : public Shape {
 public:
  double outer() const { return outer_; }

  double lowest() const override { return -0.5 * pair().gap - sag(pair().R1, outer_); }
  double highest() const override { return 0.5 * pair().gap + sag(pair().R2, outer_); }
  double widest() const override { return outer_; }
  double covered_angle(int side) const override { return std::asin(std::min(outer_ / pair().radius(side), 1.0)); }

 protected:
  EqualRims(const GrainPair& pair, double outer, double inner) : Shape(pair, inner), outer_(outer) {}

  const double outer_;
};

}  // namespace mpdem

#endif
