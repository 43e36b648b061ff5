// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fracture/separation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "crack_column.h"

namespace mpdem {
namespace {

using test::column, test::fail, test::make_residue, test::kFace, test::kHeight, test::kLinkArea, test::kWidth, test::level;

TEST(Separation, IntactBond) {
  const std::vector<CrackPoint> points = column();
  const Separation s = separate(points, kFace);
  EXPECT_FALSE(s.separated);
  EXPECT_EQ(s.piece, std::vector<int>(points.size(), 0));
  EXPECT_EQ(s.debonded_share(), 0.0);
}

// The layer of points at a grain fails: with its links the bond debonds there; if these are intact, the layer is residue on the grain and
// the crack is inside. In both cases what is left follows the other grain.
TEST(Separation, SkinsOnAGrain) {
  for (int grain : {0, 1}) {
    const int layer = grain == 0 ? 0 : kHeight - 1;
    const auto cut = [&](bool residue(const CrackPoint&)) {
      std::vector<CrackPoint> points = column();
      for (CrackPoint& p : points)
        if (level(p) == layer) residue(p) ? make_residue(p) : fail(p);
      return points;
    };
    constexpr double kAll = kWidth * kWidth;
    const Separation gone = separate(cut([](const CrackPoint&) { return false; }), kFace);
    EXPECT_NEAR(gone.at_grain[grain], kAll * kLinkArea, 1e-12);
    EXPECT_EQ(gone.inside, 0.0);
    const std::vector<CrackPoint> points = cut([](const CrackPoint&) { return true; });
    const Separation residue = separate(points, kFace);
    EXPECT_TRUE(residue.separated);
    EXPECT_EQ(residue.at_grain[0] + residue.at_grain[1], 0.0);
    EXPECT_NEAR(residue.inside, kAll, 1e-12);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(residue.piece[i], (level(points[i]) == layer) == (grain == 1) ? 1 : 0) << i;
    const Separation half = separate(cut([](const CrackPoint& p) { return p.cell[0] < 0; }), kFace);
    // points as near to residue as to what is intact above them count half
    EXPECT_NEAR(half.at_grain[grain], 0.5 * (kAll - kWidth) * kLinkArea, 1e-12);
    EXPECT_EQ(half.at_grain[1 - grain], 0.0);
    EXPECT_NEAR(half.inside, 0.5 * (kAll + kWidth), 1e-12);
  }
}

// If the cement is one point thick, the crack runs through residue that is on both grains.
TEST(Separation, SkinsOnBothGrains) {
  std::vector<CrackPoint> points = column(kWidth, 1);
  for (CrackPoint& p : points) {
    p.attached[0] = p.attached[1] = true;
    p.link_area[0] = p.link_area[1] = kLinkArea;
    make_residue(p);
  }
  const Separation s = separate(points, kFace);
  EXPECT_TRUE(s.separated);
  EXPECT_EQ(s.at_grain[0] + s.at_grain[1], 0.0);
  EXPECT_NEAR(s.inside, kWidth * kWidth * kLinkArea, 1e-12);
}

// The surface at this height of a column ten cells high, whose cells are as high as wide.
Separation crack_at(int height, double reach) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == height) fail(p);
  return separate(points, kFace, false, 1, reach);
}

// The failed points of a level are as near to both sides. So half of the surface is at their lower face and half at the upper one.
// The lower face is as many cells above the first grain as the number of the level, the upper face one more.
TEST(Separation, ABandThatReachesAGrain) {
  constexpr double kAll = kWidth * kWidth;
  const auto expect = [](const Separation& s, double first, double second, double inside) {
    EXPECT_NEAR(s.at_grain[0], first * kAll, 1e-12);
    EXPECT_NEAR(s.at_grain[1], second * kAll, 1e-12);
    EXPECT_NEAR(s.inside, inside * kAll, 1e-12);
  };
  expect(crack_at(3, 0.0), 0.0, 0.0, 1.0);
  expect(crack_at(3, 2.9), 0.0, 0.0, 1.0);
  expect(crack_at(3, 3.1), 0.5, 0.0, 0.5);
  expect(crack_at(3, 4.1), 1.0, 0.0, 0.0);
  expect(crack_at(6, 3.1), 0.0, 0.5, 0.5);    // the upper face is three cells below the second grain
  expect(crack_at(6, 6.1), 0.25, 0.75, 0.0);  // the lower one is six above the first, too
  expect(crack_at(3, 20.0), 0.5, 0.5, 0.0);
}

