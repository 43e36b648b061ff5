// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// cement/condensed/static_bond.h and Cement::stiffness_of_bonds(), on 1, 2 and 4 ranks: closed forms, the engine's own runs, and what every
// stiffness has.
#include "cement/condensed/static_bond.h"

#include <Eigen/Geometry>
#include <type_traits>

#include "cement/condensed/bond_description.h"
#include "cement_host.h"
#include "linked_bonds.h"
#include "mpi_ranks.h"

namespace mpdem {
namespace {

using test::Row;
using test::RowOfGrains;

Eigen::Map<const Matrix6> matrix(const StiffnessOfBond& s) { return Eigen::Map<const Matrix6>(s.K); }

Row elastic_row(int bonds = 1, bool whole = false) {
  Row r;
  r.bonds = bonds;
  r.whole_bonds = whole;
  r.B0 = 0.0;
  return r;
}

// Stiffness of layers of cement side by side, each with its links in series.
// It is the sum of modulus r^power over t + 2 modulus/k, for r below the outer radius.
double layers(double modulus, int power) {
  double sum = 0.0;
  constexpr int kRings = 2000;
  for (int n = 0; n < kRings; ++n) {
    const double r = (n + 0.5) * test::kOuter / kRings, t = test::kGap + r * r / test::kRadius;
    sum += modulus * std::pow(r, power) / (t + 2.0 * modulus / test::kPenalty) * 2.0 * M_PI * r * test::kOuter / kRings;
  }
  return sum;
}

// Without Poisson's ratio a disc between plates is in uniaxial strain under tension and bending, and in simple shear under torsion.
TEST(StaticBond, TensionTorsionAndBendingOfDisc) {
  RowOfGrains host(MPI_COMM_WORLD, elastic_row());
  const StiffnessOfBond s = host.cement->stiffness_of_bonds()[0];
  const PrincipalStiffness p = principal_stiffness(matrix(s), {s.axis[0], s.axis[1], s.axis[2]});
  test::expect_within(std::fabs(p.tension / layers(test::kYoung, 0) - 1.0), 0.01, "tension");
  test::expect_within(std::fabs(p.torsion / layers(0.5 * test::kYoung, 2) - 1.0), 0.02, "torsion");
  test::expect_within(std::fabs(p.bending[0] / (0.5 * layers(test::kYoung, 2)) - 1.0), 0.02, "bending");
  test::expect_within(std::fabs(p.bending[1] / p.bending[0] - 1.0), 1e-6, "bending about x and y");
  // not in simple shear: the disc is as wide as it is thick
  EXPECT_LT(p.shear[0], layers(0.5 * test::kYoung, 0));
  EXPECT_GT(p.shear[0], 0.5 * layers(0.5 * test::kYoung, 0));
  for (int d = 0; d < 2; ++d) EXPECT_NEAR(s.middle[d], 0.0, 1e-12);
  EXPECT_NEAR(s.middle[2], test::kRadius + 0.5 * test::kGap, 1e-12);
}

// A query gets a scene that it cannot change.
static_assert(std::is_same_v<decltype(std::declval<const Scene&>().bonds()), const Bonds&>);
static_assert(std::is_same_v<decltype(*std::declval<const Grain&>().state), const GrainState&>);
static_assert(!std::is_copy_constructible_v<BondedGrains>);

// Condensed bonds have no ends in a step, but the query finds ends of all. Bonds keep those of the step.
TEST(StaticBond, LeavesSidesAsTheyAre) {
  RowOfGrains host(MPI_COMM_WORLD, elastic_row(2));
  host.setup();
  host.bonds.table[0].condensed = true;
  host.bonds.resolved_changed();
  host.cement->grains().bind(MPI_COMM_WORLD, host.bonds, host.cement->scaled_density());
  const Bond* b = host.bonds.find(1);
  const int side = b ? b->first_end_index : 0;
  const std::size_t sides = host.cement->grains().ends.ends.size();
  EXPECT_TRUE(!b || sides > 0);
  const std::vector<StiffnessOfBond> s = host.cement->stiffness_of_bonds();
  EXPECT_NEAR(s[0].K[14] / s[1].K[14], 1.0, 1e-9);
  EXPECT_EQ(b ? b->first_end_index : 0, side);
  EXPECT_EQ(host.cement->grains().ends.ends.size(), sides);
}

// Whether a resolved bond would be the same if it were condensed follows from static fields, which are found anew when the bond has another
// layout. Here another law would give other fields.
TEST(StaticBond, FieldsOfAnotherLayout) {
  RowOfGrains host(MPI_COMM_SELF, elastic_row());
  host.setup();
  Bond& b = *host.bonds.begin();
  const BondRecord& record = host.bonds.table[0];
  const double way = 1e-6 * test::kGap, K = host.cement->stiffness_of_bonds()[0].K[14], gravity[3] = {0.0, 0.0, 0.0};
  EndsAtCreation at(record);
  at.ends[1].x[2] += way;
  at.ends[0].force[2] = K * way;
  at.ends[1].force[2] = -K * way;
  const NoDamage stiffer(VtiElasticity(VtiConstants::isotropic(2.0 * test::kYoung, 0.0)));
  CondensedBonds condensed;
  const auto fits = [&](const Law& law) {
    return condensed.matches_static_solution(b, record, at.ends, 0.5 * K * way * way, 0.5, 2.0, gravity, test::kStep, law);
  };
  EXPECT_TRUE(fits(host.cement->law()));
  EXPECT_TRUE(fits(stiffer)) << "the layout is the same";
  ++b.layout;
  EXPECT_FALSE(fits(stiffer));
}

// A bond that rings is not solved to be condensed again. Motion as that of its grains is no ringing.
TEST(StaticBond, RingingIsNoRest) {
  RowOfGrains host(MPI_COMM_SELF, elastic_row());
  host.setup();
  Bond& b = *host.bonds.begin();
  const BondRecord& record = host.bonds.table[0];
  const double way = 1e-6 * test::kGap, K = host.cement->stiffness_of_bonds()[0].K[14], energy = 0.5 * K * way * way;
  EndsAtCreation at(record);
  at.ends[1].x[2] += way;
  at.ends[0].force[2] = K * way;
  at.ends[1].force[2] = -K * way;
  double mass = 0.0;
  for (int i = 0; i < b.grid.size(); ++i) mass += b.grid.mass[i];
  const double gravity[3] = {0.0, 0.0, 0.0}, speed = std::sqrt(2.0 * energy / mass);
  // all nodes move along x with a share of the energy, the grains with `of_grains` of that
  const auto rests = [&](double share, double of_grains) {
    const double v = std::sqrt(share) * speed;
    for (int i = 0; i < b.grid.size(); ++i) b.grid.velocity[3 * i] = v;
    for (BondEnd& e : at.ends) e.v[0] = of_grains * v;
    CondensedBonds condensed;
    return condensed.matches_static_solution(b, record, at.ends, (1.0 + share) * energy, 1.0, 2.0, gravity, test::kStep,
                                             host.cement->law());
  };
  EXPECT_TRUE(rests(0.0, 0.0));
  EXPECT_TRUE(rests(0.5, 1.0));
  EXPECT_FALSE(rests(0.5, 0.0));
  EXPECT_FALSE(rests(0.02, 0.0));
}

// The engine itself runs and pulls slowly. The force is K times the displacement.
TEST(StaticBond, ForceOfTheRun) {
  Row r = elastic_row();
  r.speed = 0.2;
  r.ramp = 2e-6;
  RowOfGrains host(MPI_COMM_SELF, r);
  const double K = host.cement->stiffness_of_bonds()[0].K[14];
  host.setup();
  host.run(500);
  double force = 0.0, stretch = 0.0;
  for (int n = 0; n < 100; ++n) {
    host.step();
    force += host.tension(0);
    stretch += host.stretch();
  }
  test::expect_within(std::fabs(force / (K * stretch) - 1.0), 1e-3, "force of the run over K times the way");
  // strained, not damaged: the same stiffness but for the change of shape
  const double now = host.cement->stiffness_of_bonds()[0].K[14];
  test::expect_within(std::fabs(now / K - 1.0), 5e-3, "stiffness in the run");
}

// The stiffness is the same for bonds cut or whole, on one rank or many, before a run and in it.
TEST(StaticBond, SameOnAllRanks) {
  RowOfGrains cut(MPI_COMM_WORLD, elastic_row(3)), whole(MPI_COMM_WORLD, elastic_row(3, true)), alone(MPI_COMM_SELF, elastic_row(3));
  const auto a = cut.cement->stiffness_of_bonds(), b = whole.cement->stiffness_of_bonds(), c = alone.cement->stiffness_of_bonds();
  alone.setup();
  const auto d = alone.cement->stiffness_of_bonds();
  int solved = 0;
  for (int n = 0; n < 3; ++n) {
    for (const auto* other : {&a, &b, &d})
      test::expect_within((matrix((*other)[n]) - matrix(c[n])).norm() / matrix(c[n]).norm(), 1e-9, "against one rank");
    EXPECT_EQ(a[n].middle[2], c[n].middle[2]);
    solved += c[n].products > 0.0;
  }
  EXPECT_EQ(solved, 1);  // bonds of one shape
  EXPECT_NEAR(c[2].middle[2] - c[1].middle[2], 2 * test::kRadius + test::kGap, 1e-12);
  EXPECT_EQ(c[1].products, 0.0);
  if (test::ranks() > 1) {
    EXPECT_GT(a[2].products, 0.0);
  }
}

// Failed points have no stiffness, and edges of the disc have constrained nodes: the factor has them as the operator.
TEST(StaticBond, FactorAgreesWithIterationBesideFailedPoints) {
  Row r = elastic_row();
  r.B0 = 1e6;
  RowOfGrains host(MPI_COMM_SELF, r);
  host.setup();
  Bond& b = *host.bonds.begin();
  EXPECT_FALSE(b.grid.constraints.empty());
  const std::size_t middle = b.points.blocks.size() / 2;
  b.points.meta[middle].failed = b.points.meta[middle].occupied;
  b.points.meta[middle + 1].failed = b.points.meta[middle + 1].occupied & 0x55;
  b.points.meta[middle].damaged = b.points.meta[middle + 1].damaged = true;
  const EndsAtCreation at(host.bonds.table[0]);
  const StaticSystem system{b.points, b.grid, b.links, at.ends, host.bonds.table[0], host.cement->law(), b.film};
  MPI_Comm as_if_shared;
  MPI_Comm_dup(MPI_COMM_SELF, &as_if_shared);
  const StaticBond factored = solve_static(MPI_COMM_SELF, &system), iterated = solve_static(as_if_shared, &system);
  EXPECT_EQ(factored.products, 18);
  EXPECT_GT(iterated.products, 100);
  // the iteration ends sooner beside failed points
  test::expect_within((iterated.stiffness - factored.stiffness).norm() / factored.stiffness.norm(), 1e-6, "stiffness");
  MPI_Comm_free(&as_if_shared);
}

// One of three bonds has a debonded link, and so is no equal of the others.
TEST(StaticBond, WhatIsNotEqualIsSolved) {
  RowOfGrains host(MPI_COMM_SELF, elastic_row(3));
  Bond& b = *host.bonds.find(1);
  b.points.links[5].attached = false;
  const auto s = host.cement->stiffness_of_bonds();
  EXPECT_GT(s[0].products, 0.0);
  EXPECT_GT(s[1].products, 0.0);
  EXPECT_EQ(s[2].products, 0.0);
  EXPECT_LT(s[1].K[14], s[0].K[14]);
  EXPECT_GT(s[1].K[14], 0.99 * s[0].K[14]);
  for (Link& k : b.points.links)
    if (k.grain == 2) k.attached = false;
  const auto free = host.cement->stiffness_of_bonds();
  EXPECT_LT(matrix(free[1]).norm(), 1e-12 * matrix(free[0]).norm());  // is connected to one grain only
}

// Bonds of scattered points, some with links to both grains, to test what holds for every bond.
class AnyBond : public ::testing::TestWithParam<bool> {};

struct Solved {
  test::Scene scene;
  NoDamage law{VtiElasticity(VtiConstants::isotropic(5.0, 0.2))};
  StaticBond bond;
  // The whole scene is rotated by Q. It is also moved unless Q is the identity.
  Solved(bool at_surface, const Eigen::Matrix3d& Q = Eigen::Matrix3d::Identity()) : scene(3, test::penalty(at_surface, 0.0)) {
    scene.tie();
    const Eigen::Quaterniond turn(Q);
    const Eigen::Vector3d way = Q.isIdentity() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(0.3, -0.2, 0.5);
    Bond& b = scene.bonds[0];
    for (int s = 0; s < 2; ++s) {
      const BondRecord& record = scene.records[0];
      const auto vector = [](const double* x) { return Eigen::Vector3d(x[0], x[1], x[2]); };
      const double* q = record.orientation[s];
      test::copy(Eigen::Vector3d(vector(record.origin) - vector(record.shift[s]) + Q * vector(record.centre[s]) + way), scene.motion[s].x);
      test::copy(turn * Eigen::Quaterniond(q[0], q[1], q[2], q[3]), scene.motion[s].q);
    }
    scene.ends.distribute(scene.records, scene.motion);
    for (int i = 0; i < b.grid.size(); ++i) {
      const Eigen::Vector3d X = test::kH * Eigen::Vector3d(b.grid.keys[i].at(0), b.grid.keys[i].at(1), b.grid.keys[i].at(2)),
                            u = Q * X + way - X;
      test::copy(u, &b.grid.displacement[3 * i]);
    }
    for (PointBlock& p : b.points.blocks) {
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) p.F.a[i][j] = splat(Q(i, j));
      for (int l = 0; l < kLanes; ++l) {
        const Eigen::Quaterniond q = turn * Eigen::Quaterniond(p.q.w[l], p.q.x[l], p.q.y[l], p.q.z[l]);
        p.q.w[l] = q.w();
        p.q.x[l] = q.x();
        p.q.y[l] = q.y();
        p.q.z[l] = q.z();
      }
    }
    bond = solve_static({b.points, b.grid, b.links, scene.ends_of(b), scene.records[0], law, b.film});
  }
};

TEST_P(AnyBond, IsInEquilibrium) {
  Solved s(GetParam());
  const Bond& b = s.scene.bonds[0];
  const BondEnd* ends = s.scene.ends_of(b);
  const auto secants = b.links.secants(b.grid, ends);
  const Matrix6& K = s.bond.stiffness;
  EXPECT_GT(K.norm(), 0.1);
  EXPECT_EQ((K - K.transpose()).norm(), 0.0);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(K).eigenvalues()[0], 0.0);
  for (int j = 0; j < 6; ++j) {
    // force and moment of the links by the field, of both grains about the middle
    double motion[2][6] = {}, load[2][6] = {};
    const Eigen::Vector3d arm = Eigen::Vector3d(ends[1].x[0], ends[1].x[1], ends[1].x[2]) - s.bond.frame.middle;
    Eigen::Vector3d t = Eigen::Vector3d::Zero(), turn = t;
    (j < 3 ? t : turn)[j % 3] = 1.0;
    t += turn.cross(arm);
    for (int d = 0; d < 3; ++d) {
      motion[1][d] = t[d];
      motion[1][3 + d] = turn[d];
    }
    std::vector<double> force(3 * b.grid.size(), 0.0);
    b.links.add_small_force(secants, s.bond.displacement[j].data(), motion, force.data(), load);
    Eigen::Matrix<double, 6, 1> about[2];
    for (int g = 0; g < 2; ++g) {
      const Eigen::Vector3d r = Eigen::Vector3d(ends[g].x[0], ends[g].x[1], ends[g].x[2]) - s.bond.frame.middle,
                            f(load[g][0], load[g][1], load[g][2]);
      about[g] << f, Eigen::Vector3d(load[g][3], load[g][4], load[g][5]) + r.cross(f);
    }
    test::expect_within((about[1] + K.col(j)).norm() / K.norm(), 1e-6, "load of the second grain");
    test::expect_within((about[0] - K.col(j)).norm() / K.norm(), 1e-6, "load of the first grain");
  }
}

