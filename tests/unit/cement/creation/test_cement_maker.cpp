// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cement planned and made without LIGGGHTS, on 1, 2 and 3 ranks: what comes out is the same on any number of them.
#include "cement/creation/cement_maker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "cement/creation/contacts.h"
#include "mpi_ranks.h"
#include "parallel/agree.h"
#include "parallel/gather_ranks.h"

namespace mpdem {
namespace {

constexpr double kRadius = 1.0, kSpacing = 0.1;

// The box is cut along x.
SceneBox box_of(MPI_Comm comm, double wide, bool periodic) {
  int me, ranks;
  MPI_Comm_rank(comm, &me);
  MPI_Comm_size(comm, &ranks);
  SceneBox b;
  for (int c = 0; c < 3; ++c) {
    b.high[c] = b.period[c] = b.own_high[c] = wide;
    b.periodic[c] = periodic;
  }
  b.own_low[0] = me * wide / ranks;
  b.own_high[0] = me + 1 == ranks ? wide : (me + 1) * wide / ranks;
  return b;
}

// A row of touching grains along x, and a host that keeps what it is given.
class RowScene : public CementMakerHost {
 public:
  MPI_Comm comm;
  SceneBox box;
  std::vector<BondRecord> table;
  CementRequest wish;
  std::vector<GrainToBond> grains;
  struct Point {
    int tag, row;
    double x[3], volume;
  };
  std::vector<Point> points;  // of this rank
  std::string said;
  std::vector<std::pair<const void*, std::size_t>> lists;  // of points that were given

  RowScene(MPI_Comm comm, int n, bool periodic = false, double gap = 0.0)
      : comm(comm), box(box_of(comm, n * (2.0 * kRadius + gap), periodic)) {
    std::vector<Vector3> centres;
    for (int g = 0; g < n; ++g)
      centres.emplace_back((kRadius + 0.5 * gap) + g * (2.0 * kRadius + gap), 0.5 * box.high[0], 0.5 * box.high[0]);
    set_grains(centres);
    wish.spacing = kSpacing;
    wish.density = 2710.0;
    wish.shapes.push_back({shape_style("flat"), {{"outer", 0.6}}});
    wish.inner_rule = CementRequest::given;
    wish.film = false;
  }
  // Sets grains at these centres with tags from 1 on. Each rank keeps its own.
  void set_grains(const std::vector<Vector3>& centres) {
    grains.clear();
    for (std::size_t n = 0; n < centres.size(); ++n) {
      GrainToBond grain;
      grain.tag = 1 + static_cast<int>(n);
      std::copy(centres[n].data(), centres[n].data() + 3, grain.x);
      std::copy(grain.x, grain.x + 3, grain.unwrapped);
      grain.radius = kRadius;
      grain.mass = 1.0;
      if (box.owns(centres[n])) grains.push_back(grain);
    }
  }
  std::vector<Sphere> spheres() const {
    std::vector<Sphere> all;
    for (const GrainToBond& g : grains) all.push_back({g.tag, Vector3(g.x[0], g.x[1], g.x[2]), g.radius});
    return all;
  }
  std::vector<GrainTags> found(double gap = 0.1) const { return contacts(gather_all(comm, spheres()), box, gap); }
  void plan(CementPlan& plan, const std::vector<GrainTags>& pairs) {
    plan.make(pairs, grains, cemented, [this](CementRequest& w) { w = wish; });
  }
  CementMaker::Sums make(const std::vector<GrainTags>& pairs) {
    CementPlan bonds(comm, box);
    plan(bonds, pairs);
    CementMaker maker(comm, bonds, table, {spheres(), static_cast<double>(table.size()), last_tag}, *this);
    const CementMaker::Sums sums = maker.make();
    skipped = maker.skipped();
    last_tag = maker.last_tag();
    return sums;
  }
  std::vector<GrainTags> cemented, skipped;
  int last_tag = 100;
  std::vector<Point> all_points() const {
    std::vector<Point> all = gather_all(comm, points);
    std::sort(all.begin(), all.end(), [](const Point& a, const Point& b) { return a.tag < b.tag; });
    return all;
  }

