// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace mpdem {

double sag(double R, double r) { return r * r / (R + std::sqrt(std::max((R - r) * (R + r), 0.0))); }

double lens_volume(double S1, double S2, double d) {
  if (d >= S1 + S2) return 0.0;
  const double e = S1 + S2 - d, f = S1 - S2;
  return M_PI * e * e * (d * d + 2.0 * d * (S1 + S2) - 3.0 * f * f) / (12.0 * d);
}

GrainPair pair_between(double R1, double R2, const Vector3& between) {
  const Vector3 centres(between[0], between[1], between[2]);
  return {R1, R2, centres.norm() - R1 - R2, centres.normalized()};
}

double GrainPair::thickness(double r) const { return gap + sag(R1, r) + sag(R2, r); }

double GrainPair::contact_radius() const {
  if (gap >= 0.0) return 0.0;
  const double d = distance();
  const double z = (d * d + R1 * R1 - R2 * R2) / (2.0 * d);
  return std::sqrt(std::max(R1 * R1 - z * z, 0.0));
}

double GrainPair::volume_within(double a) const {
  const double c = contact_radius();
  if (a <= c) return 0.0;
  // Integral of 2 pi r sag(R, r) from 0 to a: pi a^2 s less the cap of height s. The form avoids cancellation for thin
  // bonds.
  const auto under = [](double R, double r) {
    const double s = sag(R, r);
    return M_PI * s * s * (R - 2.0 * s / 3.0);
  };
  return M_PI * gap * (a * a - c * c) + under(R1, a) - under(R1, c) + under(R2, a) - under(R2, c);
}

double GrainPair::radius_of_thickness(double t) const {
  const double largest = std::min(R1, R2);
  if (thickness(0.0) >= t) return 0.0;
  if (thickness(largest) <= t) return largest;
  return bisect_rising([&](double r) { return thickness(r) - t; }, 0.0, largest);
}

double GrainPair::usual_inner(double share) const {
  const double r = share * std::min(R1, R2);
  return gap == 0.0 ? r : radius_of_thickness(sag(R1, r) + sag(R2, r));
}

Shape::Shape(const GrainPair& pair, double inner) : pair_(pair), inner_(std::max(inner, pair.contact_radius())) {
  if (inner < 0.0) {
    std::ostringstream why;
    why << "inner radius " << inner << " must not be negative";
    throw ShapeError(why.str());
  }
}

bool Shape::between_centres(double z) const { return z > pair_.height(0) && z < pair_.height(1); }

bool Shape::inside(const Vector3& x) const {
  const double z = x.dot(pair_.n);
  if (z < lowest() || z > highest()) return false;
  const double r2 = x.squaredNorm() - z * z;
  const double out = top(z);
  if (r2 > out * out) return false;
  if (r2 < inner_ * inner_ && between_centres(z)) return false;
  for (int s = 0; s < 2; ++s) {
    const double h = z - pair_.height(s);
    if (r2 + h * h < pair_.radius(s) * pair_.radius(s)) return false;
  }
  return true;
}

double Shape::clearance(const Vector3& x) const {
  const double z = x.dot(pair_.n);
  const double r = std::sqrt(std::max(x.squaredNorm() - z * z, 0.0));
  double above[2];  // distances from the surfaces of the grains, below 0 inside
  for (int s = 0; s < 2; ++s) above[s] = std::hypot(r, z - pair_.height(s)) - pair_.radius(s);
  // The shape is an intersection of sets: below the top, outside the grains, beyond the inner radius. From outside, the
  // distance to each set is a lower bound of the distance to the shape, so the largest of these is taken. Other surfaces
  // that are near do not matter, such as those of grains where there is no cement.
  double apart = std::max({lowest() - z, z - highest(), -above[0], -above[1]});
  if (apart <= 0.0 && r > top(z)) apart = top_clearance(r, z);
  if (r < inner_ && between_centres(z)) apart = std::max(apart, std::min({inner_ - r, z - pair_.height(0), pair_.height(1) - z}));
  if (apart > 0.0) return apart;  // x is outside
  const double c = std::min({top_clearance(r, z), above[0], above[1]});
  return inner_ > 0.0 ? std::min(c, std::fabs(r - inner_)) : c;
}

