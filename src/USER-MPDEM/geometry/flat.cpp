// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "flat.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "shape_styles.h"

namespace mpdem {

Flat::Flat(const GrainPair& pair, double outer, double inner) : EqualRims(pair, outer, inner) {
  std::ostringstream why;
  const double largest = std::min(pair.R1, pair.R2);
  if (!(outer > 0.0 && outer <= largest)) {
    why << "outer radius " << outer << " must lie in (0, " << largest << "], the smaller grain's radius";
  } else if (outer <= pair.contact_radius()) {
    why << "outer radius " << outer << " is inside the overlap of the grains; use more than " << pair.contact_radius();
  } else if (!(inner < outer)) {
    why << "inner radius " << inner << " must lie in [0, " << outer << "), below the outer radius"
        << "; use more cement or a smaller 'inner', with 'inner auto' a smaller spacing";
  }
  if (!why.str().empty()) throw ShapeError(why.str());
}

double Flat::outer_for_volume(const GrainPair& pair, double volume, double inner) {
  const double largest = std::min(pair.R1, pair.R2);
  inner = std::max(inner, pair.contact_radius());
  const double base = pair.volume_within(inner);
  const auto f = [&](double a) { return pair.volume_within(a) - base - volume; };
  if (!(volume > 0.0) || f(largest) < 0.0) {
    std::ostringstream why;
    why << "a flat bond of volume " << volume << " does not fit: between these grains it holds more than 0 and at most "
        << pair.volume_within(largest) - base;
    throw VolumeError(why.str(), 0.0, pair.volume_within(largest) - base);
  }
  return bisect_rising(f, inner, largest);
}

double Flat::volume() const { return pair().volume_within(outer_) - volume_within_inner(); }

double Flat::top(double z) const { return z < lowest() || z > highest() ? 0.0 : outer_; }

double Flat::top_clearance(double r, double) const { return std::fabs(r - outer_); }

std::string Flat::describe() const {
  std::ostringstream s;
  s << "flat, inner radius " << inner() << ", outer radius " << outer_ << ", gap " << pair().gap << ", thickness " << smallest_thickness()
    << " to " << largest_thickness();
  return s.str();
}

ShapeStyle flat_style() {
  return {"flat", {{"outer"}}, [](const ShapeRequest& r) -> std::unique_ptr<Shape> {
            const double outer = r.has("outer") ? r["outer"] : Flat::outer_for_volume(r.pair, r.volume, r.inner);
            return std::make_unique<Flat>(r.pair, outer, r.inner);
          }};
}

}  // namespace mpdem
