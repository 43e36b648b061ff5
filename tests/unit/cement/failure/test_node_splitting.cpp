// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement/failure/node_splitting.h"

#include <gtest/gtest.h>

#include "cement/failure/node_aliases.h"
#include "coupling/cohesive_traction.h"
#include "coupling/penalty_traction.h"
#include "mpm/block_nodes.h"
#include "mpm/gather.h"
#include "mpm/scatter.h"

namespace mpdem {
namespace {

// A grid has the nodes that represent those of a layer, whose points may all have left layer 0: those of each cell of a block.
TEST(NodeSplitting, NodesThatStandForThoseOfABlock) {
  constexpr double kCell = 1e-3;
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic})
    for (int direction = 0; direction < 3; ++direction)
      for (bool join : {false, true}) {
        // a full block, and what is over of the cell with some of the next
        PointStore points;
        for (int n = 0; n < 13; ++n) {
          PointRecord r;
          r.layer = 2;
          r.volume = 1.0;
          for (int d = 0; d < 3; ++d) r.X[d] = kCell * (5.0 + cell_middle(basis) + (d == direction && n >= 10));
          points.add(r, n + 1);
        }
        points.arrange(kCell, basis, {}, join);
        EXPECT_EQ(points.blocks.size(), join && may_join_cells(basis) ? 2u : 3u);
        NodeSplitting splits;
        splits.restore(1, {});  // all nodes are whole
        std::vector<Key> expected;
        const int S = support(basis);
        for (int i = 0; i < S + (direction == 0); ++i)
          for (int j = 0; j < S + (direction == 1); ++j)
            for (int k = 0; k < S + (direction == 2); ++k) expected.push_back({0, 5 + i, 5 + j, 5 + k});
        EXPECT_EQ(splits.nodes_beside(points, 0, S), expected) << static_cast<int>(basis) << " " << direction << " " << join;
      }
}

CementOptions that_borrow() {
  CementOptions o;
  o.split = true;
  return o;
}

