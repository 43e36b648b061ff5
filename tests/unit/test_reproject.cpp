// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/reproject.h"

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::Matrix;
using test::Vector;

constexpr double kH = 1e-4, kDensity = 2710;

Cement some_cement(test::Random& random) {
  Cement c(kH, test::scattered(random, kH, 4, 6), kH * kH * kH / 6);
  c.grid.lump_mass(c.points, kDensity);
  for (int n = 0; n < c.grid.size(); ++n)
    c.grid.added_mass[n] = random.index(3) ? 0.0 : random.uniform(0, 2) * c.grid.mass[n];
  return c;
}

double inertia(const Grid& g, int node) { return g.mass[node] + g.added_mass[node]; }

double inner_product(const Grid& g, const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += inertia(g, static_cast<int>(i / 3)) * a[i] * b[i];
  return sum;
}

TEST(Reproject, LinearFieldsPassUnchanged) {
  test::Random random(121);
  Cement c = some_cement(random);
  const Matrix A = random.general();
  const Vector v0 = random.vector();
  c.set_velocity([&](const Vector& X) { return Vector(A * X / kH + v0); });
  const std::vector<double> before = c.grid.velocity;
  std::vector<double> jump;
  reproject_velocity(c.points, c.grid, kDensity, jump);
  test::Worst worst;
  for (std::size_t i = 0; i < before.size(); ++i) {
    worst.add(std::fabs(c.grid.velocity[i] - before[i]) / 5.0);
    worst.add(std::fabs(jump[i]) / 5.0);
  }
  expect_within(worst, 1e-13, "change of the velocity");
}

TEST(Reproject, KeepsMomentumAndMomentOfMomentum) {
  test::Random random(122);
  Cement c = some_cement(random);
  c.set_velocity([&](const Vector&) { return random.vector(); });
  const std::vector<double> before = c.grid.velocity;
  std::vector<double> jump;
  reproject_velocity(c.points, c.grid, kDensity, jump);
  Vector p = Vector::Zero(), L = Vector::Zero();
  double p_size = 0, L_size = 0, moved = 0;
  for (int n = 0; n < c.grid.size(); ++n) {
    const Vector dp = inertia(c.grid, n) * c.at(jump, n);
    p += dp;
    L += c.place(n).cross(dp);
    p_size += dp.norm();
    L_size += c.place(n).norm() * dp.norm();
    moved = std::max(moved, c.at(jump, n).norm());
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(c.grid.velocity[3 * n + d], before[3 * n + d] + jump[3 * n + d], 1e-15);
  }
  EXPECT_GT(moved, 0.1);
  test::expect_within(p.norm() / p_size, 1e-14, "momentum");
  test::expect_within(L.norm() / L_size, 1e-14, "moment of momentum");
}

// <a, P b> = <P a, b> and 0 <= <a, P a> <= <a, a>.
TEST(Reproject, IsSymmetricAndNeverAddsEnergy) {
  test::Random random(123);
  Cement c = some_cement(random);
  std::vector<double> jump;
  test::Worst asymmetry, gain, loss;
  const auto project = [&](const std::vector<double>& v) {
    c.grid.velocity = v;
    reproject_velocity(c.points, c.grid, kDensity, jump);
    return c.grid.velocity;
  };
  const auto field = [&] {
    std::vector<double> v(c.grid.velocity.size());
    for (double& x : v) x = random.uniform(-1, 1);
    return v;
  };
  for (int n = 0; n < 10; ++n) {
    const std::vector<double> a = field(), b = field(), Pa = project(a), Pb = project(b);
    const double aa = inner_product(c.grid, a, a);
    asymmetry.add(std::fabs(inner_product(c.grid, a, Pb) - inner_product(c.grid, Pa, b)) / aa);
    gain.add(inner_product(c.grid, a, Pa) / aa - 1.0);
    loss.add(-inner_product(c.grid, a, Pa) / aa);
  }
  // the field that gains most: power iteration on P, which ends among the linear fields
  std::vector<double> v = field();
  for (int n = 0; n < 200; ++n) {
    const std::vector<double> w = project(v);
    gain.add(std::sqrt(inner_product(c.grid, w, w) / inner_product(c.grid, v, v)) - 1.0);
    v = w;
  }
  expect_within(asymmetry, 1e-14, "asymmetry");
  expect_within(gain, 1e-13, "gain");
  expect_within(loss, 0.0, "negative product");
}

}  // namespace
}  // namespace mpdem