  std::vector<FullPoint> full_points(int rows) override {
    std::vector<FullPoint> full;
    for (const Point& p : points)
      if (p.row < rows && p.volume > 0.95 * std::pow(table[p.row].spacing, 3))
        full.push_back({Vector3(p.x[0], p.x[1], p.x[2]), p.row, table[p.row].spacing});
    return full;
  }
  std::size_t create_points(const std::vector<NewBond>& bonds, bool) override {
    const std::size_t before = points.size();
    for (const NewBond& b : bonds) {
      lists.emplace_back(b.points.data(), b.points.size());
      for (std::size_t n = 0; n < b.points.size(); ++n) {
        Point p{b.first_tag + static_cast<int>(n), b.row, {}, b.points[n].volume};
        int image[3] = {0, 0, 0};
        for (int c = 0; c < 3; ++c) p.x[c] = b.record.origin[c] + b.points[n].X[c];
        if (box.wrap(p.x, image)) points.push_back(p);
      }
    }
    return points.size() - before;
  }
  int template_of(const std::vector<FillPoint>& points) override {
    templates.push_back(points);
    return static_cast<int>(templates.size());
  }
  std::vector<std::vector<FillPoint>> templates;
  void say(const std::string& text) override { said += text; }
  void warn(const std::string& text) override { said += "warning: " + text + "\n"; }
};

// Text of the BadState that a function throws, empty if it throws none. It is the same on all ranks.
template <class F>
std::string complaint(F f) {
  try {
    f();
  } catch (const BadState& e) {
    return e.what();
  }
  return "";
}

void expect_same_points(const std::vector<RowScene::Point>& a, const std::vector<RowScene::Point>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    ASSERT_EQ(a[n].tag, b[n].tag);
    EXPECT_EQ(a[n].row, b[n].row);
    EXPECT_EQ(a[n].volume, b[n].volume);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(a[n].x[c], b[n].x[c]);
  }
}

TEST(CementMaker, MakesTheSameOnAnyNumberOfRanks) {
  RowScene together(MPI_COMM_WORLD, 6, true), alone(MPI_COMM_SELF, 6, true);
  const CementMaker::Sums sums = together.make(together.found());
  alone.make(alone.found());
  ASSERT_EQ(together.table.size(), 6u);  // one across the boundary
  expect_same_points(together.all_points(), alone.all_points());
  const std::vector<RowScene::Point> points = together.all_points();
  ASSERT_EQ(points.size(), static_cast<std::size_t>(sums.points));
  double volume = 0.0;
  for (std::size_t n = 0; n < points.size(); ++n) {
    EXPECT_EQ(points[n].tag, 101 + static_cast<int>(n));
    volume += points[n].volume;
  }
  // The cylinder between two spheres without what these take of it: 2 pi (r^2/2 (2 R) - 2 (R^3 - (R^2 - r^2)^(3/2))/3).
  const double r = 0.6, R = kRadius, exact = 2.0 * M_PI * (r * r * R - 2.0 / 3.0 * (R * R * R - std::pow(R * R - r * r, 1.5)));
  EXPECT_NEAR(volume, 6 * exact, 1e-9 * exact);
  EXPECT_NEAR(sums.volume, 6 * exact, 1e-9 * exact);
  EXPECT_NEAR(sums.mass, 2710.0 * sums.volume, 1e-9 * sums.mass);
  for (std::size_t b = 0; b < 6; ++b) {
    const BondRecord &mine = together.table[b], &other = alone.table[b];
    EXPECT_EQ(mine.grain[0], other.grain[0]);
    EXPECT_EQ(mine.points, other.points);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(mine.origin[c], other.origin[c]);
    const bool across = mine.grain[0] == 1 && mine.grain[1] == 6;
    EXPECT_EQ(mine.shift[1][0], across ? -12.0 : 0.0);
    EXPECT_EQ(mine.box[2], 12.0);
  }
}

// Equal geometry is filled once, and handed out again. Grains lie at whole numbers, so their distances are bitwise identical.
TEST(CementMaker, FillsEqualGeometryOnce) {
  RowScene s(MPI_COMM_SELF, 8);
  s.make(s.found());
  ASSERT_EQ(s.lists.size(), 7u);
  for (const auto& l : s.lists) EXPECT_EQ(l, s.lists.front());
  RowScene odd(MPI_COMM_SELF, 4);
  odd.grains[2].radius = 0.75;
  odd.grains[2].x[0] -= 0.25;
  odd.grains[3].x[0] -= 0.5;
  odd.make(odd.found());
  ASSERT_EQ(odd.lists.size(), 3u);
  EXPECT_NE(odd.lists[0].first, odd.lists[1].first);  // which have the first radius, gap, direction and mass in common
}

// Bonds whose points are made later have those that `now` makes as a template, on all ranks, and no IDs.
TEST(CementMaker, KeepsPatternsForLater) {
  RowScene now(MPI_COMM_SELF, 6), later(MPI_COMM_WORLD, 6);
  later.wish.later = true;
  const CementMaker::Sums made = now.make(now.found()), kept = later.make(later.found());
  EXPECT_EQ(kept.points, made.points);
  EXPECT_EQ(kept.mass, made.mass);
  EXPECT_TRUE(later.all_points().empty());
  EXPECT_EQ(later.last_tag, 100);
  ASSERT_EQ(later.templates.size(), 1u);
  ASSERT_EQ(later.table.size(), 5u);
  std::vector<RowScene::Point> points = now.all_points();
  for (const BondRecord& b : later.table) {
    EXPECT_EQ(b.point_template, 1);
    ASSERT_EQ(static_cast<std::size_t>(b.points), later.templates[0].size());
  }
  for (std::size_t n = 0; n < later.templates[0].size(); ++n)
    for (int c = 0; c < 3; ++c) EXPECT_EQ(now.table[0].origin[c] + later.templates[0][n].X[c], points[n].x[c]);
}

// Two commands in the same place: refused, left out, or allowed where they do not meet.
TEST(CementMaker, CementInCementIsRefusedOrLeftOut) {
  for (const bool skip : {false, true}) {
    RowScene s(MPI_COMM_WORLD, 4);
    s.make({{1, 2}, {3, 4}});
    const std::size_t points = s.all_points().size();
    s.wish.overlap = skip ? CementRequest::skip : CementRequest::error;
    const std::string why = complaint([&] { s.make({{1, 2}, {2, 3}}); });
    if (skip) {
      EXPECT_EQ(why, "");
      EXPECT_EQ(s.skipped, (std::vector<GrainTags>{{1, 2}}));
      EXPECT_EQ(s.table.size(), 3u);
      EXPECT_EQ(s.all_points().size(), points / 2 * 3);
      EXPECT_EQ(s.all_points().back().row, 2);
    } else {
      EXPECT_EQ(why.find("create_cement pair 1 2: the cement of grains 1 and 2 overlaps that of grains 1 and 2, in a volume of "), 0u)
          << why;
      EXPECT_EQ(s.table.size(), 2u);
    }
  }
}

// Three grains in a triangle, whose bonds meet in the middle: refused, or shared out.
TEST(CementMaker, SharesOutWhatBondsHaveInCommon) {
  const auto made = [](CementRequest::Overlap overlap, MPI_Comm comm, std::string& why) {
    RowScene s(comm, 3);
    s.set_grains({{1.5, 2.0, 3.0}, {3.5, 2.0, 3.0}, {2.5, 2.0 + std::sqrt(3.0), 3.0}});
    s.wish.shapes[0].given["outer"] = 0.75;
    s.wish.overlap = overlap;
    CementMaker::Sums sums;
    why = complaint([&] { sums = s.make(s.found()); });
    return std::make_pair(sums, s.all_points());
  };
  std::string why, why_alone;
  made(CementRequest::error, MPI_COMM_WORLD, why);
  EXPECT_NE(why.find("overlaps that of grains"), std::string::npos) << why;
  const auto trimmed = made(CementRequest::trim, MPI_COMM_WORLD, why), alone = made(CementRequest::trim, MPI_COMM_SELF, why_alone);
  EXPECT_EQ(why, "");
  expect_same_points(trimmed.second, alone.second);
  const double r = 0.75, one = 2.0 * M_PI * (r * r - 2.0 / 3.0 * (1.0 - std::pow(1.0 - r * r, 1.5)));
  EXPECT_LT(trimmed.first.volume, 2.99 * one);
  EXPECT_GT(trimmed.first.volume, 2.5 * one);
}

// All ranks know that its points are on no lattice.
TEST(CementMaker, CementThinnerThanACellIsASeam) {
  RowScene s(MPI_COMM_WORLD, 5);
  s.wish.spacing = 0.5;
  s.make({{1, 2}, {3, 4}});
  ASSERT_EQ(s.table.size(), 2u);
  for (const BondRecord& b : s.table) {
    EXPECT_FALSE(b.regular);
    EXPECT_TRUE(b.is_thinner_than(1.0));
    EXPECT_GT(b.points, 0);
  }
  EXPECT_TRUE(s.said.empty() || s.said.find("a seam") != std::string::npos);  // one rank speaks
}

TEST(CementMaker, ComplainsOfTheFirstBondThatCannotBe) {
  const auto why = [](auto change, const std::vector<GrainTags>& pairs) {
    RowScene s(MPI_COMM_WORLD, 5);
    change(s);
    return complaint([&] { s.make(pairs); });
  };
  const auto nothing = [](RowScene&) {};
  EXPECT_EQ(why(nothing, {{1, 2}, {2, 4}}).find("create_cement pair 2 4: grains 2 and 4 are not neighbours: their gap 2 "), 0u);
  EXPECT_NE(why(nothing, {{1, 9}}).find("grain 9 does not exist"), std::string::npos);
  EXPECT_NE(why([](RowScene& s) { s.cemented = {{1, 2}}; }, {{1, 2}}).find("have cement already"), std::string::npos);
  const auto thin = [](RowScene& s) {
    s.wish.spacing = 0.5;
    s.wish.shapes = {{shape_style("coating"), {{"thickness", 0.2}}}};
  };
  EXPECT_NE(why(thin, {{1, 2}}).find("less than a cell of two points of spacing 0.5"), std::string::npos);
  EXPECT_NE(why([](RowScene& s) { s.box.high[1] = s.box.low[1] + 5.1; }, {{1, 2}}).find("points lie outside the simulation box"),
            std::string::npos);
  EXPECT_NE(why([](RowScene& s) { s.last_tag = 2147483647; }, {{1, 2}}).find("exceed the number of atom IDs"), std::string::npos);
  EXPECT_NE(why([](RowScene& s) { s.wish.file = "no such file"; }, {{1, 2}}).find("'no such file' cannot be read"), std::string::npos);
  const auto in_the_way = [](RowScene& s) { s.set_grains({{2, 5, 5}, {4, 5, 5}, {3, 6.2, 5}}); };
  EXPECT_NE(why(in_the_way, {{1, 2}}).find("lie inside grain 3"), std::string::npos);
}

// Compares with a test of all pairs, in boxes with and without periods.
TEST(Contacts, AreThoseOfAllPairs) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.0, 6.0), radius(0.3, 0.9);
  for (const bool periodic : {false, true}) {
    const SceneBox box = box_of(MPI_COMM_SELF, 6.0, periodic);
    std::vector<Sphere> spheres;
    for (int n = 0; n < 60; ++n) spheres.push_back({100 - n, Vector3(place(random), place(random), place(random)), radius(random)});
    std::set<GrainTags> expected;
    for (const Sphere& a : spheres)
      for (const Sphere& b : spheres)
        for (int i = -1; i <= 1; ++i)
          for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) {
              if (a.tag >= b.tag || (!periodic && (i != 0 || j != 0 || k != 0))) continue;
              if ((b.x + 6.0 * Vector3(i, j, k) - a.x).norm() - a.radius - b.radius <= 0.2) expected.insert({a.tag, b.tag});
            }
    const std::vector<GrainTags> found = contacts(spheres, box, 0.2);
    EXPECT_GT(found.size(), 60u);
    EXPECT_EQ(found, std::vector<GrainTags>(expected.begin(), expected.end()));
  }
}

TEST(SceneBox, TakesPlacesInByPeriods) {
  SceneBox b = box_of(MPI_COMM_SELF, 4.0, true);
  b.periodic[2] = false;
  double x[3] = {-0.5, 9.0, 4.5};
  int image[3] = {0, 0, 0};
  EXPECT_FALSE(b.wrap(x, image));
  EXPECT_EQ(x[0], 3.5);
  EXPECT_EQ(x[1], 1.0);
  EXPECT_EQ(x[2], 4.5);
  EXPECT_EQ(image[0], -1);
  EXPECT_EQ(image[1], 2);
  EXPECT_EQ(image[2], 0);
  EXPECT_TRUE(b.owns(Vector3(-1e-17, 0.0, 0.0)));  // rounds to the upper face, which is the lower
  EXPECT_EQ(b.images().size(), 9u);
  EXPECT_EQ(b.shortest(Vector3(3.0, -3.0, 3.0)), Vector3(-1.0, 1.0, 3.0));
}

}  // namespace
}  // namespace mpdem
