// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "flat.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace mpdem {

namespace {

// R - sqrt(R^2 - r^2) without the cancellation at small r.
double sag(double R, double r) { return r * r / (R + std::sqrt(std::max(R * R - r * r, 0.0))); }

double thickness(const GrainPair& p, double r) { return p.gap + sag(p.R1, r) + sag(p.R2, r); }

double contact_radius(const GrainPair& p) {
  if (p.gap >= 0.0) return 0.0;
  const double d = p.distance();
  const double z = (d * d + p.R1 * p.R1 - p.R2 * p.R2) / (2.0 * d);
  return std::sqrt(std::max(p.R1 * p.R1 - z * z, 0.0));
}

// Volume between the spheres inside the cylinder of radius a. The closed form is the
// integral of 2 pi r thickness(r); each sphere gives pi a^2 (R + ..) minus its cap, put
// as the volume under the cap so that thin bonds do not cancel.
double cylinder_volume(const GrainPair& p, double a) {
  const double c = contact_radius(p);
  if (a <= c) return 0.0;
  const auto under = [](double R, double r) {
    // integral of 2 pi r sag(R, r) from 0 to r: pi r^2 s less the cap of height s
    const double s = sag(R, r);
    return M_PI * s * s * (R - 2.0 * s / 3.0);
  };
  return M_PI * p.gap * (a * a - c * c) + under(p.R1, a) - under(p.R1, c) + under(p.R2, a) - under(p.R2, c);
}

}  // namespace

Flat::Flat(const GrainPair& pair, double outer, double inner) : Shape(pair), outer_(outer), inner_(inner) {
  std::ostringstream why;
  const double largest = std::min(pair.R1, pair.R2);
  if (!(outer > 0.0 && outer <= largest)) {
    why << "outer radius " << outer << " must lie in (0, " << largest << "], the smaller grain's radius";
  } else if (!(inner >= 0.0 && inner < outer)) {
    why << "inner radius " << inner << " must lie in [0, " << outer << "), below the outer radius";
  } else if (outer <= contact_radius(pair)) {
    why << "outer radius " << outer << " is inside the overlap of the grains; use more than "
        << contact_radius(pair);
  }
  if (!why.str().empty()) throw ShapeError(why.str());
  inner_ = std::max(inner_, contact_radius(pair));
}

double Flat::outer_for_volume(const GrainPair& pair, double volume, double inner) {
  const double largest = std::min(pair.R1, pair.R2);
  inner = std::max(inner, contact_radius(pair));
  const double base = cylinder_volume(pair, inner);
  const auto f = [&](double a) { return cylinder_volume(pair, a) - base - volume; };
  if (!(volume > 0.0) || f(largest) < 0.0) {
    std::ostringstream why;
    why << "a flat bond of volume " << volume << " does not fit: between these grains it holds more than 0 and at most "
        << cylinder_volume(pair, largest) - base << "; reduce the content";
    throw ShapeError(why.str());
  }
  // f rises; bisection to the last bit, a few dozen evaluations once.
  double lo = inner, hi = largest;
  for (int i = 0; i < 200 && hi - lo > 0.0; ++i) {
    const double mid = 0.5 * (lo + hi);
    if (mid == lo || mid == hi) break;
    (f(mid) < 0.0 ? lo : hi) = mid;
  }
  return hi;
}

double Flat::radius_of_thickness(const GrainPair& pair, double t) {
  const double largest = std::min(pair.R1, pair.R2);
  if (thickness(pair, 0.0) >= t) return 0.0;
  if (thickness(pair, largest) <= t) return largest;
  double lo = 0.0, hi = largest;
  for (int i = 0; i < 200; ++i) {
    const double mid = 0.5 * (lo + hi);
    if (mid == lo || mid == hi) break;
    (thickness(pair, mid) < t ? lo : hi) = mid;
  }
  return hi;
}

bool Flat::inside(const Vector3& x) const {
  const double z = x.dot(pair().n);
  const double r2 = x.squaredNorm() - z * z;
  if (r2 > outer_ * outer_ || r2 < inner_ * inner_) return false;
  for (int s = 0; s < 2; ++s)
    if ((x - pair().centre(s)).squaredNorm() < pair().radius(s) * pair().radius(s)) return false;
  // Between the planes of largest girth; beyond them the cylinder leaves the gap.
  return std::fabs(z) <= std::max(pair().R1, pair().R2) + 0.5 * pair().gap &&
         z > pair().centre(0).dot(pair().n) && z < pair().centre(1).dot(pair().n);
}

double Flat::clearance(const Vector3& x) const {
  const double z = x.dot(pair().n);
  const double r = std::sqrt(std::max(x.squaredNorm() - z * z, 0.0));
  double c = std::min(std::fabs(r - outer_), inner_ > 0.0 ? std::fabs(r - inner_) : r + outer_);
  for (int s = 0; s < 2; ++s) {
    c = std::min(c, std::fabs((x - pair().centre(s)).norm() - pair().radius(s)));
    // the girth planes matter only if the cylinder reaches them
    c = std::min(c, std::fabs(z - pair().centre(s).dot(pair().n)));
  }
  return c;
}

Vector3 Flat::half_extent() const {
  const Vector3& n = pair().n;
  const double half_height = 0.5 * pair().gap + std::max(sag(pair().R1, outer_), sag(pair().R2, outer_));
  Vector3 e;
  for (int d = 0; d < 3; ++d)
    e[d] = std::fabs(n[d]) * half_height + std::sqrt(std::max(1.0 - n[d] * n[d], 0.0)) * outer_;
  return e;
}

double Flat::volume() const { return cylinder_volume(pair(), outer_) - cylinder_volume(pair(), inner_); }

double Flat::attached_area(int side) const {
  const double R = pair().radius(side);
  return 2.0 * M_PI * R * (sag(R, outer_) - sag(R, inner_));
}

void Flat::attached_band(int side, double& from, double& to) const {
  const double R = pair().radius(side);
  from = std::asin(std::min(inner_ / R, 1.0));
  to = std::asin(std::min(outer_ / R, 1.0));
}

double Flat::largest_thickness() const { return thickness(pair(), outer_); }
double Flat::smallest_thickness() const { return std::max(thickness(pair(), inner_), 0.0); }

std::string Flat::describe() const {
  std::ostringstream s;
  s << "flat, inner radius " << inner_ << ", outer radius " << outer_ << ", gap " << pair().gap << ", thickness "
    << smallest_thickness() << " to " << largest_thickness();
  return s.str();
}

}  // namespace mpdem
