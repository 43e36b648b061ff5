// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// coupling/added_mass.cpp: row sums against the stiffness matrix of the links, assembled by unit
// displacements; what the added mass exerts on nodes and grains; links that let go.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <tuple>

#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::copy;
using test::kBound;
using test::kDt;
using test::kDensity;
using test::kH;
using test::Scene;
using test::Vector;

// at the surface or at the points, edge nodes tied or free, basis
class AddedMass : public ::testing::TestWithParam<std::tuple<bool, bool, Basis>> {
 protected:
  Scene scene(std::uint64_t seed, double damping = 0.0) const {
    Scene s(seed, test::penalty(std::get<0>(GetParam()), damping), std::get<2>(GetParam()));
    if (std::get<1>(GetParam())) {
      s.tie();
      EXPECT_GT(s.grid.ties.size(), 20u);
    }
    return s;
  }
};

// All the mass that the penalty asks for, none of it for the cement.
void set_added_mass(Scene& s, double dt = kDt) {
  std::fill(s.grid.penalty.begin(), s.grid.penalty.end(), 0.0);
  s.links.add_stiffness(s.grid, s.sides, dt);
  s.grid.set_added_mass(dt, 0.0, false, kBound);
  s.links.share_added_mass(s.grid, s.sides);
}

// Row sum of a node, of the links to both grains.
double row_sum(const Scene& s, int n) { return s.grid.penalty[2 * n] + s.grid.penalty[2 * n + 1]; }

std::vector<int> free_nodes(const Scene& s, int body) {
  std::vector<int> nodes;
  for (int n = 0; n < s.grid.size(); ++n)
    if (body_of(s.grid.keys[n][0]) == body && s.grid.ties.row(n) < 0) nodes.push_back(n);
  return nodes;
}

// Minus the force on the nodes by a unit of `field`, which is displacement or velocity, at each.
Eigen::MatrixXd response(Scene& s, std::vector<double>& field, const std::vector<int>& nodes) {
  s.place_grains(0.0, 0.0);
  const int size = 3 * static_cast<int>(nodes.size());
  Eigen::MatrixXd K(size, size);
  for (int j = 0; j < size; ++j) {
    std::fill(field.begin(), field.end(), 0.0);
    field[3 * nodes[j / 3] + j % 3] = 1.0;
    s.grid.ties.extend(field.data());
    s.add_force();
    for (int i = 0; i < size; ++i) K(i, j) = -s.grid.force[3 * nodes[i / 3] + i % 3];
  }
  std::fill(field.begin(), field.end(), 0.0);
  return K;
}

// Largest eigenvalue of K x = lambda D x, D a number a node; where D is zero K has to be.
double largest_eigenvalue(const Eigen::MatrixXd& K, const std::vector<double>& D) {
  Eigen::VectorXd scale(K.rows());
  for (int i = 0; i < K.rows(); ++i) {
    scale[i] = D[i / 3] > 0.0 ? 1.0 / std::sqrt(D[i / 3]) : 0.0;
    if (D[i / 3] == 0.0) {
      EXPECT_LE(K.row(i).cwiseAbs().maxCoeff(), 1e-12 * K.cwiseAbs().maxCoeff());
    }
  }
  const Eigen::MatrixXd S = scale.asDiagonal() * K * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

TEST_P(AddedMass, RowSumsBoundTheStiffness) {
  Scene s = scene(151, 0.1);
  set_added_mass(s);
  const double largest = *std::max_element(s.grid.penalty.begin(), s.grid.penalty.end());
  test::Worst row, tight, matrix, step, asymmetry;
  for (int body = 0; body < 2; ++body) {
    const std::vector<int> nodes = free_nodes(s, body);
    // a damper counts as a spring 2 g/dt
    const Eigen::MatrixXd C = response(s, s.grid.velocity, nodes);
    const Eigen::MatrixXd K = response(s, s.grid.displacement, nodes) + 2.0 / kDt * C;
    asymmetry.add((K - K.transpose()).cwiseAbs().maxCoeff() / K.cwiseAbs().maxCoeff());
    std::vector<double> penalty, mass;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      penalty.push_back(row_sum(s, nodes[i]));
      mass.push_back(s.grid.mass[nodes[i]] + s.grid.added_mass[nodes[i]]);
      if (penalty[i] == 0.0) continue;
      double sum = 0.0;
      for (std::size_t j = 0; j < nodes.size(); ++j)
        sum += K.block<3, 3>(3 * i, 3 * j).jacobiSvd().singularValues()[0];
      row.add((sum - penalty[i]) / largest, std::to_string(nodes[i]));
      tight.add(sum / std::max(penalty[i], 1e-3 * largest));
    }
    matrix.add(largest_eigenvalue(K, penalty));
    step.add(kDt * kDt * largest_eigenvalue(K, mass) / kBound);
  }
  for (int n = 0; n < s.grid.size(); ++n)
    if (s.grid.ties.row(n) >= 0) {
      EXPECT_EQ(row_sum(s, n), 0.0);
    }
  expect_within(asymmetry, 1e-12, "asymmetry of the stiffness");
  expect_within(row, 1e-12, "sizes of the blocks of a row beyond the row sum");
  expect_within(matrix, 1.0 + 1e-12, "largest eigenvalue of the stiffness over the row sums");
  expect_within(step, 1.0, "largest dt^2 eigenvalue with the added mass, over the bound");
  // nor are they far too large, which would cost mass
  EXPECT_GT(tight.value(), 0.9);
  EXPECT_GT(matrix.value(), 0.7);
}

