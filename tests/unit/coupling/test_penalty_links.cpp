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
  // both grains and the nodes of a bond rotate about its origin and move on
  for (int b = 0; b < 2; ++b) {
    const Matrix R = test::rotation(s.random.direction(), 2.0);
    const Vector t = s.random.vector();
    for (int side = 0; side < 2; ++side) {
      const BondRecord& record = s.records[b];
      BondEnds::Motion& m = s.motion[2 * b + side];
      copy(Eigen::Map<const Vector>(record.origin) - Eigen::Map<const Vector>(record.shift[side]) +
               R * Eigen::Map<const Vector>(record.centre[side]) + t,
           m.x);
      const double* q = record.orientation[side];
      copy(Eigen::Quaterniond(R) * Eigen::Quaterniond(q[0], q[1], q[2], q[3]), m.q);
    }
    Grid& grid = s.bonds[b].grid;
    for (int n = 0; n < grid.size(); ++n) {
      const Vector X = kH * Vector(grid.keys[n].at(0), grid.keys[n].at(1), grid.keys[n].at(2)), u = R * X + t - X;
      copy(u, &grid.displacement[3 * n]);
    }
  }
  EXPECT_LE(s.energy(), 1e-26);
  s.add_force();
  test::Worst force;
  for (const Bond& b : s.bonds)
    for (double f : b.grid.force) force.add(std::fabs(f));
  for (const BondEnd& g : s.ends.ends)
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
  for (const Bond& b : s.bonds)
    for (double f : b.grid.force) f_size = std::max(f_size, std::fabs(f));
  for (const BondEnd& g : s.ends.ends)
    for (int d = 0; d < 3; ++d) F_size = std::max({F_size, std::fabs(g.force[d]), std::fabs(g.torque[d])});
  test::Worst node, grain, torque;
  // The energy is quadratic in the places: central differences are exact.
  for (Bond& b : s.bonds)
    for (std::size_t i = 0; i < b.grid.force.size(); ++i) {
      double& u = b.grid.displacement[i];
      const double u0 = u, step = 0.1;
      u = u0 + step;
      const double ahead = s.energy();
      u = u0 - step;
      const double behind = s.energy();
      u = u0;
      node.add(std::fabs(b.grid.force[i] + (ahead - behind) / (2 * step)) / f_size);
    }
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d) {
      const BondEnd& g = s.ends.ends[i];
      const BondEnds::Motion at = s.motion[i];
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
  s.ends.distribute(s.records, s.motion);
  expect_within(node, 1e-11, "nodes");
  expect_within(grain, 1e-11, "force on the grains");
  expect_within(torque, 1e-9, "moment on the grains");
}

TEST_P(Links, ActionIsReaction) {
  Scene s(133, parameters(GetParam(), 0.3));
  s.place_grains(0.3, 0.0);
  s.add_force();
  s.expect_balanced(s.forces(), 1e-14, "springs");
  s.place_grains(0.3, 10.0);
  s.add_force();
  s.expect_balanced(s.forces(), 1e-14, "springs and dampers");
}

TEST_P(Links, DampersTakeThePowerTheyClaim) {
  Scene s(135, parameters(GetParam(), 0.3));
  s.place_grains(0.2, 0.0);
  s.add_force();
  const std::vector<std::vector<double>> springs = s.forces();
  const BondEnds still = s.ends;
  for (Bond& b : s.bonds)
    for (double& v : b.grid.velocity) v = s.random.uniform(-1, 1);
  for (BondEnds::Motion& m : s.motion) {
    copy(s.random.vector(), m.v);
    copy(s.random.vector(), m.omega);
  }
  s.add_force();
  const BondEnds force = s.ends;
  double power = 0;
  const auto add_power = [&](std::vector<double> Grid::*velocity, double factor) {
    for (const Bond& b : s.bonds)
      for (std::size_t i = 0; i < b.grid.force.size(); ++i) power -= (b.grid.force[i] - springs[b.row][i]) * factor * (b.grid.*velocity)[i];
  };
  const auto claimed_power = [&](double later) {
    double sum = 0.0;
    for (const Bond& b : s.bonds) sum += b.links.damper_power(b.grid, s.ends_of(b)).after(later);
    return sum;
  };
  add_power(&Grid::velocity, 1.0);
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d)
      power -= (s.ends.ends[i].force[d] - still.ends[i].force[d]) * s.motion[i].v[d] +
               (s.ends.ends[i].torque[d] - still.ends[i].torque[d]) * s.motion[i].omega[d];
  const double claimed = claimed_power(0.0);
  EXPECT_GT(claimed, 0.0);
  test::expect_within(std::fabs(power / claimed - 1.0), 1e-12, "power");
  // the same force, at velocities a little later
  for (Bond& b : s.bonds)
    for (double& a : b.grid.acceleration) a = s.random.uniform(-1, 1);
  s.accelerate_grains();
  add_power(&Grid::acceleration, 0.3);
  for (int i = 0; i < 4; ++i)
    for (int d = 0; d < 3; ++d)
      power -= 0.3 * ((force.ends[i].force[d] - still.ends[i].force[d]) * s.motion[i].a[d] +
                      (force.ends[i].torque[d] - still.ends[i].torque[d]) * s.motion[i].alpha[d]);
  test::expect_within(std::fabs(power / claimed_power(0.3) - 1.0), 1e-12, "power, later");
}

