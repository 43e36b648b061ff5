// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Run on several ranks: each holds a share of the points, and must find the constraints of one rank alone.
#include "mpm/extension_constraints.h"

#include <algorithm>
#include <map>
#include <set>

#include "cement.h"
#include "lanes.h"
#include "mpi_ranks.h"
#include "mpm/largest_eigenvalue.h"

namespace mpdem {
namespace {

using test::Cement;
using test::edges_of;
using test::Vector;

constexpr double kH = 0.5;

using test::rank;
using test::ranks;

// Lattice of `percell` points along a cell, shifted by `shift` cells. It has a point where inside() is true.
template <class F>
std::vector<Vector> lattice(int percell, const Vector& shift, int cells, F inside) {
  std::vector<Vector> X;
  for (int i = -cells * percell; i < cells * percell; ++i)
    for (int j = -cells * percell; j < cells * percell; ++j)
      for (int k = -cells * percell; k < cells * percell; ++k) {
        const Vector x = kH * (Vector(i + 0.5, j + 0.5, k + 0.5) / percell + shift);
        if (inside(Vector(x / kH))) X.push_back(x);
      }
  return X;
}

std::vector<ExtensionConstraint> constraints_of(Cement& c) {
  c.grid.lump_mass(c.points, 1.0);
  return find_extension_constraints(MPI_COMM_SELF, c.grid.basis, edges_of(c.grid));
}

// Checks the sums of the weights and of their first moments, and looks for masters that are constrained.
void expect_sound(const std::vector<ExtensionConstraint>& constraints) {
  std::set<Key> constrained_nodes;
  for (const ExtensionConstraint& t : constraints) constrained_nodes.insert(t.constrained);
  test::Worst error;
  for (const ExtensionConstraint& t : constraints) {
    double sum[4] = {-1.0, 0, 0, 0};
    for (const auto& m : t.masters) {
      EXPECT_FALSE(constrained_nodes.count(m.first));
      EXPECT_EQ(m.first.field(), t.constrained.field());
      sum[0] += m.second;
      for (int d = 0; d < 3; ++d) sum[1 + d] += m.second * (m.first.at(d) - t.constrained.at(d));
    }
    for (double s : sum) error.add(std::fabs(s));
    double shares = -1.0;
    for (const auto& h : t.mass_receivers) {
      EXPECT_FALSE(constrained_nodes.count(h.first));
      EXPECT_GT(h.second, 0.0);
      shares += h.second;
    }
    error.add(std::fabs(shares));
  }
  EXPECT_LT(error.value(), 1e-11);
}

TEST(ExtensionConstraints, FullCellsHaveNone) {
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic})
    for (int percell : {1, 2, 3, 4}) {
      if (basis == Basis::cubic && percell == 1) continue;  // one point does not see the edge of a cubic
      // the cells of the quadratic splines begin at half a spacing
      const double from = basis == Basis::quadratic ? -1.5 : -2.0, shift = basis == Basis::quadratic && percell % 2 ? 0.5 : 0.0;
      const auto inside = [&](const Vector& x) { return x.minCoeff() > from && x.maxCoeff() < from + 3; };
      Cement c(kH, lattice(percell, Vector::Constant(shift), 4, inside), 1.0, Eigen::Quaterniond::Identity(), basis);
      EXPECT_TRUE(constraints_of(c).empty()) << static_cast<int>(basis) << " " << percell;
    }
}

// A half space whose face lies a quarter into a cell: the nodes before it, and no others.
TEST(ExtensionConstraints, FaceIsTiedAcross) {
  const auto inside = [](const Vector& x) { return x[2] > 0.25 && std::max({std::fabs(x[0]), std::fabs(x[1]), x[2] - 1}) < 2.5; };
  Cement c(kH, lattice(8, Vector::Zero(), 4, inside), 1.0);
  const std::vector<ExtensionConstraint> constraints = constraints_of(c);
  expect_sound(constraints);
  std::set<Key> constrained_nodes, wanted;
  for (const ExtensionConstraint& t : constraints) constrained_nodes.insert(t.constrained);
  for (const Key& k : c.grid.keys)
    if (k.at(2) == -1) wanted.insert(k);
  EXPECT_EQ(constrained_nodes, wanted);
  for (const ExtensionConstraint& t : constraints) {
    const std::vector<std::pair<Key, double>> masters{{{0, t.constrained.at(0), t.constrained.at(1), 0}, 2.0},
                                                      {{0, t.constrained.at(0), t.constrained.at(1), 1}, -1.0}};
    EXPECT_EQ(t.masters, masters);
    ASSERT_EQ(t.mass_receivers.size(), 1u);
    EXPECT_EQ(t.mass_receivers[0].first, masters[0].first);
  }
}

