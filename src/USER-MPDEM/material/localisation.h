// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The band in which an infinite bar of a softening material breaks if its strain is averaged over a length L before it is compared
// with the curve of the law (mpm/drive_average.h), with stress sigma and d the damage:
//
//   strain     e/e0 = (sigma/sigma0) c(d),   sigma0 = E e0
//   average    (ebar/e0)^(1/2) = G * (e/e0)^(1/2),   G a Gaussian of variance L^2
//   damage     ebar/e0 <= k(d), equal where damage grows, and d never falls
//   energy     per area  integral of the work -(1/2) E e^2 d(1/c) over the bar
//
// The branch that localises at the onset is followed by the damage in its middle. Where damage grows is an interval about the
// middle, which gets shorter. Solved by Newton's method on a lattice of kPerLength points a length.
#ifndef MPDEM_LOCALISATION_H
#define MPDEM_LOCALISATION_H

#include <functional>
#include <optional>

namespace mpdem {

// Logarithms, as functions of x = -ln(1 - d), and their derivatives; all are 0 at x = 0.
struct SofteningCurve {
  struct Value {
    double value, slope;
  };
  std::function<Value(double)> compliance;  // ln c
  std::function<Value(double)> threshold;   // ln k
};

struct Localisation {
  double width;   // of the damaged band, over L
  double energy;  // per area, over E e0^2 L
};

// To damage `cutoff` in the middle. Nothing if the bar does not localise at the onset, or in a band too wide for the lattice.
std::optional<Localisation> localise(const SofteningCurve& curve, double cutoff);

}  // namespace mpdem

#endif
