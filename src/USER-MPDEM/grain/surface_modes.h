// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Modes of displacement and traction on a patch of a sphere: a ring between two angles from a pole, or a cap. A scalar mode
// is a radial function times a harmonic of the angle about the pole. Modes are orthonormal over the area of the unit
// sphere. With x linear in cos(theta), which makes equal areas equal lengths, radial functions are
//
//   ring: Legendre polynomials P_a(x), x from -1 to 1, for each order m;
//   cap:  rho^m times Jacobi polynomials P_a^(0, m)(2 rho^2 - 1), with rho^2 = (1 - cos theta)/(1 - cos outer), so that modes
//         are smooth at the pole (Zernike polynomials).
//
// Vector modes are scalar modes times the unit vectors of the patch: x, y, and z from the centre to the pole. Vector mode
// 3 j + d has scalar mode j and direction d.
#ifndef MPDEM_GRAIN_SURFACE_MODES_H
#define MPDEM_GRAIN_SURFACE_MODES_H

#include <vector>

namespace mpdem {

class SurfaceModes {
 public:
  // A harmonic of the angle: order, and whether it is the sine.
  struct Harmonic {
    int order;
    bool sine;
  };
  // Angles from the pole; inner = 0: cap. degree: of the radial functions in x, or half of that in rho. orders: largest m.
  SurfaceModes(double inner, double outer, int degree, int orders);
  SurfaceModes() = default;

  int scalars() const { return static_cast<int>(modes_.size()); }
  int size() const { return 3 * scalars(); }
  // A scalar mode is a product of one radial value and one harmonic, see find_values().
  struct Scalar {
    int radial, harmonic;
  };
  const std::vector<Scalar>& modes() const { return modes_; }
  int radials() const { return radials_; }
  const std::vector<Harmonic>& harmonics() const { return harmonics_; }
  int orders() const { return orders_; }
  double inner() const { return inner_; }
  double outer() const { return outer_; }

  // Radial values by the cosine of the angle from the pole, and harmonics by the angle about it.
  void find_radials(double cosine, double* radial) const;
  void find_harmonics(double cos_phi, double sin_phi, double* harmonic) const;
  // Order of the harmonics to which a radial value belongs; -1: all.
  int order_of_radial(int radial) const { return inner_ > 0.0 ? -1 : order_of_radial_[radial]; }

 private:
  double inner_ = 0.0, outer_ = 0.0;
  int degree_ = 0, orders_ = 0, radials_ = 0;
  std::vector<Scalar> modes_;
  std::vector<Harmonic> harmonics_;
  std::vector<int> order_of_radial_;
};

}  // namespace mpdem

#endif
