// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "hourglass.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "shape_styles.h"

namespace mpdem {

namespace {

double smaller(const GrainPair& pair) { return std::min(pair.R1, pair.R2); }

// Upper bound of 1 - waist^2: L c/(2 a^2), with c the height of the centre of the smaller grain over the circle of
// radius a.
double room(const GrainPair& pair, double a) {
  const double R = smaller(pair);
  return pair.thickness(a) * std::sqrt(std::max((R - a) * (R + a), 0.0)) / (2.0 * a * a);
}

bool leaves_the_spheres(const GrainPair& pair, double a, double waist) { return (1.0 - waist) * (1.0 + waist) <= room(pair, a); }

double taken_by_the_waist(const GrainPair& pair, double a, double waist) {
  return 2.0 * M_PI / 3.0 * pair.thickness(a) * a * a * (1.0 - waist) * (1.0 + waist);
}

std::string trouble_with_waist(double waist) {
  std::ostringstream why;
  why << "waist " << waist << " must lie in (0, 1]: radius of the waist over outer radius";
  return why.str();
}

}  // namespace

Hourglass::Hourglass(const GrainPair& pair, double outer, double waist, double inner)
    : EqualRims(pair, outer, inner), neck_(waist * outer) {
  std::ostringstream why;
  if (!(outer > 0.0 && outer <= smaller(pair))) {
    why << "outer radius " << outer << " must lie in (0, " << smaller(pair) << "], the smaller grain's radius";
  } else if (!(waist > 0.0 && waist <= 1.0)) {
    why << trouble_with_waist(waist);
  } else if (neck_ <= pair.contact_radius()) {
    why << "neck radius " << neck_ << " is inside the overlap of the grains; use more than " << pair.contact_radius();
  } else if (!leaves_the_spheres(pair, outer, waist)) {
    why << "waist " << waist << " at an outer radius of " << outer << " cuts into the grains; use a waist of at least "
        << std::sqrt(std::max(1.0 - room(pair, outer), 0.0)) << (pair.gap > 0.0 ? " or a wider gap" : "");
  } else if (!(inner < neck_)) {
    why << "inner radius " << inner << " must lie in [0, " << neck_ << "), below the neck radius"
        << "; use more cement or a smaller 'inner', with 'inner auto' a smaller spacing";
  }
  if (!why.str().empty()) throw ShapeError(why.str());
  const double half = 0.5 * pair.thickness(outer);
  middle_ = 0.5 * (sag(pair.R2, outer) - sag(pair.R1, outer));
  k2_ = (outer_ - neck_) * (outer_ + neck_) / (half * half);
}

// The volume rises with the outer radius wherever there is an hourglass, by at least 2/3 waist^2 times the rise for a
// cylinder. The radii for which there is an hourglass form one interval.
double Hourglass::outer_for_volume(const GrainPair& pair, double volume, double waist, double inner) {
  const auto volume_of = [&](double a) {
    return pair.volume_within(a) - taken_by_the_waist(pair, a, waist) - pair.volume_within(std::max(inner, pair.contact_radius()));
  };
  const double least = std::max(inner, pair.contact_radius()) / std::min(waist, 1.0), largest = smaller(pair);
  constexpr int kScan = 1000;
  double from = -1.0, to = -1.0;  // radii that are allowed
  double before = least;
  for (int k = 1; k <= kScan && least < largest && waist <= 1.0; ++k) {
    const double a = least + (largest - least) * k / kScan;
    const bool allowed = leaves_the_spheres(pair, a, waist);
    if (allowed && from < 0.0) from = bisect_rising([&](double b) { return leaves_the_spheres(pair, b, waist) ? 1.0 : -1.0; }, before, a);
    if (allowed) to = a;
    if (!allowed && from >= 0.0) {
      double beyond = a;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (to + beyond);
        (leaves_the_spheres(pair, middle, waist) ? to : beyond) = middle;
      }
      break;
    }
    before = a;
  }
  std::ostringstream why;
  if (!(waist > 0.0 && waist <= 1.0)) why << trouble_with_waist(waist);
  else if (from < 0.0) why << "an hourglass of waist " << waist << " cuts into these grains with any outer radius; use a waist nearer to 1";
  if (!why.str().empty()) throw ShapeError(why.str());
  if (!(volume > 0.0 && volume >= volume_of(from) && volume <= volume_of(to))) {
    why << "an hourglass of volume " << volume << " and waist " << waist << " does not fit: between these grains it holds at least "
        << std::max(volume_of(from), 0.0) << " and at most " << volume_of(to) << "; more fits with a waist nearer to 1";
    throw VolumeError(why.str(), std::max(volume_of(from), 0.0), volume_of(to));
  }
  return bisect_rising([&](double a) { return volume_of(a) - volume; }, from, to);
}

double Hourglass::volume() const {
  return pair().volume_within(outer_) - taken_by_the_waist(pair(), outer_, neck_ / outer_) - volume_within_inner();
}

double Hourglass::top(double z) const {
  if (z < lowest() || z > highest()) return 0.0;
  const double u = z - middle_;
  return std::sqrt(neck_ * neck_ + k2_ * u * u);
}

// Over a distance d the function r^2 - w^2 - k^2 u^2 changes by at most |its gradient| d + max(1, k^2) d^2. The result is
// the d at which this bound is as large as the function.
double Hourglass::top_clearance(double r, double z) const {
  const double u = z - middle_;
  const double f = std::fabs(r * r - neck_ * neck_ - k2_ * u * u);
  const double gradient = 2.0 * std::hypot(r, k2_ * u);
  if (f == 0.0) return 0.0;
  return 2.0 * f / (gradient + std::sqrt(gradient * gradient + 4.0 * std::max(1.0, k2_) * f));
}

std::string Hourglass::describe() const {
  std::ostringstream s;
  s << "hourglass, inner radius " << inner() << ", neck radius " << neck_ << ", outer radius " << outer_ << ", gap " << pair().gap
    << ", thickness " << smallest_thickness() << " to " << pair().thickness(outer_);
  return s.str();
}

ShapeStyle hourglass_style() {
  return {"hourglass", {{"outer"}, {"neck"}, {"waist", ShapeOption::detail, 0.8}}, [](const ShapeRequest& r) -> std::unique_ptr<Shape> {
            const double waist = r["waist"];
            const double outer = r.has("outer")  ? r["outer"]
                                 : r.has("neck") ? r["neck"] / waist
                                                 : Hourglass::outer_for_volume(r.pair, r.volume, waist, r.inner);
            return std::make_unique<Hourglass>(r.pair, outer, waist, r.inner);
          }};
}

}  // namespace mpdem
