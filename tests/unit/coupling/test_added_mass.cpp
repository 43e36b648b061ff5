// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// coupling/added_mass.h: row sums against the stiffness matrix of the links, assembled by unit
// displacements; what the added mass exerts on nodes and grains; debonded links.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <tuple>

#include "coupling/rigid_motion.h"
#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::copy;
using test::kBound;
using test::kDensity;
using test::kDt;
using test::kH;
using test::Scene;
using test::Vector;

// at the surface or at the points, edge nodes constrained or free, basis
class AddedMassOfLinks : public ::testing::TestWithParam<std::tuple<bool, bool, Basis>> {
 protected:
  Scene scene(std::uint64_t seed, double damping = 0.0) const {
    Scene s(seed, test::penalty(std::get<0>(GetParam()), damping), std::get<2>(GetParam()));
    if (std::get<1>(GetParam())) {
      s.tie();
      EXPECT_GT(s.bonds[0].grid.constraints.size() + s.bonds[1].grid.constraints.size(), 20u);
    }
    return s;
  }
};

// Row sum of a node, of the links to both grains.
double row_sum(const std::vector<double>& row_sums, int n) { return row_sums[2 * n] + row_sums[2 * n + 1]; }

std::vector<int> free_nodes(const Grid& grid) {
  std::vector<int> nodes;
  for (int n = 0; n < grid.size(); ++n)
    if (grid.constraints.row(n) < 0) nodes.push_back(n);
  return nodes;
}

// Mass times a field of each bond.
std::vector<std::vector<double>> momentum_of(const Scene& s, std::vector<double> Grid::*field) {
  std::vector<std::vector<double>> p;
  for (const Bond& b : s.bonds) {
    p.push_back(b.grid.*field);
    for (std::size_t i = 0; i < p.back().size(); ++i) p.back()[i] *= b.grid.mass[i / 3];
  }
  return p;
}