// The nodes at both sides of a film are constrained, each to the two nodes between.
TEST(ExtensionConstraints, FilmIsTiedOnBothSides) {
  const auto inside = [](const Vector& x) { return std::fabs(x[2] - 0.4) < 0.3 && std::max(std::fabs(x[0]), std::fabs(x[1])) < 2.5; };
  Cement c(kH, lattice(16, Vector::Zero(), 4, inside), 1.0);
  const std::vector<ExtensionConstraint> constraints = constraints_of(c);  // from 0.1 to 0.7: the nodes -1 and 2, with 0 and 1 between them
  expect_sound(constraints);
  ASSERT_FALSE(constraints.empty());
  for (const ExtensionConstraint& t : constraints) {
    const bool below = t.constrained.at(2) == -1;
    EXPECT_TRUE(below || t.constrained.at(2) == 2);
    const std::vector<std::pair<Key, double>> masters{{{0, t.constrained.at(0), t.constrained.at(1), 0}, below ? 2.0 : -1.0},
                                                      {{0, t.constrained.at(0), t.constrained.at(1), 1}, below ? -1.0 : 2.0}};
    EXPECT_EQ(t.masters, masters);
  }
}

// A layer of points beside a node: the next nodes have 0.11 and 0.24 of its mass, and the lighter one is constrained to both.
TEST(ExtensionConstraints, LayerIsTiedOnItsLighterSide) {
  const auto inside = [](const Vector& x) { return std::fabs(x[2] - 0.1) < 0.2 && std::max(std::fabs(x[0]), std::fabs(x[1])) < 2.5; };
  Cement c(kH, lattice(2, Vector(0, 0, -0.15), 4, inside), 1.0);
  const std::vector<ExtensionConstraint> constraints = constraints_of(c);
  expect_sound(constraints);
  std::set<Key> constrained_nodes, wanted;
  for (const ExtensionConstraint& t : constraints) {
    constrained_nodes.insert(t.constrained);
    const std::vector<std::pair<Key, double>> masters{{{0, t.constrained.at(0), t.constrained.at(1), 0}, 2.0},
                                                      {{0, t.constrained.at(0), t.constrained.at(1), 1}, -1.0}};
    EXPECT_EQ(t.masters, masters);
  }
  for (const Key& k : c.grid.keys)
    if (k.at(2) == -1) wanted.insert(k);
  EXPECT_EQ(constrained_nodes, wanted);
}

// Bound to one grid and to another with more nodes: constraints are taken over from layout to layout by their keys.
TEST(ExtensionConstraints, KeysComeBack) {
  const auto inside = [](const Vector& x) { return x.norm() < 3.3; };
  Cement c(kH, lattice(4, Vector::Zero(), 4, inside), 1.0);
  const std::vector<ExtensionConstraint> constraints = constraints_of(c);
  ASSERT_GT(constraints.size(), 50u);
  ExtensionConstraints bound;
  bound.bind(constraints, c.grid.keys);
  std::vector<Key> more = c.grid.keys;
  for (const Key& k : c.grid.keys) more.push_back(k.with_field(k.field() + 1));
  more.push_back({0, -1000, 0, 0});
  std::sort(more.begin(), more.end());
  const std::vector<ExtensionConstraint> first = bound.by_key(c.grid.keys);
  bound.bind(first, more);
  const std::vector<ExtensionConstraint> second = bound.by_key(more);
  ASSERT_EQ(second.size(), constraints.size());
  for (std::size_t t = 0; t < constraints.size(); ++t) {
    EXPECT_EQ(second[t].constrained, constraints[t].constrained);
    EXPECT_EQ(second[t].masters, constraints[t].masters);
    EXPECT_EQ(second[t].mass_receivers, constraints[t].mass_receivers);
  }
}