// The rates of momentum and angular momentum of nodes (without added mass) and grains.
TEST_P(AddedMass, ActionIsReaction) {
  Scene s = scene(134, 0.1);
  s.place_grains(0.1, 1.0);
  set_added_mass(s);
  int stiff = 0;
  double row_sums = 0, stiffness = 0;
  for (int n = 0; n < s.grid.size(); ++n) {
    stiff += s.grid.added_mass[n] > 0;
    row_sums += row_sum(s, n);
  }
  for (const Link& k : s.points.links) {
    const double spring = s.links.parameters().kn * k.area;
    const double mass = kDensity * s.points.blocks[k.slot / kLanes].volume[k.slot % kLanes];
    stiffness += spring + 2.0 / kDt * 2.0 * s.links.parameters().damping * std::sqrt(spring * mass);
  }
  EXPECT_GT(stiff, 10);
  EXPECT_LT(stiff, s.grid.size());
  // Weights are negative in part at a place outside the cell of its point, and with ties; sizes count.
  const auto& [at_surface, tied, basis] = GetParam();
  if (at_surface || tied)
    EXPECT_GT(row_sums, stiffness);
  else
    test::expect_within(std::fabs(row_sums / stiffness - 1.0), 1e-13, "sum of the stiffness");
  s.add_force();
  const std::vector<double> springs = s.grid.force;
  for (int n = 0; n < s.grid.size(); ++n)
    if (s.grid.ties.row(n) < 0)
      for (int d = 0; d < 3; ++d) s.grid.force[3 * n + d] += 0.01 * s.random.uniform(-1, 1);  // of the cement
  const std::vector<double> all = s.grid.force;
  s.links.carry_added_mass(s.grid, s.sides);
  s.grid.update_acceleration();
  // what the springs put on the nodes is balanced by the grains; take the rest away
  std::vector<double> rate(all.size());
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = s.grid.mass[i / 3] * s.grid.acceleration[i] - (all[i] - springs[i]);
  s.expect_balanced(rate, 1e-13, "with added mass");
}

TEST_P(AddedMass, SidesHaveWhatNodesHave) {
  Scene s = scene(152);
  set_added_mass(s);
  double of_nodes = 0, of_sides = 0;
  for (double m : s.grid.added_mass) of_nodes += m;
  for (double m : s.links.added_mass(s.grid, s.sides)) of_sides += m;
  EXPECT_GT(of_nodes, 0.0);
  test::expect_within(std::fabs(of_sides / of_nodes - 1.0), 1e-13, "sum over sides against that over nodes");
}

