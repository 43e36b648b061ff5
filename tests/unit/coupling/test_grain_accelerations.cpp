// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// coupling/grain_accelerations.cpp: the equations of motion of nodes and grains with added mass between them, and
// the bound of the time step, against matrices assembled here.
#include <Eigen/Dense>
#include <algorithm>
#include <tuple>

#include "coupling/grain_accelerations.h"
#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::copy;
using test::kBound;
using test::kDt;
using test::Scene;
using test::Vector;

// edge nodes constrained or free, basis, mass of the grains over that of the cement of a bond
class Accelerations : public ::testing::TestWithParam<std::tuple<bool, Basis, double>> {
 protected:
  // Grains 0 to 3; the second bond has the same grain at its first end as the first at its second, grain 1.
  struct Setting : Scene {
    using Scene::Scene;
    std::vector<Grain> grains;
    std::vector<GrainAccelerations::Vector6> load;  // of each
    GrainAccelerations accelerations;

    std::vector<GrainAccelerations::OfBond> of_bonds() const {
      std::vector<GrainAccelerations::OfBond> all;
      for (const Bond& b : bonds) all.push_back({&b.added, &b.grid, b.first_end_index});
      return all;
    }
  };
  Setting setting(std::uint64_t seed) const {
    const auto& [tied, basis, mass] = GetParam();
    Setting s(seed, test::penalty(true, 0.0), basis);
    if (tied) s.tie();
    double cement = 0.0;
    for (const Bond& b : s.bonds)
      for (double m : b.grid.mass) cement += 0.5 * m;
    const std::vector<std::vector<int>> sides{{0}, {1, 2}, {3}};
    for (const std::vector<int>& of : sides) {
      Grain g;
      g.ends = of;
      g.mass = mass * cement * s.random.uniform(0.5, 2.0);
      const double radius = s.records[of[0] / 2].radius[of[0] % 2];
      g.inertia = 0.4 * g.mass * radius * radius;
      for (bool& f : g.free) f = true;
      for (int i : of) s.motion[i].mass_ratio = 3.5 * of.size() * cement / g.mass;
      s.grains.push_back(g);
      s.load.emplace_back(GrainAccelerations::Vector6::Zero());
    }
    return s;
  }
};

void prepare(Scene& s, double lambda = 0.0) {
  s.ends.distribute(s.records, s.motion);
  s.set_added_mass(kDt, lambda);
}

TEST_P(Accelerations, SolveTheEquationsOfMotion) {
  Setting s = setting(171);
  s.place_grains(0.05, 1.0);
  prepare(s);
  int of_both = 0;
  for (const Bond& b : s.bonds)
    for (const AddedMass::OfNode& a : b.added.shares()) of_both += a.mass[0] > 0.0 && a.mass[1] > 0.0;
  EXPECT_GT(of_both, 5);
  for (int turn = 0; turn < 4; ++turn) {
    // all free, then some prescribed, which all ends at a grain get
    for (std::size_t n = 0; n < s.grains.size(); ++n) {
      Grain& g = s.grains[n];
      Vector a = Vector::Zero(), alpha = Vector::Zero();
      for (int i = 0; i < 6; ++i) {
        g.free[i] = turn == 0 || s.random.index(3) != 0;
        if (!g.free[i]) (i < 3 ? a : alpha)[i % 3] = s.random.uniform(-1, 1);
        s.load[n][i] = s.random.uniform(-1, 1);
      }
      copy(a, g.acceleration);
      copy(alpha, g.acceleration + 3);
      for (int side : g.ends) {
        copy(a, s.motion[side].a);
        copy(alpha, s.motion[side].alpha);
      }
    }
    s.ends.distribute(s.records, s.motion);
    s.ends.clear_forces();
    for (Bond& b : s.bonds)
      for (std::size_t i = 0; i < b.grid.force.size(); ++i)
        b.grid.force[i] = b.grid.constraints.row(static_cast<int>(i / 3)) < 0 ? s.random.uniform(-1, 1) : 0.0;
    const std::vector<std::vector<double>> force = s.forces();
    const std::vector<BondEnd> before = s.ends.ends;
    CondensedPack none;
    s.accelerations.find(MPI_COMM_SELF, s.of_bonds(), s.grains, s.load, s.ends, true, none);
    test::Worst node, grain;
    for (Bond& b : s.bonds) {
      b.added.accelerate(b.grid, s.ends_of(b));
      for (const AddedMass::OfNode& m : b.added.shares()) {
        Vector rest(&force[b.row][3 * m.node]);
        const Vector a(&b.grid.acceleration[3 * m.node]);
        rest -= b.grid.mass[m.node] * a;
        for (int side = 0; side < 2; ++side) {
          const BondEnd& g = s.ends_of(b)[side];
          const Vector arm = s.node(b.grid, m.node) - Vector(g.x);
          rest -= m.mass[side] * (a - Vector(g.a) - Vector(g.alpha).cross(arm));
        }
        node.add(rest.norm());
      }
    }
    for (std::size_t n = 0; n < s.grains.size(); ++n) {
      const Grain& g = s.grains[n];
      const BondEnd& first = s.ends.ends[g.ends[0]];
      Eigen::Matrix<double, 6, 1> rest = s.load[n], A;
      A << Vector(first.a), Vector(first.alpha);
      for (int side : g.ends) {
        const BondEnd& of = s.ends.ends[side];
        for (int d = 0; d < 3; ++d) {
          rest[d] += of.force[d];
          rest[3 + d] += of.torque[d];
        }
      }
      for (int i = 0; i < 6; ++i) {
        if (g.free[i]) grain.add(std::fabs(rest[i] - (i < 3 ? g.mass : g.inertia) * A[i]));
        else EXPECT_EQ(A[i], (i < 3 ? before[g.ends[0]].a[i] : before[g.ends[0]].alpha[i - 3]));
      }
    }
    expect_within(node, 1e-12, "forces on nodes that are left, forces being of order one");
    // grains as heavy as their cement are at the end of the sweeps
    expect_within(grain, std::get<2>(GetParam()) < 5 ? 1e-6 : 1e-8, "forces and moments on grains that are left");
  }
  EXPECT_GT(s.accelerations.sweeps(), 1);
}

