// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "fracture/ligament.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "crack_column.h"
#include "fracture/separation.h"

namespace mpdem {
namespace {

using test::column, test::fail, test::kFace, test::kHeight, test::kLinkArea, test::kWidth, test::level;

std::set<int> tags_of(const std::vector<int>& cut, const std::vector<CrackPoint>& points) {
  std::set<int> tags;
  for (int i : cut) tags.insert(points[i].tag);
  EXPECT_EQ(tags.size(), cut.size());
  return tags;
}

std::set<int> tags_where(const std::vector<CrackPoint>& points, const std::function<bool(const CrackPoint&)>& is) {
  std::set<int> tags;
  for (const CrackPoint& p : points)
    if (is(p)) tags.insert(p.tag);
  return tags;
}

// The only cut, or the last of two where either will do.
const std::vector<int>& cut_of(const Ligament& l) { return l.cuts.back(); }

TEST(Ligament, OfAnUnbrokenBondIsWhole) {
  const std::vector<CrackPoint> points = column();
  const Ligament l = find_ligament(points);
  EXPECT_EQ(l.whole, kWidth * kWidth);
  EXPECT_EQ(l.share(), 1.0);
}

TEST(Ligament, OfASeparatedBondIsNothing) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == 6) fail(p);
  const Ligament l = find_ligament(points);
  EXPECT_EQ(l.left(), 0);
  EXPECT_EQ(l.cuts.size(), 1u);
  EXPECT_EQ(l.whole, kWidth * kWidth);
  EXPECT_EQ(l.share(), 0.0);
  EXPECT_EQ(find_ligament({}).share(), 0.0);
}

// Two sections with bridges: that with fewer points left is the ligament, or the points that lead to it, whatever the damage.
TEST(Ligament, OfTwoSectionsTheOneWithLessLeft) {
  for (const auto& [below, above] : {std::make_pair(2, 6), {6, 2}, {0, 5}, {5, kHeight - 1}}) {
    std::vector<CrackPoint> points = column();
    for (CrackPoint& p : points) {
      const int at = p.cell[0] + p.cell[1];
      if (level(p) == below && at != 0) fail(p);   // 7 left
      if (level(p) == above && at != -4) fail(p);  // 5 left
      p.damage = level(p) == below ? 0.8f : 0.1f;
    }
    const Ligament l = find_ligament(points);
    EXPECT_EQ(l.left(), 5);
    for (int i : cut_of(l)) {
      EXPECT_LE(std::abs(level(points[i]) - above), 1);
      EXPECT_EQ(points[i].cell[0] + points[i].cell[1], -4);
    }
    EXPECT_EQ(l.share(), 5.0 / (kWidth * kWidth));
  }
}

// A crack leaves k points of a ring at the second grain.
TEST(Ligament, OfARingWithPointsLeft) {
  for (int k : {28, 11, 1}) {
    std::vector<CrackPoint> points = column();
    int left = k;
    for (CrackPoint& p : points) {
      if (level(p) != kHeight - 1) continue;
      const bool ring = std::max(std::abs(2 * p.cell[0] + 1), std::abs(2 * p.cell[1] + 1)) == kWidth - 1;
      if (!ring || left-- <= 0) fail(p);
      p.damage = 0.5f;
    }
    const Ligament l = find_ligament(points);
    ASSERT_EQ(l.left(), k);
    const Separation s = separate(cut_through(cut_of(l), points), kFace);
    EXPECT_TRUE(s.separated);
    EXPECT_NEAR(s.at_grain[1], kLinkArea * kWidth * kWidth, 1e-12);
    EXPECT_EQ(s.debonded_share(), 1.0);
  }
}

// Debonded links make a section of those that are intact, though no point failed.
TEST(Ligament, AttachedPointsAreASection) {
  for (int grain : {0, 1}) {
    std::vector<CrackPoint> points = column();
    for (CrackPoint& p : points) p.attached[grain] = p.attached[grain] && p.cell[0] == 1 && p.cell[1] < 2;
    const Ligament l = find_ligament(points);
    EXPECT_EQ(l.left(), 6);
    EXPECT_EQ(l.whole, kWidth * kWidth);
    for (int i : cut_of(l)) points[i].damage = 0.5f;
    const Ligament again = find_ligament(points);
    EXPECT_EQ(tags_of(cut_of(again), points), tags_where(points, [&](const CrackPoint& p) { return p.attached[grain]; }));
    EXPECT_NEAR(separate(cut_through(cut_of(again), points), kFace).at_grain[grain], kLinkArea * kWidth * kWidth, 1e-12);
  }
}

