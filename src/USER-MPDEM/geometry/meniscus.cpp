// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "meniscus.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "shape_styles.h"

namespace mpdem {

Meniscus::Meniscus(const GrainPair& pair, double filling_angle, double contact_angle, double inner)
    : Shape(pair, inner), contact_(contact_angle) {
  std::ostringstream why;
  if (!(contact_angle >= 0.0 && contact_angle < 0.5 * M_PI))
    why << "contact angle " << contact_angle / kDegree << " degrees must lie in [0, 90)";
  else if (!(filling_angle > 0.0 && filling_angle + contact_angle < 0.5 * M_PI))
    why << "filling angle " << filling_angle / kDegree << " degrees must lie between 0 and " << 90.0 - contact_angle / kDegree
        << ", a right angle less the contact angle";
  if (!why.str().empty()) throw ShapeError(why.str());

  // Radii are from the line of centres, heights from the centre of the first grain.
  const double R1 = pair.R1, R2 = pair.R2, d = pair.distance(), b = filling_angle, t = contact_angle;
  const double pr = R1 * std::sin(b), pz = R1 * std::cos(b);  // (pr, pz) is P1
  const double mr = std::sin(b + t), mz = std::cos(b + t);    // (mr, mz) is m
  const double apart = pr * pr + (pz - d) * (pz - d) - R2 * R2;
  const double slope = 2.0 * (R2 * std::cos(t) - mr * pr - mz * (pz - d));
  rho_ = apart / slope;
  r0_ = pr + rho_ * mr;
  z0_ = pz + rho_ * mz;
  const double s = std::sin(0.5 * (0.5 * M_PI - b - t));
  waist_ = pr - 2.0 * rho_ * s * s;  // r0 - rho without cancellation
  // From the centre of the second grain the centre of the arc appears at the angle b2 + alpha from the line of centres. The
  // way there by the end P2 of the arc has the lengths R2 and rho, and turns by t at P2.
  const double w = std::hypot(r0_, d - z0_);
  const double alpha = std::atan2(rho_ * std::sin(t), R2 + rho_ * std::cos(t));
  b_[0] = b;
  b_[1] = std::atan2(r0_, d - z0_) - alpha;
  if (!(apart > 0.0 && slope > 0.0 && rho_ > 0.0 && b_[1] > 0.0 && b_[1] < 0.5 * M_PI && waist_ > 0.0) || !std::isfinite(w)) {
    why << "no meniscus with filling angle " << b / kDegree << " and contact angle " << t / kDegree << " degrees spans a gap of "
        << pair.gap << "; use a larger filling angle or content";
    throw ShapeError(why.str());
  }
  const double shift = pair.height(0);
  z_[0] = pz + shift;
  z_[1] = d - R2 * std::cos(b_[1]) + shift;
  z0_ += shift;
  if (!(this->inner() < neck())) {
    why << "inner radius " << this->inner() << " must lie in [0, " << neck() << "), inside the neck"
        << "; use more cement or a smaller 'inner', with 'inner auto' a smaller spacing";
    throw ShapeError(why.str());
  }
}

namespace {

// Filling angle at which `measure` of the meniscus takes a value. Volume and neck rise with the angle wherever there is
// a meniscus. Below the first meniscus that spans the gap they count as 0.
template <class F>
double filling_for(const GrainPair& pair, double value, double contact_angle, double inner, const char* name, F measure) {
  const auto measure_of = [&](double b) {
    try {
      return measure(Meniscus(pair, b, contact_angle, inner));
    } catch (const ShapeError&) {
      return 0.0;
    }
  };
  // If the first grain is the larger one, the largest angle is that at which the arc reaches the widest circle of the second.
  double limit = (0.5 * M_PI - contact_angle) * (1.0 - 1e-9);
  constexpr int kScan = 1000;
  for (int k = kScan - 1; k > 0 && measure_of(limit) == 0.0; --k) {
    double lo = limit * k / kScan, hi = limit * (k + 1) / kScan;
    if (measure_of(lo) == 0.0) continue;
    for (int i = 0; i < 60; ++i) (measure_of(0.5 * (lo + hi)) > 0.0 ? lo : hi) = 0.5 * (lo + hi);
    limit = lo;
  }
  const double most = measure_of(limit), least = least_of_rising(measure_of, limit);
  if (!(value > 0.0 && value >= least && value <= most)) {
    std::ostringstream why;
    if (!(contact_angle >= 0.0 && contact_angle < 0.5 * M_PI))
      why << "contact angle " << contact_angle / kDegree << " degrees must lie in [0, 90)";
    else if (most == 0.0)
      why << "with the contact angle " << contact_angle / kDegree
          << " degrees no meniscus spans the gap of these grains; use a smaller one";
    else
      why << "a meniscus of " << name << " " << value << " does not fit: between these grains and outside the inner radius " << inner
          << " it has at least " << least << " and at most " << most << "; use a value between them, or another inner radius";
    if (name == std::string("volume")) throw VolumeError(why.str(), least, most);
    throw ShapeError(why.str());
  }
  return bisect_rising([&](double b) { return measure_of(b) - value; }, 0.0, limit);
}

}  // namespace

double Meniscus::filling_for_volume(const GrainPair& pair, double volume, double contact_angle, double inner) {
  return filling_for(pair, volume, contact_angle, inner, "volume", [](const Meniscus& m) { return m.volume(); });
}

double Meniscus::filling_for_neck(const GrainPair& pair, double neck, double contact_angle, double inner) {
  return filling_for(pair, neck, contact_angle, inner, "neck radius", [](const Meniscus& m) { return m.neck(); });
}

double Meniscus::neck() const {
  // The arc is narrowest at the height of its centre, unless that lies beyond a sphere.
  const double z = std::min(std::max(z0_, z_[0]), z_[1]);
  return top(z);
}

// Integral of r(z)^2 with r = waist + q, q = rho - sqrt(rho^2 - u^2), by the closed form. On an arc that is short for its
// radius this cancels. There q is smooth, so Gauss-Legendre quadrature is used.
double Meniscus::profile_integral(double from, double to) const {
  if (std::max(std::fabs(from), std::fabs(to)) > 0.3 * rho_) {
    const auto primitive = [this](double u) {
      const double root = std::sqrt(std::max(rho_ * rho_ - u * u, 0.0));
      return (r0_ * r0_ + rho_ * rho_) * u - u * u * u / 3.0 -
             r0_ * (u * root + rho_ * rho_ * std::asin(std::min(std::max(u / rho_, -1.0), 1.0)));
    };
    return primitive(to) - primitive(from);
  }
  return gauss_legendre([this](double u) { return std::pow(top(z0_ + u), 2); }, from, to);
}

double Meniscus::volume() const {
  double V = M_PI * profile_integral(z_[0] - z0_, z_[1] - z0_);
  for (int s = 0; s < 2; ++s) {
    const double R = pair().radius(s), h = 2.0 * R * std::pow(std::sin(0.5 * b_[s]), 2);
    V -= M_PI * h * h * (R - h / 3.0);
  }
  V += lens_volume(pair().R1, pair().R2, pair().distance());  // both caps have it
  return V - volume_within_inner();
}

double Meniscus::top(double z) const {
  if (z < z_[0] || z > z_[1]) return 0.0;
  const double u = z - z0_;
  return waist_ + u * u / (rho_ + std::sqrt(std::max(rho_ * rho_ - u * u, 0.0)));
}

double Meniscus::top_clearance(double r, double z) const { return std::fabs(std::hypot(r - r0_, z - z0_) - rho_); }

double Meniscus::widest() const { return std::max(pair().R1 * std::sin(b_[0]), pair().R2 * std::sin(b_[1])); }

double Meniscus::largest_thickness() const { return pair().thickness(std::min(pair().R1 * std::sin(b_[0]), pair().R2 * std::sin(b_[1]))); }

std::string Meniscus::describe() const {
  std::ostringstream s;
  s << "meniscus, filling angles " << b_[0] / kDegree << " and " << b_[1] / kDegree << " degrees, contact angle " << contact_ / kDegree
    << " degrees, neck radius " << neck() << ", inner radius " << inner() << ", gap " << pair().gap;
  return s.str();
}

ShapeStyle meniscus_style() {
  return {"meniscus",
          {{"filling"}, {"neck"}, {"contact", ShapeOption::detail, 0.0, ShapeOption::not_negative}},
          [](const ShapeRequest& r) -> std::unique_ptr<Shape> {
            const double contact = r["contact"] * kDegree;
            const double filling = r.has("filling") ? r["filling"] * kDegree
                                   : r.has("neck")  ? Meniscus::filling_for_neck(r.pair, r["neck"], contact, r.inner)
                                                    : Meniscus::filling_for_volume(r.pair, r.volume, contact, r.inner);
            return std::make_unique<Meniscus>(r.pair, filling, contact, r.inner);
          }};
}

}  // namespace mpdem
