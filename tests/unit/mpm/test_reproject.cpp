// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/reproject.h"

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCalcite;
using test::kCell;
using test::Matrix;
using test::Vector;

struct Burdened : Cement {
  std::vector<double> added;  // mass

  explicit Burdened(test::Random& random) : Cement(kCell, test::scattered(random, kCell, 4, 6), kCell * kCell * kCell / 6) {
    grid.lump_mass(points, kCalcite);
    for (double m : grid.mass) added.push_back(random.index(3) ? 0.0 : random.uniform(0, 2) * m);
  }
  double inertia(int node) const { return grid.mass[node] + added[node]; }
  double inner_product(const std::vector<double>& a, const std::vector<double>& b) const {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += inertia(static_cast<int>(i / 3)) * a[i] * b[i];
    return sum;
  }
};

TEST(Reproject, LinearFieldsPassUnchanged) {
  test::Random random(121);
  Burdened c(random);
  const Matrix A = random.general();
  const Vector v0 = random.vector();
  c.set_velocity([&](const Vector& X) { return Vector(A * X / kCell + v0); });
  const std::vector<double> before = c.grid.velocity;
  std::vector<double> jump;
  reproject_velocity(c.points, c.grid, c.added, kCalcite, Transfer(), 0.0, jump);
  test::Worst worst;
  for (std::size_t i = 0; i < before.size(); ++i) {
    worst.add(std::fabs(c.grid.velocity[i] - before[i]) / 5.0);
    worst.add(std::fabs(jump[i]) / 5.0);
  }
  expect_within(worst, 1e-13, "change of the velocity");
}

TEST(Reproject, KeepsMomentumAndMomentOfMomentum) {
  test::Random random(122);
  Burdened c(random);
  c.set_velocity([&](const Vector&) { return random.vector(); });
  const std::vector<double> before = c.grid.velocity;
  std::vector<double> jump;
  reproject_velocity(c.points, c.grid, c.added, kCalcite, Transfer(), 0.0, jump);
  Vector p = Vector::Zero(), L = Vector::Zero();
  double p_size = 0, L_size = 0, moved = 0;
  for (int n = 0; n < c.grid.size(); ++n) {
    const Vector dp = c.inertia(n) * c.at(jump, n);
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
  Burdened c(random);
  std::vector<double> jump;
  test::Worst asymmetry, gain, loss;
  const auto project = [&](const std::vector<double>& v) {
    c.grid.velocity = v;
    reproject_velocity(c.points, c.grid, c.added, kCalcite, Transfer(), 0.0, jump);
    return c.grid.velocity;
  };
  const auto field = [&] {
    std::vector<double> v(c.grid.velocity.size());
    for (double& x : v) x = random.uniform(-1, 1);
    return v;
  };
  for (int n = 0; n < 10; ++n) {
    const std::vector<double> a = field(), b = field(), Pa = project(a), Pb = project(b);
    const double aa = c.inner_product(a, a);
    asymmetry.add(std::fabs(c.inner_product(a, Pb) - c.inner_product(Pa, b)) / aa);
    gain.add(c.inner_product(a, Pa) / aa - 1.0);
    loss.add(-c.inner_product(a, Pa) / aa);
  }
  // the field that gains most: power iteration on P, which ends among the linear fields
  std::vector<double> v = field();
  for (int n = 0; n < 200; ++n) {
    const std::vector<double> w = project(v);
    gain.add(std::sqrt(c.inner_product(w, w) / c.inner_product(v, v)) - 1.0);
    v = w;
  }
  expect_within(asymmetry, 1e-14, "asymmetry");
  expect_within(gain, 1e-13, "gain");
  expect_within(loss, 0.0, "negative product");
}

// All methods follow from the one map y: xpic is a polynomial of it, and flip with nothing to keep is y itself.
// Each keeps momentum.
TEST(Reproject, MethodsArePolynomialsOfOneMap) {
  test::Random random(124);
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic}) {
    Cement c(kCell, test::scattered(random, kCell, 4, 6), kCell * kCell * kCell / 6, Eigen::Quaterniond::Identity(), basis);
    c.grid.lump_mass(c.points, kCalcite);
    std::vector<double> v(c.grid.velocity.size()), jump;
    for (double& x : v) x = random.uniform(-1, 1);
    for (double& a : c.grid.acceleration) a = random.uniform(-1, 1);
    const auto apply = [&](const std::vector<double>& field, Transfer::Method method, int order, double A, double dt) {
      c.grid.velocity = field;
      Transfer t;
      t.method = method;
      t.order = order;
      t.flip_share = A;
      reproject_velocity(c.points, c.grid, {}, kCalcite, t, dt, jump);
      return c.grid.velocity;
    };
    const auto combine = [](double a, const std::vector<double>& x, double b, const std::vector<double>& y) {
      std::vector<double> r(x.size());
      for (std::size_t i = 0; i < r.size(); ++i) r[i] = a * x[i] + b * y[i];
      return r;
    };
    const auto y = [&](const std::vector<double>& f) { return apply(f, Transfer::flip, 1, 0.0, 0.0); };
    const std::vector<double> a = c.grid.acceleration, yv = y(v), yyv = y(yv), ya = y(a);
    // 1 - (1 - y)^2 = 2 y - y^2
    const std::vector<double> cases[][2] = {{apply(v, Transfer::xpic, 1, 0, 0), yv},
                                            {apply(v, Transfer::xpic, 2, 0, 0), combine(2, yv, -1, yyv)},
                                            {apply(v, Transfer::flip, 1, 0.0, 0.5), combine(1, combine(1, yv, 0.5, ya), -0.5, a)},
                                            {apply(v, Transfer::flip, 1, 1.0, 0.5), combine(1, combine(1, v, 0.5, ya), -0.5, a)}};
    test::Worst worst;
    for (const auto& pair : cases)
      for (std::size_t i = 0; i < v.size(); ++i) worst.add(std::fabs(pair[0][i] - pair[1][i]));
    expect_within(worst, 1e-13, "method against polynomial");
    // what xpic 2 makes of the velocity before the kick, seen by the points: y q(y) = 2 y - y^2
    c.grid.velocity = v;
    filter_velocity(c.points, c.grid, {}, kCalcite, 2);
    const std::vector<double> filtered = c.grid.velocity, through = y(filtered), exact = combine(2, yv, -1, yyv);
    test::Worst filter;
    for (std::size_t i = 0; i < v.size(); ++i) filter.add(std::fabs(through[i] - exact[i]));
    expect_within(filter, 1e-13, "filter");
  }
}

}  // namespace
}  // namespace mpdem
