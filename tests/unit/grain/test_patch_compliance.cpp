// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Numbers are those of tests/verification/elastic_sphere.py, whose sphere finite elements confirm.
#include "grain/patch_compliance.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace mpdem {
namespace {

const double kInner = std::asin(0.2), kOuter = std::asin(0.4), kNu = 0.22;

// A sum of vector modes of radial function `radial` of each order, by harmonic and direction.
struct Part {
  int order;
  bool sine;
  int direction;
  double factor;
};
Eigen::VectorXd sum_of(const SurfaceModes& m, int radial, const std::vector<Part>& parts) {
  Eigen::VectorXd v = Eigen::VectorXd::Zero(m.size());
  for (const Part& p : parts) {
    int left = radial;
    for (int j = 0; j < m.scalars(); ++j) {
      const SurfaceModes::Harmonic& h = m.harmonics()[m.modes()[j].harmonic];
      if (h.order == p.order && h.sine == p.sine && left-- == 0) v[3 * j + p.direction] = p.factor;
    }
  }
  return v;
}

struct Case {
  double inner, zz, zz1, z1z1, torsion, radial, radial_z, xx, tilt_x, tilt, second, second_x;
};

class Patch : public ::testing::TestWithParam<Case> {};

TEST_P(Patch, ComplianceIsThatOfTheVerification) {
  const Case& c = GetParam();
  const SurfaceModes m(c.inner, kOuter, 6, 2);
  const Eigen::MatrixXd B = compliance_of_modes(m, kNu);
  const Eigen::VectorXd z = sum_of(m, 0, {{0, false, 2, 1.0}}), z1 = sum_of(m, 1, {{0, false, 2, 1.0}});
  const Eigen::VectorXd torsion = sum_of(m, 0, {{1, true, 0, -1.0}, {1, false, 1, 1.0}}),
                        radial = sum_of(m, 0, {{1, false, 0, 1.0}, {1, true, 1, 1.0}});
  const Eigen::VectorXd x = sum_of(m, 0, {{0, false, 0, 1.0}}), y = sum_of(m, 0, {{0, false, 1, 1.0}}),
                        tilt = sum_of(m, 0, {{1, false, 2, 1.0}});
  const Eigen::VectorXd second = sum_of(m, 0, {{2, false, 0, 1.0}, {2, true, 1, 1.0}});
  const auto expect = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b, double value) {
    EXPECT_NEAR(a.dot(B * b), value, 1e-10 * c.xx);
  };
  expect(z, z, c.zz);
  expect(z, z1, c.zz1);
  expect(z1, z1, c.z1z1);
  expect(torsion, torsion, c.torsion);
  expect(radial, radial, c.radial);
  expect(radial, z, c.radial_z);
  expect(x, x, c.xx);
  expect(y, y, c.xx);
  expect(x, y, 0.0);
  expect(tilt, x, c.tilt_x);
  expect(tilt, tilt, c.tilt);
  expect(second, second, c.second);
  expect(second, x, c.second_x);
}

INSTANTIATE_TEST_SUITE_P(RingAndCap, Patch,
                         ::testing::Values(Case{kInner, 0.1359888733305749, -0.011633573441430395, 0.03996258557531481, 0.36709287574916183,
                                                0.2164328812388945, 0.013623684896084542, 0.21818105214384248, -0.02687246132970139,
                                                0.10743970160427836, 0.1932226419890796, 0.0030991178140431907},
                                           Case{0.0, 0.18133139143571014, -0.03001969448162232, 0.07053824294702153, 0.38926191120043535,
                                                0.22760097326313478, 0.02898592479047741, 0.2987033151126659, -0.040977902353361614,
                                                0.11304264183334574, 0.18502069704724175, 0.017862939053462788}));

TEST(PatchModes, AreOrthonormal) {
  for (double inner : {0.0, kInner}) {
    const SurfaceModes m(inner, kOuter, 5, 2);
    constexpr int kRadial = 400, kAround = 16;
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(m.scalars(), m.scalars());
    const double top = std::cos(inner), bottom = std::cos(kOuter);
    std::vector<double> radial(m.radials()), harmonic(m.harmonics().size());
    Eigen::VectorXd v(m.scalars());
    for (int i = 0; i < kRadial; ++i) {
      // Simpson's rule would need the ends: midpoints in a variable whose slope vanishes there
      const double t = (i + 0.5) / kRadial, share = t * t * t * (10 - 15 * t + 6 * t * t), slope = 30 * t * t * (1 - t) * (1 - t);
      m.find_radials(top - share * (top - bottom), radial.data());
      for (int k = 0; k < kAround; ++k) {
        m.find_harmonics(std::cos(2 * M_PI * k / kAround), std::sin(2 * M_PI * k / kAround), harmonic.data());
        for (int j = 0; j < m.scalars(); ++j) v[j] = radial[m.modes()[j].radial] * harmonic[m.modes()[j].harmonic];
        G += (top - bottom) * slope / kRadial * 2 * M_PI / kAround * v * v.transpose();
      }
    }
    EXPECT_LT((G - Eigen::MatrixXd::Identity(m.scalars(), m.scalars())).norm(), 1e-6) << inner;
  }
}

TEST(PatchCompliance, HasATailBelowAllModes) {
  const SurfaceModes m(kInner, kOuter, 6, 2);
  const GrainElasticity glass{70e9, kNu};
  const PatchCompliance patch(m, glass, 5e-3);
  const Eigen::MatrixXd B = 5e-3 / glass.shear_modulus() * compliance_of_modes(m, kNu);
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(B).eigenvalues()[0];
  EXPECT_GT(least, 0.0);
  EXPECT_NEAR(patch.tail(), 0.5 * least, 1e-12 * least);
  const Eigen::MatrixXd left = B - patch.tail() * Eigen::MatrixXd::Identity(B.rows(), B.cols());
  EXPECT_LT((patch.factor() * patch.factor().transpose() - left).norm(), 1e-12 * left.norm());
}

}  // namespace
}  // namespace mpdem
