// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Quadrature over the angle from a pole, for integrals over a patch of the unit sphere.
#ifndef MPDEM_GRAIN_POLAR_RULE_H
#define MPDEM_GRAIN_POLAR_RULE_H

#include <vector>

namespace mpdem {

// The weights include sin(angle).
struct PolarRule {
  std::vector<double> angle, weight;
};

// Rule of Gauss and Legendre between two angles.
PolarRule polar_rule(double from, double to, int points);

}  // namespace mpdem

#endif
