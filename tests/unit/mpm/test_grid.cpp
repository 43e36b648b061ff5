// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/grid.h"

#include <algorithm>
#include <limits>
#include <set>

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::Vector;

constexpr double kH = 0.5;

struct Cells {
  std::vector<Key> cell;  // its first node
  std::vector<std::array<int, 9>> column;

  explicit Cells(std::vector<Key> c) : cell(std::move(c)), column(cell.size()) {}
  std::vector<Grid::Cell> list() {
    std::vector<Grid::Cell> all;
    for (std::size_t i = 0; i < cell.size(); ++i) all.push_back({cell[i].field(), cell[i].index().data(), column[i].data()});
    return all;
  }
};

void expect_columns(const Grid& grid, const Cells& c) {
  for (std::size_t n = 0; n < c.cell.size(); ++n)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          const Key expected = c.cell[n].moved(0, i).moved(1, j).moved(2, k);
          EXPECT_EQ(grid.keys.at(c.column[n][3 * i + j] + k), expected);
        }
}

TEST(Grid, HasTheNodesOfItsCellsAndNoOthers) {
  test::Random random(111);
  std::vector<Key> list;
  for (int i = 0; i < 60; ++i) list.push_back({random.index(2), random.index(7) - 3, random.index(7) - 3, random.index(7) - 3});
  Cells c(list);
  Grid grid;
  std::vector<char> fresh;
  grid.build(MPI_COMM_SELF, kH, c.list(), NodeKinematics(), fresh);
  EXPECT_TRUE(std::is_sorted(grid.keys.begin(), grid.keys.end()));
  std::set<Key> expected;
  for (const Key& a : list)
    for (int n = 0; n < 27; ++n) expected.insert(a.moved(0, n / 9).moved(1, n / 3 % 3).moved(2, n % 3));
  EXPECT_EQ(std::set<Key>(grid.keys.begin(), grid.keys.end()), expected);
  EXPECT_EQ(grid.keys.size(), expected.size());
  expect_columns(grid, c);
  EXPECT_EQ(std::count(fresh.begin(), fresh.end(), 1), grid.size());
  for (double v : grid.velocity) EXPECT_EQ(v, 0.0);
}

// Points far from each other take the nodes of a margin each.
TEST(Grid, RefusesMoreNodesThanThereIsMemoryFor) {
  std::vector<Key> list;
  for (int i = 0; i < 1000; ++i) list.push_back({0, 100 * i, 0, 0});
  Cells c(list);
  Grid grid;
  std::vector<char> fresh;
  const auto build_within = [&](double bytes) {
    std::vector<GridRequest> one(1);
    one[0].grid = &grid;
    one[0].cells = c.list();
    build_grids(MPI_COMM_SELF, kH, 3, bytes, one);
  };
  try {
    build_within(2e7);
    FAIL();
  } catch (const GridTooLarge& e) {
    EXPECT_GT(e.bytes, 2e7);
    EXPECT_LE(e.bytes, 1000.0 * 729.0 * 500.0);
  }
  grid.build(MPI_COMM_SELF, kH, c.list(), NodeKinematics(), fresh);  // without margin: 27 nodes each
  EXPECT_EQ(grid.size(), 27000);
  build_within(1e9);
  EXPECT_EQ(grid.size(), 729000);
}

// The limit is that of all grids together.
TEST(Grid, MemoryLimitIsOfAllGrids) {
  const auto build = [](int grids, double bytes) {
    std::vector<Cells> cells;
    std::vector<Grid> all(grids);
    std::vector<GridRequest> requests(grids);
    for (int n = 0; n < grids; ++n) cells.push_back(Cells({{n, 0, 0, 0}}));
    for (int n = 0; n < grids; ++n) {
      requests[n].grid = &all[n];
      requests[n].cells = cells[n].list();
    }
    build_grids(MPI_COMM_SELF, kH, 0, bytes, requests);
  };
  constexpr double kOfOne = 27 * 500.0;
  EXPECT_NO_THROW(build(1, kOfOne));
  EXPECT_NO_THROW(build(10, 10 * kOfOne));
  EXPECT_THROW(build(11, 10 * kOfOne), GridTooLarge);
}

