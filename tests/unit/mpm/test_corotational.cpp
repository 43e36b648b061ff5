// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/corotational.h"

#include <vector>

#include "damage_reference.h"
#include "material/tensor_damage.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::Vector;

struct Points {
  Mat3<vd> F{};
  Frame q{};
  Sym3<vd> strain{};

  Points() {
    q.w = splat(1.0);
    for (int l = 0; l < kLanes; ++l) test::set_matrix(F, l, Matrix::Identity());
  }
  void turn(int l, const Eigen::Quaterniond& r) {
    q.w[l] = r.w();
    q.x[l] = r.x();
    q.y[l] = r.y();
    q.z[l] = r.z();
  }
  void advance(const Mat3<vd>& dF) {
    advance_strain(F, dF, q, strain);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) F.a[i][j] += dF.a[i][j];
  }
  // Advances to the deformation gradient F_new(lane).
  template <class Function>
  void advance_to(Function F_new) {
    Mat3<vd> dF{};
    for (int l = 0; l < kLanes; ++l) test::set_matrix(dF, l, F_new(l) - test::matrix(F, l));
    advance(dF);
  }
};

TEST(Corotational, RotationMatrixOfAFrame) {
  test::Random random(51);
  test::Worst worst;
  Points p;
  for (int n = 0; n < 20; ++n) {
    Matrix expected[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      expected[l] = random.frame();
      p.turn(l, Eigen::Quaterniond(expected[l]));
    }
    const Mat3<vd> R = rotation_matrix(p.q);
    for (int l = 0; l < kLanes; ++l) worst.add(test::matrix(R, l) - expected[l], 1.0);
  }
  expect_within(worst, 1e-14, "matrix");
}

// Q(W) = (1 - W/2)^-1 (1 + W/2)
TEST(Corotational, SpinIsTheCayleyRotation) {
  test::Random random(52);
  test::Worst worst;
  for (int n = 0; n < 20; ++n) {
    Points p;
    Vector w[kLanes];
    Matrix before[kLanes];
    vd v[3];
    for (int l = 0; l < kLanes; ++l) {
      before[l] = random.frame();
      p.turn(l, Eigen::Quaterniond(before[l]));
      w[l] = 3.0 * random.vector();
      for (int d = 0; d < 3; ++d) v[d][l] = w[l][d];
    }
    const Mat3<vd> after = rotation_matrix(spun(unnormalised_product(p.q, v[0], v[1], v[2]), v[0], v[1], v[2]));
    for (int l = 0; l < kLanes; ++l) {
      Matrix W;
      W << 0, -w[l][2], w[l][1], w[l][2], 0, -w[l][0], -w[l][1], w[l][0], 0;
      const Matrix Q = (Matrix::Identity() - 0.5 * W).inverse() * (Matrix::Identity() + 0.5 * W);
      worst.add(test::matrix(after, l) - Q * before[l], 1.0);
    }
  }
  expect_within(worst, 1e-14, "matrix");
}

// A stressed, damaged point with a tilted axis rotates ten times about its own direction in
// every lane, in n steps a revolution.
class TenRevolutions : public ::testing::TestWithParam<int> {};

TEST_P(TenRevolutions, StrainStaysAndStressDamageAndAxisReturn) {
  const int n = GetParam();
  test::Random random(53);
  DamageParameters parameters;
  parameters.B0 = 9.6e6;
  const TensorDamage law(VtiElasticity(test::calcite()), parameters);

  Points p;
  Sym3<vd> D{};
  Vector axis[kLanes];
  Matrix start[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    axis[l] = random.direction();
    p.turn(l, Eigen::Quaterniond(random.frame()));
    start[l] = Matrix::Identity() + 0.01 * random.general();
  }
  p.advance_to([&](int l) { return start[l]; });
  law.update(Sym3<vd>{}, p.strain, D, splat_mask(true));
  const Points begin = p;
  const Sym3<vd> D_begin = D, stress = law.stress(p.strain, D);
  const Mat3<vd> R_begin = rotation_matrix(p.q);

  test::Worst strain_change, stress_error, frame_error, damage_error;
  for (int step = 1; step <= 10 * n; ++step) {
    const Sym3<vd> before = p.strain;
    p.advance_to([&](int l) { return Matrix(test::rotation(axis[l], 2 * M_PI * step / n) * start[l]); });
    law.update(before, p.strain, D, splat_mask(true));
    const Mat3<vd> R = rotation_matrix(p.q);
    const Sym3<vd> s = law.stress(p.strain, D);
    for (int l = 0; l < kLanes; ++l) {
      const Matrix turn = test::rotation(axis[l], 2 * M_PI * step / n), Rl = test::matrix(R, l), R0 = test::matrix(R_begin, l),
                   sl = Rl * test::tensor(s, l) * Rl.transpose(), s0 = R0 * test::tensor(stress, l) * R0.transpose(),
                   Dl = Rl * test::tensor(D, l) * Rl.transpose(), D0 = R0 * test::tensor(D_begin, l) * R0.transpose();
      // at every step, not only after whole revolutions
      const Matrix e0 = test::tensor(begin.strain, l);
      strain_change.add(test::tensor(p.strain, l) - e0, e0.norm());
      stress_error.add(sl - turn * s0 * turn.transpose(), s0.norm());
      damage_error.add(Dl - turn * D0 * turn.transpose(), 1.0);
      frame_error.add(Rl - turn * R0, 1.0);
    }
  }
  int damaged = 0;
  for (int l = 0; l < kLanes; ++l) damaged += test::tensor(D, l).norm() > 0.01;
  EXPECT_GT(damaged, 0);
  expect_within(strain_change, 1e-12, "strain change over strain");
  expect_within(stress_error, 1e-12, "stress");
  expect_within(damage_error, 1e-12, "damage");
  expect_within(frame_error, 1e-12, "axis");
}

