// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Blocks of two and three cells against blocks of one: the same points, nodes, masses, strains and forces in fewer blocks.
#include <map>
#include <set>

#include "cement.h"
#include "mpm/gather.h"
#include "mpm/largest_eigenvalue.h"
#include "mpm/reproject.h"
#include "mpm/scatter.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCell;
using test::Vector;

// Points of a ball, so that cells at its surface are cut in all directions. They lie anywhere in the cells. JoinedCells puts them in two layers.
std::vector<Vector> ball(test::Random& random, int points) {
  std::vector<Vector> X;
  while (static_cast<int>(X.size()) < points) {
    const Vector x(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
    if (x.norm() < 2.0) X.push_back(kCell * (x + Vector(0.2, -0.1, 0.3)));
  }
  return X;
}

std::array<int, 3> cell_of(const PointStore& points, int b, int l) {
  const BlockMeta& m = points.meta[b];
  return {mpdem::cell_of(m, l, 0), mpdem::cell_of(m, l, 1), mpdem::cell_of(m, l, 2)};
}

class JoinedCells : public ::testing::TestWithParam<Basis> {
 protected:
  test::Random random{77};
  std::vector<Vector> X = ball(random, 150);
  std::vector<int> layer = [this] {
    std::vector<int> p;
    for (const Vector& x : X) p.push_back(x[0] > 0.3 * kCell);
    return p;
  }();
  double volume = std::pow(kCell, 3) / 8;
  Eigen::Quaterniond q{Eigen::AngleAxisd(0.7, Vector(1, 2, 3).normalized())};
  Cement apart{kCell, X, volume, q, GetParam(), 0, layer, false}, joined{kCell, X, volume, q, GetParam(), 0, layer, true};

  // The largest difference over the largest value.
  template <class List>
  static double difference(const List& a, const List& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      most = std::max(most, std::fabs(a[i] - b[i]));
      largest = std::max(largest, std::fabs(a[i]));
    }
    EXPECT_GT(largest, 0.0);
    return most / largest;
  }
};

TEST_P(JoinedCells, FullerBlocks) {
  const PointStore& p = joined.points;
  const double shift = cell_shift(GetParam());
  for (std::size_t i = 0; i < X.size(); ++i) {
    const int b = joined.slots[i] / kLanes, l = joined.slots[i] % kLanes;
    EXPECT_EQ(p.tags[b][l], static_cast<int>(i) + 1);
    EXPECT_EQ(p.meta[b].layer, layer[i]);
    const std::array<int, 3> cell = cell_of(p, b, l);
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(double(p.blocks[b].X[d][l]), X[i][d]);
      EXPECT_EQ(support_base(X[i][d], 1.0 / kCell, shift), cell[d]);
    }
  }
  std::set<int> rows;
  for (std::size_t b = 0; b < p.meta.size(); ++b) {
    const BlockMeta& m = p.meta[b];
    EXPECT_EQ((m.second | m.third) & ~m.occupied, 0);
    EXPECT_EQ(m.second & m.third, 0);
    EXPECT_NE(m.second | m.third, m.occupied);  // some are in the first
    const int reach = m.third ? 2 : m.second ? 1 : 0;
    for (int d = 0; d < 3; ++d) EXPECT_EQ(reach_along(m.joined, d), m.joined % 3 == d ? reach : 0);
    EXPECT_EQ(m.joined == kOneCell, reach == 0);
    if (reach > 0) rows.insert(m.joined);
  }
  if (!may_join_cells(GetParam())) {
    EXPECT_EQ(p.blocks.size(), apart.points.blocks.size());
    return;
  }
  EXPECT_EQ(rows.size(), 6u);  // of two and of three, in each direction
  EXPECT_LT(p.blocks.size(), 0.7 * apart.points.blocks.size());
  // no two are left that fit into one, but for layers, which have blocks of their own
  PointStore whole = p;
  std::map<int, int> no_part;
  for (int slot : joined.slots) no_part[slot] = 0;
  whole.arrange(kCell, GetParam(), no_part, true);
  std::map<std::array<int, 4>, int> left;  // points of blocks of one cell that are not full
  for (const BlockMeta& m : whole.meta)
    if (m.joined == kOneCell && m.occupied != 0xff) left[{m.layer, m.base[0], m.base[1], m.base[2]}] = __builtin_popcount(m.occupied);
  for (const auto& [cell, count] : left)
    for (int d = 0; d < 3; ++d) {
      std::array<int, 4> next = cell;
      ++next[1 + d];
      const auto at = left.find(next);
      if (at != left.end()) {
        EXPECT_GT(count + at->second, kLanes);
      }
    }
}