// Grains accelerate and turn, each on its own.
TEST_P(AddedMass, CarriedByGrains) {
  Scene s = scene(153);
  s.place_grains(0.1, 1.0);
  set_added_mass(s);
  s.grid.clear_force();
  s.sides.clear_forces();
  s.links.carry_added_mass(s.grid, s.sides);
  for (double f : s.grid.force) EXPECT_EQ(f, 0.0);
  for (GrainSides::Motion& m : s.motion) {
    copy(s.random.vector(), m.a);
    copy(s.random.vector(), m.alpha);
  }
  s.sides.distribute(s.bodies, s.motion);
  s.links.carry_added_mass(s.grid, s.sides);
  s.grid.update_acceleration();
  std::vector<double> rate(s.grid.force.size());
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = s.grid.mass[i / 3] * s.grid.acceleration[i];
  s.expect_balanced(rate, 1e-13, "carried");
}

// Both grains of a body and its nodes accelerate as one rigid body does: nodes as if there were no
// added mass, and grains feel nothing of it.
TEST_P(AddedMass, ExertsNothingWhereNodesMoveWithTheGrain) {
  Scene s = scene(154);
  s.place_grains(0.1, 1.0);
  set_added_mass(s);
  std::vector<double> field(s.grid.force.size());
  for (int b = 0; b < 2; ++b) {
    const Vector a = s.random.vector(), alpha = s.random.vector();
    for (int i = 2 * b; i < 2 * b + 2; ++i) {
      const Vector x = Eigen::Map<const Vector>(s.sides.sides[i].x);
      copy(a + alpha.cross(x), s.motion[i].a);
      copy(alpha, s.motion[i].alpha);
    }
    for (int n = 0; n < s.grid.size(); ++n)
      if (body_of(s.grid.keys[n][0]) == b) copy(a + alpha.cross(s.node(n)), &field[3 * n]);
  }
  s.sides.distribute(s.bodies, s.motion);
  s.sides.clear_forces();
  for (std::size_t i = 0; i < field.size(); ++i) s.grid.force[i] = s.grid.mass[i / 3] * field[i];  // of the cement
  s.links.carry_added_mass(s.grid, s.sides);
  double size = 0.0;
  for (std::size_t i = 0; i < field.size(); ++i) size = std::max(size, std::fabs(s.grid.added_mass[i / 3] * field[i]));
  s.grid.update_acceleration();
  test::Worst node, grain;
  for (std::size_t i = 0; i < field.size(); ++i)
    if (s.grid.added_mass[i / 3] > 0.0) node.add(std::fabs(s.grid.acceleration[i] - field[i]));
  EXPECT_GT(size, 0.0);
  for (const GrainSide& g : s.sides.sides)
    for (int d = 0; d < 3; ++d) grain.add(std::max(std::fabs(g.force[d]), std::fabs(g.torque[d])) / size);
  expect_within(node, 1e-13, "acceleration of nodes with added mass");
  expect_within(grain, 1e-11, "force and moment on grains, over what carries the mass of a node");
}