TEST_P(AnyBond, TurnsWithItsGrains) {
  const Eigen::Matrix3d Q = Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Solved there(GetParam()), turned(GetParam(), Q);
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = Q;
  const Matrix6 K = both * there.bond.stiffness * both.transpose();
  test::expect_within((turned.bond.stiffness - K).norm() / K.norm(), 1e-9, "stiffness after a turn");
  test::expect_within((turned.bond.frame.axis - Q * there.bond.frame.axis).norm(), 1e-12, "axis after a turn");
}

// The fields belong to the operator: strain energy and that of the links are K.
TEST_P(AnyBond, EnergyOfTheFields) {
  Solved s(GetParam());
  const Bond& b = s.scene.bonds[0];
  for (int j = 0; j < 6; ++j) {
    double energy = 0.0;
    for (std::size_t n = 0; n < b.points.blocks.size(); ++n) {
      const Sym3<vd>& e = s.bond.strain[j][n];
      energy += sum_lanes(b.points.blocks[n].volume * contract(e, s.law.elasticity().stress(e)));
    }
    EXPECT_GT(energy, 0.0);
    EXPECT_LT(energy, s.bond.stiffness(j, j) * (1.0 + 1e-6));  // the rest is in the links
    EXPECT_GT(energy, 0.05 * s.bond.stiffness(j, j));
  }
}

