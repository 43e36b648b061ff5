// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Tests of points and grid together: fields they have to reproduce, and quantities they conserve.
#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCell;
using test::law_of;
using test::Matrix;
using test::Vector;

constexpr int kCells = 5;

// Global Kirchhoff stress of a point.
Matrix stress_of(const Cement& c, const NoDamage& law, int b, int l) {
  const PointBlock& p = c.points.blocks[b];
  const Matrix R = test::matrix(rotation_matrix(p.q), l);
  return R * test::tensor(law.stress(p.strain, {}), l) * R.transpose();
}

class LinearField : public ::testing::TestWithParam<double> {};

TEST_P(LinearField, UniformStrainAndStressOnScatteredPoints) {
  const double size = GetParam(), dt = 1e-9;
  test::Random random(91);
  const Eigen::Quaterniond axis(random.frame());
  Cement c(kCell, test::scattered(random, kCell, kCells, 9), kCell * kCell * kCell / 9, axis);
  const NoDamage law(test::elastic_calcite());
  const Matrix A = size * random.general(), B = size * random.general();
  const Vector v0 = 100.0 * random.vector();

  // two steps, the second from a deformed state
  c.set_velocity([&](const Vector& X) { return Vector(A * X / dt + v0); });
  c.advance(law, dt);
  c.set_velocity([&](const Vector& X) { return Vector(B * X / dt - v0); });
  c.advance(law, dt);

  // the same by hand for one point
  const auto increment = [](const Matrix& F, const Matrix& dF) { return Matrix(dF * (F + 0.5 * dF).inverse()); };
  const auto cayley = [](const Matrix& W) { return Matrix((Matrix::Identity() - 0.5 * W).inverse() * (Matrix::Identity() + 0.5 * W)); };
  Matrix F = Matrix::Identity(), R = axis.toRotationMatrix(), strain = Matrix::Zero();
  for (const Matrix& dF : {A, B}) {
    const Matrix G = increment(F, dF), W = 0.5 * (G - G.transpose()), half = cayley(0.5 * W) * R;
    strain += half.transpose() * test::symmetric(G) * half;
    R = cayley(W) * R;
    F += dF;
  }
  const Matrix s = R * test::tensor(law.elasticity().stress(test::sym3(strain))) * R.transpose();

  test::Worst strain_error, stress_error, F_error;
  c.for_points([&](int b, int l) {
    strain_error.add(test::tensor(c.points.blocks[b].strain, l) - strain, strain.norm());
    stress_error.add(stress_of(c, law, b, l) - s, s.norm());
    F_error.add(test::matrix(c.points.blocks[b].F, l) - F, 1.0);
  });
  expect_within(strain_error, 1e-12, "strain");
  expect_within(stress_error, 1e-12, "stress");
  expect_within(F_error, 1e-12, "deformation gradient");
}

// A regular lattice integrates the gradients of interior nodes to nothing.
TEST_P(LinearField, InteriorNodesOfALatticeAreInBalance) {
  const double size = GetParam(), dt = 1e-9;
  test::Random random(92);
  Cement c(kCell, test::lattice(kCell, kCells), kCell * kCell * kCell / 8, Eigen::Quaterniond(random.frame()));
  const NoDamage law(test::elastic_calcite());
  const Matrix A = size * random.general();
  c.set_velocity([&](const Vector& X) { return Vector(A * X / dt); });
  c.advance(law, dt);
  const double typical = stress_of(c, law, 0, 0).norm() * kCell * kCell;
  test::Worst interior;
  double largest = 0.0;
  int inside = 0;
  for (int n = 0; n < c.grid.size(); ++n) {
    const Vector f = c.at(c.grid.force, n);
    largest = std::max(largest, f.norm());
    const auto& k = c.grid.keys[n];
    bool full = true;
    for (int d = 0; d < 3; ++d) full = full && k.at(d) >= 2 && k.at(d) <= kCells - 2;
    if (!full) continue;
    ++inside;
    interior.add(f.norm() / typical);
  }
  EXPECT_EQ(inside, 8);
  EXPECT_GT(largest, 0.1 * typical);  // the surface does carry the stress
  expect_within(interior, 1e-12, "force over stress h^2");
}

