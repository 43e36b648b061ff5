// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coupling/relaxation.h"

#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::copy;
using test::Scene;
using test::Vector;

constexpr double kShare = 0.3, kSpeed = 2.0;
constexpr int kPieces = 4;  // of the second body, each with two sheets

struct Damped : Scene {
  Relaxation relaxation;

  explicit Damped(std::uint64_t seed, const std::vector<char>& apart = {0, 0})
      : Scene(seed, test::penalty(true, 0.0), Basis::quadratic, 2 * kPieces) {
    bodies[0].thickness = 0.1;
    bodies[1].thickness = 0.2;
    place_grains(0.1, 1.0);
    relaxation.build(grid, bodies, apart, kShare, kSpeed);
    relaxation.bind(sides);
  }
  const std::vector<double>& forces() {
    grid.clear_force();
    sides.clear_forces();
    relaxation.add_force(grid, sides);
    return grid.force;
  }
  Vector velocity_of_grain(int side, int node_) const {
    const GrainSide& g = sides.sides[side];
    return Eigen::Map<const Vector>(g.v) + Eigen::Map<const Vector>(g.omega).cross(node(node_) - Eigen::Map<const Vector>(g.x));
  }
  Vector at(const std::vector<double>& field, int n) const { return {field[3 * n], field[3 * n + 1], field[3 * n + 2]}; }
  double rate(int body) const { return kShare * 2.0 * M_PI * kSpeed / bodies[body].thickness; }
};

TEST(Relaxation, ActionIsReaction) {
  Damped s(161);
  s.expect_balanced(s.forces(), 1e-13, "damping");
}

TEST(Relaxation, NothingWhereNodesGoWithBothGrains) {
  Damped s(162);
  for (int b = 0; b < 2; ++b) {
    const Vector v = s.random.vector(), omega = s.random.vector();
    for (int i = 2 * b; i < 2 * b + 2; ++i) {
      copy(v + omega.cross(Vector(Eigen::Map<const Vector>(s.sides.sides[i].x))), s.motion[i].v);
      copy(omega, s.motion[i].omega);
    }
    for (int n = 0; n < s.grid.size(); ++n)
      if (body_of(s.grid.keys[n][0]) == b) copy(v + omega.cross(s.node(n)), &s.grid.velocity[3 * n]);
  }
  s.sides.distribute(s.bodies, s.motion);
  const std::vector<double>& force = s.forces();
  test::Worst worst;
  for (int n = 0; n < s.grid.size(); ++n)
    if (s.grid.mass[n] > 0.0)
      worst.add(s.at(force, n).norm() / (s.grid.mass[n] * s.rate(body_of(s.grid.keys[n][0]))));
  expect_within(worst, 1e-13, "velocity that is damped");
}

// A share of each grain's motion that falls from one at its surface to none at the other's.
TEST(Relaxation, GrainsShareByDistance) {
  Damped s(163);
  const std::vector<double>& force = s.forces();
  test::Worst worst;
  double least = 1.0, most = 0.0;
  for (int n = 0; n < s.grid.size(); ++n) {
    const int b = body_of(s.grid.keys[n][0]);
    const auto& k = s.grid.keys[n];
    double depth[2];
    for (int g = 0; g < 2; ++g) {
      const Vector X = test::kH * Vector(k[1], k[2], k[3]) - Vector(Eigen::Map<const Vector>(s.bodies[b].centre[g]));
      depth[g] = std::max(X.norm() - s.bodies[b].radius[g], 0.0);
    }
    const double share = depth[0] + depth[1] > 0.0 ? depth[0] / (depth[0] + depth[1]) : 0.5;
    least = std::min(least, share);
    most = std::max(most, share);
    const Vector follows = (1.0 - share) * s.velocity_of_grain(2 * b, n) + share * s.velocity_of_grain(2 * b + 1, n);
    const Vector expected = -s.rate(b) * s.grid.mass[n] * (s.at(s.grid.velocity, n) - follows);
    worst.add((s.at(force, n) - expected).norm() / (s.rate(b) * std::max(s.grid.mass[n], 1e-300)));
  }
  EXPECT_LT(least, 0.1);
  EXPECT_GT(most, 0.9);
  expect_within(worst, 1e-12, "damped velocity");
}

TEST(Relaxation, TakesThePowerItClaims) {
  Damped s(164);
  for (double& a : s.grid.acceleration) a = s.random.uniform(-1, 1);
  for (GrainSides::Motion& m : s.motion) {
    copy(s.random.vector(), m.a);
    copy(s.random.vector(), m.alpha);
  }
  s.sides.distribute(s.bodies, s.motion);
  const std::vector<double>& force = s.forces();
  for (double later : {0.0, 0.3}) {
    double power = 0.0;
    for (int n = 0; n < s.grid.size(); ++n) power -= s.at(force, n).dot(s.at(s.grid.velocity, n) + later * s.at(s.grid.acceleration, n));
    for (const GrainSide& g : s.sides.sides)
      for (int d = 0; d < 3; ++d)
        power -= g.force[d] * (g.v[d] + later * g.a[d]) + g.torque[d] * (g.omega[d] + later * g.alpha[d]);
    const double claimed = s.relaxation.power(s.grid, s.sides, later);
    test::expect_within(std::fabs(power / claimed - 1.0), 1e-12, "power");
    EXPECT_TRUE(later != 0.0 || claimed > 0.0);
    EXPECT_LT(std::fabs(s.relaxation.power(s.grid, s.sides, later, 1)), std::fabs(claimed));
    EXPECT_EQ(s.relaxation.power(s.grid, s.sides, later, 2), 0.0);
  }
}

// The second body came apart: piece 0 follows the first grain alone, 1 the second, loose ones go their way.
TEST(Relaxation, PartsFollowTheirOwnGrain) {
  Damped s(165, {0, 1});
  const std::vector<double>& force = s.forces();
  test::Worst worst;
  int nodes[kPieces] = {0, 0, 0, 0};
  for (int n = 0; n < s.grid.size(); ++n) {
    if (body_of(s.grid.keys[n][0]) != 1 || s.grid.mass[n] == 0.0) continue;
    const int piece = piece_of(part_of_field(s.grid.keys[n][0]));
    ++nodes[piece];
    if (piece > 1) {
      EXPECT_EQ(s.at(force, n), Vector::Zero());
      continue;
    }
    const Vector expected = -s.rate(1) * s.grid.mass[n] * (s.at(s.grid.velocity, n) - s.velocity_of_grain(2 + piece, n));
    worst.add((s.at(force, n) - expected).norm() / (s.rate(1) * s.grid.mass[n]));
  }
  for (int count : nodes) EXPECT_GT(count, 20);
  expect_within(worst, 1e-12, "damped velocity");
  s.expect_balanced(force, 1e-13, "damping");
}

// A grain that flew far has no hold on the cement.
TEST(Relaxation, EndsAtADistance) {
  Damped s(166);
  for (int i = 0; i < 4; ++i)
    for (double& x : s.motion[i].x) x += 10.0;
  s.sides.distribute(s.bodies, s.motion);
  for (double f : s.forces()) EXPECT_EQ(f, 0.0);
}

}  // namespace
}  // namespace mpdem
