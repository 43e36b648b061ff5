// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement/splits.h"

#include <gtest/gtest.h>

namespace mpdem {
namespace {

// A grid has the nodes that stand for those of a part, whose points may all have left part 0: those of each cell of a block.
TEST(Splits, NodesThatStandForThoseOfABlock) {
  constexpr double kCell = 1e-3;
  for (Basis basis : {Basis::linear, Basis::quadratic, Basis::cubic})
    for (int direction = 0; direction < 3; ++direction)
      for (bool join : {false, true}) {
        // a full block, and what is over of the cell with some of the next
        PointStore points;
        for (int n = 0; n < 13; ++n) {
          PointRecord r;
          r.part = 2;
          r.volume = 1.0;
          for (int d = 0; d < 3; ++d) r.X[d] = kCell * (5.0 + cell_middle(basis) + (d == direction && n >= 10));
          points.add(r, n + 1);
        }
        points.arrange(kCell, basis, {}, join);
        EXPECT_EQ(points.blocks.size(), join && may_join_cells(basis) ? 2u : 3u);
        Splits splits;
        splits.restore(1, {});  // all nodes are whole
        std::vector<Key> expected;
        const int S = support(basis);
        for (int i = 0; i < S + (direction == 0); ++i)
          for (int j = 0; j < S + (direction == 1); ++j)
            for (int k = 0; k < S + (direction == 2); ++k) expected.push_back({0, 5 + i, 5 + j, 5 + k});
        EXPECT_EQ(splits.nodes_beside(points, 0, S), expected) << static_cast<int>(basis) << " " << direction << " " << join;
      }
}

}  // namespace
}  // namespace mpdem