// A whole bond is solved with a factor of its stiffness, and one that may be shared by conjugate gradients alone. Both see the same nodes.
TEST_P(AnyBond, FactorAgreesWithIteration) {
  Solved s(GetParam());
  const Bond& b = s.scene.bonds[0];
  MPI_Comm as_if_shared;
  MPI_Comm_dup(MPI_COMM_SELF, &as_if_shared);
  const StaticSystem system{b.points, s.scene.bonds[0].grid, b.links, s.scene.ends_of(b), s.scene.records[0], s.law, b.film};
  const StaticBond iterated = solve_static(as_if_shared, &system);
  EXPECT_EQ(s.bond.products, 18);  // one step for each field
  EXPECT_GT(iterated.products, 100);
  test::expect_within((iterated.stiffness - s.bond.stiffness).norm() / s.bond.stiffness.norm(), 1e-10, "stiffness");
  for (int j = 0; j < 6; ++j) {
    const Eigen::Map<const Eigen::VectorXd> one(s.bond.displacement[j].data(), s.bond.displacement[j].size()),
        other(iterated.displacement[j].data(), iterated.displacement[j].size());
    test::expect_within((one - other).norm() / one.norm(), 1e-6, "a field");
  }
  // Forces of a force, and what the operator says of the answer.
  std::vector<double> force(3 * b.grid.size(), 0.0);
  for (int i = 0; i < b.grid.size(); ++i)
    if (b.grid.constraints.row(i) < 0) force[3 * i + i % 3] = 1e-3 * (i % 5 - 2);
  const std::vector<double> by_factor = static_displacement(MPI_COMM_SELF, &system, force),
                            by_iteration = static_displacement(as_if_shared, &system, force);
  const Eigen::Map<const Eigen::VectorXd> one(by_factor.data(), by_factor.size()), other(by_iteration.data(), by_iteration.size());
  test::expect_within((one - other).norm() / one.norm(), 1e-6, "displacement by a force");
  MPI_Comm_free(&as_if_shared);
}

INSTANTIATE_TEST_SUITE_P(Links, AnyBond, ::testing::Values(true, false));

TEST(PrincipalStiffness, AreThoseOfTheFrame) {
  Matrix6 K = Matrix6::Zero();
  K.diagonal() << 2.0, 3.0, 7.0, 0.5, 0.25, 0.125;
  K(0, 5) = K(5, 0) = 0.1;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  Matrix6 both = Matrix6::Zero();
  both.topLeftCorner<3, 3>() = both.bottomRightCorner<3, 3>() = R;
  const PrincipalStiffness p = principal_stiffness(both * K * both.transpose(), R.col(2));
  EXPECT_NEAR(p.tension, 7.0, 1e-12);
  EXPECT_NEAR(p.shear[0], 2.0, 1e-12);
  EXPECT_NEAR(p.shear[1], 3.0, 1e-12);
  EXPECT_NEAR(p.torsion, 0.125, 1e-12);
  EXPECT_NEAR(p.bending[0], 0.25, 1e-12);
  EXPECT_NEAR(p.bending[1], 0.5, 1e-12);
}

}  // namespace
}  // namespace mpdem