// Grains that jump take nodes along: momentum is kept, energy changes by the work of the reaction at the mean velocity of each
// grain, and added mass has the energy before the jump until its nodes follow.
TEST_P(AddedMass, FollowsJumps) {
  Scene s = scene(157);
  s.place_grains(0.1, 1.0);
  set_added_mass(s);
  std::vector<double>& change = s.grid.acceleration;
  std::fill(change.begin(), change.end(), 0.0);
  const auto energy = [&] {
    double cement = 0.0;
    for (std::size_t i = 0; i < change.size(); ++i) cement += 0.5 * s.grid.mass[i / 3] * s.grid.velocity[i] * s.grid.velocity[i];
    return cement + s.links.inertial_energy(s.grid, s.sides);
  };
  const double before = energy(), inertial = s.links.inertial_energy(s.grid, s.sides);
  for (GrainSides::Motion& m : s.motion) {
    copy(s.random.vector(), m.jump);
    copy(s.random.vector(), m.jump + 3);
    for (int d = 0; d < 3; ++d) {
      m.v[d] += m.jump[d];
      m.omega[d] += m.jump[3 + d];
    }
  }
  s.sides.distribute(s.bodies, s.motion);
  EXPECT_NEAR(s.links.inertial_energy_ahead(s.grid, s.sides, 0.0, 2), inertial, 1e-12 * inertial);
  EXPECT_GT(std::fabs(s.links.inertial_energy(s.grid, s.sides) - inertial), 0.1 * inertial);
  s.sides.clear_forces();
  s.sides.clear_sudden_forces();
  s.links.follow_jumps(s.grid, s.sides, 1.0, 1.0);
  std::vector<double> momentum(change);
  double work = 0.0;
  for (std::size_t i = 0; i < change.size(); ++i) {
    s.grid.velocity[i] += change[i];
    momentum[i] *= s.grid.mass[i / 3];
  }
  for (GrainSide& g : s.sides.sides)
    for (int d = 0; d < 3; ++d) {
      g.force[d] = g.jump_force[d];
      g.torque[d] = g.jump_force[3 + d];
      work -= g.jump_force[d] * (g.v[d] - 0.5 * g.jump[d]) + g.jump_force[3 + d] * (g.omega[d] - 0.5 * g.jump[3 + d]);
    }
  s.expect_balanced(momentum, 1e-13, "momentum");
  EXPECT_NEAR(energy() - before, work, 1e-11 * before);

  // The same by forces, which is how momentum is exchanged at once.
  const std::vector<double> followed(change);
  s.grid.clear_force();
  s.sides.clear_forces();
  s.links.add_jumps(s.grid, s.sides, 0, false);
  s.links.carry_added_mass(s.grid, s.sides);
  s.grid.update_acceleration();
  test::Worst node, grain;
  for (std::size_t i = 0; i < change.size(); ++i) node.add(std::fabs(change[i] - followed[i]));
  for (const GrainSide& g : s.sides.sides)
    for (int d = 0; d < 3; ++d) grain.add(std::max(std::fabs(g.force[d] - g.jump_force[d]), std::fabs(g.torque[d] - g.jump_force[3 + d])));
  expect_within(node, 1e-13, "change of velocity");
  expect_within(grain, 1e-13, "momentum of the grains");
}

// (1 + t) times the stiffness, t the mass ratio of the grain.
TEST_P(AddedMass, LinksOfFreeGrainsCountMore) {
  Scene s = scene(156);
  const auto row_sums = [&] {
    s.sides.distribute(s.bodies, s.motion);
    std::fill(s.grid.penalty.begin(), s.grid.penalty.end(), 0.0);
    s.links.add_stiffness(s.grid, s.sides, kDt);
    return s.grid.penalty;
  };
  const std::vector<double> held = row_sums();
  s.motion[0].mass_ratio = 0.6;  // the first grain of the first body
  const std::vector<double> free = row_sums();
  test::Worst worst;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const bool of_first = body_of(s.grid.keys[i / 2][0]) == 0 && i % 2 == 0;
    if (held[i] > 0.0) worst.add(std::fabs(free[i] / ((of_first ? 1.6 : 1.0) * held[i]) - 1.0));
  }
  expect_within(worst, 1e-12, "row sums against (1 + t) times those of grains that are held");
}

// The energy that central differences keep is a product of velocities half a step before and after.
TEST_P(AddedMass, EnergyIsBilinearInTheVelocity) {
  constexpr double t = 0.3;
  Scene s = scene(155);
  s.place_grains(0.1, 1.0);
  set_added_mass(s);
  for (double& a : s.grid.acceleration) a = s.random.uniform(-1, 1);
  for (GrainSides::Motion& m : s.motion) {
    copy(s.random.vector(), m.a);
    copy(s.random.vector(), m.alpha);
  }
  // velocities of nodes and grains: share of the first ones, and so long of acceleration
  const std::vector<double> first = s.grid.velocity;
  const std::vector<GrainSides::Motion> motion = s.motion;
  const auto energy = [&](double share, double time, double early, double late, int body = 0) {
    for (std::size_t i = 0; i < first.size(); ++i) s.grid.velocity[i] = share * first[i] + time * s.grid.acceleration[i];
    for (std::size_t i = 0; i < motion.size(); ++i)
      for (int d = 0; d < 3; ++d) {
        s.motion[i].v[d] = share * motion[i].v[d] + time * motion[i].a[d];
        s.motion[i].omega[d] = share * motion[i].omega[d] + time * motion[i].alpha[d];
      }
    s.sides.distribute(s.bodies, s.motion);
    return s.links.inertial_energy(s.grid, s.sides, early, late, body);
  };
  const double E = energy(1.0, 0.0, t, t);
  EXPECT_GT(E, 0.0);
  test::expect_within(std::fabs(energy(1.0, t, 0.0, 0.0) / E - 1.0), 1e-13, "later velocity against acceleration");
  test::expect_within(std::fabs(energy(1.0, 0.0, 0.0, t) - energy(1.0, t / 2, 0.0, 0.0) + energy(0.0, t / 2, 0.0, 0.0)) / E, 1e-13,
                      "product against difference of squares");
  // bodies are counted from one on
  const double both = energy(1.0, 0.0, 0.0, 0.0), second = energy(1.0, 0.0, 0.0, 0.0, 1);
  EXPECT_TRUE(second > 0.0 && second < both);
  EXPECT_EQ(energy(1.0, 0.0, 0.0, 0.0, 2), 0.0);
}