Vector3 Shape::half_extent() const {
  const double half_height = std::max(std::fabs(lowest()), std::fabs(highest()));
  Vector3 e;
  for (int d = 0; d < 3; ++d)
    e[d] = std::fabs(pair_.n[d]) * half_height + std::sqrt(std::max(1.0 - pair_.n[d] * pair_.n[d], 0.0)) * widest();
  return e;
}

void Shape::attached_band(int side, double& from, double& to) const {
  from = std::asin(std::min(inner_ / pair_.radius(side), 1.0));
  to = covered_angle(side);
}

double Shape::attached_area(int side) const {
  const double R = pair_.radius(side);
  const double s = std::sin(0.5 * covered_angle(side));
  return 2.0 * M_PI * R * (2.0 * R * s * s - sag(R, inner_));
}

void Shape::add_breaks(std::vector<double>& at) const {
  for (double z : {lowest(), highest()}) at.push_back(z);
  const double d = pair_.distance();
  const double meet = pair_.height(0) + (d * d + pair_.R1 * pair_.R1 - pair_.R2 * pair_.R2) / (2.0 * d);
  std::vector<double> z = {meet};
  for (int s = 0; s < 2; ++s) {
    const double R = pair_.radius(s), h = pair_.height(s), rim = std::sqrt(std::max(R * R - inner_ * inner_, 0.0));
    for (double offset : {0.0, R, -R, rim, -rim}) z.push_back(h + offset);
  }
  for (double v : z)
    if (v > lowest() && v < highest()) at.push_back(v);
}

double Shape::smallest_thickness() const { return std::max(pair_.thickness(inner_), 0.0); }

namespace {

// Area of the cross-section at height z.
double slice(const Shape& shape, double z) {
  const double out = shape.top(z);
  double in2 = shape.between_centres(z) ? shape.inner() * shape.inner() : 0.0;
  for (int s = 0; s < 2; ++s) {
    const double h = z - shape.pair().height(s), R = shape.pair().radius(s);
    in2 = std::max(in2, R * R - h * h);
  }
  return M_PI * std::max(out * out - in2, 0.0);
}

// Volume between the heights a and b by one Gauss rule.
double rule(const Shape& shape, double a, double b) {
  return gauss_legendre([&shape](double z) { return slice(shape, z); }, a, b);
}

// The same, halved until both halves agree with the whole. rounding: rounding error of a slice.
double adaptive(const Shape& shape, double a, double b, double whole, double tolerance, double rounding, int depth) {
  const double m = 0.5 * (a + b);
  const double left = rule(shape, a, m), right = rule(shape, m, b);
  if (depth == 0 || std::fabs(left + right - whole) < std::max(tolerance, rounding * (b - a))) return left + right;
  return adaptive(shape, a, m, left, 0.5 * tolerance, rounding, depth - 1) +
         adaptive(shape, m, b, right, 0.5 * tolerance, rounding, depth - 1);
}

}  // namespace

double volume_by_quadrature(const Shape& shape) {
  std::vector<double> at;
  shape.add_breaks(at);
  std::sort(at.begin(), at.end());
  double first = 0.0;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) first += rule(shape, at[i], at[i + 1]);
  // Rounding error of a slice, which is the difference of two disks that may be nearly equal.
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * M_PI * shape.widest() * shape.widest();
  double total = 0.0;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    if (at[i + 1] <= at[i]) continue;
    // The subdivision ensures that the first rule does not miss a kink between shapes.
    constexpr int kParts = 16;
    const double step = (at[i + 1] - at[i]) / kParts;
    for (int k = 0; k < kParts; ++k) {
      const double a = at[i] + k * step, b = a + step;
      total += adaptive(shape, a, b, rule(shape, a, b), 1e-15 * first, rounding, 45);
    }
  }
  return total;
}

}  // namespace mpdem