// Some constraints go, some come, some change. The result is what binding all of it gives, whatever lies beside.
TEST(ExtensionConstraints, ExchangeIsBinding) {
  const auto inside = [](const Vector& x) { return x.norm() < 3.3; };
  Cement c(kH, lattice(4, Vector::Zero(), 4, inside), 1.0);
  const std::vector<Key>& keys = c.grid.keys;
  const std::vector<ExtensionConstraint> all = constraints_of(c);
  test::Random random(7);
  const auto some = [&](double share) { return random.uniform(0, 1) < share; };
  std::vector<ExtensionConstraint> now;
  for (const ExtensionConstraint& t : all)
    if (some(0.7)) now.push_back(t);
  ExtensionConstraints constraints;
  constraints.bind(now, keys);
  int freed_in = 0;
  for (int round = 0; round < 20; ++round) {
    std::vector<int> nodes;
    std::vector<ExtensionConstraint> wanted, next;
    bool freed = false;
    auto was = now.begin();
    for (std::size_t i = 0, t = 0; i < keys.size(); ++i) {
      while (t < all.size() && all[t].constrained < keys[i]) ++t;
      const bool had = was != now.end() && was->constrained == keys[i], may = t < all.size() && all[t].constrained == keys[i];
      if (some(round % 2 ? 0.9 : 0.02)) {
        nodes.push_back(static_cast<int>(i));
        const bool has = may && some(0.8);
        if (has) {
          wanted.push_back(all[t]);
          if (some(0.2)) wanted.back().masters.front().second += 0.125 * round;
          if (some(0.2)) wanted.back().mass_receivers.assign(1, wanted.back().mass_receivers.front());
          next.push_back(wanted.back());
        }
        freed =
            freed || (had && was->masters.size() > 1 &&
                      (!has || was->masters != wanted.back().masters || was->mass_receivers.size() != wanted.back().mass_receivers.size()));
      } else if (had) {
        next.push_back(*was);
      }
      if (had) ++was;
    }
    EXPECT_EQ(constraints.replace(nodes, wanted, keys), freed) << round;
    freed_in += freed;
    now = next;
    const std::vector<ExtensionConstraint> found = constraints.by_key(keys);
    ASSERT_EQ(found.size(), now.size()) << round;
    for (std::size_t t = 0; t < now.size(); ++t) {
      EXPECT_EQ(found[t].constrained, now[t].constrained);
      EXPECT_EQ(found[t].masters, now[t].masters);
      EXPECT_EQ(found[t].mass_receivers, now[t].mass_receivers);
    }
  }
  EXPECT_GT(freed_in, 10);
}

// Going node by node, from the edge inwards and back, gives the same as going by the masters.
TEST(ExtensionConstraints, ChainIsMasters) {
  const auto inside = [](const Vector& x) { return x.norm() < 3.3; };
  Cement c(kH, lattice(4, Vector::Zero(), 4, inside), 1.0);
  const std::vector<ExtensionConstraint> constraints = constraints_of(c);
  std::set<Key> constrained_nodes;
  for (const ExtensionConstraint& t : constraints) constrained_nodes.insert(t.constrained);
  int chained = 0;
  for (const ExtensionConstraint& t : constraints)
    for (const auto& b : t.behind) chained += static_cast<int>(constrained_nodes.count(b.first));
  EXPECT_GT(chained, 50);
  ExtensionConstraints by_masters, by_chain;
  by_masters.bind(constraints, c.grid.keys, false);
  by_chain.bind(constraints, c.grid.keys, true);
  EXPECT_GT(by_chain.memory_usage(), by_masters.memory_usage());
  test::Random random(5);
  std::vector<double> a(3 * c.grid.keys.size()), b;
  for (double& v : a) v = random.uniform(-1, 1);
  b = a;
  by_masters.gather_to_masters(a.data());
  by_chain.gather_to_masters(b.data());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << i;
  for (double& v : a) v = random.uniform(-1, 1);
  b = a;
  by_masters.extend(a.data());
  by_chain.extend(b.data());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << i;
}

TEST(ExtensionConstraints, BallIsSoundAndSymmetric) {
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic}) {
    const auto inside = [](const Vector& x) { return x.norm() < 3.3; };
    Cement c(kH, lattice(4, Vector::Zero(), 4, inside), 1.0, Eigen::Quaterniond::Identity(), basis);
    const std::vector<ExtensionConstraint> constraints = constraints_of(c);
    expect_sound(constraints);
    EXPECT_GT(constraints.size(), 50u);
    std::map<Key, std::map<Key, double>> all;  // masters, and mass receivers with field 1
    for (const ExtensionConstraint& t : constraints) {
      all[t.constrained] = {t.masters.begin(), t.masters.end()};
      for (const auto& h : t.mass_receivers) all[t.constrained][h.first.with_field(1)] = h.second;
    }
    // mirrored in x = y and in z = 0
    for (const auto& t : all)
      for (const auto& image : {+[](const Key& k) {
                                  return Key{k.field(), k.at(1), k.at(0), k.at(2)};
                                },
                                +[](const Key& k) {
                                  return Key{k.field(), k.at(0), k.at(1), -k.at(2)};
                                }}) {
        ASSERT_TRUE(all.count(image(t.first)));
        const auto& other = all[image(t.first)];
        EXPECT_EQ(other.size(), t.second.size());
        for (const auto& m : t.second) {
          ASSERT_TRUE(other.count(image(m.first)));
          EXPECT_NEAR(other.at(image(m.first)), m.second, 1e-12);
        }
      }
  }
}