// The path leads from grain to grain, over faces of intact points, past damage where that is possible.
TEST(Separation, PathOfIntactPoints) {
  std::vector<CrackPoint> points = column();
  const auto expect_path = [&](std::size_t length) {
    const std::vector<int> path = separate(points, kFace).path;
    ASSERT_EQ(path.size(), length);
    EXPECT_TRUE(std::is_sorted(path.begin(), path.end()));
    std::vector<CrackPoint> only = column();
    for (std::size_t i = 0; i < only.size(); ++i) {
      const bool on = std::binary_search(path.begin(), path.end(), only[i].tag);
      EXPECT_FALSE(on && points[i].failed);
      if (!on) fail(only[i]);
    }
    EXPECT_FALSE(separate(only, kFace).separated);
    for (int tag : path) {  // and no point of it is idle
      std::vector<CrackPoint> less = only;
      fail(less[static_cast<std::size_t>(tag) - 1]);
      EXPECT_TRUE(separate(less, kFace).separated);
    }
  };
  expect_path(kHeight);
  for (CrackPoint& p : points) {
    p.damage = level(p) == 4 && p.cell[0] < 3 ? 0.5f : 0.0f;
    if (level(p) == 6 && p.cell[0] > 0) fail(p);
  }
  expect_path(kHeight + 3);  // aside below the crack, past the damage
  for (CrackPoint& p : points) p.damage = 0.5f;
  expect_path(kHeight);
  for (CrackPoint& p : points)
    if (level(p) == 6) fail(p);
  EXPECT_TRUE(separate(points, kFace).path.empty());
}

// The fields are random, of few values of damage and of many, with layers or empty space. No path over points and links has less damage
// than the one that is named. There is no path where the bond is separated.
TEST(Separation, ThePathIsThatOfTheLeastDamage) {
  test::Random random(977);
  int separated = 0, held = 0;
  for (int n = 0; n < 60; ++n) {
    std::vector<CrackPoint> points = column();
    const int values = n % 3 == 0 ? 4 : 100;
    test::make_random(points, random, random.uniform(0.0, 0.75), values, n % 4);
    for (CrackPoint& p : points)
      for (float& d : p.link_damage) d = static_cast<float>(0.9 * random.index(values) / values);
    const auto look = [&](const std::vector<CrackPoint>& p) { return separate(p, kFace); };
    const Separation s = look(points);
    EXPECT_EQ(s.path.empty(), s.separated);
    ++(s.separated ? separated : held);
    if (s.separated) continue;
    float most = 0.0f, link[2] = {1.0f, 1.0f};
    for (const CrackPoint& p : points)
      if (std::binary_search(s.path.begin(), s.path.end(), p.tag)) {
        EXPECT_FALSE(p.failed);
        most = std::max(most, p.damage);
        for (int g = 0; g < 2; ++g)
          if (p.attached[g]) link[g] = std::min(link[g], p.link_damage[g]);
      }
    most = std::max({most, link[0], link[1]});
    std::vector<CrackPoint> worse = points, better = points;
    for (CrackPoint& p : worse) {
      for (int g = 0; g < 2; ++g) p.attached[g] = p.attached[g] && p.link_damage[g] < most;
      if (p.damage >= most) fail(p);
    }
    for (CrackPoint& p : better) {
      for (int g = 0; g < 2; ++g) p.attached[g] = p.attached[g] && p.link_damage[g] <= most;
      if (p.damage > most) fail(p);
    }
    EXPECT_TRUE(look(worse).separated);
    EXPECT_FALSE(look(better).separated);
  }
  EXPECT_GT(separated, 5);
  EXPECT_GT(held, 20);
}

TEST(Separation, OneBridgeHolds) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == 5 && !(p.cell[0] == 2 && p.cell[1] == -3)) fail(p);
  EXPECT_FALSE(separate(points, kFace).separated);
}

TEST(Separation, CrackInside) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == 6) fail(p);
  const Separation s = separate(points, kFace);
  EXPECT_TRUE(s.separated);
  EXPECT_EQ(s.inside, kWidth * kWidth);
  EXPECT_EQ(s.at_grain[0], 0.0);
  EXPECT_EQ(s.at_grain[1], 0.0);
  EXPECT_EQ(s.debonded_share(), 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].failed) continue;
    EXPECT_EQ(s.piece[i], level(points[i]) < 6 ? 0 : 1);
  }
}

