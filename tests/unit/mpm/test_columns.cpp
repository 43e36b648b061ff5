// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "mpm/columns.h"
#include "mpm/gather.h"
#include "mpm/point_store.h"
#include "mpm/scatter.h"

namespace mpdem {
namespace {

constexpr double kColumnCell = 0.3;

// Points of one cell, whose base is (-4, 2, 7): `shift` moves columns, `lift` points along them, `left_out` is a mask of lanes.
PointStore points_of_a_cell(double shift, double lift, unsigned left_out = 0) {
  PointStore store;
  const double first = cell_middle(Basis::quadratic) - 0.5, corner[3] = {-4 + first, 2 + first, 7 + first};
  for (int n = 0; n < kLanes; ++n) {
    const int l = (5 * n + 3) % kLanes;  // not in the order of their places
    if (left_out >> l & 1) continue;
    PointRecord r;
    r.volume = 0.01;
    const int a = l >> 2 & 1, b = l >> 1 & 1, c = l & 1;
    r.X[0] = kColumnCell * (corner[0] + 0.2 + 0.5 * a + shift * (a + b * (1 - a)) * b);
    r.X[1] = kColumnCell * (corner[1] + 0.3 + 0.5 * b - shift * a * b);
    r.X[2] = kColumnCell * (corner[2] + 0.1 + 0.5 * c + lift * (a + 2 * b));
    store.add(r, n + 1);
  }
  store.arrange(kColumnCell, Basis::quadratic, {}, true);
  return store;
}

// Nodes of a cell, as columns that do not follow each other.
struct Nodes {
  int column[9];
  std::vector<double> value;
  Nodes() : value(3 * 9 * 5) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int c = 0; c < 9; ++c) column[c] = 5 * ((4 * c + 2) % 9);
    for (double& v : value) v = any(random);
  }
};

Mat3<vd> any_tensor(const BlockMeta& m) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  Mat3<vd> T;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int l = 0; l < kLanes; ++l) T.a[i][j][l] = m.occupied >> l & 1 ? any(random) : 0.0;
  return T;
}

// Gradients, values and forces are those of points anywhere, to rounding.
void expect_same_as_anywhere(const PointStore& store, Lattice lattice) {
  ASSERT_EQ(store.blocks.size(), 1u);
  const PointBlock& p = store.blocks[0];
  const BlockMeta& m = store.meta[0];
  ASSERT_EQ(m.lattice, lattice);
  const Weights<QuadraticBspline> everywhere(p.X, m.base, 1.0 / kColumnCell);
  const Nodes nodes;
  const Mat3<vd> G = gather_gradient(nodes.value.data(), nodes.column, everywhere), T = any_tensor(m);
  const vd value = gather_scalar(nodes.value.data(), nodes.column, everywhere);
  std::vector<double> force = nodes.value;
  scatter_gradient(force.data(), nodes.column, everywhere, T);
  with_gradient_weights<QuadraticBspline>(p, m, 1.0 / kColumnCell, [&](const auto& s) {
    const Mat3<vd> same = gather_gradient(nodes.value.data(), nodes.column, s);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int l = 0; l < kLanes; ++l) {
          if (!(m.occupied >> l & 1)) continue;
          EXPECT_NEAR(same.a[i][j][l], G.a[i][j][l], 1e-14 / kColumnCell) << i << j << ' ' << l;
        }
    const vd same_value = gather_scalar(nodes.value.data(), nodes.column, s);
    for (int l = 0; l < kLanes; ++l) {
      if (!(m.occupied >> l & 1)) continue;
      EXPECT_NEAR(same_value[l], value[l], 1e-14) << l;
    }
    std::vector<double> other = nodes.value;
    scatter_gradient(other.data(), nodes.column, s, T);
    for (std::size_t n = 0; n < force.size(); ++n) EXPECT_NEAR(other[n], force[n], 4e-14 / kColumnCell) << n;
  });
}

TEST(Columns, BoxIsAsPointsAnywhere) { expect_same_as_anywhere(points_of_a_cell(0, 0), Lattice::box); }
TEST(Columns, BoxThatIsNotFull) { expect_same_as_anywhere(points_of_a_cell(0, 0, 0b01100010), Lattice::box); }
TEST(Columns, ColumnsThatStandAnywhere) { expect_same_as_anywhere(points_of_a_cell(0.07, 0), Lattice::columns); }
TEST(Columns, ColumnsThatAreNotFull) { expect_same_as_anywhere(points_of_a_cell(0.07, 0, 0b00001001), Lattice::columns); }
TEST(Columns, PointsAnywhere) {
  EXPECT_EQ(points_of_a_cell(0, 0.01).meta[0].lattice, Lattice::none);
  // A block keeps its points, whatever they are in.
  EXPECT_EQ(points_of_a_cell(0.07, 0.01, 0b1).size(), 7);
}

// Points that move to another layer leave the others in their lanes. Empty lanes are where they would be after a fresh start.
TEST(Columns, PartsKeepTheLattice) {
  for (double shift : {0.0, 0.07}) {
    PointStore moved = points_of_a_cell(shift, 0), fresh = moved;
    const std::map<int, int> layer = {{1, 3}, {4, 3}, {6, 3}};
    moved.move_to_layers(layer, kColumnCell, Basis::quadratic);
    fresh.arrange(kColumnCell, Basis::quadratic, layer, true);
    ASSERT_EQ(moved.blocks.size(), 2u);
    ASSERT_EQ(fresh.blocks.size(), 2u);
    for (int b = 0; b < 2; ++b) {
      EXPECT_EQ(moved.meta[b].lattice, fresh.meta[b].lattice);
      EXPECT_NE(moved.meta[b].lattice, Lattice::none);
      for (int d = 0; d < 3; ++d)
        for (int l = 0; l < kLanes; ++l) EXPECT_EQ(double(moved.blocks[b].X[d][l]), double(fresh.blocks[b].X[d][l]));
    }
  }
}

}  // namespace
}  // namespace mpdem
