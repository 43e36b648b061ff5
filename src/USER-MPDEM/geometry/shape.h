// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// What a cement shape has to tell about itself. Coordinates are relative to the origin of
// the body: on the line of centres, in the middle of the gap.
#ifndef MPDEM_SHAPE_H
#define MPDEM_SHAPE_H

#include <Eigen/Dense>
#include <stdexcept>
#include <string>

namespace mpdem {

using Vector3 = Eigen::Vector3d;

// Two spheres and the line of centres; `gap` may be negative.
struct GrainPair {
  double R1, R2, gap;
  Vector3 n;  // unit vector from grain 1 to grain 2

  double distance() const { return R1 + R2 + gap; }
  Vector3 centre(int side) const { return side == 0 ? Vector3(-(R1 + 0.5 * gap) * n) : Vector3((R2 + 0.5 * gap) * n); }
  double radius(int side) const { return side == 0 ? R1 : R2; }
};

// Thrown for dimensions that do not make a body; the text names word, value and cure.
struct ShapeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Shape {
 public:
  explicit Shape(const GrainPair& pair) : pair_(pair) {}
  virtual ~Shape() = default;

  const GrainPair& pair() const { return pair_; }

  virtual bool inside(const Vector3& x) const = 0;
  // Not more than the distance from x to the surface of the body.
  virtual double clearance(const Vector3& x) const = 0;
  // Half-widths of a box around the origin that holds the body.
  virtual Vector3 half_extent() const = 0;
  // Exact.
  virtual double volume() const = 0;
  virtual double attached_area(int side) const = 0;
  // Polar angles about the contact normal between which the grain's surface is attached.
  virtual void attached_band(int side, double& from, double& to) const = 0;
  // Where the cement is thickest between the grains, measured along the axis.
  virtual double largest_thickness() const = 0;
  virtual double smallest_thickness() const = 0;
  virtual std::string describe() const = 0;

 private:
  GrainPair pair_;
};

}  // namespace mpdem

#endif