TEST(Separation, Debonding) {
  for (int grain = 0; grain < 2; ++grain) {
    std::vector<CrackPoint> points = column();
    for (CrackPoint& p : points) p.attached[grain] = false;  // the links debonded, no point failed
    const Separation s = separate(points, kFace);
    EXPECT_TRUE(s.separated);
    EXPECT_NEAR(s.at_grain[grain], kLinkArea * kWidth * kWidth, 1e-12);
    EXPECT_EQ(s.at_grain[1 - grain], 0.0);
    EXPECT_EQ(s.inside, 0.0);
    EXPECT_EQ(s.debonded_share(), 1.0);
  }
}

TEST(Separation, BothGrainsLetGo) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == 0 || level(p) == kHeight - 1) fail(p);
  const Separation s = separate(points, kFace);
  EXPECT_TRUE(s.separated);
  for (int grain = 0; grain < 2; ++grain) EXPECT_NEAR(s.at_grain[grain], kLinkArea * kWidth * kWidth, 1e-12);
  EXPECT_EQ(s.debonded_share(), 1.0);
  // crushed altogether: no surface is at a grain rather than inside
  for (CrackPoint& p : points) fail(p);
  EXPECT_TRUE(separate(points, kFace).separated);
  EXPECT_EQ(separate(points, kFace).debonded_share(), 0.0);
}

// There are two cracks. If one runs along a grain, all of the cement at that grain has debonded.
TEST(Separation, TwoCracks) {
  for (const auto& [levels, share] : {std::make_pair(std::make_pair(0, 5), 1.0), {{5, kHeight - 1}, 1.0}, {{3, 6}, 0.0}}) {
    std::vector<CrackPoint> points = column();
    for (CrackPoint& p : points)
      if (level(p) == levels.first || level(p) == levels.second) fail(p);
    const Separation s = separate(points, kFace);
    EXPECT_TRUE(s.separated);
    EXPECT_EQ(s.debonded_share(), share);
    EXPECT_NEAR(s.at_grain[0] + s.at_grain[1] + s.inside, (share > 0 ? kLinkArea : 1.0) * kWidth * kWidth, 1e-9);
  }
}

// A stepped crack has known areas: a ring debonds at the first grain, and the core breaks through the middle.
TEST(Separation, SteppedCrack) {
  std::vector<CrackPoint> points = column();
  const auto core = [](const CrackPoint& p) { return p.cell[0] >= -2 && p.cell[0] < 2 && p.cell[1] >= -2 && p.cell[1] < 2; };
  const auto rim = [&](const CrackPoint& p) {  // of the core
    return !core(p) && p.cell[0] >= -3 && p.cell[0] < 3 && p.cell[1] >= -3 && p.cell[1] < 3;
  };
  for (CrackPoint& p : points) {
    if (!core(p) && level(p) == 0) fail(p);
    if (core(p) && level(p) == 5) fail(p);
    if (rim(p) && level(p) <= 5) fail(p);
  }
  const Separation s = separate(points, kFace);
  EXPECT_TRUE(s.separated);
  EXPECT_EQ(s.at_grain[1], 0.0);
  // the column of failed points about the core counts half to it, half to what is outside
  EXPECT_GE(s.at_grain[0], kLinkArea * (kWidth * kWidth - 36) - 1e-9);
  EXPECT_LE(s.at_grain[0], kLinkArea * (kWidth * kWidth - 16) + 1e-9);
  EXPECT_GE(s.inside, 16.0);
  EXPECT_LE(s.inside, 36.0);
}

// Half the section goes along the second grain, half through the middle.
TEST(Separation, MixedMode) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points) {
    if (p.cell[0] < 0 && level(p) == kHeight - 1) fail(p);
    if (p.cell[0] >= 0 && level(p) == 5) fail(p);
    // the wall between the two levels
    if (p.cell[0] == 0 && level(p) >= 5) fail(p);
  }
  const Separation s = separate(points, kFace);
  EXPECT_TRUE(s.separated);
  EXPECT_GT(s.at_grain[1], 0.3 * kWidth * kWidth);
  EXPECT_GT(s.inside, 0.3 * kWidth * kWidth);
  EXPECT_EQ(s.at_grain[0], 0.0);
  EXPECT_GT(s.debonded_share(), 0.1);
  EXPECT_LT(s.debonded_share(), 0.9);
}

