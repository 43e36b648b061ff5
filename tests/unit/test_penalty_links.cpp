// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coupling/penalty_links.h"

#include <algorithm>

#include "linked_bonds.h"

namespace mpdem {
namespace {

using test::copy;
using test::kDensity;
using test::kH;
using test::Matrix;
using test::Scene;
using test::Vector;

PenaltyParameters parameters(bool at_surface, double damping = 0.0) { return test::penalty(at_surface, damping); }

class Links : public ::testing::TestWithParam<bool> {};

TEST_P(Links, NothingHappensAtRestOrInRigidMotion) {
  Scene s(131, parameters(GetParam()));
  EXPECT_LE(s.energy(), 1e-26);
  // both grains and the nodes of a body turn about its origin and move on
  for (int b = 0; b < 2; ++b) {
    const Matrix R = test::rotation(s.random.direction(), 2.0);
    const Vector t = s.random.vector();
    for (int side = 0; side < 2; ++side) {
      const Body& body = s.bodies[b];
      GrainSides::Motion& m = s.motion[2 * b + side];
      copy(Eigen::Map<const Vector>(body.origin) - Eigen::Map<const Vector>(body.shift[side]) +
               R * Eigen::Map<const Vector>(body.centre[side]) + t, m.x);
      const double* q = body.orientation[side];
      copy(Eigen::Quaterniond(R) * Eigen::Quaterniond(q[0], q[1], q[2], q[3]), m.q);
    }
    for (int n = 0; n < s.grid.size(); ++n) {
      if (body_of(s.grid.keys[n][0]) != b) continue;
      const Vector X = kH * Vector(s.grid.keys[n][1], s.grid.keys[n][2], s.grid.keys[n][3]), u = R * X + t - X;
      copy(u, &s.grid.displacement[3 * n]);
    }
  }
  EXPECT_LE(s.energy(), 1e-26);
  s.add_force();
  test::Worst force;
  for (double f : s.grid.force) force.add(std::fabs(f));
  for (const GrainSide& g : s.sides.sides)
    for (int d = 0; d < 3; ++d) force.add(std::fabs(g.force[d]) + std::fabs(g.torque[d]));
  expect_within(force, 1e-12, "force");
}

TEST_P(Links, ForceAndMomentDeriveFromTheEnergy) {
  Scene s(132, parameters(GetParam()));
  s.place_grains(0.3, 0.0);
  s.add_force();
  const double U = s.energy();
  EXPECT_GT(U, 0.1);
  double f_size = 0, F_size = 0;
  for (double f : s.grid.force) f_size = std::max(f_size, std::fabs(f));
  for (const GrainSide& g : s.sides.sides)
    for (int d = 0; d < 3; ++d) F_size = std::max({F_size, std::fabs(g.force[d]), std::fabs(g.torque[d])});
  const std::vector<double> force = s.grid.force;
  test::Worst node, grain, torque;
  // The energy is quadratic in the places: central differences are exact.
  for (std::size_t i = 0; i < force.size(); ++i) {
    double& u = s.grid.displacement[i];
    const double u0 = u, step = 0.1;
    u = u0 + step;
    const double ahead = s.energy();
    u = u0 - step;
    const double behind = s.energy();
    u = u0;
    node.add(std::fabs(force[i] + (ahead - behind) / (2 * step)) / f_size);
  }
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d) {
      const GrainSide& g = s.sides.sides[i];
      const GrainSides::Motion at = s.motion[i];
      const auto moved = [&](double step) {
        s.motion[i] = at;
        s.motion[i].x[d] += step;
        return s.energy();
      };
      const auto turned = [&](double angle) {
        s.motion[i] = at;
        s.turn(i, angle * Vector::Unit(d));
        return s.energy();
      };
      const auto slope = [&](double a) { return (turned(a) - turned(-a)) / (2 * a); };
      grain.add(std::fabs(g.force[d] + (moved(0.1) - moved(-0.1)) / 0.2) / F_size);
      // sixth order
      const double fine = slope(0.01), middle = slope(0.02), coarse = slope(0.04);
      const double one = (4 * fine - middle) / 3, two = (4 * middle - coarse) / 3;
      torque.add(std::fabs(g.torque[d] + (16 * one - two) / 15) / F_size);
      s.motion[i] = at;
    }
  s.sides.distribute(s.bodies, s.motion);
  expect_within(node, 1e-11, "nodes");
  expect_within(grain, 1e-11, "force on the grains");
  expect_within(torque, 1e-9, "moment on the grains");
}

TEST_P(Links, ActionIsReaction) {
  Scene s(133, parameters(GetParam(), 0.3));
  s.place_grains(0.3, 0.0);
  s.add_force();
  s.expect_balanced(s.grid.force, 1e-14, "springs");
  s.place_grains(0.3, 10.0);
  s.add_force();
  s.expect_balanced(s.grid.force, 1e-14, "springs and dampers");
}

TEST_P(Links, DampersTakeThePowerTheyClaim) {
  Scene s(135, parameters(GetParam(), 0.3));
  s.place_grains(0.2, 0.0);
  s.add_force();
  const std::vector<double> springs = s.grid.force;
  const GrainSides still = s.sides;
  for (double& v : s.grid.velocity) v = s.random.uniform(-1, 1);
  for (GrainSides::Motion& m : s.motion) {
    copy(s.random.vector(), m.v);
    copy(s.random.vector(), m.omega);
  }
  s.add_force();
  const GrainSides force = s.sides;
  double power = 0;
  for (std::size_t i = 0; i < springs.size(); ++i) power -= (s.grid.force[i] - springs[i]) * s.grid.velocity[i];
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d)
      power -= (s.sides.sides[i].force[d] - still.sides[i].force[d]) * s.motion[i].v[d] +
               (s.sides.sides[i].torque[d] - still.sides[i].torque[d]) * s.motion[i].omega[d];
  const double claimed = s.links.damper_power(s.grid, s.sides, 0.0);
  EXPECT_GT(claimed, 0.0);
  test::expect_within(std::fabs(power / claimed - 1.0), 1e-12, "power");
  // the same force, at velocities a little later
  for (double& a : s.grid.acceleration) a = s.random.uniform(-1, 1);
  for (GrainSides::Motion& m : s.motion) {
    copy(s.random.vector(), m.a);
    copy(s.random.vector(), m.alpha);
  }
  s.sides.distribute(s.bodies, s.motion);
  for (std::size_t i = 0; i < springs.size(); ++i) power -= (s.grid.force[i] - springs[i]) * 0.3 * s.grid.acceleration[i];
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d)
      power -= 0.3 * ((force.sides[i].force[d] - still.sides[i].force[d]) * s.motion[i].a[d] +
                      (force.sides[i].torque[d] - still.sides[i].torque[d]) * s.motion[i].alpha[d]);
  test::expect_within(std::fabs(power / s.links.damper_power(s.grid, s.sides, 0.3) - 1.0), 1e-12, "power, later");
}

