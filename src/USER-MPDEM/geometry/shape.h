// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The interface of a cement shape. All shapes are solids of revolution about the line of centres that lie on the
// grains. At height z along the line they reach from the surface of the grains, or from the inner radius if that is
// further out, to top(z). The origin of coordinates is on the line of centres, in the middle of the gap.
#ifndef MPDEM_GEOMETRY_SHAPE_H
#define MPDEM_GEOMETRY_SHAPE_H

#include <Eigen/Dense>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace mpdem {

using Vector3 = Eigen::Vector3d;

// Two spheres and the line of centres. R1 is the radius of the first grain (side 0), R2 that of the second one (side 1).
// `gap` may be negative.
struct GrainPair {
  double R1, R2, gap;
  Vector3 n;  // unit vector from the first grain to the second

  double distance() const { return R1 + R2 + gap; }
  double radius(int side) const { return side == 0 ? R1 : R2; }
  // Height of the centre of a grain on the line.
  double height(int side) const { return side == 0 ? -(R1 + 0.5 * gap) : R2 + 0.5 * gap; }
  Vector3 centre(int side) const { return height(side) * n; }

  // Distance between the surfaces along the line at radius r, at most the smaller radius.
  double thickness(double r) const;
  // Radius of the circle in which overlapping spheres meet, 0 if they do not overlap.
  double contact_radius() const;
  // Volume between the spheres inside the cylinder of radius a.
  double volume_within(double a) const;
  // Radius at which thickness(r) = t; 0 if it is larger everywhere.
  double radius_of_thickness(double t) const;
  // Radius within which cement is left out unless a script says otherwise. There the spheres are as far apart as
  // touching spheres are at the radius `share` times the smaller one. So it is this radius if they touch, smaller across
  // a gap, and larger if they overlap. It scales with the grains, and no cement is thinner than there.
  static constexpr double kLeftOut = 0.2;
  double usual_inner(double share = kLeftOut) const;
};

// Pair of grains whose centres are `between` apart. Not inline: gap and direction are bitwise identical for all
// callers.
GrainPair pair_between(double R1, double R2, const Vector3& between);

// Returns R - sqrt(R^2 - r^2) without the cancellation at small r.
double sag(double R, double r);

// Volume common to two balls at distance d; 0 if they do not overlap. Not valid if one ball contains the other.
double lens_volume(double S1, double S2, double d);

// Thrown for dimensions that give no solid. The text names option, value and cure.
struct ShapeError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Thrown for a volume that gives no solid. least, most: volumes that do, least < most.
struct VolumeError : ShapeError {
  VolumeError(const std::string& text, double least, double most) : ShapeError(text), least(least), most(most) {}
  double least, most;
};

class Shape {
 public:
  // inner: radius about the line of centres within which there is no cement between the two centres. The contact radius
  // is used if that is larger. Throws ShapeError if inner is negative.
  Shape(const GrainPair& pair, double inner);
  virtual ~Shape() = default;

  const GrainPair& pair() const { return pair_; }
  double inner() const { return inner_; }

  bool inside(const Vector3& x) const;
  // Lower bound of the distance from x to the surface of the shape.
  double clearance(const Vector3& x) const;
  // Half-widths of a box around the origin that contains the shape.
  Vector3 half_extent() const;
  // Polar angles about the contact normal between which the surface of a grain is attached.
  void attached_band(int side, double& from, double& to) const;
  // Exact area of the attached surface of a grain.
  double attached_area(int side) const;
  virtual double volume() const = 0;

  // Outer radius at height z; 0 if there is no cement.
  virtual double top(double z) const = 0;
  // Lower bound of the distance from (r, z) to the outer surface.
  virtual double top_clearance(double r, double z) const = 0;
  // Least and largest height, and largest radius.
  virtual double lowest() const = 0;
  virtual double highest() const = 0;
  virtual double widest() const = 0;
  // Polar angle up to which the grain is covered.
  virtual double covered_angle(int side) const = 0;
  // Largest thickness of the cement, for the check against the grid.
  virtual double largest_thickness() const = 0;
  double smallest_thickness() const;
  virtual std::string describe() const = 0;
  // Radius up to which the cement reaches from grain to grain.
  virtual double spans() const = 0;
  // Has it almost no volume beyond that radius? Then a film (film_fill.h) can replace all of it.
  virtual bool ends_where_it_spans() const = 0;
  // The same outline with another inner radius, which must be below spans().
  virtual std::unique_ptr<Shape> with_inner(double inner) const = 0;

  bool between_centres(double z) const;
  // Number of the first of its parts that contains x; 0 if it has one part, or if none contains x.
  virtual int part_at(const Vector3& /* x */) const { return 0; }
  // Heights at which the profile has a corner.
  virtual void add_breaks(std::vector<double>& at) const;

 protected:
  // Volume between the grains within the inner radius, to be subtracted from that of a shape without inner radius.
  double volume_within_inner() const { return pair_.volume_within(inner_); }

 private:
  GrainPair pair_;
  double inner_;
};

// Volume of the solid of revolution by adaptive quadrature, for shapes without a closed form and to check the others.
// The relative error is below 1e-12 unless the shell is thin: rounding adds an error of about 1e-15 R/t for a thickness
// t on radius R.
double volume_by_quadrature(const Shape& shape);

// Integral of a function from a to b by the Gauss-Legendre rule of ten points, exact for polynomials of degree 19.
template <class F>
double gauss_legendre(F f, double a, double b) {
  static const double x[5] = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244, 0.8650633666889845, 0.9739065285171717};
  static const double w[5] = {0.2955242247147529, 0.2692667193099963, 0.2190863625159820, 0.1494513491505806, 0.0666713443086881};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  double sum = 0.0;
  for (int i = 0; i < 5; ++i) sum += w[i] * (f(middle - half * x[i]) + f(middle + half * x[i]));
  return half * sum;
}

// Root of a function that rises from f(lo) <= 0 to f(hi) >= 0, to the last bit.
template <class F>
double bisect_rising(F f, double lo, double hi) {
  for (int i = 0; i < 300; ++i) {
    const double mid = 0.5 * (lo + hi);
    if (mid == lo || mid == hi) break;
    (f(mid) < 0.0 ? lo : hi) = mid;
  }
  return hi;
}

// Least value above 0 of a measure (volume, neck) of shapes of all sizes up to `hi`. It must rise with the size. Small
// sizes may have no shape, and count as 0.
template <class F>
double least_of_rising(F measure, double hi) {
  return measure(bisect_rising([&](double size) { return measure(size) > 0.0 ? 1.0 : -1.0; }, 0.0, hi));
}

}  // namespace mpdem

#endif
