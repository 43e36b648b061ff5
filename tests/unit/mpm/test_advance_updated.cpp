// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/advance_updated.h"

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCalcite;
using test::kCell;
using test::Matrix;
using test::Vector;

NoDamage elastic() { return NoDamage(VtiElasticity(VtiConstants{60e9, 40e9, 0.25, 0.2, 18e9})); }

Transfer transfer(Transfer::Method method, double share = 1.0) {
  Transfer t;
  t.method = method;
  t.flip_share = share;
  return t;
}

// A lump of points and its grid, stepped without forces from outside.
struct Lump {
  Cement c;
  UpdatedPass pass;
  Transfer method;
  NoDamage law = elastic();
  double dt = 2e-9;
  int layouts = 0, moved = 0;

  Lump(test::Random& random, Basis basis, const Transfer& t, int per_cell = 8)
      : c(kCell, test::scattered(random, kCell, 4, per_cell), kCell * kCell * kCell / per_cell, Eigen::Quaterniond::Identity(), basis,
          UpdatedPass::kMargin),
        method(t) {
    c.grid.lump_mass(c.points, kCalcite);
    c.points.start_motion();
    pass.bind(c.points, c.grid);
  }

  template <class F>
  void set_velocity(F f) {
    c.set_velocity(f);
    UpdatedPass::start(c.points, c.grid, 0);
    project();
  }
  void project() {
    UpdatedPass::project(c.points, c.grid, law, kCalcite, method);
    take_nodes();
  }
  void take_nodes() {
    c.grid.update_acceleration();
    for (int i = 0; i < c.grid.size(); ++i)
      for (int d = 0; d < 3; ++d) c.grid.velocity[3 * i + d] = c.grid.mass[i] > 0 ? c.grid.momentum[3 * i + d] / c.grid.mass[i] : 0.0;
  }
  // The grid for the blocks as they are.
  void lay_out() {
    std::vector<Grid::Cell> cells;
    for (BlockMeta& m : c.points.meta) cells.push_back({field_of(m.row, m.layer), m.base, m.column});
    std::vector<char> fresh;
    c.grid.build(MPI_COMM_SELF, kCell, cells, NodeKinematics(), fresh, UpdatedPass::kMargin);
    c.grid.lump_mass(c.points, kCalcite);
    pass.bind(c.points, c.grid);
    ++layouts;
  }
  void step() {
    if (pass.layout_is_stale()) lay_out();
    c.grid.drift(dt, 0.0);
    AdvanceResult result;
    pass.advance(c.points, c.grid, law, kCalcite, dt, dt, method, AdvanceOptions(), result);
    ASSERT_EQ(pass.lost(), 0);
    moved += pass.crossings();
    take_nodes();
  }
  template <class F>
  void for_points(F f) const {
    for (std::size_t b = 0; b < c.points.blocks.size(); ++b)
      for (int l = 0; l < kLanes; ++l)
        if (c.points.meta[b].occupied >> l & 1) f(static_cast<int>(b), l);
  }
  Vector momentum() const {
    Vector p = Vector::Zero();
    for (int n = 0; n < c.grid.size(); ++n) p += c.at(c.grid.momentum, n);
    return p;
  }
  Vector angular_momentum() const {
    Vector L = Vector::Zero();
    for (int n = 0; n < c.grid.size(); ++n) L += c.place(n).cross(c.at(c.grid.momentum, n));
    return L;
  }
};

class Updated : public ::testing::TestWithParam<Basis> {};
INSTANTIATE_TEST_SUITE_P(Bases, Updated, ::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic));

// A flight through many cells: every point goes as far, without strain, and none is lost.
TEST_P(Updated, Translation) {
  test::Random random(141);
  for (const Transfer& t : {transfer(Transfer::flip), transfer(Transfer::apic), transfer(Transfer::xpic)}) {
    Lump lump(random, GetParam(), t);
    const Vector v(3000, -1700, 900);
    lump.set_velocity([&](const Vector&) { return v; });
    int points = 0;
    lump.for_points([&](int, int) { ++points; });
    const int steps = 150;  // nine cells along x
    for (int n = 0; n < steps; ++n) lump.step();
    test::Worst strain, place;
    int left = 0;
    lump.for_points([&](int b, int l) {
      ++left;
      const PointStore& s = lump.c.points;
      strain.add(test::tensor(s.blocks[b].strain, l), 1.0);
      for (int d = 0; d < 3; ++d) place.add(std::fabs(s.blocks[b].X[d][l] - s.motion[b].X0[d][l] - steps * lump.dt * v[d]) / kCell);
    });
    EXPECT_EQ(left, points);
    EXPECT_GT(lump.moved, 10 * points);
    // points of a cell are in as few blocks as they fit into, but for cells that gained some since they last lost one
    std::map<Key, std::array<int, 2>> cells;  // points, blocks
    for (const BlockMeta& m : lump.c.points.meta) {
      std::array<int, 2>& n = cells[{field_of(m.row, m.layer), m.base[0], m.base[1], m.base[2]}];
      n[0] += __builtin_popcount(m.occupied);
      n[1] += m.occupied != 0;
    }
    int blocks = 0, least = 0;
    for (const auto& cell : cells) {
      blocks += cell.second[1];
      least += (cell.second[0] + kLanes - 1) / kLanes;
    }
    EXPECT_LE(blocks, 1.1 * least);
    EXPECT_GT(lump.layouts, 2);
    expect_within(strain, 1e-12, "strain");
    expect_within(place, 1e-11, "place");
  }
}