// Cement that debonds from both grains, at one check or one after the other, is a loose piece even if it is all there is.
// Layers 0 and 1 follow their grains.
TEST(Separation, ALoneLoosePieceFollowsNoGrain) {
  const auto parts_of_rest = [](std::vector<CrackPoint>& points) {
    const Separation s = separate(points, kFace);
    EXPECT_TRUE(s.separated);
    int least = 99, most = -1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].layer = s.piece[i];
      if (points[i].failed) continue;
      least = std::min(least, s.piece[i]);
      most = std::max(most, s.piece[i]);
    }
    return std::make_pair(least, most);
  };
  for (int looks : {1, 2})
    for (int earlier : {0, kHeight - 1}) {
      std::vector<CrackPoint> points = column();
      if (looks == 2) {
        for (CrackPoint& p : points)
          if (level(p) == earlier) fail(p);
        const int follows = earlier == 0 ? 1 : 0;
        EXPECT_EQ(parts_of_rest(points), std::make_pair(follows, follows));
      }
      for (CrackPoint& p : points)
        if (level(p) == 0 || level(p) == kHeight - 1) fail(p);
      EXPECT_EQ(parts_of_rest(points), std::make_pair(2, 2));
      EXPECT_EQ(parts_of_rest(points), std::make_pair(2, 2));  // and stays that piece
    }
}

TEST(Separation, LoosePiecesBecomePartsAndCrumbsDoNot) {
  std::vector<CrackPoint> points = column();
  // two cracks leave a slab of two layers (128 cells) between them
  for (CrackPoint& p : points)
    if (level(p) == 3 || level(p) == 6) fail(p);
  Separation s = separate(points, kFace);
  EXPECT_TRUE(s.separated);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].failed) {
      EXPECT_EQ(s.piece[i], level(points[i]) < 3 ? 0 : level(points[i]) > 6 ? 1 : 2);
    }
  // a later check of the same layers changes nothing
  for (std::size_t i = 0; i < points.size(); ++i) points[i].layer = s.piece[i];
  EXPECT_EQ(separate(points, kFace).piece, s.piece);

  // a slab of fewer cells than count joins its neighbours
  points = column();
  int loose_points = 0;
  for (CrackPoint& p : points) {
    if (level(p) == 3 || level(p) == 6) fail(p);
    if ((level(p) == 4 || level(p) == 5) && p.cell[0] >= -1) fail(p);
    loose_points += (level(p) == 4 || level(p) == 5) && !p.failed;
  }
  ASSERT_LT(loose_points, kLeastLoose);
  s = separate(points, kFace);
  EXPECT_LE(*std::max_element(s.piece.begin(), s.piece.end()), 1);
}

// The halves are the two sides of an unbonded gap. They are connected where their material touches.
TEST(Separation, TwoSidesOfAGap) {
  std::vector<CrackPoint> points = column();
  const auto beside = [](const CrackPoint& p) { return std::abs(p.cell[0] + 1) <= 1 && std::abs(p.cell[1] + 1) <= 1; };
  const auto leave_space = [&](float first, float second) {
    for (CrackPoint& p : points) {
      if (level(p) == 4) p.space[5] = beside(p) ? first : 0.2f;
      if (level(p) == 5) p.space[4] = beside(p) ? second : 0.0f;
    }
  };
  leave_space(0.0f, 0.0f);
  EXPECT_FALSE(separate(points, kFace).separated);
  std::vector<CrackPoint> cut = points;
  for (CrackPoint& p : cut)
    if (beside(p) && level(p) == 5) fail(p);
  const Separation s = separate(cut, kFace);
  EXPECT_TRUE(s.separated);
  EXPECT_EQ(s.inside, 9.0);  // nothing separates where nothing was connected
  leave_space(0.06f, 0.03f);
  EXPECT_FALSE(separate(points, kFace).separated);
  leave_space(0.06f, 0.05f);
  EXPECT_TRUE(separate(points, kFace).separated);
}

// A layer that breaks again splits, and never takes in points of another layer.
TEST(Separation, PartsOnlySplit) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == 6) fail(p);
  const Separation first = separate(points, kFace);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].layer = first.piece[i];
  for (CrackPoint& p : points)
    if (level(p) == 2) fail(p);
  const Separation second = separate(points, kFace);
  std::map<int, int> parent;  // new layer to old
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto it = parent.emplace(second.piece[i], points[i].layer).first;
    EXPECT_EQ(it->second, points[i].layer);
    if (!points[i].failed) {
      EXPECT_EQ(second.piece[i], level(points[i]) < 2 ? 0 : level(points[i]) > 6 ? 1 : 2);
    }
  }
}