// A step between two half sections is counted with them.
TEST(Ligament, OfASteppedSection) {
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points)
    if (level(p) == (p.cell[0] < 0 ? 3 : 6)) fail(p);
  const Ligament l = find_ligament(points);
  // points of the wall between the halves, in the two levels that paths have between 3 and 6
  EXPECT_EQ(l.left(), 2 * kWidth);
  EXPECT_TRUE(separate(cut_through(cut_of(l), points), kFace).separated);
}

// Several cuts are alike; here they lead to two bridges. The more damaged of the outermost cuts is taken. If these are
// as damaged as each other, both are taken.
TEST(Ligament, OfCutsAlikeTheMoreDamaged) {
  const auto bridge = [](const CrackPoint& p) { return std::abs(2 * p.cell[0] + 1) < 2 && std::abs(2 * p.cell[1] + 1) < 2; };
  using Levels = std::vector<int>;
  for (const auto& [first, second, taken] :
       {std::make_tuple(0.3f, 0.4f, Levels{8}), {0.4f, 0.3f, Levels{1}}, {0.3f, 0.3f, Levels{1, 8}}, {0.3f, 0.3005f, Levels{1, 8}}}) {
    std::vector<CrackPoint> points = column();
    for (CrackPoint& p : points) {
      if ((level(p) == 2 || level(p) == 7) && !bridge(p)) fail(p);
      p.damage = level(p) < kHeight / 2 ? first : second;
    }
    const Ligament l = find_ligament(points);
    ASSERT_EQ(l.cuts.size(), taken.size());
    for (std::size_t n = 0; n < taken.size(); ++n)
      EXPECT_EQ(tags_of(l.cuts[n], points),
                tags_where(points, [&, at = taken[n]](const CrackPoint& p) { return level(p) == at && bridge(p); }));
  }
}

// If the first grain and the second are swapped, the ligaments are the same, in the other order.
TEST(Ligament, WhichGrainIsTheFirstDoesNotMatter) {
  test::Random random(182);
  int two = 0;
  for (int n = 0; n < 60; ++n) {
    std::vector<CrackPoint> points = column();
    test::make_random(points, random, random.uniform(0.0, 0.5), n % 2 == 0 ? 1 : 100, n % 4);
    const Ligament one = find_ligament(points);
    const Ligament other = find_ligament(test::swapped(points));
    EXPECT_EQ(other.whole, one.whole);
    EXPECT_EQ(std::vector<std::vector<int>>(other.cuts.rbegin(), other.cuts.rend()), one.cuts);
    two += one.cuts.size() == 2;
  }
  EXPECT_GT(two, 10);
}

// All sets of points of small bonds are tried. None smaller than the ligament separates the bond.
TEST(Ligament, IsTheLeastOfAllCutsOfSmallBonds) {
  test::Random random(5);
  constexpr int kSmall = 2, kThick = 3, kAll = kSmall * kSmall * kThick;
  std::set<std::size_t> sizes;
  for (int n = 0; n < 40; ++n) {
    std::vector<CrackPoint> points = column(kSmall, kThick);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(kAll));
    test::make_random(points, random, 0.2, 4, 0);
    random.shuffle(points);
    const Ligament l = find_ligament(points);
    std::size_t least = kAll;
    for (int set = 0; set < 1 << kAll; ++set) {
      const std::size_t size = static_cast<std::size_t>(__builtin_popcount(set));
      if (size >= least) continue;
      std::vector<int> cut;
      for (int i = 0; i < kAll; ++i)
        if (set >> i & 1) cut.push_back(i);
      if (separate(cut_through(cut, points), kFace).separated) least = size;
    }
    EXPECT_EQ(static_cast<std::size_t>(l.left()), least);
    EXPECT_EQ(separate(cut_through(cut_of(l), points), kFace).separated, true);
    EXPECT_EQ(l.whole, kSmall * kSmall);
    sizes.insert(least);
  }
  EXPECT_GE(sizes.size(), 4u);
}

