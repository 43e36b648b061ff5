// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/tensor_damage.h"

#include "damage_reference.h"
#include "mpm/point_store.h"

namespace mpdem {
namespace {

using test::DamageReference;
using test::equivalent_at;
using test::kB0;
using test::law_of;
using test::Matrix;
using test::strain_at;
using test::tensor;
using test::Vector;

bool grows(const TensorDamage& law, const Matrix& strain) {
  Sym3<vd> D{};
  return law.update(Sym3<vd>{}, test::on_all_lanes(strain), D, splat_mask(true)).grown[3];
}

// Stress, conjugate force and onset; growth is in test_tensor_damage_update.cpp.

TEST(TensorDamageState, StressIsTheReference) {
  const TensorDamage law = law_of();
  const DamageReference reference(test::calcite());
  test::Random random(61);
  test::Worst stress, drive_full, drive;
  const TensorDamage full = law_of(false);
  for (int n = 0; n < 4000; ++n) {
    const Matrix e = 0.01 * random.sym(), D = random.damage(0.9), Y = reference.force(e, D);
    const Matrix s = tensor(law.stress(test::on_all_lanes(e), test::on_all_lanes(D)), n % kLanes);
    stress.add(s - reference.stress(e, D), reference.elastic_stress(e).norm());
    drive_full.add(std::fabs(equivalent_at(full, e, D) / test::equivalent(Y) - 1.0));
    drive.add(std::fabs(equivalent_at(law, e, D) / test::equivalent(test::positive_part(Y)) - 1.0));
  }
  expect_within(stress, 1e-13, "stress over C0:eps");
  expect_within(drive_full, 1e-12, "Yeq");
  expect_within(drive, 1e-12, "Yeq of the positive part");
}

// The energy is quadratic in the strain: central differences are exact.
TEST(TensorDamageState, StressDerivesFromTheEnergy) {
  const TensorDamage law = law_of();
  const DamageReference reference(test::calcite());
  test::Random random(62);
  test::Worst worst;
  for (int n = 0; n < 500; ++n) {
    const Matrix e = 0.01 * random.sym(), D = random.damage(0.9), d = 0.01 * random.sym();
    const Matrix s = tensor(law.stress(test::on_all_lanes(e), test::on_all_lanes(D)), 0);
    const double difference = 0.5 * (reference.psi(e + d, D) - reference.psi(e - d, D));
    worst.add(std::fabs(test::contract(s, d) - difference) / (reference.elastic_stress(e).norm() * d.norm()));
  }
  expect_within(worst, 1e-13, "stress:d");
}

// -d psi/dD by central differences, in the six independent components.
Matrix force_by_differences(const DamageReference& reference, const Matrix& e, const Matrix& D) {
  Matrix Y;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      Matrix d = Matrix::Zero();
      d(i, j) += 0.5;
      d(j, i) += 0.5;
      const auto slope = [&](double t) { return (reference.psi(e, D - t * d) - reference.psi(e, D + t * d)) / (2 * t); };
      Y(i, j) = Y(j, i) = (4.0 * slope(2e-4) - slope(4e-4)) / 3.0;
    }
  return Y;
}

// Yeq comes from drive(); the direction is that of a small growth, at a load so little above
// the surface that it does not rotate meanwhile (extrapolated to none).
void expect_force(bool monotone) {
  const TensorDamage law = law_of(monotone);
  const DamageReference reference(test::calcite());
  test::Random random(63);
  test::Worst size, direction;
  for (int n = 0; n < 300; ++n) {
    const Matrix D = n % 5 ? random.damage(0.7) : Matrix(Matrix::Zero());
    const double eta = 1e-5;
    const Matrix e = strain_at(law, 1.0, random.sym(), D);
    Matrix Y = force_by_differences(reference, e, D);
    if (monotone) Y = test::positive_part(Y);
    size.add(std::fabs(equivalent_at(law, e, D) / test::equivalent(Y) - 1.0));
    Sym3<vd> strain{}, damage = test::on_all_lanes(D);
    test::set_tensor(strain, 0, std::sqrt(1.0 + eta) * e);
    test::set_tensor(strain, 1, std::sqrt(1.0 + 0.5 * eta) * e);
    const TensorDamage::Update u = law.update(Sym3<vd>{}, strain, damage, lanes(3));
    const Matrix whole = tensor(damage, 0) - D, half = tensor(damage, 1) - D;
    // Beside the surface Yeq may rise with D when Y is not cut: then the step is long.
    if (!monotone && (u.failed[0] || u.failed[1] || whole.norm() > 1e-3)) continue;
    const Matrix N = 2.0 * half / half.norm() - whole / whole.norm();
    direction.add(N - Y / Y.norm(), 1.0);
  }
  EXPECT_GT(direction.count(), 150);
  expect_within(size, 1e-7, "Yeq");
  expect_within(direction, 1e-7, "direction of growth");
}

TEST(TensorDamageState, ForceAgainstDifferencesOfTheEnergyMonotone) { expect_force(true); }
TEST(TensorDamageState, ForceAgainstDifferencesOfTheEnergyFull) { expect_force(false); }

TEST(TensorDamageState, BoundOfUndamagedPoints) {
  test::Random random(64);
  for (double zeta : {1.0, 0.1}) {
    const TensorDamage law = law_of(true, zeta);
    test::Worst excess;
    for (int n = 0; n < 2000; ++n) {
      const Sym3<vd> e = test::on_all_lanes(0.01 * random.sym());
      const double bound = TensorDamage::square_bound(law.elasticity().stress(e), e)[0];
      const double Yeq = law.drive(e, Sym3<vd>{}).Yeq[0];
      excess.add(Yeq * Yeq / bound - 1.0);
    }
    expect_within(excess, 1e-13, "Yeq^2 over bound - 1, zeta " + std::to_string(zeta));
  }
}

// ------------------------------------------------------------------------------- onset

// Uniaxial stress at an angle to the axis. With n the direction, t across it in the plane of
// n and axis, S = n.(S0:nn).n = 1/E and H = t.(S0:nn).n, Y is sigma^2 (S nn + H (nt + tn)/2).
TEST(TensorDamageOnset, OffAxisUniaxialStress) {
  const VtiConstants c = test::calcite();
  const DamageReference reference(c);
  const TensorDamage full = law_of(false), monotone = law_of(true);
  test::Worst elastic, onset_full, onset_monotone;
  for (int degrees = 0; degrees <= 90; degrees += 5)
    for (double azimuth : {0.0, 0.7}) {
      const double a = degrees * M_PI / 180, C = std::cos(a), s = std::sin(a);
      const Vector n(s * std::cos(azimuth), s * std::sin(azimuth), C);
      const double S = s * s * s * s / c.Ep + C * C * C * C / c.Ez + s * s * C * C * (1 / c.Gzp - 2 * c.nu_zp / c.Ez);
      // t = -dn/da
      const double H = s * C * (C * C * (1 / c.Ez + c.nu_zp / c.Ez) - s * s * (1 / c.Ep + c.nu_zp / c.Ez) + (s * s - C * C) / (2 * c.Gzp));
      const double sigma_full = std::sqrt(kB0 / std::sqrt(0.5 * (S * S + 0.5 * H * H)));
      // the positive eigenvalue of ((S, H/2), (H/2, 0))
      const double positive = 0.5 * (S + std::sqrt(S * S + H * H));
      const double sigma_monotone = std::sqrt(std::sqrt(2.0) * kB0 / positive);
      const std::string where = std::to_string(degrees) + " degrees";

      const Matrix unit = n * n.transpose(), e = reference.elastic_strain(unit);
      const Matrix stress = tensor(full.stress(test::on_all_lanes(sigma_full * e), Sym3<vd>{}), 0);
      elastic.add(stress / sigma_full - unit, 1.0, where);
      elastic.add(std::fabs(n.dot(e * n) / S - 1.0), where);
      onset_full.add(std::fabs(equivalent_at(full, sigma_full * e, Matrix::Zero()) / kB0 - 1.0), where);
      onset_monotone.add(std::fabs(equivalent_at(monotone, sigma_monotone * e, Matrix::Zero()) / kB0 - 1.0), where);
      EXPECT_FALSE(grows(full, (1 - 1e-12) * sigma_full * e)) << where;
      EXPECT_TRUE(grows(full, (1 + 1e-12) * sigma_full * e)) << where;
      EXPECT_FALSE(grows(monotone, (1 - 1e-12) * sigma_monotone * e)) << where;
      EXPECT_TRUE(grows(monotone, (1 + 1e-12) * sigma_monotone * e)) << where;
    }
  expect_within(elastic, 1e-12, "elastic response");
  expect_within(onset_full, 1e-12, "onset");
  expect_within(onset_monotone, 1e-12, "onset of the positive part");
}

// f_c = f_t/zeta; in shear the weight is (1 + zeta^2)/2.
TEST(TensorDamageOnset, CompressiveStrength) {
  const VtiConstants iso = VtiConstants::isotropic(60e9, 0.3);
  for (double zeta : {0.1, 0.35, 1.0}) {
    test::Worst worst;
    for (const VtiConstants& c : {test::calcite(), iso})
      for (int axis : {0, 2}) {
        const TensorDamage law = law_of(true, zeta, c);
        const DamageReference reference(c);
        const double ft = std::pow(2.0, 0.25) * std::sqrt(kB0 * (axis == 2 ? c.Ez : c.Ep));
        Matrix unit = Matrix::Zero();
        unit(axis, axis) = 1.0;
        const Matrix e = reference.elastic_strain(unit);
        worst.add(std::fabs(std::sqrt(equivalent_at(law, ft * e, Matrix::Zero()) / kB0) - 1.0), "tension");
        worst.add(std::fabs(std::sqrt(equivalent_at(law, -ft / zeta * e, Matrix::Zero()) / kB0) - 1.0), "compression");
        EXPECT_FALSE(grows(law, -(1 - 1e-12) * ft / zeta * e));
        EXPECT_TRUE(grows(law, -(1 + 1e-12) * ft / zeta * e));
        EXPECT_FALSE(grows(law, (1 - 1e-12) * ft * e));
        EXPECT_TRUE(grows(law, (1 + 1e-12) * ft * e));
      }
    const TensorDamage law = law_of(true, zeta, iso);
    const double G = iso.Gzp, tau = std::sqrt(2 * G * kB0) * std::sqrt(2.0 / (1.0 + zeta * zeta));
    Matrix e = Matrix::Zero();
    e(0, 1) = e(1, 0) = tau / (2 * G);
    worst.add(std::fabs(std::sqrt(equivalent_at(law, e, Matrix::Zero()) / kB0) - 1.0), "shear");
    expect_within(worst, 1e-12, "strength, zeta " + std::to_string(zeta));
  }
}

}  // namespace
}  // namespace mpdem