// A second arrangement changes nothing, nor does one from blocks of one cell.
TEST_P(JoinedCells, DependOnThePointsAlone) {
  PointStore again = joined.points;
  const std::vector<int> same = again.arrange(kCell, GetParam(), {}, true);
  for (int s : joined.slots) EXPECT_EQ(same[s], s);
  PointStore other = apart.points;
  const std::vector<int> moved = other.arrange(kCell, GetParam(), {}, true);
  for (std::size_t i = 0; i < X.size(); ++i) EXPECT_EQ(moved[apart.slots[i]], joined.slots[i]);
}

TEST_P(JoinedCells, SameNodesAndMasses) {
  EXPECT_EQ(apart.grid.keys, joined.grid.keys);
  for (Cement* c : {&apart, &joined}) c->grid.lump_mass(c->points, test::kCalcite);
  test::expect_within(difference(apart.grid.mass, joined.grid.mass), 1e-14, "masses");
}

TEST_P(JoinedCells, SameStepsAndEigenvalue) {
  for (Cement* c : {&apart, &joined}) c->grid.lump_mass(c->points, test::kCalcite);
  const TensorDamage law = test::law_of(1e4);
  const double dt = 1e-9;
  const double speed = GetParam() == Basis::linear ? 4.0 : 10.0;
  for (double& v : apart.grid.velocity) v = speed * random.uniform(-1, 1);
  joined.grid.velocity = apart.grid.velocity;
  for (int step = 0; step < 60; ++step) {
    const AdvanceResult a = apart.advance(law, dt), b = joined.advance(law, dt);
    EXPECT_NEAR(a.dissipated, b.dissipated, 1e-11 * a.dissipated);
  }
  test::expect_within(difference(apart.grid.force, joined.grid.force), 1e-11, "forces after steps with damage");
  double worst = 0.0, most = 0.0;
  int damaged = 0;
  for (std::size_t i = 0; i < X.size(); ++i) {
    const int s = apart.slots[i], t = joined.slots[i];
    const test::Matrix e = test::tensor(apart.points.blocks[s / kLanes].strain, s % kLanes);
    worst = std::max(worst, (e - test::tensor(joined.points.blocks[t / kLanes].strain, t % kLanes)).norm());
    most = std::max(most, e.norm());
    damaged += test::tensor(test::damage_of(apart.points, s / kLanes), s % kLanes).norm() > 0.0;
  }
  EXPECT_GT(damaged, 20);
  test::expect_within(worst / most, 1e-12, "strains");

  double lambda[2], *next = lambda;
  for (Cement* c : {&apart, &joined}) {
    *next++ = largest_eigenvalue(MPI_COMM_SELF, c->points, c->grid, law).value;
    c->grid.clear_force();
    add_internal_force(c->points, c->grid, law);
  }
  test::expect_within(difference(apart.grid.force, joined.grid.force), 1e-11, "forces of the state");
  EXPECT_GT(lambda[0], 0.0);
  EXPECT_NEAR(lambda[1] / lambda[0], 1.0, 1e-9);
  for (bool apic : {false, true}) {
    Transfer transfer;
    transfer.method = apic ? Transfer::apic : Transfer::xpic;
    std::vector<double> jump[2];
    std::size_t n = 0;
    for (Cement* c : {&apart, &joined}) reproject_velocity(c->points, c->grid, {}, test::kCalcite, transfer, 0.0, jump[n++]);
    test::expect_within(difference(jump[0], jump[1]), 1e-12, "jumps by a transfer");
  }
}

INSTANTIATE_TEST_SUITE_P(Bases, JoinedCells, ::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic));

}  // namespace
}  // namespace mpdem
