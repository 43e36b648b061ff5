// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Union of shapes on one pair, such as a coating and a meniscus. Its volume has no closed form and is integrated to
// rounding. Covered angles and heights are the largest of its shapes, since all of them lie on the grains.
#ifndef MPDEM_GEOMETRY_COMPOSITE_H
#define MPDEM_GEOMETRY_COMPOSITE_H

#include <memory>

#include "shape.h"

namespace mpdem {

class Composite : public Shape {
 public:
  // Takes at least one shape. All must have the same pair and inner radius.
  explicit Composite(std::vector<std::unique_ptr<Shape>> parts);

  double volume() const override { return volume_; }
  double top(double z) const override;
  double top_clearance(double r, double z) const override;
  double lowest() const override;
  double highest() const override;
  double widest() const override;
  double covered_angle(int side) const override;
  double largest_thickness() const override;
  std::string describe() const override;
  double spans() const override;
  bool ends_where_it_spans() const override;
  std::unique_ptr<Shape> with_inner(double inner) const override;
  void add_breaks(std::vector<double>& at) const override;
  int part_at(const Vector3& x) const override;

 private:
  std::vector<std::unique_ptr<Shape>> parts_;
  double volume_ = 0.0;
};

}  // namespace mpdem

#endif