// Every link stays with its point, wherever that goes or is packed to, also in steps in which no linked point changes cell, and where a block that took
// points of another one is dissolved in the same step.
TEST_P(Updated, LinksGoWithTheirPoints) {
  test::Random random(145);
  for (const auto& [every, per_cell] : {std::pair(1, 8), std::pair(7, 8), std::pair(40, 8), std::pair(1, 50)}) {
    Lump lump(random, GetParam(), transfer(Transfer::flip), per_cell);
    PointStore& points = lump.c.points;
    int n = 0;
    lump.for_points([&](int b, int l) {
      if (n++ % every) return;
      Link k{};
      k.slot = kLanes * b + l;
      k.grain = points.tags[b][l];  // to know the point by
      points.links.push_back(k);
      points.meta[b].linked |= static_cast<std::uint8_t>(1u << l);
    });
    lump.set_velocity([&](const Vector& x) { return Vector(Vector(2000, -900, 500) + 500 * (x / kCell) + 300 * random.vector()); });
    int astray = 0, bits = 0;
    for (int step = 0; step < 40; ++step) {
      lump.step();
      for (const Link& k : points.links) {
        const int b = k.slot / kLanes, l = k.slot % kLanes;
        astray += points.tags[b][l] != k.grain || !(points.meta[b].occupied >> l & 1) || !(points.meta[b].linked >> l & 1);
      }
    }
    for (const BlockMeta& m : points.meta) bits += __builtin_popcount(m.linked);
    EXPECT_EQ(astray, 0) << "every " << every << " of " << per_cell;
    EXPECT_EQ(bits, static_cast<int>(points.links.size()));
    EXPECT_GT(lump.moved, 200);
  }
}

// Points that changed cell give to the nodes what they give after everything was laid out anew.
TEST_P(Updated, RelocationKeepsThePass) {
  test::Random random(142);
  Lump lump(random, GetParam(), transfer(Transfer::apic));
  lump.set_velocity([&](const Vector& x) { return Vector(500 * (x / kCell) + 300 * random.vector()); });
  for (int n = 0; n < 20; ++n) lump.step();
  EXPECT_GT(lump.moved, 100);
  const Grid& g = lump.c.grid;
  std::map<Key, std::array<double, 7>> nodes;
  for (int i = 0; i < g.size(); ++i)
    if (g.mass[i] > 0.0)
      // of the forces a step leaves the accelerations
      nodes[g.keys[i]] = {g.mass[i],
                          g.momentum[3 * i],
                          g.momentum[3 * i + 1],
                          g.momentum[3 * i + 2],
                          g.mass[i] * g.acceleration[3 * i],
                          g.mass[i] * g.acceleration[3 * i + 1],
                          g.mass[i] * g.acceleration[3 * i + 2]};
  lump.c.points.arrange(kCell, GetParam());
  lump.lay_out();
  lump.project();
  double mass = 0, momentum = 0, force = 0;
  for (const auto& n : nodes) {
    mass = std::max(mass, n.second[0]);
    for (int d = 0; d < 3; ++d) {
      momentum = std::max(momentum, std::fabs(n.second[1 + d]));
      force = std::max(force, std::fabs(n.second[4 + d]));
    }
  }
  ASSERT_GT(force, 0.0);
  test::Worst worst;
  for (int i = 0; i < g.size(); ++i) {
    const auto it = nodes.find(g.keys[i]);
    const std::array<double, 7> before = it == nodes.end() ? std::array<double, 7>{} : it->second;
    worst.add(std::fabs(g.mass[i] - before[0]) / mass);
    for (int d = 0; d < 3; ++d) {
      worst.add(std::fabs(g.momentum[3 * i + d] - before[1 + d]) / momentum);
      worst.add(std::fabs(g.mass[i] * g.acceleration[3 * i + d] - before[4 + d]) / force);
    }
  }
  expect_within(worst, 1e-12, "nodes");
}

// A free lump that rotates and is strained: momentum with every transfer, angular momentum with
// apic, where the nodes' own is kept from step to step by the pass and by the force.
TEST_P(Updated, Conservation) {
  test::Random random(143);
  for (const Transfer& t : {transfer(Transfer::flip, 0.98), transfer(Transfer::apic), transfer(Transfer::xpic)}) {
    Lump lump(random, GetParam(), t);
    const Matrix A = 40.0 * random.general();
    // with linear hat functions a node may have almost no mass at full force
    if (GetParam() == Basis::linear) lump.dt = 2e-12;
    lump.set_velocity([&](const Vector& x) { return Vector(A * (x / kCell) + Vector(100, 50, -70)); });
    const Vector p = lump.momentum(), L = lump.angular_momentum();
    for (int n = 0; n < 100; ++n) lump.step();
    test::expect_within((lump.momentum() - p).norm() / p.norm(), 1e-12, "momentum");
    // x <- x + dt v changes nothing in x ^ v, so all of it is the transfer's
    if (t.method == Transfer::apic && GetParam() != Basis::linear)
      test::expect_within((lump.angular_momentum() - L).norm() / L.norm(), 1e-11, "angular momentum");
  }
}

TEST(UpdatedPass, TellsOfPointsThatWentTooFar) {
  test::Random random(144);
  Lump lump(random, Basis::quadratic, transfer(Transfer::xpic));
  lump.set_velocity([&](const Vector&) { return Vector(1e9, 0, 0); });
  lump.c.grid.drift(lump.dt, 0.0);
  AdvanceResult result;
  lump.pass.advance(lump.c.points, lump.c.grid, lump.law, kCalcite, lump.dt, lump.dt, lump.method, AdvanceOptions(), result);
  EXPECT_NE(lump.pass.lost(), 0);
}

}  // namespace
}  // namespace mpdem
