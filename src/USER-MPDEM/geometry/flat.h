// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Flat bond: the space between the two spheres inside a cylinder about the line of centres. It reaches from an inner
// radius (0: none) to an outer one, which is at most that of the smaller grain.
#ifndef MPDEM_GEOMETRY_FLAT_H
#define MPDEM_GEOMETRY_FLAT_H

#include "equal_rims.h"

namespace mpdem {

class Flat : public EqualRims {
 public:
  // Throws ShapeError.
  Flat(const GrainPair& pair, double outer, double inner);

  // Outer radius that encloses `volume` outside `inner`. Throws ShapeError.
  static double outer_for_volume(const GrainPair& pair, double volume, double inner);

  double volume() const override;
  double top(double z) const override;
  double top_clearance(double r, double z) const override;
  double largest_thickness() const override { return pair().thickness(outer_); }
  std::string describe() const override;
  double spans() const override { return outer_; }
  bool ends_where_it_spans() const override { return true; }
  std::unique_ptr<Shape> with_inner(double inner) const override { return std::make_unique<Flat>(pair(), outer_, inner); }
};

}  // namespace mpdem

#endif