// Points go to other cells, links debond and lose their added mass: blocks that follow are bitwise identical to those built anew.
TEST_P(Links, FollowPointsThatChangeCells) {
  Scene one(141, parameters(GetParam(), 0.3)), two(141, parameters(GetParam(), 0.3));
  int crossings = 0;
  for (int n = 0; n < 40; ++n) {
    if (n > 0)
      for (Scene* s : {&one, &two}) s->place_grains(0.01, 1.0);
    const int row = n % 2, points = static_cast<int>(one.slots[row].size());
    const int from = one.random.index(points), to = one.random.index(points);
    bool left[2];
    for (Scene* s : {&one, &two}) {
      Bond& bond = s->bonds[row];
      s->ends.distribute(s->records, one.motion);
      for (int b = 0; b < 2; ++b) {
        s->bonds[b].grid.displacement = one.bonds[b].grid.displacement;
        s->bonds[b].grid.velocity = one.bonds[b].grid.velocity;
      }
      double released = 0.0;
      if (n / 2 % 3 == 1) bond.links.debond(bond.points, {s->slots[row][7 * n % points]}, bond.grid, s->ends_of(bond), 0.0, released);
      if (n / 2 % 3 == 2) bond.links.drop_added_mass(bond.points);
      bond.links.find_moves(bond.grid, 1e-3);
      const int a = s->slots[row][from], b = s->slots[row][to];
      if (bond.points.meta[a / kLanes].layer == bond.points.meta[b / kLanes].layer && n / 2 % 4 != 0)
        for (int d = 0; d < 3; ++d) bond.points.blocks[a / kLanes].X[d][a % kLanes] = bond.points.blocks[b / kLanes].X[d][b % kLanes];
      left[s == &one] = bond.links.move_links(bond.points);
    }
    EXPECT_EQ(left[0], left[1]);
    if (!left[1]) continue;
    ++crossings;
    Bond &followed = one.bonds[row], &anew = two.bonds[row];
    EXPECT_TRUE(followed.links.follow_points(followed.points, one.records[row], followed.grid));
    anew.links = two.links_anew(anew);
    for (Scene* s : {&one, &two}) {
      s->motion = one.motion;
      s->add_force();
    }
    EXPECT_EQ(followed.grid.force, anew.grid.force);
    EXPECT_EQ(one.row_sums(followed, 0.2), two.row_sums(anew, 0.2));
    for (std::size_t i = 0; i < one.ends.ends.size(); ++i)
      for (int d = 0; d < 3; ++d) EXPECT_EQ(one.ends.ends[i].torque[d], two.ends.ends[i].torque[d]);
  }
  EXPECT_GT(crossings, 6);
}

int attached(const PointStore& points) {
  return static_cast<int>(std::count_if(points.links.begin(), points.links.end(), [](const Link& k) { return k.attached; }));
}

TEST_P(Links, LetGo) {
  constexpr double kStep = 0.2;
  Scene s(137, parameters(GetParam()));
  s.place_grains(0.2, 1.0);
  s.set_added_mass(kStep);
  for (Bond& b : s.bonds) {
    const double before = s.energy(), inertial = b.added.energy(b.grid, s.ends_of(b));
    EXPECT_GT(inertial, 0.0);
    std::vector<int> failed;
    for (std::size_t i = 0; i < s.slots[b.row].size(); i += 3) failed.push_back(s.slots[b.row][i]);
    std::sort(failed.begin(), failed.end());
    const int whole = attached(b.points);
    int expected = 0;
    for (const Link& k : b.points.links) expected += std::binary_search(failed.begin(), failed.end(), k.slot);
    EXPECT_GT(expected, 10);
    double released = 0;
    b.links.debond(b.points, {}, b.grid, s.ends_of(b), 0.0, released);
    EXPECT_EQ(attached(b.points), whole);
    EXPECT_EQ(released, 0.0);
    b.links.debond(b.points, failed, b.grid, s.ends_of(b), 0.0, released);
    EXPECT_EQ(attached(b.points), whole - expected);
    const double once = released;
    b.links.debond(b.points, failed, b.grid, s.ends_of(b), 0.0, released);
    EXPECT_EQ(released, once);
    for (const Link& k : b.points.links) {
      EXPECT_EQ(k.attached == 0, std::binary_search(failed.begin(), failed.end(), k.slot));
      EXPECT_EQ(k.keeps_added_mass, !k.attached);
    }
    test::expect_within(std::fabs((before - s.energy()) / released - 1.0), 1e-13, "spring energy released");
    s.add_force();
    s.expect_balanced(s.forces(), 1e-14, "after");
    // added mass reacts as before, in a layout from the store as it is now too, until it is dropped
    const auto inertial_of = [&](const PenaltyLinks& links) {
      b.added.find(links, b.grid, s.ends_of(b), {kStep, 0.0, false, 4.0});
      return b.added.energy(b.grid, s.ends_of(b));
    };
    EXPECT_EQ(inertial_of(b.links), inertial);
    test::expect_within(std::fabs(inertial_of(s.links_anew(b)) / inertial - 1.0), 1e-13, "energy of added mass in a new layout");
    b.links.drop_added_mass(b.points);
    for (const Link& k : b.points.links) EXPECT_FALSE(k.keeps_added_mass);
    EXPECT_LT(inertial_of(b.links), inertial);
    test::expect_within(std::fabs(inertial_of(s.links_anew(b)) / inertial_of(b.links) - 1.0), 1e-13, "energy of what is left");

    // a layout from the store as it is now gives the same force
    const std::vector<double> force = b.grid.force;
    PenaltyLinks again(b.points, s.records[b.row], b.links.parameters(), kH, kDensity);
    std::vector<Grid::Cell> cells;
    for (BlockMeta& m : b.points.meta) cells.push_back({field_of(m.row, m.layer), m.base, m.column});
    b.links.add_cells(cells);  // keeps the nodes
    again.add_cells(cells);
    std::vector<char> fresh;
    b.grid.build(MPI_COMM_SELF, kH, cells, NodeKinematics(), fresh);
    again.add_force(b.grid, s.ends_of(b));
    ASSERT_EQ(force.size(), b.grid.force.size());
    test::Worst worst;
    for (std::size_t i = 0; i < force.size(); ++i) worst.add(std::fabs(force[i] - b.grid.force[i]));
    expect_within(worst, 1e-12, "force of the links that are left");
    b.grid.lump_mass(b.points, kDensity);
  }
}