// Points go to other cells, links let go and lose their added mass: blocks that follow are those built anew, to the bit.
TEST_P(Links, FollowPointsThatChangeCells) {
  Scene one(141, parameters(GetParam(), 0.3)), two(141, parameters(GetParam(), 0.3));
  int crossings = 0;
  for (int n = 0; n < 20; ++n) {
    const int from = one.random.index(static_cast<int>(one.slots.size())), to = one.random.index(static_cast<int>(one.slots.size()));
    double released;
    bool left[2];
    for (Scene* s : {&one, &two}) {
      if (n > 0) s->place_grains(0.01, 1.0);
      s->sides.distribute(s->bodies, one.motion);
      s->grid.displacement = one.grid.displacement;
      s->grid.velocity = one.grid.velocity;
      if (n % 3 == 1) s->links.let_go(s->points, {s->slots[7 * n % s->slots.size()]}, s->grid, s->sides, released);
      if (n % 3 == 2) s->links.drop_inertia(s->points);
      s->links.find_moves(s->grid, 1e-3);
      const int a = s->slots[from], b = s->slots[to];
      if (s->points.meta[a / kLanes].body == s->points.meta[b / kLanes].body &&
          s->points.meta[a / kLanes].part == s->points.meta[b / kLanes].part && n % 4 != 0)
        for (int d = 0; d < 3; ++d) s->points.blocks[a / kLanes].X[d][a % kLanes] = s->points.blocks[b / kLanes].X[d][b % kLanes];
      left[s == &one] = s->links.move_places(s->points);
    }
    EXPECT_EQ(left[0], left[1]);
    if (!left[1]) continue;
    ++crossings;
    EXPECT_TRUE(one.links.follow_points(one.points, one.bodies, one.grid, one.sides));
    two.links.build(two.points, two.bodies, parameters(GetParam(), 0.3), kH, kDensity);
    EXPECT_TRUE(two.links.find_columns(two.grid));
    two.links.bind(two.sides);
    for (Scene* s : {&one, &two}) {
      s->motion = one.motion;
      s->add_force();
      std::fill(s->grid.penalty.begin(), s->grid.penalty.end(), 0.0);
      s->links.add_stiffness(s->grid, s->sides, 0.2);
    }
    EXPECT_EQ(one.grid.force, two.grid.force);
    EXPECT_EQ(one.grid.penalty, two.grid.penalty);
    for (std::size_t i = 0; i < one.sides.sides.size(); ++i)
      for (int d = 0; d < 3; ++d) EXPECT_EQ(one.sides.sides[i].torque[d], two.sides.sides[i].torque[d]);
  }
  EXPECT_GT(crossings, 3);
}

