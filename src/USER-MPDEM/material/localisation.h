// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds the band in which an infinite bar of a softening material breaks. The strain is averaged over a length L before
// it is compared with the curve of the law (mpm/drive_average.h). With stress sigma and damage d
//
//   strain     e/e0 = (sigma/sigma0) c(d),   sigma0 = E e0,   e0 the strain at the onset, c the compliance over 1/E
//   average    (ebar/e0)^(1/2) = G * (e/e0)^(1/2),   G a Gaussian of variance L^2
//   damage     ebar/e0 <= k(d), equal where damage grows, and d never falls;   k the threshold of the strain over e0
//   spent      by damage, per area  integral of -(1/2) E e^2 d(1/c) over the bar
//   energy     per area  spent, and what the band stores at the cut-off beyond the bar around it, (1/2) sigma
//              (e - sigma/E): it is lost in waves when the middle fails. Together they are the area under stress over
//              opening.
//
// The branch that localises at the onset is followed by the damage in its middle. Damage grows in an interval about the
// middle, which gets shorter. The equations are solved by Newton's method on a lattice with kPerLength points in a
// length.
//
// The bar is symmetric about the crack. An average ends where the cement ends, so half of the bar is also a bar that
// debonds from the rigid grain at its end, with half of the energy.
#ifndef MPDEM_MATERIAL_LOCALISATION_H
#define MPDEM_MATERIAL_LOCALISATION_H

#include <functional>
#include <optional>

namespace mpdem {

// Logarithms of c and k, as functions of x = -ln(1 - d), with their derivatives. All values are 0 at x = 0.
struct SofteningCurve {
  struct Value {
    double value, slope;
  };
  std::function<Value(double)> compliance;  // ln c
  std::function<Value(double)> threshold;   // ln k
};

struct Localisation {
  double width;   // width of the damaged band, over L
  double energy;  // energy per area, over E e0^2 L
  double spent;   // energy dissipated by damage, in the same units
};

// Follows the branch to damage `cutoff` in the middle. Returns nothing if the bar does not localise at the onset, or if
// the band is too wide for the lattice.
std::optional<Localisation> localise(const SofteningCurve& curve, double cutoff);
// Follows the branch for a curve that depends on the distance from the crack, in units of L.
std::optional<Localisation> localise(const std::function<SofteningCurve(double)>& curve_at, double cutoff);

}  // namespace mpdem

#endif