// Minus the force on the nodes by a unit of `field`, which is displacement or velocity, at each.
Eigen::MatrixXd response(Scene& s, Grid& grid, std::vector<double>& field, const std::vector<int>& nodes) {
  s.place_grains(0.0, 0.0);
  const int size = 3 * static_cast<int>(nodes.size());
  Eigen::MatrixXd K(size, size);
  for (int j = 0; j < size; ++j) {
    std::fill(field.begin(), field.end(), 0.0);
    field[3 * nodes[j / 3] + j % 3] = 1.0;
    grid.constraints.extend(field.data());
    s.add_force();
    for (int i = 0; i < size; ++i) K(i, j) = -grid.force[3 * nodes[i / 3] + i % 3];
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

TEST_P(AddedMassOfLinks, RowSumsBoundTheStiffness) {
  Scene s = scene(151, 0.1);
  s.set_added_mass();
  std::vector<double> row_sums[2];
  double largest = 0.0;
  for (const Bond& b : s.bonds) {
    row_sums[b.row] = s.row_sums(b);
    for (double k : row_sums[b.row]) largest = std::max(largest, k);
  }
  test::Worst row, tight, matrix, step, asymmetry;
  for (Bond& b : s.bonds) {
    Grid& grid = b.grid;
    const std::vector<int> nodes = free_nodes(grid);
    // a damper counts as a spring 2 g/dt
    const Eigen::MatrixXd C = response(s, grid, grid.velocity, nodes);
    const Eigen::MatrixXd K = response(s, grid, grid.displacement, nodes) + 2.0 / kDt * C;
    asymmetry.add((K - K.transpose()).cwiseAbs().maxCoeff() / K.cwiseAbs().maxCoeff());
    std::vector<double> penalty, mass;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      penalty.push_back(row_sum(row_sums[b.row], nodes[i]));
      mass.push_back(grid.mass[nodes[i]] + b.added.of_nodes()[nodes[i]]);
      if (penalty[i] == 0.0) continue;
      double sum = 0.0;
      for (std::size_t j = 0; j < nodes.size(); ++j) sum += K.block<3, 3>(3 * i, 3 * j).jacobiSvd().singularValues()[0];
      row.add((sum - penalty[i]) / largest, std::to_string(nodes[i]));
      tight.add(sum / std::max(penalty[i], 1e-3 * largest));
    }
    matrix.add(largest_eigenvalue(K, penalty));
    step.add(kDt * kDt * largest_eigenvalue(K, mass) / kBound);
    for (int n = 0; n < grid.size(); ++n)
      if (grid.constraints.row(n) >= 0) {
        EXPECT_EQ(row_sum(row_sums[b.row], n), 0.0);
      }
  }
  expect_within(asymmetry, 1e-12, "asymmetry of the stiffness");
  expect_within(row, 1e-12, "sizes of the blocks of a row beyond the row sum");
  expect_within(matrix, 1.0 + 1e-12, "largest eigenvalue of the stiffness over the row sums");
  expect_within(step, 1.0, "largest dt^2 eigenvalue with the added mass, over the bound");
  // nor are they far too large, which would cost mass
  EXPECT_GT(tight.value(), 0.9);
  EXPECT_GT(matrix.value(), 0.7);
}

// dt^2 (lambda m + k) <= bound (m + c) at every node, and no mass without need. A bound of the eigenvalue that knows
// nothing of constrained nodes is raised node by node.
TEST_P(AddedMassOfLinks, IsEnoughAndNoMore) {
  Scene s = scene(158, 0.1);
  int raised = 0, none = 0, some = 0;
  for (double dt : {0.2 * kDt, kDt, 5 * kDt})
    for (double bound : {4.0, 2.0})
      for (double share : {0.0, 0.25, 1.0})
        for (bool is_bound : {false, true}) {
          for (Bond& b : s.bonds) {
            const double lambda = share * bound / (dt * dt);
            b.added.find(b.links, b.grid, s.ends_of(b), {dt, lambda, is_bound, bound});
            const std::vector<double> row_sums = s.row_sums(b, dt);
            ASSERT_EQ(b.added.of_nodes().size(), b.grid.mass.size());
            for (int n = 0; n < b.grid.size(); ++n) {
              const double m = b.grid.mass[n], a = b.added.of_nodes()[n], k = row_sum(row_sums, n);
              const double cement_load = std::min(bound, dt * dt * lambda * (is_bound ? b.grid.constraint_factor(n) : 1.0));
              const double load = cement_load * m + dt * dt * k;
              raised += is_bound && share > 0.0 && b.grid.constraint_factor(n) > 1.001;
              EXPECT_LE(load, bound * (m + a) * (1 + 1e-14));
              if (k == 0.0) {
                EXPECT_EQ(a, 0.0);
              }
              none += a == 0.0;
              if (a > 0.0) {
                ++some;
                EXPECT_LE(bound * (m + a), 1.06 * load);
              }
            }
          }
        }
  EXPECT_GT(some, 0);
  EXPECT_GT(none, 0);
  EXPECT_EQ(raised > 0, std::get<1>(GetParam()));
}

// Shares are of the nodes that have added mass, in their order, and split it by the stiffness of the links to either grain.
TEST_P(AddedMassOfLinks, SharesAreByStiffness) {
  Scene s = scene(159);
  s.set_added_mass();
  for (const Bond& b : s.bonds) {
    const std::vector<double> k = s.row_sums(b);
    const SharedList<double>& mass = b.added.of_nodes();
    const std::vector<AddedMass::OfNode> shares = b.added.shares();
    std::size_t at = 0;
    test::Worst worst;
    for (int n = 0; n < b.grid.size(); ++n) {
      if (mass[n] == 0.0) continue;
      ASSERT_LT(at, shares.size());
      const AddedMass::OfNode& a = shares[at++];
      EXPECT_EQ(a.node, n);
      for (int side = 0; side < 2; ++side) worst.add(std::fabs(a.mass[side] - mass[n] * k[2 * n + side] / row_sum(k, n)) / mass[n]);
    }
    EXPECT_EQ(at, shares.size());
    EXPECT_EQ(b.added.empty(), at == 0);
    expect_within(worst, 1e-14, "share of a side");
  }
}

// The rates of momentum and angular momentum of nodes (without added mass) and grains.
TEST_P(AddedMassOfLinks, ActionIsReaction) {
  Scene s = scene(134, 0.1);
  s.place_grains(0.1, 1.0);
  s.set_added_mass();
  int stiff = 0, nodes = 0;
  double row_sums = 0, stiffness = 0;
  for (const Bond& b : s.bonds) {
    const std::vector<double> of_nodes = s.row_sums(b);
    nodes += b.grid.size();
    for (int n = 0; n < b.grid.size(); ++n) {
      stiff += b.added.of_nodes()[n] > 0;
      row_sums += row_sum(of_nodes, n);
    }
    for (const Link& k : b.points.links) {
      const double spring = b.links.parameters().law->stiffness().kn * k.area;
      const double mass = kDensity * b.points.blocks[k.slot / kLanes].volume[k.slot % kLanes];
      stiffness += spring + 2.0 / kDt * 2.0 * b.links.parameters().damping * std::sqrt(spring * mass);
    }
  }
  EXPECT_GT(stiff, 10);
  EXPECT_LT(stiff, nodes);
  // Some weights are negative at a place outside the cell of its point, and with constrained nodes; sizes count.
  const auto& [at_surface, tied, basis] = GetParam();
  if (at_surface || tied) EXPECT_GT(row_sums, stiffness);
  else test::expect_within(std::fabs(row_sums / stiffness - 1.0), 1e-13, "sum of the stiffness");
  s.add_force();
  const std::vector<std::vector<double>> springs = s.forces();
  for (Bond& b : s.bonds)
    for (int n = 0; n < b.grid.size(); ++n)
      if (b.grid.constraints.row(n) < 0)
        for (int d = 0; d < 3; ++d) b.grid.force[3 * n + d] += 0.01 * s.random.uniform(-1, 1);  // of the cement
  const std::vector<std::vector<double>> all = s.forces();
  for (Bond& b : s.bonds) {
    b.added.accelerate(b.grid, s.ends_of(b));
  }
  // what the springs put on the nodes is balanced by the grains; take the rest away
  std::vector<std::vector<double>> rate = momentum_of(s, &Grid::acceleration);
  for (int b = 0; b < 2; ++b)
    for (std::size_t i = 0; i < rate[b].size(); ++i) rate[b][i] -= all[b][i] - springs[b][i];
  s.expect_balanced(rate, 1e-13, "with added mass");
}

TEST_P(AddedMassOfLinks, SidesHaveWhatNodesHave) {
  Scene s = scene(152);
  s.set_added_mass();
  for (const Bond& b : s.bonds) {
    double of_nodes = 0, of_ends[2] = {0, 0};
    for (double m : b.added.of_nodes()) of_nodes += m;
    b.added.add_to_ends(b.grid, of_ends);
    EXPECT_GT(of_nodes, 0.0);
    test::expect_within(std::fabs((of_ends[0] + of_ends[1]) / of_nodes - 1.0), 1e-13, "sum over sides against that over nodes");
  }
}

// Equal bonds share what they have in common. Their results are bitwise identical, and a change of one does not affect the others.
TEST_P(AddedMassOfLinks, EqualBondsHoldTheirListsTogether) {
  Scene scenes[] = {scene(160), scene(160), scene(160)};  // the last shares nothing
  AlikeLists alike;
  const auto bytes = [&](const Scene& s) {
    double sum = 0.0;
    for (const Bond& b : s.bonds) sum += b.grid.constraints.memory_usage() + b.links.memory_usage() + b.added.memory_usage();
    return sum;
  };
  for (Scene& s : scenes) {
    s.place_grains(0.1, 1.0);
    s.set_added_mass();
    if (&s == &scenes[2]) continue;
    for (Bond& b : s.bonds) b.share(alike);
  }
  EXPECT_LT(bytes(scenes[0]), 0.75 * bytes(scenes[2]));
  const auto answer = [](Scene& s) {
    s.ends.clear_forces();
    for (Bond& b : s.bonds) b.grid.clear_force();
    s.add_force();
    for (Bond& b : s.bonds) {
      b.grid.constraints.gather_to_masters(b.grid.force.data());
      b.added.accelerate(b.grid, s.ends_of(b));
    }
    std::vector<double> all;
    for (const Bond& b : s.bonds) all.insert(all.end(), b.grid.acceleration.begin(), b.grid.acceleration.end());
    for (const BondEnd& g : s.ends.ends) all.insert(all.end(), g.force, g.force + 3);
    return all;
  };
  const std::vector<double> whole = answer(scenes[2]);
  EXPECT_EQ(answer(scenes[0]), whole);
  EXPECT_EQ(answer(scenes[1]), whole);
  // a point fails, and links get another order
  for (Scene* s : {&scenes[0], &scenes[2]}) {
    Bond& b = s->bonds[0];
    ASSERT_FALSE(b.points.links.empty());
    double released = 0.0;
    b.links.debond(b.points, {b.points.links.front().slot}, b.grid, s->ends_of(b), 0.0, released);
    EXPECT_TRUE(b.links.drop_added_mass(b.points));
    std::vector<int> order(b.points.links.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(order.size() - 1 - i);
    std::reverse(b.points.links.begin(), b.points.links.end());
    b.links.renumber(order);
    for (double& m : b.grid.mass.own()) m *= 2.0;
    b.added.find(b.links, b.grid, s->ends_of(b), {kDt, 0.0, false, kBound});
  }
  const std::vector<double> other = answer(scenes[2]);
  EXPECT_NE(other, whole);
  EXPECT_EQ(answer(scenes[0]), other);
  EXPECT_EQ(answer(scenes[1]), whole);
}

// Grains accelerate and rotate, each on its own.
TEST_P(AddedMassOfLinks, CarriedByGrains) {
  Scene s = scene(153);
  s.place_grains(0.1, 1.0);
  s.set_added_mass();
  s.ends.clear_forces();
  for (Bond& b : s.bonds) {
    b.grid.clear_force();
    b.added.accelerate(b.grid, s.ends_of(b));
    for (double a : b.grid.acceleration) EXPECT_EQ(a, 0.0);
  }
  s.accelerate_grains();
  for (Bond& b : s.bonds) {
    b.added.accelerate(b.grid, s.ends_of(b));
  }
  s.expect_balanced(momentum_of(s, &Grid::acceleration), 1e-13, "carried");
}

// Both grains of a bond and its nodes accelerate as one rigid body does. Nodes then accelerate as if there were no
// added mass, and grains feel nothing of it.
TEST_P(AddedMassOfLinks, ExertsNothingWhereNodesMoveWithTheGrain) {
  Scene s = scene(154);
  s.place_grains(0.1, 1.0);
  s.set_added_mass();
  std::vector<double> field[2];
  for (int b = 0; b < 2; ++b) {
    const Grid& grid = s.bonds[b].grid;
    const Vector a = s.random.vector(), alpha = s.random.vector();
    for (int i = 2 * b; i < 2 * b + 2; ++i) {
      const Vector x = Eigen::Map<const Vector>(s.ends.ends[i].x);
      copy(a + alpha.cross(x), s.motion[i].a);
      copy(alpha, s.motion[i].alpha);
    }
    field[b].resize(3 * grid.size());
    for (int n = 0; n < grid.size(); ++n) copy(a + alpha.cross(s.node(grid, n)), &field[b][3 * n]);
  }
  s.ends.distribute(s.records, s.motion);
  s.ends.clear_forces();
  double size = 0.0;
  test::Worst node, grain;
  for (Bond& b : s.bonds) {
    const std::vector<double>& of_other = field[b.row];
    const SharedList<double>& added = b.added.of_nodes();
    for (std::size_t i = 0; i < of_other.size(); ++i) b.grid.force[i] = b.grid.mass[i / 3] * of_other[i];  // of the cement
    b.added.accelerate(b.grid, s.ends_of(b));
    for (std::size_t i = 0; i < of_other.size(); ++i) size = std::max(size, std::fabs(added[i / 3] * of_other[i]));
    for (std::size_t i = 0; i < of_other.size(); ++i)
      if (added[i / 3] > 0.0) node.add(std::fabs(b.grid.acceleration[i] - of_other[i]));
  }
  EXPECT_GT(size, 0.0);
  for (const BondEnd& g : s.ends.ends)
    for (int d = 0; d < 3; ++d) grain.add(std::max(std::fabs(g.force[d]), std::fabs(g.torque[d])) / size);
  expect_within(node, 1e-13, "acceleration of nodes with added mass");
  expect_within(grain, 1e-11, "force and moment on grains, over what carries the mass of a node");
}

double added_energy(const Scene& s, double early = 0.0, double late = 0.0) {
  double energy = 0.0;
  for (const Bond& b : s.bonds) energy += b.added.energy(b.grid, s.ends_of(b), early, late);
  return energy;
}

// Grains that jump take nodes along: momentum is kept, energy changes by the work of the reaction at the mean velocity of each
// grain, and added mass has the energy before the jump until its nodes follow.
TEST_P(AddedMassOfLinks, FollowsJumps) {
  Scene s = scene(157);
  s.place_grains(0.1, 1.0);
  s.set_added_mass();
  for (Bond& b : s.bonds) std::fill(b.grid.acceleration.begin(), b.grid.acceleration.end(), 0.0);
  const auto energy = [&] {
    double cement = 0.0;
    for (const Bond& b : s.bonds)
      for (std::size_t i = 0; i < b.grid.velocity.size(); ++i) cement += 0.5 * b.grid.mass[i / 3] * b.grid.velocity[i] * b.grid.velocity[i];
    return cement + added_energy(s);
  };
  const double before = energy(), inertial = added_energy(s);
  for (BondEnds::Motion& m : s.motion) {
    copy(s.random.vector(), m.jump);
    copy(s.random.vector(), m.jump + 3);
    for (int d = 0; d < 3; ++d) {
      m.v[d] += m.jump[d];
      m.omega[d] += m.jump[3 + d];
    }
  }
  s.ends.distribute(s.records, s.motion);
  double ahead = 0.0;
  for (const Bond& b : s.bonds) ahead += b.added.energy_ahead(b.grid, s.ends_of(b), 0.0);
  EXPECT_NEAR(ahead, inertial, 1e-12 * inertial);
  EXPECT_GT(std::fabs(added_energy(s) - inertial), 0.1 * inertial);
  s.ends.clear_forces();
  s.ends.clear_sudden_forces();
  for (Bond& b : s.bonds) b.added.follow_jumps(b.grid, s.ends_of(b), 1.0, 1.0, {});
  const std::vector<std::vector<double>> momentum = momentum_of(s, &Grid::acceleration);
  double work = 0.0;
  for (Bond& b : s.bonds)
    for (std::size_t i = 0; i < b.grid.velocity.size(); ++i) b.grid.velocity[i] += b.grid.acceleration[i];
  for (BondEnd& g : s.ends.ends)
    for (int d = 0; d < 3; ++d) {
      g.force[d] = g.jump_force[d];
      g.torque[d] = g.jump_force[3 + d];
      work -= g.jump_force[d] * (g.v[d] - 0.5 * g.jump[d]) + g.jump_force[3 + d] * (g.omega[d] - 0.5 * g.jump[3 + d]);
    }
  s.expect_balanced(momentum, 1e-13, "momentum");
  EXPECT_NEAR(energy() - before, work, 1e-11 * before);

  // Forces give the same change. This is how momentum is exchanged at once.
  s.ends.clear_forces();
  test::Worst node, grain;
  for (Bond& b : s.bonds) {
    const std::vector<double> followed(b.grid.acceleration);
    b.grid.clear_force();
    b.added.add_jumps(b.grid, s.ends_of(b), false);
    b.added.accelerate(b.grid, s.ends_of(b));
    for (std::size_t i = 0; i < followed.size(); ++i) node.add(std::fabs(b.grid.acceleration[i] - followed[i]));
  }
  for (const BondEnd& g : s.ends.ends)
    for (int d = 0; d < 3; ++d) grain.add(std::max(std::fabs(g.force[d] - g.jump_force[d]), std::fabs(g.torque[d] - g.jump_force[3 + d])));
  expect_within(node, 1e-13, "change of velocity");
  expect_within(grain, 1e-13, "momentum of the grains");
}

// Nodes that gain added mass keep the energy of their motion against the grain, those that lose it keep their velocity.
// Momentum is kept, and what the cement loses is its kinetic energy less the work on the grains.
TEST_P(AddedMassOfLinks, TakesUpMassWithoutGainOfEnergy) {
  Scene s = scene(158);
  s.place_grains(0.1, 1.0);
  s.set_added_mass();
  s.ends.clear_forces();
  s.ends.clear_sudden_forces();
  test::Worst kept, same;
  double lost = 0.0, kinetic = 0.0;
  int slowed = 0;
  for (Bond& b : s.bonds) {
    Grid& grid = b.grid;
    std::fill(grid.acceleration.begin(), grid.acceleration.end(), 0.0);
    grid.constraints.extend(grid.velocity.data());
    std::vector<AddedMass::OfNode> before = b.added.shares();
    const std::vector<AddedMass::OfNode> now = before;
    const auto ends_of = [&](std::size_t n) { return now[n].mass[0] > 0.0 ? 0 : 1; };  // the end whose mass changes
    for (std::size_t n = 0; n < now.size(); ++n) before[n].mass[ends_of(n)] *= n % 3 == 0 ? 0.0 : n % 3 == 1 ? 0.3 : 2.0;
    const std::vector<double> first = grid.velocity;
    std::vector<AddedMass::OfNode> listed;
    std::copy_if(before.begin(), before.end(), std::back_inserter(listed),
                 [](const AddedMass::OfNode& a) { return a.mass[0] + a.mass[1] > 0.0; });
    const auto grains_go_on = [&](double time) {
      for (int n = 0; n < 2; ++n)
        for (int d = 0; d < 3; ++d) s.ends_of(b)[n].x[d] += time * s.ends_of(b)[n].v[d];
    };
    grains_go_on(1.0);
    lost += b.added.slow_nodes(listed, grid, s.ends_of(b), 0.0, 1.0);
    grains_go_on(-1.0);
    for (std::size_t n = 0; n < now.size(); ++n) {
      const int node = now[n].node, side = ends_of(n);
      double r[3], of_grain[3], was = 0.0, is = 0.0, change = 0.0;
      lever_arm(grid, node, s.ends_of(b)[side], r);
      velocity_at(s.ends_of(b)[side], r, of_grain);
      for (int d = 0; d < 3; ++d) {
        was += std::pow(first[3 * node + d] - of_grain[d], 2);
        is += std::pow(grid.velocity[3 * node + d] - of_grain[d], 2);
        change += std::fabs(grid.velocity[3 * node + d] - first[3 * node + d]);
      }
      if (n % 3 == 2) same.add(change);
      else
        kept.add(std::fabs(is / was - (grid.mass[node] + before[n].mass[0] + before[n].mass[1]) /
                                          (grid.mass[node] + now[n].mass[0] + now[n].mass[1])));
      slowed += n % 3 != 2 && is < was;
    }
    for (std::size_t i = 0; i < first.size(); ++i) {
      grid.acceleration[i] = grid.velocity[i] - first[i];
      kinetic += 0.5 * grid.mass[i / 3] * (first[i] * first[i] - grid.velocity[i] * grid.velocity[i]);
    }
    const std::vector<double> moved = grid.acceleration;
    grid.constraints.extend(grid.acceleration.data());
    for (std::size_t i = 0; i < moved.size(); ++i) same.add(std::fabs(grid.acceleration[i] - moved[i]));  // constrained nodes follow
  }
  EXPECT_GT(slowed, 20);
  expect_within(kept, 1e-12, "energy against the grain");
  expect_within(same, 1e-14, "velocity of the other nodes");
  for (BondEnd& g : s.ends.ends)
    for (int d = 0; d < 3; ++d) {
      g.force[d] = g.transfer_force[d];
      g.torque[d] = g.transfer_force[3 + d];
      kinetic -= g.force[d] * g.v[d] + g.torque[d] * g.omega[d];
    }
  s.expect_balanced(momentum_of(s, &Grid::acceleration), 1e-13, "momentum");
  EXPECT_NEAR(lost, kinetic, 1e-11 * std::fabs(kinetic));
}

// Links of a free grain count with (1 + t) times their stiffness. t is the mass ratio of the grain.
TEST_P(AddedMassOfLinks, LinksOfFreeGrainsCountMore) {
  Scene s = scene(156);
  const std::vector<double> held[2] = {s.row_sums(s.bonds[0]), s.row_sums(s.bonds[1])};
  s.motion[0].mass_ratio = 0.6;  // the first grain of the first bond
  s.ends.distribute(s.records, s.motion);
  test::Worst worst;
  for (const Bond& b : s.bonds) {
    const std::vector<double> free = s.row_sums(b);
    for (std::size_t i = 0; i < free.size(); ++i) {
      const bool of_first = b.row == 0 && i % 2 == 0;
      if (held[b.row][i] > 0.0) worst.add(std::fabs(free[i] / ((of_first ? 1.6 : 1.0) * held[b.row][i]) - 1.0));
    }
  }
  expect_within(worst, 1e-12, "row sums against (1 + t) times those of grains that are held");
}

// The energy that central differences keep is a product of velocities half a step before and after.
TEST_P(AddedMassOfLinks, EnergyIsBilinearInTheVelocity) {
  constexpr double t = 0.3;
  Scene s = scene(155);
  s.place_grains(0.1, 1.0);
  s.set_added_mass();
  for (Bond& b : s.bonds)
    for (double& a : b.grid.acceleration) a = s.random.uniform(-1, 1);
  s.accelerate_grains();
  // velocities of nodes and grains: share of the first ones, and so long of acceleration
  const std::vector<double> first[2] = {s.bonds[0].grid.velocity, s.bonds[1].grid.velocity};
  const std::vector<BondEnds::Motion> motion = s.motion;
  const auto energy = [&](double share, double time, double early, double late) {
    for (Bond& b : s.bonds)
      for (std::size_t i = 0; i < b.grid.velocity.size(); ++i) b.grid.velocity[i] = share * first[b.row][i] + time * b.grid.acceleration[i];
    for (std::size_t i = 0; i < motion.size(); ++i)
      for (int d = 0; d < 3; ++d) {
        s.motion[i].v[d] = share * motion[i].v[d] + time * motion[i].a[d];
        s.motion[i].omega[d] = share * motion[i].omega[d] + time * motion[i].alpha[d];
      }
    s.ends.distribute(s.records, s.motion);
    return added_energy(s, early, late);
  };
  const double E = energy(1.0, 0.0, t, t);
  EXPECT_GT(E, 0.0);
  test::expect_within(std::fabs(energy(1.0, t, 0.0, 0.0) / E - 1.0), 1e-13, "later velocity against acceleration");
  test::expect_within(std::fabs(energy(1.0, 0.0, 0.0, t) - energy(1.0, t / 2, 0.0, 0.0) + energy(0.0, t / 2, 0.0, 0.0)) / E, 1e-13,
                      "product against difference of squares");
}

// All links of one grain debond. Added mass stays until it is dropped. It is then as if these links had never been.
TEST_P(AddedMassOfLinks, DroppedWithLinksThatLetGo) {
  Scene s = scene(155, 0.1);
  Bond& b = s.bonds[0];
  const std::vector<double> whole = s.row_sums(b);
  std::vector<int> failed;
  for (const Link& k : b.points.links)
    if (k.grain == s.records[0].grain[0]) failed.push_back(k.slot);
  std::sort(failed.begin(), failed.end());
  EXPECT_GT(failed.size(), 10u);
  double released = 0;
  b.links.debond(b.points, failed, b.grid, s.ends_of(b), 0.0, released);
  for (const Link& k : b.points.links)
    if (k.grain == s.records[0].grain[0]) {
      EXPECT_FALSE(k.attached);
    }
  EXPECT_EQ(s.row_sums(b), whole);
  s.set_added_mass();
  double held[2] = {0, 0}, left[2] = {0, 0};
  b.added.add_to_ends(b.grid, held);
  EXPECT_GT(held[0], 0.0);

  b.links.drop_added_mass(b.points);
  s.set_added_mass();
  const std::vector<double> dropped = s.row_sums(b);
  b.added.add_to_ends(b.grid, left);
  EXPECT_EQ(left[0], 0.0);
  EXPECT_GT(left[1], 0.0);
  s.ends.clear_forces();
  s.ends.clear_sudden_forces();
  const std::vector<double> field(b.grid.force.size(), 1.0);
  b.added.add_reaction(b.grid, field, 1.0, s.ends_of(b));
  for (int d = 0; d < 3; ++d) EXPECT_EQ(s.ends.ends[0].force[d], 0.0);
  for (double f : s.ends.ends[0].transfer_force) EXPECT_EQ(f, 0.0);

  b.links = s.links_anew(b);
  const std::vector<double> rest = s.row_sums(b);
  double largest = 0.0, less = 0.0;
  test::Worst worst;
  for (std::size_t n = 0; n < dropped.size(); ++n) {
    largest = std::max(largest, whole[n]);
    less = std::max(less, whole[n] - dropped[n]);
  }
  for (std::size_t n = 0; n < dropped.size(); ++n) {
    worst.add(std::fabs(dropped[n] - rest[n]) / largest);
    EXPECT_EQ(dropped[n] == 0.0, rest[n] == 0.0);
  }
  EXPECT_GT(less, 0.1 * largest);
  expect_within(worst, 1e-14, "row sums against those of the links that are left");
}

std::string name_of(const ::testing::TestParamInfo<std::tuple<bool, bool, Basis>>& p) {
  const auto& [at_surface, tied, basis] = p.param;
  const char* const bases[] = {"linear", "quadratic", "cubic"};
  return std::string(at_surface ? "at_surface_" : "at_points_") + (tied ? "tied_" : "free_") + bases[static_cast<int>(basis)];
}

INSTANTIATE_TEST_SUITE_P(Penalty, AddedMassOfLinks,
                         ::testing::Combine(::testing::Bool(), ::testing::Bool(),
                                            ::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic)),
                         name_of);

}  // namespace
}  // namespace mpdem
