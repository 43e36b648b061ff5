// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "surface_band.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "localisation.h"
#include "tensor_damage.h"

namespace mpdem {

namespace {

constexpr double kMostThin = 2.99;  // largest exponent of thin layers; with 3 the stress would not fall

double half_band(DamageParameters p, double exponent, double length) {
  p.exponent = exponent;
  return 0.5 * localise(softening_curve(p), p.Dcut).value().width * length;
}

}  // namespace

double exponent_of_layer(const DamageParameters& p, double energy, double thickness) {
  DamageParameters q = p;
  q.exponent = kMostThin;
  const double most = implied_strength(q, 1.0).work_per_volume * thickness;
  if (energy >= most) return kMostThin;  // too thin to take so much
  q.exponent = p.exponent;
  if (energy <= implied_strength(q, 1.0).work_per_volume * thickness) return p.exponent;
  return crack_band_exponent(p, energy, thickness);
}

SurfaceBand::SurfaceBand(const DamageParameters& p, double length) : SurfaceBand(p.exponent) {
  const std::optional<Localisation> band = localise(softening_curve(p), p.Dcut);
  if (!band) return;  // the energy of a crack is not known then
  energy_ = std::sqrt(2.0) * p.B0 * band->energy * length;
  surface_ = nonlocal_exponent(p, kBandsOfSurface * energy_, length);
  thin_ = half_band(p, surface_, length);
  for (int k = 0; k <= kTable; ++k) {
    of_thickness_[k] = exponent_of_layer(p, energy_, thin_ * std::max(k, 1) / kTable);
  }
}

double SurfaceBand::thin_exponent(double thickness) const {
  const double at = kTable * std::max(thickness, 0.0) / thin_;
  const int k = std::min(static_cast<int>(at), kTable - 1);
  return of_thickness_[k] + (at - k) * (of_thickness_[k + 1] - of_thickness_[k]);
}

double SurfaceBand::exponent(double d0, double d1) const {
  if (!depends_on_position()) return middle_;
  if (d0 + d1 < thin_) return thin_exponent(d0 + d1);
  const double far = std::clamp(2.0 * std::min(d0, d1) / thin_ - 1.0, 0.0, 1.0);
  return surface_ + far * (middle_ - surface_);
}

}  // namespace mpdem