// Places of the unknowns: those of free nodes with links come first, then those of grains.
struct Unknowns {
  struct Node {
    int bond, node;
  };
  std::vector<Node> nodes;
  std::vector<int> at[2], grain_of;  // at: place of each node of either bond, -1: none; grain_of: of each end
  int first = 0, size = 0;           // first unknown of the grains; number of all unknowns

  Unknowns(const Scene& s, const std::vector<Grain>& grains) : grain_of(s.ends.ends.size()) {
    for (const Bond& b : s.bonds) {
      at[b.row].assign(b.grid.size(), -1);
      const std::vector<double> k = s.row_sums(b);
      for (int n = 0; n < b.grid.size(); ++n)
        if (k[2 * n] + k[2 * n + 1] > 0.0) {
          at[b.row][n] = 3 * static_cast<int>(nodes.size());
          nodes.push_back({b.row, n});
        }
    }
    for (std::size_t g = 0; g < grains.size(); ++g)
      for (int side : grains[g].ends) grain_of[side] = static_cast<int>(g);
    first = 3 * static_cast<int>(nodes.size());
    size = first + 6 * static_cast<int>(grains.size());
  }
};

// Stiffness matrix of the links, found by small displacements.
Eigen::MatrixXd stiffness(Scene& s, const std::vector<Grain>& grains, const Unknowns& u) {
  constexpr double kStep = 1e-5;
  const std::vector<BondEnds::Motion> rest = s.motion;
  const auto forces = [&] {
    s.add_force();
    Eigen::VectorXd f = Eigen::VectorXd::Zero(u.size);
    for (std::size_t i = 0; i < u.nodes.size(); ++i)
      f.segment<3>(3 * i) = Vector(&s.bonds[u.nodes[i].bond].grid.force[3 * u.nodes[i].node]);
    for (std::size_t side = 0; side < u.grain_of.size(); ++side) {
      f.segment<3>(u.first + 6 * u.grain_of[side]) += Vector(s.ends.ends[side].force);
      f.segment<3>(u.first + 6 * u.grain_of[side] + 3) += Vector(s.ends.ends[side].torque);
    }
    return f;
  };
  const auto displaced = [&](int j, double by) {
    for (Bond& b : s.bonds) std::fill(b.grid.displacement.begin(), b.grid.displacement.end(), 0.0);
    s.motion = rest;
    if (j < u.first) {
      Grid& grid = s.bonds[u.nodes[j / 3].bond].grid;
      grid.displacement[3 * u.nodes[j / 3].node + j % 3] = by;
      grid.constraints.extend(grid.displacement.data());
    } else {
      const Vector direction = by * Vector::Unit((j - u.first) % 3);
      for (int side : grains[(j - u.first) / 6].ends) {
        if ((j - u.first) % 6 < 3) copy(Vector(s.motion[side].x) + direction, s.motion[side].x);
        else s.turn(side, direction);
      }
    }
    return forces();
  };
  Eigen::MatrixXd K(u.size, u.size);
  for (int j = 0; j < u.size; ++j) K.col(j) = (displaced(j, -kStep) - displaced(j, kStep)) / (2 * kStep);
  displaced(0, 0.0);
  return K;
}

