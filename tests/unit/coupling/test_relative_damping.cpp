// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coupling/relative_damping.h"

#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::copy;
using test::Scene;
using test::Vector;

constexpr double kShare = 0.3, kSpeed = 2.0;
constexpr int kPieces = 4;  // of the second bond

struct Damped : Scene {
  explicit Damped(std::uint64_t seed, const std::vector<char>& apart = {0, 0})
      : Scene(seed, test::penalty(true, 0.0), Basis::quadratic, kPieces) {
    records[0].thickness = 0.1;
    records[1].thickness = 0.2;
    place_grains(0.1, 1.0);
    for (Bond& b : bonds) {
      for (BlockMeta& m : b.points.meta)
        for (int g = 0; g < 2; ++g) m.connected[g] = apart[b.row] && m.layer != g ? 0 : 0xff;
      b.mechanisms.push_back(std::make_unique<RelativeDamping>(records[b.row], kShare, kSpeed));
      relaxation(b).follow_grains(b.grid, records[b.row], apart[b.row] ? connected_grains_of_nodes(b.points, b.grid) : std::vector<char>());
    }
  }
  static RelativeDamping& relaxation(const Bond& b) { return *b.mechanism<RelativeDamping>(); }
  std::vector<std::vector<double>> damping() {
    ends.clear_forces();
    for (Bond& b : bonds) {
      b.grid.clear_force();
      relaxation(b).slow_nodes(b.grid, ends_of(b));
    }
    return forces();
  }
  Vector velocity_of_grain(const Bond& b, int s, int n) const {
    const BondEnd& g = ends_of(b)[s];
    return Eigen::Map<const Vector>(g.v) + Eigen::Map<const Vector>(g.omega).cross(node(b.grid, n) - Eigen::Map<const Vector>(g.x));
  }
  double rate(int row) const { return kShare * 2.0 * M_PI * kSpeed / records[row].thickness; }
};

TEST(RelativeDamping, ActionIsReaction) {
  Damped s(161);
  s.expect_balanced(s.damping(), 1e-13, "damping");
}

TEST(RelativeDamping, NothingWhereNodesGoWithBothGrains) {
  Damped s(162);
  for (int b = 0; b < 2; ++b) {
    const Vector v = s.random.vector(), omega = s.random.vector();
    for (int i = 2 * b; i < 2 * b + 2; ++i) {
      copy(v + omega.cross(Vector(Eigen::Map<const Vector>(s.ends.ends[i].x))), s.motion[i].v);
      copy(omega, s.motion[i].omega);
    }
    Grid& grid = s.bonds[b].grid;
    for (int n = 0; n < grid.size(); ++n) copy(v + omega.cross(s.node(grid, n)), &grid.velocity[3 * n]);
  }
  s.ends.distribute(s.records, s.motion);
  const std::vector<std::vector<double>> force = s.damping();
  test::Worst worst;
  for (const Bond& b : s.bonds)
    for (int n = 0; n < b.grid.size(); ++n)
      if (b.grid.mass[n] > 0.0) worst.add(s.at(force[b.row], n).norm() / (b.grid.mass[n] * s.rate(b.row)));
  expect_within(worst, 1e-13, "velocity that is damped");
}

// A share of each grain's motion that falls from one at its surface to none at the other's.
TEST(RelativeDamping, GrainsShareByDistance) {
  Damped s(163);
  const std::vector<std::vector<double>> force = s.damping();
  test::Worst worst;
  double least = 1.0, most = 0.0;
  for (const Bond& b : s.bonds)
    for (int n = 0; n < b.grid.size(); ++n) {
      const auto& k = b.grid.keys[n];
      double depth[2];
      for (int g = 0; g < 2; ++g) {
        const Vector X = test::kH * Vector(k.at(0), k.at(1), k.at(2)) - Vector(Eigen::Map<const Vector>(s.records[b.row].centre[g]));
        depth[g] = std::max(X.norm() - s.records[b.row].radius[g], 0.0);
      }
      const double share = depth[0] + depth[1] > 0.0 ? depth[0] / (depth[0] + depth[1]) : 0.5;
      least = std::min(least, share);
      most = std::max(most, share);
      const Vector follows = (1.0 - share) * s.velocity_of_grain(b, 0, n) + share * s.velocity_of_grain(b, 1, n);
      const Vector expected = -s.rate(b.row) * b.grid.mass[n] * (s.at(b.grid.velocity, n) - follows);
      worst.add((s.at(force[b.row], n) - expected).norm() / (s.rate(b.row) * std::max(b.grid.mass[n], 1e-300)));
    }
  EXPECT_LT(least, 0.1);
  EXPECT_GT(most, 0.9);
  expect_within(worst, 1e-12, "damped velocity");
}

TEST(RelativeDamping, TakesThePowerItClaims) {
  Damped s(164);
  for (Bond& b : s.bonds)
    for (double& a : b.grid.acceleration) a = s.random.uniform(-1, 1);
  s.accelerate_grains();
  const std::vector<std::vector<double>> force = s.damping();
  for (double later : {0.0, 0.3}) {
    double of_both = 0.0;
    for (const Bond& b : s.bonds) {
      double power = 0.0;
      for (int n = 0; n < b.grid.size(); ++n)
        power -= s.at(force[b.row], n).dot(s.at(b.grid.velocity, n) + later * s.at(b.grid.acceleration, n));
      for (int side = 0; side < 2; ++side) {
        const BondEnd& g = s.ends_of(b)[side];
        for (int d = 0; d < 3; ++d) power -= g.force[d] * (g.v[d] + later * g.a[d]) + g.torque[d] * (g.omega[d] + later * g.alpha[d]);
      }
      const double claimed = Damped::relaxation(b).power(b.grid, s.ends_of(b)).after(later);
      test::expect_within(std::fabs(power / claimed - 1.0), 1e-12, "power");
      EXPECT_TRUE(later != 0.0 || claimed > 0.0);
      of_both += claimed;
    }
    EXPECT_NE(of_both, 0.0);
  }
}

// The second bond is separated: piece 0 follows the first grain alone, 1 the second, loose ones follow none.
TEST(RelativeDamping, PartsFollowTheirOwnGrain) {
  Damped s(165, {0, 1});
  const std::vector<std::vector<double>> force = s.damping();
  test::Worst worst;
  int nodes[kPieces] = {0, 0, 0, 0};
  const Bond& b = s.bonds[1];
  for (int n = 0; n < b.grid.size(); ++n) {
    if (b.grid.mass[n] == 0.0) continue;
    const int piece = layer_of_field(b.grid.keys[n].field());
    ++nodes[piece];
    if (piece > 1) {
      EXPECT_EQ(s.at(force[1], n), Vector::Zero());
      continue;
    }
    const Vector expected = -s.rate(1) * b.grid.mass[n] * (s.at(b.grid.velocity, n) - s.velocity_of_grain(b, piece, n));
    worst.add((s.at(force[1], n) - expected).norm() / (s.rate(1) * b.grid.mass[n]));
  }
  for (int count : nodes) EXPECT_GT(count, 20);
  expect_within(worst, 1e-12, "damped velocity");
  s.expect_balanced(force, 1e-13, "damping");
}

// A grain that flew far does not damp the cement.
TEST(RelativeDamping, EndsAtADistance) {
  Damped s(166);
  for (int i = 0; i < 4; ++i)
    for (double& x : s.motion[i].x) x += 10.0;
  s.ends.distribute(s.records, s.motion);
  for (const std::vector<double>& of_bond : s.damping())
    for (double f : of_bond) EXPECT_EQ(f, 0.0);
}

}  // namespace
}  // namespace mpdem