// Points that failed in layer 2 among intact ones: with nodes of their own, each of which moves as that of layer 0 does, they have the same
// place and the same mass.
TEST(NodeAliases, PlaceAndMassAreThoseOfOwnNodes) {
  constexpr double kCell = 1e-3, kDensity = 2710.0;
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic})
    for (int direction = 0; direction < 3; ++direction) {
      PointStore points;
      for (int n = 0; n < 13; ++n)
        for (int layer : {0, 2}) {
          PointRecord r;
          r.layer = layer;
          r.volume = 1e-12 * (1 + n);
          r.failed = layer != 0;
          for (int d = 0; d < 3; ++d) r.X[d] = kCell * (5.0 + cell_middle(basis) + 0.03 * (n % (3 + d)) + (d == direction && n >= 10));
          points.add(r, 1 + 2 * n + (layer != 0));
        }
      points.arrange(kCell, basis, {}, true);
      NodeSplitting splits;
      splits.restore(1, {});  // all nodes are whole
      const auto grid_of = [&](PointStore& p, bool own) {
        Grid grid;
        grid.basis = basis;
        std::vector<Grid::Cell> cells;
        for (BlockMeta& m : p.meta)
          if (own || m.layer == 0) cells.push_back({field_of(m.row, m.layer), m.base, m.column, m.joined});
        std::vector<char> fresh;
        grid.build(MPI_COMM_SELF, kCell, cells, {}, fresh, 0, splits.nodes_beside(p, 0, support(basis)));
        for (int i = 0; i < grid.size(); ++i)
          for (int d = 0; d < 3; ++d)
            grid.displacement[3 * i + d] =
                std::sin(1.0 + grid.keys[i].at(0) + 2.0 * grid.keys[i].at(1) * (1 + d) + 3.0 * grid.keys[i].at(2));
        grid.constrain(splits.constraints(grid.keys), true);
        return grid;
      };
      PointStore with_own(points);
      Grid own = grid_of(with_own, true), lent = grid_of(points, false);
      const NodeAliases rule(that_borrow(), nullptr);
      rule.find(points, lent, splits);
      EXPECT_LT(lent.size(), own.size());
      own.lump_mass(with_own, kDensity);
      lent.lump_mass(points, kDensity);
      double whole = 0.0, all = 0.0;
      for (int i = 0; i < lent.size(); ++i) {
        EXPECT_NEAR(lent.mass[i], own.mass[own.node_at(lent.keys[i])], 1e-14 * kDensity * 1e-10);
        whole += lent.mass[i];
      }
      for (int n = 0; n < 13; ++n) all += 2.0 * kDensity * 1e-12 * (1 + n);
      EXPECT_NEAR(whole, all, 1e-13 * all);
      int borrowing = 0;
      with_basis(basis, [&](auto type) {
        for (std::size_t b = 0; b < points.blocks.size(); ++b) {
          const BlockMeta& m = points.meta[b];
          ASSERT_EQ(m.aliases != BlockMeta::kOwn, m.layer == 2);
          borrowing += m.layer == 2;
          with_weights<decltype(type)>(points.blocks[b], m, 1.0 / kCell, [&](const auto& w) {
            vd u[3], v[3];
            gather_value(own.displacement.data(), with_own.meta[b].column, w, u);
            with_values<3>(lent, m, lent.displacement.data(),
                           [&](const double* values, const int* column) { gather_value(values, column, w, v); });
            for (int d = 0; d < 3; ++d)
              for (int l = 0; l < kLanes; ++l) EXPECT_EQ(u[d][l], v[d][l]);
          });
        }
      });
      EXPECT_GT(borrowing, 0);
      // nodes went elsewhere: lists follow
      std::vector<int> before;
      for (const BlockMeta& m : points.meta) for_each_node(lent, m, [&](int i) { before.push_back(i); });
      const std::vector<Key> keys = lent.keys;
      const std::vector<int> place = lent.add_nodes({Key{keys.front().field(), keys.front().at(0) - 9, 0, 0}});
      std::size_t n = 0;
      for (const BlockMeta& m : points.meta)
        for_each_node(lent, m, [&](int i) {
          const int was = before[n++];
          if (m.aliases != BlockMeta::kOwn) {
            EXPECT_EQ(i, place[was]);
          }
        });
    }
}

// Points may have no aliases if they may be stiff again, touch, are connected to a grain, or go through the pass over the points.
TEST(NodeAliases, WhoMayBorrow) {
  BlockMeta dead;
  dead.layer = 3;
  dead.occupied = dead.failed = 0x0f;
  dead.linked = 0x01;
  const CementOptions o = that_borrow();
  EXPECT_TRUE(NodeAliases(o, nullptr).may_alias(dead));
  BlockMeta some = dead, first = dead, none = dead;
  some.failed = 0x07;
  first.layer = 0;
  none.occupied = none.failed = 0;
  for (const BlockMeta& m : {some, first, none}) EXPECT_FALSE(NodeAliases(o, nullptr).may_alias(m));
  CementOptions unilateral(o), all_points(o), bonds(o);
  unilateral.unilateral = true;
  all_points.advance.skip_failed = false;
  bonds.split = false;
  for (const CementOptions& other : {unilateral, all_points, bonds}) EXPECT_FALSE(NodeAliases(other, nullptr).may_alias(dead));
  PenaltyParameters p;
  p.law = std::make_shared<PenaltyTraction>(TractionStiffness{1e13, 1e13});
  EXPECT_TRUE(NodeAliases(o, &p).may_alias(dead));
  p.friction = 0.0;
  EXPECT_FALSE(NodeAliases(o, &p).may_alias(dead));
  p.friction = -1.0;
  p.law = std::make_shared<CohesiveTraction>(TractionStiffness{1e13, 1e13}, LawValues());
  EXPECT_FALSE(NodeAliases(o, &p).may_alias(dead));
  dead.linked = 0;
  EXPECT_TRUE(NodeAliases(o, &p).may_alias(dead));
}

}  // namespace
}  // namespace mpdem
