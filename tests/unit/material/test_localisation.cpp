// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/localisation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "material/tensor_damage.h"

namespace mpdem {
namespace {

Localisation band(double m) {
  DamageParameters p;
  p.B0 = 1.0;
  p.exponent = m;
  return localise(softening_curve(p), p.Dcut).value();
}

// Compares with tests/verification/localisation.py, which solves the equations on another lattice, of 16 points a length.
TEST(Localisation, BandsOfTheTensorLaw) {
  struct Known {
    double m, spent, stored, width;
  };
  for (const Known& k : {Known{0.0, 3.9084, 0.6032, 2.875}, Known{1.0, 10.7296, 3.2456, 4.75}, Known{2.0, 45.2514, 26.796, 8.375}}) {
    const Localisation b = band(k.m);
    EXPECT_NEAR(b.spent, k.spent, 0.003 * k.spent) << "m " << k.m;
    EXPECT_NEAR(b.energy, k.spent + k.stored, 0.01 * k.spent) << "m " << k.m;
    EXPECT_NEAR(b.width, k.width, 0.15) << "m " << k.m;
  }
}

// At the onset damage is a cosine of the wave number k with exp(-k^2/2) = slope of ln k over slope of ln c. The band is wider than half
// of that wave, and narrower than a whole one.
TEST(Localisation, BandIsThatOfTheOnset) {
  for (double m : {-0.5, 0.0, 1.0}) {
    const double wave = 2.0 * M_PI / std::sqrt(2.0 * std::log(4.0 / (1.0 + m)));
    EXPECT_GT(band(m).width, 0.5 * wave) << "m " << m;
    EXPECT_LT(band(m).width, wave) << "m " << m;
  }
}

TEST(Localisation, ExponentSpendsTheEnergy) {
  DamageParameters p;
  p.B0 = 7.0;
  const double length = 0.3, unit = std::sqrt(2.0) * p.B0 * length;
  for (double energy : {3.1, 4.53, 10.0, 70.0}) {
    const double m = nonlocal_exponent(p, energy * unit, length);
    EXPECT_NEAR(band(m).energy, energy, 1e-5 * energy);
  }
  for (double energy : {2.9, 75.0}) EXPECT_THROW(nonlocal_exponent(p, energy * unit, length), std::domain_error);
}

// If stress rises at the onset of damage, the bar does not localise there.
TEST(Localisation, NoneWhereStressRises) {
  SofteningCurve hardening = softening_curve(DamageParameters());
  hardening.threshold = [](double x) { return SofteningCurve::Value{3.0 * x, 3.0}; };
  EXPECT_FALSE(localise(hardening, 0.9));
}

}  // namespace
}  // namespace mpdem