Eigen::MatrixXd mass_matrix(const Scene& s, const std::vector<Grain>& grains, const Unknowns& u) {
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(u.size, u.size);
  const auto mass_of = [&](const Unknowns::Node& n) { return s.bonds[n.bond].grid.mass[n.node]; };
  for (std::size_t i = 0; i < u.nodes.size(); ++i) M.diagonal().segment<3>(3 * i).setConstant(mass_of(u.nodes[i]));
  for (std::size_t g = 0; g < grains.size(); ++g) {
    M.diagonal().segment<3>(u.first + 6 * g).setConstant(grains[g].mass);
    M.diagonal().segment<3>(u.first + 6 * g + 3).setConstant(grains[g].inertia);
  }
  for (const Bond& b : s.bonds)
    for (const AddedMass::OfNode& a : b.added.shares())
      for (int side = 0; side < 2; ++side) {
        const Vector r = s.node(b.grid, a.node) - Vector(s.ends_of(b)[side].x);
        const int part[2] = {u.at[b.row][a.node], u.first + 6 * u.grain_of[b.first_end_index + side]};
        Eigen::Matrix<double, 3, 9> relative;
        relative.leftCols<3>().setIdentity();
        relative.middleCols<3>(3) = -Eigen::Matrix3d::Identity();
        for (int d = 0; d < 3; ++d) relative.col(6 + d) = -Vector::Unit(d).cross(r);
        const Eigen::Matrix<double, 9, 9> m = a.mass[side] * relative.transpose() * relative;
        M.block<3, 3>(part[0], part[0]) += m.topLeftCorner<3, 3>();
        M.block<3, 6>(part[0], part[1]) += m.topRightCorner<3, 6>();
        M.block<6, 3>(part[1], part[0]) += m.bottomLeftCorner<6, 3>();
        M.block<6, 6>(part[1], part[1]) += m.bottomRightCorner<6, 6>();
      }
  return M;
}

// Is dt^2 times the largest eigenvalue at most `bound`? If and only if bound M - dt^2 K is not negative.
bool is_stable(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M, double bound) {
  const Eigen::MatrixXd A = bound * M - 0.5 * kDt * kDt * (K + K.transpose());
  return Eigen::LLT<Eigen::MatrixXd>(A).info() == Eigen::Success;
}

// No cement is stiffer than one of which each node has the largest eigenvalue.
TEST_P(Accelerations, BoundOfTheTimeStepHolds) {
  Setting s = setting(172);
  s.place_grains(0.0, 0.0);
  prepare(s);
  const Unknowns u(s, s.grains);
  const Eigen::MatrixXd K = stiffness(s, s.grains, u);
  for (double share : {0.0, 0.5, 0.95}) {
    const double lambda = share * kBound / (kDt * kDt);
    prepare(s, lambda);
    EXPECT_GT(s.bonds[0].added.shares().size() + s.bonds[1].added.shares().size(), 10u);
    const Eigen::MatrixXd M = mass_matrix(s, s.grains, u);
    Eigen::MatrixXd both = K;
    for (int i = 0; i < u.first; ++i) both(i, i) += lambda * s.bonds[u.nodes[i / 3].bond].grid.mass[u.nodes[i / 3].node];
    EXPECT_TRUE(is_stable(both, M, kBound)) << "cement at " << share;
    EXPECT_FALSE(is_stable(both, M, (std::get<2>(GetParam()) < 5 ? 0.1 : 0.5) * kBound)) << "cement at " << share;
  }
}

std::string name_of_grains(const ::testing::TestParamInfo<std::tuple<bool, Basis, double>>& p) {
  const auto& [tied, basis, mass] = p.param;
  const char* const bases[] = {"linear", "quadratic", "cubic"};
  return std::string(tied ? "tied_" : "free_") + bases[static_cast<int>(basis)] +
         (mass < 5     ? "_light"
          : mass < 100 ? "_middling"
                       : "_heavy");
}

INSTANTIATE_TEST_SUITE_P(Grains, Accelerations,
                         ::testing::Combine(::testing::Bool(), ::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic),
                                            ::testing::Values(1.0, 10.0, 1000.0)),
                         name_of_grains);

}  // namespace
}  // namespace mpdem