INSTANTIATE_TEST_SUITE_P(Patch, LinearField, ::testing::Values(1e-6, 1e-3, 0.1));

TEST(Patch, RigidTranslationAndRotationGiveNoStrain) {
  const double dt = 1e-9;
  test::Random random(93);
  const TensorDamage law = law_of(9.6e6);
  test::Worst strain, force, frame;
  for (double angle : {0.0, 1e-4, 0.3, 1.5, 2.5}) {
    Cement c(kCell, test::scattered(random, kCell, kCells, 9), kCell * kCell * kCell / 9);
    const Vector axis = random.direction(), t = kCell * random.vector();
    // two steps of the same rotation, carried by the nodes
    for (int k = 0; k < 2; ++k) {
      const Matrix before = test::rotation(axis, k * angle), after = test::rotation(axis, (k + 1) * angle);
      c.set_velocity([&](const Vector& X) { return Vector(((after - before) * X + t) / dt); });
      const AdvanceResult r = c.advance(law, dt);
      EXPECT_TRUE(r.failed.empty());
      EXPECT_EQ(r.dissipated, 0.0);
    }
    const Matrix R = test::rotation(axis, 2 * angle);
    c.for_points([&](int b, int l) {
      strain.add(test::tensor(c.points.blocks[b].strain, l), 1.0);
      frame.add(test::matrix(rotation_matrix(c.points.blocks[b].q), l) - R, 1.0);
    });
    for (double f : c.grid.force) force.add(std::fabs(f) / (law.elasticity().C11 * kCell * kCell));
  }
  expect_within(strain, 1e-12, "strain");
  expect_within(frame, 1e-12, "axes");
  expect_within(force, 1e-12, "force over C11 h^2");
}

// Sum of forces and of x_I x f_I with x_I the present place of the node, for any motion, also
// of damaged and failed cement.
TEST(Patch, InternalForceHasNoResultantAndNoMoment) {
  test::Random random(94);
  const NoDamage elastic(test::elastic_calcite());
  const TensorDamage damaged = law_of(9.6e4);
  for (const Law* which_law : {static_cast<const Law*>(&elastic), static_cast<const Law*>(&damaged)}) {
    const Law& law = *which_law;
    Cement c(kCell, test::scattered(random, kCell, kCells, 9), kCell * kCell * kCell / 9);
    std::size_t failed = 0;
    test::Worst resultant, moment, again;
    for (int step = 0; step < 6; ++step) {
      c.set_velocity([&](const Vector&) { return Vector(2e-3 * kCell / 1e-9 * random.vector()); });
      failed += c.advance(law, 1e-9).failed.size();
      Vector f = Vector::Zero(), m = Vector::Zero();
      double f_size = 0, m_size = 0;
      for (int n = 0; n < c.grid.size(); ++n) {
        const Vector fn = c.at(c.grid.force, n), x = c.place(n) + c.at(c.grid.displacement, n);
        f += fn;
        m += x.cross(fn);
        f_size += fn.norm();
        m_size += x.norm() * fn.norm();
      }
      resultant.add(f.norm() / f_size);
      moment.add(m.norm() / m_size);

      // and the same force from the state alone
      const std::vector<double> first = c.grid.force;
      c.grid.clear_force();
      add_internal_force(c.points, c.grid, law);
      for (std::size_t i = 0; i < first.size(); ++i) again.add(std::fabs(c.grid.force[i] - first[i]) * c.grid.size() / f_size);
    }
    const std::string which = law.inert() ? ", elastic" : ", with damage";
    if (!law.inert()) {
      EXPECT_GT(failed, 10u);
      EXPECT_LT(failed, 800u);
    }
    expect_within(resultant, 1e-14, "resultant" + which);
    expect_within(moment, 1e-14, "moment" + which);
    expect_within(again, 1e-13, "add_internal_force" + which);
  }
}

}  // namespace
}  // namespace mpdem
