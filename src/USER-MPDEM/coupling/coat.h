// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A coat: cement that covers a whole grain as a spherical shell of even thickness. It has no points. Its mass and
// moment of inertia are those of the shell, and other grains touch its outer surface. Bonds lie on the bare grain.
#ifndef MPDEM_COUPLING_COAT_H
#define MPDEM_COUPLING_COAT_H

#include <cmath>

#include "../parallel/record.h"

namespace mpdem {

struct Coat {
  int grain = 0;                      // ID
  double radius = 0, mass = 0;        // radius and mass of the bare grain, m, kg
  double thickness = 0, density = 0;  // thickness and density of the shell, m, kg/m3
  bool at_walls = true;               // walls touch the shell; false: they touch the bare grain

  double outer() const { return radius + thickness; }
  // 4 pi/3 ((R + t)^3 - R^3), without cancellation.
  double volume() const {
    const double R = radius, t = thickness;
    return 4.0 / 3.0 * M_PI * t * (3.0 * R * R + 3.0 * R * t + t * t);
  }
  double mass_of_coat() const { return density * volume(); }
  double mass_of_both() const { return mass + mass_of_coat(); }
  double mean_density() const { return mass_of_both() / (4.0 / 3.0 * M_PI * std::pow(outer(), 3)); }
  // Moment of inertia about a diameter of grain and shell: 2/5 m R^2 + 8 pi/15 rho ((R + t)^5 - R^5).
  double inertia() const {
    const double R = radius, t = thickness, R2 = R * R, t2 = t * t;
    const double fifths = t * (5.0 * R2 * R2 + 10.0 * R2 * R * t + 10.0 * R2 * t2 + 5.0 * R * t2 * t + t2 * t2);
    return 0.4 * mass * R2 + 8.0 / 15.0 * M_PI * density * fifths;
  }

  template <class Self, class Visitor>
  static constexpr void describe(Self& c, Visitor& visit) {
    visit("the ID of a coated grain", c.grain, from(1, kLargestInt));
    visit("the radius of a coated grain", c.radius, kPositive);
    visit("the mass of a coated grain", c.mass, kPositive);
    visit("the thickness of a coat", c.thickness, kPositive);
    visit("the density of a coat", c.density, kPositive);
    visit("'walls touch the coat'", c.at_walls);
  }
};

// Two grains, at least one of them with a coat, that touch each other with their bare surfaces: they have a bond, or were
// nearer to each other than their coats are thick when these were made.
struct BarePair {
  int grain[2] = {0, 0};  // IDs, ascending

  template <class Self, class Visitor>
  static constexpr void describe(Self& p, Visitor& visit) {
    visit("the ID of a grain of a pair that touches without its coats", p.grain, from(1, kLargestInt));
  }
};

}  // namespace mpdem

#endif
