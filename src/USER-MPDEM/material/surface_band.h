// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Softening of the tensor law near the grains, where damage is nonlocal.
//
// An average ends at the surface of a grain. So the band of a crack there is half a band, and with one exponent m for
// all points it would take half of the energy. A layer thinner than a band softens as a whole, and takes less still.
// The exponent of a point therefore depends on its distances d0, d1 from the surfaces of the two grains, so that a
// crack takes the same energy G per area wherever it runs along a grain:
//
//   d0 + d1 < thin        uniform damage: sqrt(2) B0 W(m) (d0 + d1) = G, see crack_band_exponent()
//   else                  m = ms + (m0 - ms) x,  x = 2 min(d0, d1)/thin - 1, between 0 and 1
//
// m0 is the exponent of the law. ms is that with which a crack in the interior would take 2 G, so half of its band
// takes G. `thin` is the width of that half: a thinner layer does not localise. A bar that debonds from a grain takes
// 0.95 to 1.03 G, since its band extends a little beyond the points with ms.
//
// Grassl, Xenos, Jirasek & Horak (arXiv:1406.3381, 2014) compare ways to average near boundaries. Those that change the
// weights change the load at which damage begins, too; this one does not.
#ifndef MPDEM_MATERIAL_SURFACE_BAND_H
#define MPDEM_MATERIAL_SURFACE_BAND_H

#include <array>

namespace mpdem {

struct DamageParameters;

// Exponent with which a layer that softens as a whole takes this energy per area. It is at least that of the law, and at most 2.99:
// with 3 the stress would not fall.
double exponent_of_layer(const DamageParameters& p, double energy, double thickness);

class SurfaceBand {
 public:
  // Gives all points the same exponent.
  explicit SurfaceBand(double exponent = 0.0) : middle_(exponent), surface_(exponent) {}
  // Finds the exponents of a material with these parameters and this length. Throws std::domain_error if no exponent spends the
  // energy of a crack at a surface, see nonlocal_exponent().
  SurfaceBand(const DamageParameters& p, double length);

  bool depends_on_position() const { return thin_ > 0.0; }
  // Exponent of a point at these distances from the surfaces of its grains.
  double exponent(double d0, double d1) const;
  double at_surface() const { return surface_; }
  double thin() const { return thin_; }
  double energy() const { return energy_; }  // G; 0: one exponent for all points

 private:
  double thin_exponent(double thickness) const;

  static constexpr int kTable = 128;
  double middle_, surface_, thin_ = 0.0, energy_ = 0.0;
  std::array<double, kTable + 1> of_thickness_{};  // exponents of layers of thickness thin_ k/kTable
};

}  // namespace mpdem

#endif
