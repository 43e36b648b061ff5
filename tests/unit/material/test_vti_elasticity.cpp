// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/vti_elasticity.h"

#include <limits>

#include "damage_reference.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::Matrix6;
using test::sym3;
using test::tensor;

VtiConstants random_constants(test::Random& random) {
  return {random.uniform(1, 10), random.uniform(1, 10), random.uniform(-1.1, 1.1), random.uniform(-1.1, 1.1), random.uniform(0.5, 10)};
}

Matrix6 stiffness_of(const VtiElasticity& c) {
  Matrix6 C;
  for (int j = 0; j < 6; ++j) {
    test::Vector6 unit = test::Vector6::Zero();
    unit[j] = 1.0;
    C.col(j) = test::voigt(tensor(c.stress(sym3(test::from_voigt(unit, 2.0)))), 1.0);
  }
  return C;
}

TEST(VtiElasticity, StiffnessInvertsTheCompliance) {
  test::Random random(11);
  test::Worst worst;
  for (int n = 0; n < 2000; ++n) {
    const VtiConstants c = random_constants(random);
    const Matrix6 S = test::compliance(c);
    const Eigen::SelfAdjointEigenSolver<Matrix6> s(S);
    // Nearly singular sets only amplify the rounding of the input.
    if (s.eigenvalues()[0] < 0.05 * s.eigenvalues()[5]) continue;
    worst.add((stiffness_of(VtiElasticity(c)) * S - Matrix6::Identity()).cwiseAbs().maxCoeff());
  }
  expect_within(worst, 1e-13, "C S - 1");
}

TEST(VtiElasticity, ConditionsAreThoseOfAPositiveEnergy) {
  test::Random random(12);
  int accepted = 0, rejected = 0;
  for (int n = 0; n < 20000; ++n) {
    const VtiConstants c = random_constants(random);
    const double least = Eigen::SelfAdjointEigenSolver<Matrix6>(test::compliance(c)).eigenvalues()[0];
    if (std::fabs(least) < 1e-12) continue;
    const bool ok = c.violated_condition().empty();
    ASSERT_EQ(ok, least > 0.0) << c.Ep << " " << c.Ez << " " << c.nu_p << " " << c.nu_zp << " " << c.Gzp;
    ++(ok ? accepted : rejected);
  }
  EXPECT_GT(accepted, 3000);
  EXPECT_GT(rejected, 3000);
}

TEST(VtiElasticity, ViolatedConditionNamesTheConstant) {
  const VtiConstants good = test::calcite();
  EXPECT_EQ(good.violated_condition(), "");
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto expect_named = [&](double VtiConstants::*member, double value, const char* name) {
    VtiConstants c = good;
    c.*member = value;
    EXPECT_NE(c.violated_condition().find(name), std::string::npos) << c.violated_condition();
  };
  for (double bad : {0.0, -1.0, nan}) {
    expect_named(&VtiConstants::Ep, bad, "Ep");
    expect_named(&VtiConstants::Ez, bad, "Ez");
    expect_named(&VtiConstants::Gzp, bad, "Gzp");
  }
  for (double bad : {1.0, -1.0, nan}) expect_named(&VtiConstants::nu_p, bad, "nu_p");
  for (double bad : {0.9, -0.9, nan}) expect_named(&VtiConstants::nu_zp, bad, "nu_zp");
  expect_named(&VtiConstants::Gzp, inf, "finite");
}

TEST(VtiElasticity, IsotropicLimit) {
  const double E = 60e9, nu = 0.3, G = 0.5 * E / (1 + nu), lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  const VtiElasticity c(VtiConstants::isotropic(E, nu));
  test::Random random(13);
  test::Worst worst;
  for (int n = 0; n < 100; ++n) {
    const Matrix e = random.sym(), s = lambda * e.trace() * Matrix::Identity() + 2 * G * e;
    worst.add(tensor(c.stress(sym3(e))) - s, s.norm());
  }
  expect_within(worst, 1e-14, "stress");
}

TEST(VtiElasticity, TurningAboutTheAxisChangesNothing) {
  const VtiElasticity c(test::calcite());
  test::Random random(14);
  test::Worst worst;
  for (int n = 0; n < 100; ++n) {
    const Matrix q = test::rotation({0, 0, 1}, random.uniform(-3, 3)), e = random.sym();
    const Matrix s = q * tensor(c.stress(sym3(e))) * q.transpose();
    worst.add(tensor(c.stress(sym3(q * e * q.transpose()))) - s, s.norm());
  }
  expect_within(worst, 1e-14, "stress");
}

TEST(VtiElasticity, SpeedOfTheFastestWaveAlongAxisOrPlane) {
  test::Random random(15);
  test::Worst worst;
  for (int n = 0; n < 500; ++n) {
    const VtiConstants constants = random_constants(random);
    if (!constants.violated_condition().empty()) continue;
    const VtiElasticity c(constants);
    double fastest = 0.0;
    for (int d = 0; d < 3; ++d) {
      // Christoffel: column j is the traction on plane d of a shear d (x) j
      Matrix acoustic;
      for (int j = 0; j < 3; ++j) {
        Matrix gradient = Matrix::Zero();
        gradient(j, d) = 1.0;
        acoustic.col(j) = tensor(c.stress(sym3(test::symmetric(gradient)))).col(d);
      }
      fastest = std::max(fastest, Eigen::SelfAdjointEigenSolver<Matrix>(acoustic).eigenvalues()[2]);
    }
    worst.add(std::fabs(c.fastest_wave(2.0) / std::sqrt(fastest / 2.0) - 1.0));
  }
  expect_within(worst, 1e-13, "speed");
}

TEST(VtiElasticity, LargestStiffnessIsTheLargestEigenvalue) {
  test::Random random(16);
  test::Worst worst;
  for (int n = 0; n < 500; ++n) {
    const VtiConstants constants = random_constants(random);
    if (!constants.violated_condition().empty()) continue;
    const VtiElasticity c(constants);
    Matrix6 mandel = stiffness_of(c);
    mandel.bottomRows<3>() *= std::sqrt(2.0);
    mandel.rightCols<3>() *= std::sqrt(2.0);
    worst.add(std::fabs(c.largest_stiffness() / Eigen::SelfAdjointEigenSolver<Matrix6>(mandel).eigenvalues()[5] - 1.0));
  }
  expect_within(worst, 1e-13, "eigenvalue");
}

}  // namespace
}  // namespace mpdem