// All links of one grain let go: added mass stays until it is dropped, and is then that of links that never were.
TEST_P(AddedMass, DroppedWithLinksThatLetGo) {
  Scene s = scene(155, 0.1);
  set_added_mass(s);
  const std::vector<double> whole = s.grid.penalty;
  std::vector<int> failed;
  for (const Link& k : s.points.links)
    if (k.grain == s.bodies[0].grain[0]) failed.push_back(k.slot);
  std::sort(failed.begin(), failed.end());
  double released = 0;
  EXPECT_GT(s.links.let_go(s.points, failed, s.grid, s.sides, released), 10);
  set_added_mass(s);
  EXPECT_EQ(s.grid.penalty, whole);
  EXPECT_GT(s.links.added_mass(s.grid, s.sides)[0], 0.0);

  s.links.drop_inertia(s.points);
  set_added_mass(s);
  const std::vector<double> dropped = s.grid.penalty;
  const std::vector<double> of_sides = s.links.added_mass(s.grid, s.sides);
  EXPECT_EQ(of_sides[0], 0.0);
  EXPECT_GT(of_sides[1], 0.0);
  s.sides.clear_forces();
  const std::vector<double> field(s.grid.force.size(), 1.0);
  s.links.add_reaction(s.grid, field, 1.0, s.sides);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(s.sides.sides[0].force[d], 0.0);

  PenaltyLinks rest;
  rest.build(s.points, s.bodies, s.links.parameters(), kH, kDensity, s.grid.basis);
  EXPECT_TRUE(rest.find_columns(s.grid));
  rest.bind(s.sides);
  rest.find_masters(s.grid);
  std::fill(s.grid.penalty.begin(), s.grid.penalty.end(), 0.0);
  rest.add_stiffness(s.grid, s.sides, kDt);
  double largest = 0.0, less = 0.0;
  test::Worst worst;
  for (std::size_t n = 0; n < dropped.size(); ++n) {
    largest = std::max(largest, whole[n]);
    less = std::max(less, whole[n] - dropped[n]);
  }
  for (std::size_t n = 0; n < dropped.size(); ++n) {
    worst.add(std::fabs(dropped[n] - s.grid.penalty[n]) / largest);
    EXPECT_EQ(dropped[n] == 0.0, s.grid.penalty[n] == 0.0);
  }
  EXPECT_GT(less, 0.1 * largest);
  expect_within(worst, 1e-14, "row sums against those of the links that are left");
}

std::string name_of(const ::testing::TestParamInfo<std::tuple<bool, bool, Basis>>& p) {
  const auto& [at_surface, tied, basis] = p.param;
  const char* const bases[] = {"linear", "quadratic", "cubic"};
  return std::string(at_surface ? "at_surface_" : "at_points_") + (tied ? "tied_" : "free_") + bases[static_cast<int>(basis)];
}

INSTANTIATE_TEST_SUITE_P(Penalty, AddedMass,
                         ::testing::Combine(::testing::Bool(), ::testing::Bool(),
                                            ::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic)),
                         name_of);

}  // namespace
}  // namespace mpdem
