// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/largest_eigenvalue.h"

#include <Eigen/Eigenvalues>

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCalcite;
using test::kCell;

class LargestEigenvalue : public ::testing::TestWithParam<Basis> {};
INSTANTIATE_TEST_SUITE_P(Bases, LargestEigenvalue, ::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic));

// Compares with all eigenvalues of the matrix. The matrix is found column by column from the internal force
// of small displacements.
TEST_P(LargestEigenvalue, IsThatOfTheMatrix) {
  test::Random random(151);
  const Eigen::Quaterniond q(test::rotation(random.direction(), 1.0));
  Cement c(kCell, test::lattice(kCell, 3), kCell * kCell * kCell / 8, q, GetParam());
  c.grid.lump_mass(c.points, kCalcite);
  const NoDamage law(VtiElasticity(VtiConstants{60e9, 40e9, 0.25, 0.2, 18e9}));
  const int n = 3 * c.grid.size();
  Eigen::MatrixXd A(n, n);
  const double step = 1e-6 * kCell;
  for (int i = 0; i < n; ++i) {
    Cement moved = c;
    moved.grid.velocity.assign(n, 0.0);
    moved.grid.velocity[i] = step;
    moved.advance(law, 1.0);
    for (int j = 0; j < n; ++j) A(j, i) = -moved.grid.force[j] / step / std::sqrt(c.grid.mass[i / 3] * c.grid.mass[j / 3]);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> all(0.5 * (A + A.transpose()), Eigen::EigenvaluesOnly);
  const double exact = all.eigenvalues()[n - 1];
  const EigenvalueEstimate found = largest_eigenvalue(MPI_COMM_SELF, c.points, c.grid, law, 1e-6);
  test::expect_within(std::fabs(found.value / exact - 1.0), 2e-6, "eigenvalue");  // differences of order step/h
  EXPECT_LE(found.value, exact * (1.0 + 2e-6));
  const EigenvalueEstimate rough = largest_eigenvalue(MPI_COMM_SELF, c.points, c.grid, law, 1e-3);
  EXPECT_LT(rough.products, found.products);
  EXPECT_NEAR(rough.value / exact, 1.0, 1e-3);
  const double bound = eigenvalue_bound(GetParam(), law.elasticity().largest_stiffness(), kCalcite, kCell);
  if (GetParam() == Basis::linear) EXPECT_EQ(bound, 0.0);
  else EXPECT_LE(exact, bound);
}

// The eigenvalue of some blocks alone, on the grid with its constraints, is that of all blocks when the points of the others failed.
TEST_P(LargestEigenvalue, OfSomeBlocks) {
  test::Random random(152);
  Cement c(kCell, test::lattice(kCell, 4), kCell * kCell * kCell / 8, Eigen::Quaterniond(test::rotation(random.direction(), 1.0)),
           GetParam());
  // a side of it is constrained to the lines behind
  std::vector<ExtensionConstraint> constraints;
  int least = c.grid.keys.front().at(0);
  for (const Key& k : c.grid.keys) least = std::min(least, k.at(0));
  for (const Key& k : c.grid.keys) {
    const Key next = k.moved(0, 1), second = k.moved(0, 2);
    if (k.at(0) == least) constraints.push_back({k, {{next, 2.0}, {second, -1.0}}, {{next, 1.0}}, {}});
  }
  c.grid.constrain(constraints, true);
  c.grid.lump_mass(c.points, kCalcite);
  const NoDamage law(VtiElasticity(VtiConstants{60e9, 40e9, 0.25, 0.2, 18e9}));
  std::vector<int> blocks;
  Cement others_failed = c;
  for (int b = 0; b < static_cast<int>(c.points.blocks.size()); ++b)
    if (b % 3 == 0) blocks.push_back(b);
    else others_failed.points.meta[b].failed = c.points.meta[b].occupied;
  const EigenvalueEstimate whole = largest_eigenvalue(MPI_COMM_SELF, others_failed.points, others_failed.grid, law, 1e-7);
  const EigenvalueEstimate some = largest_eigenvalue(MPI_COMM_SELF, {{&c.points, &c.grid, false, &blocks}}, law, 1e-7);
  EXPECT_FALSE(c.grid.constraints.empty());
  test::expect_within(std::fabs(some.value / whole.value - 1.0), 1e-9, "eigenvalue of some blocks");
}

}  // namespace
}  // namespace mpdem
