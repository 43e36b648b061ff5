// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/surface_band.h"

#include <gtest/gtest.h>

#include <cmath>

#include "material/localisation.h"
#include "material/tensor_damage.h"

namespace mpdem {
namespace {

constexpr double kBandLength = 0.3, kFarAway = 1e3;

DamageParameters with_exponent(double m) {
  DamageParameters p;
  p.B0 = 7.0;
  p.exponent = m;
  return p;
}

double unit_energy(const DamageParameters& p) { return std::sqrt(2.0) * p.B0 * kBandLength; }

// Energy per area of a bar that comes off a grain, over sqrt(2) B0 L.
double energy_at_surface(const DamageParameters& p, const SurfaceBand& band) {
  const auto curve = [&](double d) {
    DamageParameters q = p;
    q.exponent = band.exponent(d * kBandLength, kFarAway);
    return softening_curve(q);
  };
  return 0.5 * localise(curve, p.Dcut).value().energy;
}

TEST(SurfaceBand, BarThatComesOffAGrainTakesTheEnergyOfACrack) {
  for (double m : {-0.4, 0.0, 0.6, 1.3}) {
    const DamageParameters p = with_exponent(m);
    const double whole = localise(softening_curve(p), p.Dcut).value().energy;
    const SurfaceBand band(p, kBandLength);
    EXPECT_NEAR(energy_at_surface(p, band), whole, 0.05 * whole) << "m " << m;
    EXPECT_NEAR(energy_at_surface(p, SurfaceBand(m)), 0.5 * whole, 1e-12 * whole) << "m " << m;
    DamageParameters q = p;
    q.exponent = band.at_surface();
    EXPECT_NEAR(localise(softening_curve(q), q.Dcut).value().energy, 2.0 * whole, 1e-5 * whole) << "m " << m;
  }
}

// A layer between two grains that softens as a whole spends sqrt(2) B0 W(m) on each volume.
TEST(SurfaceBand, ThinLayerTakesTheEnergyOfACrack) {
  const DamageParameters p = with_exponent(0.4);
  const SurfaceBand band(p, kBandLength);
  const double energy = localise(softening_curve(p), p.Dcut).value().energy * unit_energy(p);
  for (double share : {0.1, 0.35, 0.77, 0.99})
    for (double place : {0.0, 0.2, 0.5}) {
      const double t = share * band.thin(), m = band.exponent(place * t, (1.0 - place) * t);
      EXPECT_NEAR(m, crack_band_exponent(p, energy, t), 2e-3) << "thickness " << t;
    }
}

TEST(SurfaceBand, FarFromGrainsTheExponentIsThatOfTheLaw) {
  const DamageParameters p = with_exponent(0.4);
  const SurfaceBand band(p, kBandLength);
  const double t = band.thin();
  EXPECT_EQ(band.exponent(t, 1.01 * t), 0.4);
  EXPECT_EQ(band.exponent(kFarAway, 2.0 * t), 0.4);
  for (double d : {-1e-9, 0.0, 0.3 * t, 0.499 * t}) EXPECT_EQ(band.exponent(d, kFarAway), band.at_surface());
  EXPECT_NEAR(band.exponent(kFarAway, 0.75 * t), 0.5 * (0.4 + band.at_surface()), 1e-12);
  EXPECT_EQ(SurfaceBand(0.4).exponent(0.0, 0.0), 0.4);
}

TEST(SurfaceBand, TooMuchEnergyIsRefused) {
  const DamageParameters p = with_exponent(2.0);
  EXPECT_THROW(SurfaceBand(p, kBandLength), std::domain_error);
}

}  // namespace
}  // namespace mpdem