TEST_P(Links, LetGo) {
  Scene s(137, parameters(GetParam()));
  s.place_grains(0.2, 1.0);
  s.links.add_stiffness(s.grid, s.sides, 0.2);
  s.grid.set_added_mass(0.2, 0.0, false, 4.0);
  s.links.share_added_mass(s.grid, s.sides);
  const double before = s.energy(), inertial = s.links.inertial_energy(s.grid, s.sides);
  EXPECT_GT(inertial, 0.0);
  std::vector<int> failed;
  for (std::size_t i = 0; i < s.slots.size(); i += 3) failed.push_back(s.slots[i]);
  std::sort(failed.begin(), failed.end());
  int expected = 0;
  for (const Link& k : s.points.links) expected += std::binary_search(failed.begin(), failed.end(), k.slot);
  double released = 0;
  EXPECT_EQ(s.links.let_go(s.points, {}, s.grid, s.sides, released), 0);
  EXPECT_EQ(s.links.let_go(s.points, failed, s.grid, s.sides, released), expected);
  EXPECT_EQ(s.links.let_go(s.points, failed, s.grid, s.sides, released), 0);  // once only
  for (const Link& k : s.points.links)
    EXPECT_EQ(k.attached == 0, std::binary_search(failed.begin(), failed.end(), k.slot));
  test::expect_within(std::fabs((before - s.energy()) / released - 1.0), 1e-13, "spring energy released");
  s.add_force();
  s.expect_balanced(s.grid.force, 1e-14, "after");
  // added mass reacts as before, in a layout from the store as it is now too, until it is dropped
  const auto build_anew = [&](PenaltyLinks& links) {
    links.build(s.points, s.bodies, s.links.parameters(), kH, kDensity);
    links.find_columns(s.grid);
    links.bind(s.sides);
  };
  const auto inertial_of = [&](PenaltyLinks& links) {
    std::fill(s.grid.penalty.begin(), s.grid.penalty.end(), 0.0);
    links.add_stiffness(s.grid, s.sides, 0.2);
    s.grid.set_added_mass(0.2, 0.0, false, 4.0);
    links.share_added_mass(s.grid, s.sides);
    return links.inertial_energy(s.grid, s.sides);
  };
  EXPECT_EQ(inertial_of(s.links), inertial);
  PenaltyLinks same;
  build_anew(same);
  test::expect_within(std::fabs(inertial_of(same) / inertial - 1.0), 1e-13, "energy of added mass in a new layout");
  s.links.drop_inertia(s.points);
  inertial_of(s.links);
  EXPECT_LT(s.links.inertial_energy(s.grid, s.sides), inertial);

  // a layout from the store as it is now gives the same force
  const std::vector<double> force = s.grid.force;
  PenaltyLinks again;
  again.build(s.points, s.bodies, s.links.parameters(), kH, kDensity);
  std::vector<Grid::Cell> cells;
  for (BlockMeta& m : s.points.meta) cells.push_back({field_of(m.body, m.part), m.base, m.column});
  s.links.add_cells(cells);  // keeps the nodes
  again.add_cells(cells);
  std::vector<char> fresh;
  s.grid.build(MPI_COMM_SELF, kH, cells, NodeKinematics(), fresh);
  again.bind(s.sides);
  again.add_force(s.grid, s.sides);
  test::Worst worst;
  for (std::size_t i = 0; i < force.size(); ++i) worst.add(std::fabs(force[i] - s.grid.force[i]));
  expect_within(worst, 1e-12, "force of the links that are left");
}