// Paths with no point in common, one after the other by Ford and Fulkerson's method on a plain table of capacities.
std::vector<std::vector<int>> disjoint_paths(const std::vector<CrackPoint>& points, const Neighbours& near) {
  const int n = static_cast<int>(points.size()), source = 2 * n, sink = 2 * n + 1;
  std::vector<std::map<int, int>> capacity(static_cast<std::size_t>(2 * n + 2));
  for (int i = 0; i < n; ++i) {
    if (points[i].failed) continue;
    capacity[2 * i][2 * i + 1] = 1;
    if (points[i].attached[0]) capacity[source][2 * i] = 1;
    if (points[i].attached[1]) capacity[2 * i + 1][sink] = 1;
    for (int j : near.of(i))
      if (j >= 0 && !points[j].failed && points[j].layer == points[i].layer) capacity[2 * i + 1][2 * j] = 1;
  }
  const std::vector<std::map<int, int>> before = capacity;
  for (;;) {
    std::vector<int> from(capacity.size(), -1), queue{source};
    from[source] = source;
    for (std::size_t k = 0; k < queue.size() && from[sink] < 0; ++k)
      for (const auto& [to, c] : capacity[queue[k]])
        if (c > 0 && from[to] < 0) {
          from[to] = queue[k];
          queue.push_back(to);
        }
    if (from[sink] < 0) break;
    for (int v = sink; v != source; v = from[v]) {
      --capacity[from[v]][v];
      ++capacity[v][from[v]];
    }
  }
  const auto next = [&](int v) {
    for (const auto& [to, c] : before[v])
      if (capacity[v][to] < c) return to;
    return -1;
  };
  std::vector<std::vector<int>> paths;
  for (const auto& [start, c] : before[source]) {
    if (capacity[source][start] == c) continue;
    paths.emplace_back();
    for (int v = start; v != sink; v = next(v))
      if (v % 2 == 0) paths.back().push_back(v / 2);
  }
  return paths;
}

// Menger's theorem: as many paths with no point in common as there are points in the ligament, which lies across each of
// them once; it separates the bond.
TEST(Ligament, IsAsManyPointsAsThereArePathsWithNoneInCommon) {
  test::Random random(41);
  std::set<std::size_t> sizes;
  for (int n = 0; n < 60; ++n) {
    std::vector<CrackPoint> points = column();
    test::make_random(points, random, random.uniform(0.0, 0.7), 100, n % 4);
    const Neighbours near(points);
    const Ligament l = find_ligament(points);
    const std::set<int> cut(cut_of(l).begin(), cut_of(l).end());
    const std::vector<std::vector<int>> paths = disjoint_paths(points, near);
    std::set<int> met;
    std::size_t steps = 0;
    for (const std::vector<int>& path : paths) {
      int crossed = 0;
      for (int i : path) crossed += cut.count(i) > 0;
      EXPECT_EQ(crossed, 1);
      met.insert(path.begin(), path.end());
      steps += path.size();
    }
    EXPECT_EQ(met.size(), steps);
    EXPECT_EQ(static_cast<int>(paths.size()), l.left());
    EXPECT_TRUE(separate(cut_through(cut_of(l), points), kFace).separated);
    EXPECT_EQ(l.left() == 0, separate(points, kFace).separated);
    for (CrackPoint& p : points) {  // the unbroken bond
      p.failed = false;
      for (int g = 0; g < 2; ++g) p.attached[g] = p.link_area[g] > 0.0;
    }
    EXPECT_EQ(static_cast<int>(disjoint_paths(points, near).size()), l.whole);
    sizes.insert(static_cast<std::size_t>(l.left()));
  }
  EXPECT_GT(sizes.size(), 15u);
}

// Points fail one after the other: the ligament loses one at a time at most, and gets none back.
TEST(Ligament, NeverGrowsAsPointsFail) {
  test::Random random(8);
  std::vector<CrackPoint> points = column();
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  random.shuffle(order);
  int last = find_ligament(points).left();
  for (int i : order) {
    fail(points[i]);
    const int now = find_ligament(points).left();
    EXPECT_LE(now, last);
    EXPECT_LE(last, now + 1);
    last = now;
  }
  EXPECT_EQ(last, 0);
}