INSTANTIATE_TEST_SUITE_P(Corotational, TenRevolutions, ::testing::Values(4, 7, 100));

// A rotation laid over a deformation rotates the stress and leaves the strain, but for the
// mid-point rule, which sees the mean of a deformation that grows while it rotates.
TEST(Corotational, SuperposedRotationIsNotSeenToSecondOrder) {
  const auto error_at = [](int steps) {
    test::Random random(54);
    Points plain, turned;
    Matrix rate[kLanes];
    Vector axis[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      rate[l] = 0.01 * random.general();
      axis[l] = random.direction();
    }
    for (int step = 1; step <= steps; ++step) {
      const auto F = [&](int l) { return Matrix(Matrix::Identity() + rate[l] * (double(step) / steps)); };
      plain.advance_to(F);
      turned.advance_to([&](int l) { return Matrix(test::rotation(axis[l], 2.0 * step / steps) * F(l)); });
    }
    test::Worst worst;
    for (int l = 0; l < kLanes; ++l)
      worst.add(test::tensor(plain.strain, l) - test::tensor(turned.strain, l), test::tensor(plain.strain, l).norm());
    return worst.value();
  };
  test::expect_within(std::fabs(std::log2(error_at(64) / error_at(128)) - 2.0), 0.02, "order minus 2");
}

// Simple shear with the Jaumann rate: s12 = G sin g, s11 = -s22 = G (1 - cos g).
TEST(Corotational, SimpleShearIsSecondOrder) {
  const double G = 23e9;
  const VtiElasticity elastic(VtiConstants::isotropic(2 * G * 1.3, 0.3));
  const auto error_at = [&](int steps) {
    Points p;
    test::Worst worst;
    for (int step = 1; step <= steps; ++step) {
      const double g = 4.0 * step / steps;
      p.advance_to([&](int) {
        Matrix F = Matrix::Identity();
        F(0, 1) = g;
        return F;
      });
      const Sym3<vd> s = rotate(rotation_matrix(p.q), elastic.stress(p.strain));
      Matrix exact = Matrix::Zero();
      exact(0, 1) = exact(1, 0) = G * std::sin(g);
      exact(0, 0) = G * (1 - std::cos(g));
      exact(1, 1) = -exact(0, 0);
      for (int l = 0; l < kLanes; ++l) worst.add(test::tensor(s, l) - exact, G);
    }
    return worst.value();
  };
  const double e100 = error_at(100), e200 = error_at(200), e400 = error_at(400);
  test::expect_within(e400, 2e-5, "error over G at 400 steps");
  test::expect_within(std::fabs(std::log2(e100 / e200) - 2.0), 0.02, "order, 100 to 200 steps, minus 2");
  test::expect_within(std::fabs(std::log2(e200 / e400) - 2.0), 0.02, "order, 200 to 400 steps, minus 2");
}

TEST(Corotational, StretchAlongAnAxisIsTheLogarithmicStrain) {
  const auto error_at = [](int steps) {
    Points p;
    for (int step = 1; step <= steps; ++step)
      p.advance_to([&](int l) {
        Matrix F = Matrix::Identity();
        F(l % 3, l % 3) = 1.0 + 0.5 * step / steps;
        return F;
      });
    test::Worst worst;
    for (int l = 0; l < kLanes; ++l) {
      Matrix exact = Matrix::Zero();
      exact(l % 3, l % 3) = std::log(1.5);
      worst.add(test::tensor(p.strain, l) - exact, 1.0);
    }
    return worst.value();
  };
  test::expect_within(std::fabs(std::log2(error_at(50) / error_at(100)) - 2.0), 0.02, "order minus 2");
}

TEST(Corotational, FrameStaysNormalised) {
  test::Random random(55);
  Points p;
  vd w[3];
  for (int l = 0; l < kLanes; ++l)
    for (int d = 0; d < 3; ++d) w[d][l] = random.uniform(-1, 1);
  for (int n = 0; n < 100000; ++n) p.q = spun(unnormalised_product(p.q, w[0], w[1], w[2]), w[0], w[1], w[2]);
  test::Worst worst;
  for (int l = 0; l < kLanes; ++l) {
    const double w0 = p.q.w[l], x = p.q.x[l], y = p.q.y[l], z = p.q.z[l];
    worst.add(std::fabs(std::sqrt(w0 * w0 + x * x + y * y + z * z) - 1.0));
  }
  expect_within(worst, 1e-15, "norm");
}

}  // namespace
}  // namespace mpdem