// Points crowd in one cell, so that blocks of links are full: one link after the other lets go, in whatever lane it is.
TEST_P(Links, LetGoInEachLane) {
  Scene s(142, parameters(GetParam()), Basis::quadratic, 1, 0.4 * kH);
  std::vector<int> linked;
  for (const Link& k : s.points.links) linked.push_back(k.slot);
  linked.erase(std::unique(linked.begin(), linked.end()), linked.end());
  std::sort(linked.begin(), linked.end());
  ASSERT_GT(linked.size(), 2u * 60 * 3 / 4);
  s.place_grains(0.2, 0.0);
  double released = 0.0;
  const double whole = s.energy();
  for (int slot : linked) {
    const double before = s.energy(), gone = released;
    const auto links = std::count_if(s.points.links.begin(), s.points.links.end(), [&](const Link& k) { return k.slot == slot; });
    EXPECT_EQ(s.links.let_go(s.points, {slot}, s.grid, s.sides, released), links) << "slot " << slot;
    for (const Link& k : s.points.links)
      if (k.slot == slot) EXPECT_FALSE(k.attached);
    EXPECT_GT(released, gone);
    test::expect_within(std::fabs(before - s.energy() - (released - gone)) / whole, 1e-14, "energy of the links that let go");
  }
  EXPECT_EQ(s.energy(), 0.0);
  test::expect_within(std::fabs(released / whole - 1.0), 1e-13, "energy of all");
}

// A spring one node wide, by hand: normal along R q0, not along the present vector.
TEST_P(Links, DirectionsOfTheSpring) {
  Scene s(138, parameters(GetParam()));
  for (int axis = 0; axis < 2; ++axis) {
    // every node moves along or across the bond of body 0; grains stay
    const Vector n = Eigen::Map<const Vector>(s.bodies[0].centre[1]).normalized();
    const Vector move = 0.3 * (axis == 0 ? n : n.unitOrthogonal());
    s.place_grains(0.0, 0.0);
    for (int i = 0; i < s.grid.size(); ++i)
      if (body_of(s.grid.keys[i][0]) == 0) copy(move, &s.grid.displacement[3 * i]);
    s.add_force();
    for (int side = 0; side < 2; ++side) {
      Vector expected = Vector::Zero();
      for (const Link& k : s.points.links) {
        const int b = k.slot / kLanes, l = k.slot % kLanes;
        if (s.points.meta[b].body != 0 || k.grain != s.bodies[0].grain[side]) continue;
        const vd* X = s.points.blocks[b].X;
        const Vector at = GetParam() ? Vector(Eigen::Map<const Vector>(k.foot)) : Vector(X[0][l], X[1][l], X[2][l]);
        const Vector m = (at - Eigen::Map<const Vector>(s.bodies[0].centre[side])).normalized();
        const Vector normal = move.dot(m) * m;
        expected += k.area * (900.0 * normal + 250.0 * (move - normal));
      }
      const Vector force = Eigen::Map<const Vector>(s.sides.sides[side].force);
      test::expect_within((force - expected).norm() / expected.norm(), 1e-12, "force on a grain");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Penalty, Links, ::testing::Values(true, false),
                         [](const ::testing::TestParamInfo<bool>& p) { return p.param ? "at_surface" : "at_points"; });

}  // namespace
}  // namespace mpdem
