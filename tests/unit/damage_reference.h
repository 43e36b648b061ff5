// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A reference for the law of material/tensor_damage.h, one point at a time and as the law is defined.
// Eigen finds the principal axes of D, and harmonic means are taken there. The compliance follows from
// the engineering constants and is inverted by Eigen.
#ifndef MPDEM_TESTS_DAMAGE_REFERENCE_H
#define MPDEM_TESTS_DAMAGE_REFERENCE_H

#include "lanes.h"
#include "material/tensor_damage.h"
#include "material/vti_elasticity.h"

namespace mpdem::test {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Compliance matrix in the order 11, 22, 33, 23, 13, 12, with engineering shears.
inline Matrix6 compliance(const VtiConstants& c) {
  Matrix6 S = Matrix6::Zero();
  S(0, 0) = S(1, 1) = 1.0 / c.Ep;
  S(2, 2) = 1.0 / c.Ez;
  S(0, 1) = S(1, 0) = -c.nu_p / c.Ep;
  S(0, 2) = S(2, 0) = S(1, 2) = S(2, 1) = -c.nu_zp / c.Ez;
  S(3, 3) = S(4, 4) = 1.0 / c.Gzp;
  S(5, 5) = 2.0 * (1.0 + c.nu_p) / c.Ep;
  return S;
}

inline Vector6 voigt(const Matrix& m, double shear_factor) {
  Vector6 v;
  v << m(0, 0), m(1, 1), m(2, 2), shear_factor * m(1, 2), shear_factor * m(0, 2), shear_factor * m(0, 1);
  return v;
}
inline Matrix from_voigt(const Vector6& v, double shear_factor) {
  const double y = v[3] / shear_factor, z = v[4] / shear_factor, w = v[5] / shear_factor;
  Matrix m;
  m << v[0], w, z, w, v[1], y, z, y, v[2];
  return m;
}

class DamageReference {
 public:
  explicit DamageReference(const VtiConstants& c) : S_(compliance(c)), C_(Eigen::FullPivLU<Matrix6>(S_).inverse()) {}

  Matrix elastic_stress(const Matrix& strain) const { return from_voigt(C_ * voigt(strain, 2.0), 1.0); }
  Matrix elastic_strain(const Matrix& stress) const { return from_voigt(S_ * voigt(stress, 1.0), 2.0); }

  // M^-1 : e
  static Matrix effective(const Matrix& e, const Matrix& D) {
    const Eigen::SelfAdjointEigenSolver<Matrix> s(D);
    const Vector a = Vector::Ones() - s.eigenvalues();
    Matrix x = s.eigenvectors().transpose() * e * s.eigenvectors();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) x(i, j) *= 2.0 * a[i] * a[j] / (a[i] + a[j]);
    return symmetric(s.eigenvectors() * x * s.eigenvectors().transpose());
  }
  // M : s
  static Matrix amplified(const Matrix& s, const Matrix& D) { return symmetric((Matrix::Identity() - D).inverse() * s); }

  double psi(const Matrix& strain, const Matrix& D) const {
    const Matrix e = effective(strain, D);
    return 0.5 * contract(e, elastic_stress(e));
  }
  Matrix stress(const Matrix& strain, const Matrix& D) const { return effective(elastic_stress(effective(strain, D)), D); }
  // -d psi/dD
  Matrix force(const Matrix& strain, const Matrix& D) const {
    const Matrix phi = (Matrix::Identity() - D).inverse();
    return symmetric(phi * symmetric(stress(strain, D) * effective(strain, D)) * phi);
  }

 private:
  Matrix6 S_, C_;
};

inline Matrix positive_part(const Matrix& m) {
  const Eigen::SelfAdjointEigenSolver<Matrix> s(m);
  return symmetric(s.eigenvectors() * s.eigenvalues().cwiseMax(0.0).asDiagonal() * s.eigenvectors().transpose());
}

inline double equivalent(const Matrix& Y) { return std::sqrt(0.5 * contract(Y, Y)); }

// Constants of calcite that all these tests use.
inline VtiConstants calcite() { return {50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9}; }
constexpr double kB0 = 9.6e6;
// The law finds D to 2e-11; what follows from D is at most 1/(1 - Dcut) times as far off.
constexpr double kRootTolerance = 2e-10;

inline TensorDamage law_of(bool monotone = true, double zeta = 1.0, const VtiConstants& c = calcite()) {
  DamageParameters p;
  p.B0 = kB0;
  p.monotone = monotone;
  p.zeta = zeta;
  return TensorDamage(VtiElasticity(c), p);
}

inline double equivalent_at(const TensorDamage& law, const Matrix& strain, const Matrix& D) {
  return law.drive(on_all_lanes(strain), on_all_lanes(D)).Yeq[0];
}

// A strain scaled so that the drive is `level` times the threshold.
inline Matrix strain_at(const TensorDamage& law, double level, const Matrix& strain, const Matrix& D) {
  return std::sqrt(level * kB0 / equivalent_at(law, strain, D)) * strain;
}

}  // namespace mpdem::test

#endif
