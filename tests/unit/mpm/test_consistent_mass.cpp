// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The consistent mass against its definition, and what its bound and its momentum depend on.
#include "mpm/consistent_mass.h"

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCalcite;
using test::kCell;
using test::Vector;

std::vector<Vector> ball(test::Random& random) {
  std::vector<Vector> X;
  while (X.size() < 150) {
    const Vector x(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
    if (x.norm() < 2.0) X.push_back(kCell * (x + Vector(0.2, -0.1, 0.3)));
  }
  return X;
}

class MassOfPoints : public ::testing::TestWithParam<Basis> {
 protected:
  test::Random random{5};
  double volume = std::pow(kCell, 3) / 8;
  Cement c{kCell, ball(random), volume, Eigen::Quaterniond::Identity(), GetParam(), 0, {}, true};  // with blocks of two cells

  void tie() {
    c.grid.lump_mass(c.points, kCalcite);  // by which edges are found
    c.grid.constrain(find_extension_constraints(MPI_COMM_SELF, GetParam(), test::edges_of(c.grid)), true);
    ASSERT_GT(c.grid.constraints.size(), 5u);
  }
  std::vector<double> any_field() {
    std::vector<double> f(3 * c.grid.size());
    for (double& x : f) x = random.uniform(-1, 1);
    for (int i = 0; i < c.grid.size(); ++i)
      for (int d = 0; d < 3 && c.grid.mass[i] == 0.0; ++d) f[3 * i + d] = 0.0;
    return f;
  }
  std::vector<double> product(const std::vector<double>& field) {
    std::vector<double> out(field.size(), 0.0);
    add_consistent_mass(c.points, c.grid, kCalcite, MassOf::all_points, 1.0, field, out);
    return out;
  }
  static double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  }
};

// Weights of one node alone, from where its value is one; all others are at zero.
TEST_P(MassOfPoints, IsTheSumOverPoints) {
  c.grid.lump_mass(c.points, kCalcite);
  const double all = std::accumulate(c.grid.mass.begin(), c.grid.mass.end(), 0.0);
  const std::vector<double> f = any_field(), out = product(f);
  std::vector<double> expected(f.size(), 0.0);
  with_basis(GetParam(), [&](auto type) {
    using Type = decltype(type);
    for (const PointBlock& p : c.points.blocks)
      for (int l = 0; l < kLanes; ++l) {
        if (p.volume[l] == 0.0) continue;
        const vd X[3] = {splat(p.X[0][l]), splat(p.X[1][l]), splat(p.X[2][l])};
        int base[3];
        for (int d = 0; d < 3; ++d) base[d] = support_base(X[d][0], 1.0 / kCell, Type::kShift);
        const Weights<Type> w(X, base, 1.0 / kCell);
        std::vector<std::pair<int, double>> N;
        for (int n = 0; n < c.grid.size(); ++n) {
          double weight = 1.0;
          for (int d = 0; d < 3; ++d) {
            const int i = c.grid.keys[n].at(d) - base[d];
            weight *= i >= 0 && i < Type::kSupport ? w.w[d][i][0] : 0.0;
          }
          if (weight != 0.0) N.emplace_back(n, weight);
        }
        for (const auto& [i, Ni] : N)
          for (const auto& [j, Nj] : N)
            for (int d = 0; d < 3; ++d) expected[3 * i + d] += kCalcite * p.volume[l] * Ni * Nj * f[3 * j + d];
      }
  });
  for (std::size_t i = 0; i < f.size(); ++i) EXPECT_NEAR(out[i], expected[i], 1e-13 * all);
}

// Momentum: the sum of M a is that of M_L a. The bound of the step: 0 <= M <= M_L. Symmetry keeps energy.
TEST_P(MassOfPoints, HasTheLumpedMassForRowSumsWithTiesToo) {
  for (bool tied : {false, true}) {
    if (tied) tie();
    c.grid.lump_mass(c.points, kCalcite);
    const double all = std::accumulate(c.grid.mass.begin(), c.grid.mass.end(), 0.0);
    std::vector<double> one(3 * c.grid.size(), 0.0);
    for (int i = 0; i < c.grid.size(); ++i) one[3 * i + 1] = c.grid.mass[i] > 0.0;
    const std::vector<double> rows = product(one);
    for (int i = 0; i < c.grid.size(); ++i) EXPECT_NEAR(rows[3 * i + 1], c.grid.mass[i], 1e-13 * all);
    for (int n = 0; n < 20; ++n) {
      const std::vector<double> a = any_field(), b = any_field(), Ma = product(a), Mb = product(b);
      double lumped = 0.0;
      for (std::size_t i = 0; i < a.size(); ++i) lumped += c.grid.mass[i / 3] * a[i] * a[i];
      EXPECT_GE(dot(a, Ma), 0.0);
      EXPECT_LE(dot(a, Ma), lumped);
      EXPECT_NEAR(dot(a, Mb), dot(b, Ma), 1e-13 * lumped);
    }
  }
}

// Where points failed, a rigid acceleration has no inertial force. Any other acceleration has none in sum.
TEST_P(MassOfPoints, InertialForceOfWhatHoldsHasNoResultant) {
  tie();
  c.grid.lump_mass(c.points, kCalcite);
  ConsistentMass mass;
  for (int failing : {0, 3, 60}) {
    for (int n = 0; n < failing; ++n) c.points.meta[c.slots[2 * n] / kLanes].failed |= 1 << c.slots[2 * n] % kLanes;
    mass = ConsistentMass();
    double largest = 0.0;
    for (bool rigid : {false, true}) {
      c.grid.acceleration = any_field();
      if (rigid) c.grid.acceleration.assign(3 * c.grid.size(), 2.0);
      mass.find_inertial_force(c.points, c.grid, kCalcite);
      double sum[3] = {0, 0, 0}, most = 0.0;
      for (std::size_t n = 0; n < c.grid.inertial_force.size(); ++n) {
        sum[n % 3] += c.grid.inertial_force[n];
        most = std::max(most, std::fabs(c.grid.inertial_force[n]));
      }
      if (!rigid) largest = most;
      EXPECT_GT(largest, 0.0);
      for (double s : sum) EXPECT_NEAR(s, 0.0, 1e-12 * largest);
      if (rigid) {
        EXPECT_LT(most, 1e-12 * largest);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Bases, MassOfPoints, ::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic),
                         [](const ::testing::TestParamInfo<Basis>& p) {
                           return std::string(p.param == Basis::linear ? "linear" : p.param == Basis::quadratic ? "quadratic" : "cubic");
                         });

}  // namespace
}  // namespace mpdem