TEST(ExtensionConstraints, ForceIsTransposedAndMassIsKept) {
  test::Random random(118);
  const auto inside = [](const Vector& x) { return x.norm() < 2.9; };
  Cement c(kH, lattice(2, Vector(0.1, 0.3, -0.2), 4, inside), 0.3);
  const std::vector<ExtensionConstraint> constraints = constraints_of(c);
  const SharedList<double> untied = c.grid.mass;
  c.grid.constrain(constraints, true);
  EXPECT_EQ(c.grid.constraints.size(), constraints.size());
  c.grid.lump_mass(c.points, 1.0);
  double before = 0, after = 0, least = 1e9;
  for (int n = 0; n < c.grid.size(); ++n) {
    before += untied[n];
    after += c.grid.mass[n];
    if (c.grid.constraints.row(n) >= 0) EXPECT_EQ(c.grid.mass[n], 0.0);
    else least = std::min(least, c.grid.mass[n] - untied[n]);
  }
  EXPECT_NEAR(after, before, 1e-13 * before);
  EXPECT_GE(least, 0.0);
  std::vector<double> f(3 * c.grid.size()), x(f.size());
  for (double& v : f) v = random.uniform(-1, 1);
  for (double& v : x) v = random.uniform(-1, 1);
  c.grid.constraints.extend(x.data());
  double power = 0, pulled = 0;
  for (std::size_t i = 0; i < f.size(); ++i) power += f[i] * x[i];
  c.grid.constraints.gather_to_masters(f.data());
  for (std::size_t i = 0; i < f.size(); ++i) pulled += f[i] * x[i];
  EXPECT_NEAR(power, pulled, 1e-10 * std::fabs(power));
}

// The bound of the largest eigenvalue, raised for constraints, holds.
TEST(ExtensionConstraints, BoundOfTheEigenvalueHolds) {
  const VtiElasticity elasticity(VtiConstants::isotropic(60e9, 0.25));
  const NoDamage law(elasticity);
  for (Basis basis : {Basis::quadratic, Basis::cubic})
    for (double s : {0.0, 0.1, 0.25, 0.4}) {
      const auto inside = [](const Vector& x) { return x.norm() < 2.9; };
      Cement c(kH, lattice(2, Vector(s, 0.5 * s, -s), 4, inside), kH * kH * kH / 8, Eigen::Quaterniond::Identity(), basis);
      c.grid.constrain(constraints_of(c), true);
      c.grid.lump_mass(c.points, 2700.0);
      const double bound = eigenvalue_bound(basis, law.elasticity().largest_stiffness(), 2700.0, kH) * c.grid.largest_constraint_factor();
      const EigenvalueEstimate e = largest_eigenvalue(MPI_COMM_SELF, c.points, c.grid, law);
      EXPECT_GT(c.grid.largest_constraint_factor(), 1.0);
      EXPECT_LE(e.value, bound);
      EXPECT_GT(e.value, 0.02 * bound);
    }
}

TEST(ExtensionConstraints, SameOnAnyNumberOfRanks) {
  const std::vector<Vector> ball = lattice(2, Vector(0.1, 0.3, -0.2), 4, [](const Vector& x) { return x.norm() < 3.3; });
  const auto cement = [&](const std::vector<int>& which) {
    std::vector<Vector> X;
    for (int i : which) X.push_back(ball[i]);
    return Cement(kH, X, 0.7);
  };
  std::vector<int> all(ball.size()), mine;
  std::iota(all.begin(), all.end(), 0);
  Cement whole = cement(all);
  whole.grid.lump_mass(whole.points, 1.0);
  std::map<Key, ExtensionConstraint> wanted;
  for (const ExtensionConstraint& t : find_extension_constraints(MPI_COMM_SELF, Basis::quadratic, edges_of(whole.grid)))
    wanted[t.constrained] = t;

  test::Random same(119);
  for (int i : all) {
    const int owner = static_cast<int>((ball[i][2] / (8 * kH) + 0.5 + 0.05 * same.uniform(-1, 1)) * ranks());
    if (std::max(0, std::min(ranks() - 1, owner)) == rank()) mine.push_back(i);
  }
  Cement part = cement(mine);
  HaloSum halo;
  halo.build(MPI_COMM_WORLD, part.grid.keys);
  part.grid.lump_mass(part.points, 1.0);
  halo.sum(part.grid.mass.own().data(), 1);
  std::set<Key> found;
  for (const ExtensionConstraint& t : find_extension_constraints(MPI_COMM_WORLD, Basis::quadratic, edges_of(part.grid))) {
    found.insert(t.constrained);
    ASSERT_TRUE(wanted.count(t.constrained));
    EXPECT_EQ(wanted[t.constrained].mass_receivers, t.mass_receivers);
    EXPECT_EQ(wanted[t.constrained].masters, t.masters);
  }
  for (const Key& k : part.grid.keys) EXPECT_EQ(found.count(k), wanted.count(k));
}

}  // namespace
}  // namespace mpdem