// Points crowd in one cell, so that blocks of links are full: one link after the other debonds, in whatever lane it is.
TEST_P(Links, LetGoInEachLane) {
  Scene s(142, parameters(GetParam()), Basis::quadratic, 1, 0.4 * kH);
  s.place_grains(0.2, 0.0);
  double released = 0.0;
  const double whole = s.energy();
  std::size_t all = 0;
  for (Bond& b : s.bonds) {
    std::vector<int> linked;
    for (const Link& k : b.points.links) linked.push_back(k.slot);
    linked.erase(std::unique(linked.begin(), linked.end()), linked.end());
    all += linked.size();
    for (int slot : linked) {
      const double before = s.energy(), gone = released;
      const int held = attached(b.points);
      const auto links = std::count_if(b.points.links.begin(), b.points.links.end(), [&](const Link& k) { return k.slot == slot; });
      b.links.debond(b.points, {slot}, b.grid, s.ends_of(b), 0.0, released);
      EXPECT_EQ(held - attached(b.points), links) << "slot " << slot;
      for (const Link& k : b.points.links)
        if (k.slot == slot) {
          EXPECT_FALSE(k.attached);
        }
      EXPECT_GT(released, gone);
      test::expect_within(std::fabs(before - s.energy() - (released - gone)) / whole, 1e-14, "energy of the links that debonded");
    }
  }
  ASSERT_GT(all, 2u * 60 * 3 / 4);
  EXPECT_EQ(s.energy(), 0.0);
  test::expect_within(std::fabs(released / whole - 1.0), 1e-13, "energy of all");
}

// A spring one node wide, by hand: normal along R q0, not along the present vector.
TEST_P(Links, DirectionsOfTheSpring) {
  Scene s(138, parameters(GetParam()));
  for (int axis = 0; axis < 2; ++axis) {
    // every node moves along or across bond 0; grains stay
    const Vector n = Eigen::Map<const Vector>(s.records[0].centre[1]).normalized();
    const Vector move = 0.3 * (axis == 0 ? n : n.unitOrthogonal());
    s.place_grains(0.0, 0.0);
    for (int i = 0; i < s.bonds[0].grid.size(); ++i) copy(move, &s.bonds[0].grid.displacement[3 * i]);
    s.add_force();
    for (int side = 0; side < 2; ++side) {
      Vector expected = Vector::Zero();
      for (const Link& k : s.bonds[0].points.links) {
        const int b = k.slot / kLanes, l = k.slot % kLanes;
        if (k.grain != s.records[0].grain[side]) continue;
        const vd* X = s.bonds[0].points.blocks[b].X;
        const Vector at = GetParam() ? Vector(Eigen::Map<const Vector>(k.foot)) : Vector(X[0][l], X[1][l], X[2][l]);
        const Vector m = (at - Eigen::Map<const Vector>(s.records[0].centre[side])).normalized();
        const Vector normal = move.dot(m) * m;
        expected += k.area * (900.0 * normal + 250.0 * (move - normal));
      }
      const Vector force = Eigen::Map<const Vector>(s.ends.ends[side].force);
      test::expect_within((force - expected).norm() / expected.norm(), 1e-12, "force on a grain");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Penalty, Links, ::testing::Values(true, false),
                         [](const ::testing::TestParamInfo<bool>& p) { return p.param ? "at_surface" : "at_points"; });

}  // namespace
}  // namespace mpdem