TEST(Grid, CarriesTheMotionOver) {
  test::Random random(112);
  Cells first({{0, 0, 0, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}}), second({{0, 1, 0, 0}, {0, 2, 0, 1}, {1, 0, 0, 0}});
  Grid grid;
  std::vector<char> fresh;
  grid.build(MPI_COMM_SELF, kH, first.list(), NodeKinematics(), fresh);
  for (std::vector<double>* field : {&grid.velocity, &grid.displacement, &grid.acceleration})
    for (double& v : *field) v = random.uniform(1, 2);
  const Grid before = grid;
  const NodeKinematics saved = grid.kinematics();
  const auto expect_carried = [&] {
    int fresh_nodes = 0;
    for (int i = 0; i < grid.size(); ++i) {
      const auto it = std::lower_bound(before.keys.begin(), before.keys.end(), grid.keys[i]);
      const bool had = it != before.keys.end() && *it == grid.keys[i];
      const int at = static_cast<int>(it - before.keys.begin());
      EXPECT_EQ(fresh[i] != 0, !had);
      fresh_nodes += !had;
      for (int d = 0; d < 3; ++d) {
        EXPECT_EQ(grid.velocity[3 * i + d], had ? before.velocity[3 * at + d] : 0.0);
        EXPECT_EQ(grid.displacement[3 * i + d], had ? before.displacement[3 * at + d] : 0.0);
        EXPECT_EQ(grid.acceleration[3 * i + d], had ? before.acceleration[3 * at + d] : 0.0);
      }
    }
    EXPECT_GT(fresh_nodes, 0);
  };
  grid.build(MPI_COMM_SELF, kH, second.list(), NodeKinematics(), fresh);
  expect_columns(grid, second);
  expect_carried();
  // as after a restart: from the saved motion, into an empty grid
  grid = Grid();
  grid.build(MPI_COMM_SELF, kH, second.list(), saved, fresh);
  expect_carried();
}

// Nodes are added before the others, between them and behind. New nodes are at rest. All others keep what they have.
TEST(Grid, NodesAreAdded) {
  test::Random random(113);
  for (int round = 0; round < 20; ++round) {
    Cells cells({{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}});
    Grid grid;
    std::vector<char> fresh;
    grid.build(MPI_COMM_SELF, kH, cells.list(), NodeKinematics(), fresh);
    grid.given_volume.assign(grid.size(), 0.0);
    for (std::vector<double>* field :
         {&grid.velocity, &grid.displacement, &grid.acceleration, &grid.force, &grid.mass.own(), &grid.given_volume})
      for (double& v : *field) v = random.uniform(1, 2);
    const Grid before = grid;
    std::set<Key> more;
    for (int n = 0; n < round; ++n) more.insert({random.index(3), random.index(9) - 3, random.index(7) - 3, random.index(7) - 3});
    for (const Key& k : before.keys) more.erase(k);
    const std::vector<int> place = grid.add_nodes({more.begin(), more.end()});
    ASSERT_EQ(place.size(), before.keys.size());
    ASSERT_EQ(grid.keys.size(), before.keys.size() + more.size());
    EXPECT_TRUE(std::is_sorted(grid.keys.begin(), grid.keys.end()));
    std::vector<int> was(grid.size(), -1);
    for (int i = 0; i < before.size(); ++i) {
      EXPECT_EQ(grid.keys[place[i]], before.keys[i]);
      was[place[i]] = i;
    }
    for (int i = 0; i < grid.size(); ++i) {
      EXPECT_EQ(more.count(grid.keys[i]), was[i] < 0 ? 1u : 0u);
      EXPECT_EQ(grid.mass[i], was[i] < 0 ? 0.0 : before.mass[was[i]]);
      EXPECT_EQ(grid.given_volume[i], was[i] < 0 ? -1.0 : before.given_volume[was[i]]);
      for (int d = 0; d < 3; ++d)
        for (auto field : {&Grid::velocity, &Grid::displacement, &Grid::acceleration, &Grid::force})
          EXPECT_EQ((grid.*field)[3 * i + d], was[i] < 0 ? 0.0 : (before.*field)[3 * was[i] + d]);
    }
  }
}

