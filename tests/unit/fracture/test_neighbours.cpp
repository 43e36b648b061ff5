// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fracture/neighbours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "crack_column.h"

namespace mpdem {
namespace {

using test::column, test::fail, test::level;

// A column with a crack through level `at`. The crack leaves a rectangle with its corner at (first_x, first_y).
std::vector<CrackPoint> with_bridge(int at, int first_x, int first_y, int wide, int deep) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points) {
    const bool inside = p.cell[0] >= first_x && p.cell[0] < first_x + wide && p.cell[1] >= first_y && p.cell[1] < first_y + deep;
    if (level(p) == at && !inside) fail(p);
  }
  return points;
}

// Puts the axes of the cells in another order, and the points backwards. x is then another direction.
std::vector<CrackPoint> turned(std::vector<CrackPoint> points, int by) {
  for (CrackPoint& p : points) std::rotate(p.cell, p.cell + by, p.cell + 3);
  std::reverse(points.begin(), points.end());
  return points;
}

// Number of faces of the level that are bridged, on either side of it.
std::array<int, 2> bridged_faces(const std::vector<CrackPoint>& points, int by, int at, int across) {
  const Neighbours near(points, across);
  const int along = (2 - by + 3) % 3;
  std::array<int, 2> count{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].cell[along] + test::kHeight / 2 != at) continue;
    for (int side = 0; side < 2; ++side) count[side] += near.bridged(static_cast<int>(i), 2 * along + side);
  }
  return count;
}

// In the middle of the section a rectangle is a bridge if a square fits into it. All of its faces are bridged then.
TEST(Neighbours, ABridgeIsAsWideAsASquare) {
  for (int by = 0; by < 3; ++by)
    for (int across = 1; across <= 3; ++across)
      for (int wide = 1; wide <= 4; ++wide)
        for (int deep = 1; deep <= 4; ++deep) {
          const int at = 5, faces = std::min(wide, deep) >= across ? wide * deep : 0;
          const std::array<int, 2> found = bridged_faces(turned(with_bridge(at, -2, -1, wide, deep), by), by, at, across);
          EXPECT_EQ(found, (std::array<int, 2>{faces, faces})) << by << ' ' << across << ' ' << wide << ' ' << deep;
        }
}

// A strip along the rim has no more faces beside it there than material has, so one row of them is not narrower than it was made.
TEST(Neighbours, WholeSectionIsABridgeToItsRim) {
  for (int by = 0; by < 3; ++by)
    for (int across = 1; across <= 4; ++across) {
      const std::array<int, 2> found = bridged_faces(turned(column(), by), by, 5, across);
      EXPECT_EQ(found, (std::array<int, 2>{test::kWidth * test::kWidth, test::kWidth * test::kWidth})) << by << ' ' << across;
    }
}

// The points of the square that makes a face one of a bridge: as many faces as that has, with a point on either side.
TEST(Neighbours, PointsOfABridge) {
  const std::vector<CrackPoint> points = with_bridge(5, -2, -1, 2, 2);
  const Neighbours near(points, 2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (level(points[i]) != 5 || points[i].failed) continue;
    std::vector<int> beside = near.bridge(static_cast<int>(i), 5);
    std::sort(beside.begin(), beside.end());
    std::vector<int> expected;
    for (std::size_t j = 0; j < points.size(); ++j) {
      const int* c = points[j].cell;
      if ((level(points[j]) == 5 || level(points[j]) == 6) && c[0] >= -2 && c[0] < 0 && c[1] >= -1 && c[1] < 1)
        expected.push_back(static_cast<int>(j));
    }
    EXPECT_EQ(beside, expected);
  }
}

}  // namespace
}  // namespace mpdem