TEST(Ligament, OrderOfThePointsDoesNotMatter) {
  test::Random random(181);
  for (int n = 0; n < 20; ++n) {
    std::vector<CrackPoint> points = column();
    test::make_random(points, random, random.uniform(0.0, 0.5), n % 2 == 0 ? 1 : 100, n % 4);
    const Ligament one = find_ligament(points);
    std::vector<std::set<int>> tags;
    for (const std::vector<int>& cut : one.cuts) tags.push_back(tags_of(cut, points));
    for (int again = 0; again < 3; ++again) {
      random.shuffle(points);
      const Ligament other = find_ligament(points);
      ASSERT_EQ(other.cuts.size(), tags.size());
      for (std::size_t c = 0; c < tags.size(); ++c) EXPECT_EQ(tags_of(other.cuts[c], points), tags[c]);
      EXPECT_EQ(other.whole, one.whole);
    }
  }
}

// The bond is connected by points at a grain. With residue, the link or the point fails there: the one that is damaged more.
TEST(Ligament, WithSkinsTheLinkOrThePointBreaks) {
  for (const auto& [link, point, debonds] : {std::make_tuple(0.7f, 0.2f, true), {0.2f, 0.7f, false}, {0.0f, 0.0f, false}}) {
    std::vector<CrackPoint> points = column();
    for (CrackPoint& p : points) {
      if (level(p) != 0) continue;
      if (p.cell[0] > 0) {
        p.attached[0] = false;
      } else {
        p.link_damage[0] = link;
        p.damage = point;
      }
    }
    const Ligament l = find_ligament(points);
    ASSERT_EQ(l.left(), 5 * kWidth);
    std::vector<int> cut;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].attached[0]) cut.push_back(static_cast<int>(i));
    const Separation now = separate(cut_through(cut, points, true), kFace), before = separate(cut_through(cut, points), kFace);
    EXPECT_TRUE(now.separated && before.separated);
    EXPECT_NEAR(before.at_grain[0], kWidth * kWidth * kLinkArea, 1e-12);
    EXPECT_NEAR(now.at_grain[0], (debonds ? 8 : 3) * kWidth * kLinkArea, 1e-12);
    EXPECT_NEAR(now.inside, (debonds ? 0 : 5) * kWidth, 1e-12);
  }
}

// A patch is connected to the second grain beside the place where all else debonds. It is connected to the rest of the bond over
// points that are connected to that grain themselves. It is not enough that these points debond.
TEST(Ligament, WithSkinsPointsThatLeadOnFail) {
  constexpr int kRim = -kWidth / 2;
  std::vector<CrackPoint> points = column();
  for (CrackPoint& p : points) {
    if (level(p) != kHeight - 1) continue;
    if (p.cell[0] > kRim + 1) p.attached[1] = false;
    p.link_damage[1] = 0.7f;
    if (p.cell[0] == kRim) p.link_damage[1] = 0.0f;
  }
  for (CrackPoint& p : points)
    if (level(p) < kHeight - 1 && p.cell[0] == kRim) fail(p);
  const Ligament l = find_ligament(points);
  ASSERT_EQ(l.left(), kWidth);
  for (const std::vector<int>& cut : l.cuts) {
    const Separation s = separate(cut_through(cut, points, true), kFace);
    EXPECT_TRUE(s.separated);
    EXPECT_GT(s.at_grain[1], 0.0);
  }
}

TEST(Ligament, WithSkinsSeparatesRandomBonds) {
  test::Random random(73);
  for (int n = 0; n < 60; ++n) {
    std::vector<CrackPoint> points = column();
    test::make_random(points, random, random.uniform(0.0, 0.6), 100, n % 4);
    for (CrackPoint& p : points)
      for (float& damage : p.link_damage) damage = static_cast<float>(random.uniform(0.0, 1.0));
    const Ligament l = find_ligament(points);
    for (const std::vector<int>& cut : l.cuts) EXPECT_TRUE(separate(cut_through(cut, points, true), kFace).separated) << n;
  }
}

}  // namespace
}  // namespace mpdem
