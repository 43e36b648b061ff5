// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Displacement of the surface of an elastic sphere under tractions on it, in vector spherical harmonics. The load is
// balanced by the body force of free acceleration, and the displacement is relative to the mean motion of the sphere
// (inertia relief). With Y a spherical harmonic of degree l, orthonormal on the unit sphere,
//
//   t = t_r Y n + t_s grad Y + t_t n x grad Y,   u = u_r Y n + u_s grad Y + u_t n x grad Y,
//
// where grad is that of the unit sphere. Solutions for l > 1: Love, A treatise on the mathematical theory of elasticity
// (1927), articles 172 to 174. tests/verification/elastic_sphere.py checks all by finite elements.
#ifndef MPDEM_GRAIN_ELASTIC_SPHERE_H
#define MPDEM_GRAIN_ELASTIC_SPHERE_H

#include <vector>

namespace mpdem {

// Young's modulus and Poisson's ratio; E = 0: rigid.
struct GrainElasticity {
  double E = 0.0, nu = 0.0;
  bool is_rigid() const { return E == 0.0; }
  double shear_modulus() const { return E / (2.0 * (1.0 + nu)); }
  bool operator==(const GrainElasticity& e) const { return E == e.E && nu == e.nu; }
};

// Displacement over traction of one degree, for R/mu = 1: u_r = rr t_r + rs t_s, u_s = sr t_r + ss t_s, u_t = tt t_t.
struct SphereResponse {
  double rr = 0.0, rs = 0.0, sr = 0.0, ss = 0.0, tt = 0.0;
};
SphereResponse sphere_response(int degree, double nu);

// Associated Legendre functions of one order m >= 0 and ascending degree, at given angles from the pole. P cos(m phi) and
// P sin(m phi) are orthonormal on the unit sphere.
class LegendreFunctions {
 public:
  LegendreFunctions(int order, const std::vector<double>& angles);
  int degree() const { return degree_; }  // from the order on
  const std::vector<double>& value() const { return P_; }
  const std::vector<double>& slope() const { return slope_; }  // derivative by the angle
  void next();

 private:
  void find_slope();
  int order_, degree_;
  std::vector<double> cosine_, sine_, P_, before_, slope_;
};

}  // namespace mpdem

#endif