// Nodes that have a source take its motion, if there is such a node.
TEST(Grid, NodesTakeTheMotionOfTheirSource) {
  test::Random random(117);
  const Field layer = field_of(0, 1);
  EXPECT_EQ(row_of(field_of(7, 3)), 7);
  Cells first({{0, 0, 0, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}}), second({{0, 0, 0, 0}, {layer, 0, 0, 0}, {layer, 2, 0, 0}, {1, 0, 0, 0}});
  Grid grid;
  std::vector<char> fresh;
  grid.build(MPI_COMM_SELF, kH, first.list(), NodeKinematics(), fresh);
  for (std::vector<double>* field : {&grid.velocity, &grid.displacement, &grid.acceleration})
    for (double& v : *field) v = random.uniform(1, 2);
  const Grid before = grid;
  std::vector<GridRequest> requests(1);
  GridRequest& request = requests.front();
  request.grid = &grid;
  request.cells = second.list();
  request.before = before.kinematics();
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) request.source[{layer, i, j, k}] = {0, i, j, k};
  build_grids(MPI_COMM_SELF, kH, 0, std::numeric_limits<double>::infinity(), requests);
  fresh.swap(request.fresh);
  expect_columns(grid, second);
  int inherited = 0;
  for (int i = 0; i < grid.size(); ++i) {
    Key source = grid.keys[i];
    if (source.field() == layer) source = source.with_field(0);
    const auto it = std::lower_bound(before.keys.begin(), before.keys.end(), source);
    const bool had = it != before.keys.end() && *it == source;
    const int at = static_cast<int>(it - before.keys.begin());
    inherited += had && grid.keys[i].field() == layer;
    EXPECT_EQ(fresh[i] != 0, !had);
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(grid.velocity[3 * i + d], had ? before.velocity[3 * at + d] : 0.0);
      EXPECT_EQ(grid.displacement[3 * i + d], had ? before.displacement[3 * at + d] : 0.0);
      EXPECT_EQ(grid.acceleration[3 * i + d], had ? before.acceleration[3 * at + d] : 0.0);
    }
  }
  EXPECT_EQ(inherited, 4 * 9);  // the four layers that both have
}

TEST(Grid, LumpedMassKeepsTotalAndCentre) {
  test::Random random(113);
  Cement c(kH, test::scattered(random, kH, 3, 5), 0.7);
  const double density = 2710;
  c.grid.lump_mass(c.points, density);
  c.grid.lump_mass(c.points, density);  // does not add up
  double mass = 0;
  Vector moment = Vector::Zero(), exact = Vector::Zero();
  for (int n = 0; n < c.grid.size(); ++n) {
    EXPECT_GE(c.grid.mass[n], 0.0);
    mass += c.grid.mass[n];
    moment += c.grid.mass[n] * c.place(n);
  }
  c.for_points([&](int b, int l) {
    for (int d = 0; d < 3; ++d) exact[d] += density * 0.7 * c.points.blocks[b].X[d][l];
  });
  const double total = density * 0.7 * static_cast<double>(c.slots.size());
  test::expect_within(std::fabs(mass / total - 1.0), 1e-14, "mass");
  test::expect_within((moment - exact).norm() / exact.norm(), 1e-14, "first moment");
}

TEST(Grid, LeapFrog) {
  test::Random random(115);
  Cement c(kH, test::scattered(random, kH, 2, 5), 0.7);
  Grid& g = c.grid;
  g.lump_mass(c.points, 1.0);
  std::vector<double> added(g.size());
  for (double& m : added) m = random.uniform(0, 1);
  g.mass.own()[3] = added[3] = 0.0;
  for (std::vector<double>* field : {&g.velocity, &g.displacement, &g.force})
    for (double& v : *field) v = random.uniform(-1, 1);
  const Grid start = g;
  for (bool with_added : {true, false}) {
    g = start;
    const Grid before = g;
    if (with_added) g.update_acceleration(added);
    else g.update_acceleration();
    g.drift(0.2, 0.3);
    for (int i = 0; i < 3 * g.size(); ++i) {
      const double m = g.mass[i / 3] + (with_added ? added[i / 3] : 0.0), a = m > 0 ? before.force[i] / m : 0.0;
      const double v = before.velocity[i] + 0.2 * a;
      EXPECT_NEAR(g.acceleration[i], a, 1e-14 * std::fabs(a));
      EXPECT_NEAR(g.velocity[i], v, 1e-13 * (1 + std::fabs(a)));
      EXPECT_NEAR(g.displacement[i], before.displacement[i] + 0.3 * v, 1e-13 * (1 + std::fabs(a)));
    }
  }
  g.clear_force();
  for (double f : g.force) EXPECT_EQ(f, 0.0);
}

TEST(Grid, NoticesWhatIsNotFinite) {
  test::Random random(116);
  Cement c(kH, test::scattered(random, kH, 2, 5), 0.7);
  EXPECT_TRUE(c.grid.finite());
  for (std::vector<double>* field : {&c.grid.velocity, &c.grid.displacement, &c.grid.acceleration})
    for (double bad : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
      field->back() = bad;
      EXPECT_FALSE(c.grid.finite());
      field->back() = 1e100;
      EXPECT_TRUE(c.grid.finite());
    }
}

}  // namespace
}  // namespace mpdem