// A point that is as far from the material of either grain counts half to each. It follows the grain whose surface is nearer.
TEST(Separation, PointsHalfWayCountHalfToEach) {
  // a rim that broke through: in the lower level the first grain debonded, in the upper the second
  for (int at : {2, 7}) {
    std::vector<CrackPoint> points = column();
    for (CrackPoint& p : points)
      if (level(p) == at) fail(p);
    const Separation s = separate(points, kFace);
    EXPECT_EQ(s.inside, kWidth * kWidth);
    for (std::size_t i = 0; i < points.size(); ++i)
      if (level(points[i]) == at) {
        EXPECT_EQ(s.piece[i], at == 7);
      }
  }
  // one column of failed points, of the height of the bond, between what is connected to the one grain and what to the other
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points) {
    if (p.cell[0] == 0) fail(p);
    p.attached[p.cell[0] < 0 ? 1 : 0] = false;
  }
  const double side_face[3] = {1.0, 0.0, 0.0};
  const Separation s = separate(points, side_face);
  EXPECT_TRUE(s.separated);
  EXPECT_EQ(s.inside, kWidth * kHeight);
  // all of the grain beyond the column, and half of what is in it
  EXPECT_NEAR(s.at_grain[0], kLinkArea * kWidth * (kWidth / 2 - 1 + 0.5), 1e-12);
  EXPECT_NEAR(s.at_grain[1], kLinkArea * kWidth * (kWidth / 2 + 0.5), 1e-12);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].cell[0] == 0) {
      EXPECT_EQ(s.piece[i], level(points[i]) < kHeight / 2 ? 0 : 1);
    }
}

// A point that no step from cell to cell leads to follows the nearer grain. It does so when the bond separates and not later.
TEST(Separation, PointsThatCannotBeReached) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == 6) fail(p);
  for (int at : {0, 1}) {
    CrackPoint p{};
    p.tag = static_cast<int>(points.size()) + 1;
    p.cell[0] = 20 + 2 * at;
    p.failed = true;
    p.nearer = at;
    points.push_back(p);
  }
  Separation s = separate(points, kFace);
  for (int at : {0, 1}) EXPECT_EQ(s.piece[points.size() - 2 + at], at);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].layer = s.piece[i];
  for (CrackPoint& p : points) fail(p);
  s = separate(points, kFace, true);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(s.piece[i], points[i].layer);
}

// If the first grain and the second are swapped, areas and pieces of the grains swap and the rest stays.
TEST(Separation, WhichGrainIsTheFirstDoesNotMatter) {
  test::Random random(183);
  int separated = 0, pieces = 0;
  for (int n = 0; n < 100; ++n) {
    std::vector<CrackPoint> points = column();
    test::make_random(points, random, random.uniform(0.1, 0.7), 100, n % 2 == 0 ? 0 : 2);
    if (n % 5 == 0)  // a slab between two cracks
      for (CrackPoint& p : points)
        if (level(p) == 2 || level(p) == 8) fail(p);
    const double reach = n % 3;
    const Separation a = separate(points, kFace, false, 1, reach);
    const Separation b = separate(test::swapped(points), kFace, false, 1, reach);
    EXPECT_EQ(b.separated, a.separated);
    EXPECT_EQ(b.inside, a.inside);
    EXPECT_NEAR(b.debonded_share(), a.debonded_share(), 1e-14);
    for (int g = 0; g < 2; ++g) EXPECT_NEAR(b.at_grain[g], a.at_grain[1 - g], 1e-12);
    separated += a.separated;
    pieces += *std::max_element(a.piece.begin(), a.piece.end()) > 1;
    if (!a.separated) continue;
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(b.piece[i], a.piece[i] > 1 ? a.piece[i] : 1 - a.piece[i]);
  }
  EXPECT_GT(separated, 30);
  EXPECT_GT(pieces, 5);
}

TEST(Separation, OrderOfThePointsDoesNotMatter) {
  test::Random random(181);
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == 4 + (p.cell[0] + p.cell[1]) % 2 || level(p) == 4 || random.index(20) == 0) fail(p);
  const Separation a = separate(points, kFace);
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  for (int n = 0; n < 5; ++n) {
    random.shuffle(order);
    std::vector<CrackPoint> shuffled;
    for (int i : order) shuffled.push_back(points[i]);
    const Separation b = separate(shuffled, kFace);
    EXPECT_EQ(b.separated, a.separated);
    EXPECT_EQ(b.inside, a.inside);
    for (int g = 0; g < 2; ++g) EXPECT_NEAR(b.at_grain[g], a.at_grain[g], 1e-12);
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(b.piece[i], a.piece[order[i]]);
  }
}

}  // namespace
}  // namespace mpdem
