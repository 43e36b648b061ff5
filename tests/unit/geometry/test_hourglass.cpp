// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/hourglass.h"

#include <limits>
#include <map>

#include "bodies.h"
#include "geometry/flat.h"
#include "geometry/lattice_fill.h"

namespace mpdem {
namespace {

using test::Vector;

struct HourglassCase {
  GrainPair pair;
  double outer, waist, inner;
  std::string name() const {
    return test::name_of(pair) + ", outer " + std::to_string(1e3 * outer) + " mm, waist " + std::to_string(waist) + ", inner " +
           std::to_string(1e3 * inner) + " mm";
  }
};

std::vector<HourglassCase> hourglass_cases() {
  std::vector<HourglassCase> all;
  for (GrainPair p : test::pairs())
    for (double gap : {p.gap, 1.5e-3})
      for (double outer : {1e-3, 1.8e-3, 2.4e-3})
        for (double waist : {0.3, 0.6, 0.75, 0.9, 1.0})
          for (double inner : {0.0, 0.8}) {
            p.gap = gap;
            const HourglassCase c{p, outer, waist, inner * waist * outer};
            if (test::shape_error([&] { Hourglass(c.pair, c.outer, c.waist, c.inner); }).empty()) all.push_back(c);
          }
  return all;
}

// Solid of revolution under the hyperbola less the caps of the spheres, whose common part is taken once.
TEST(Hourglass, VolumeAgainstClosedForm) {
  test::Worst worst, quadrature;
  int waisted = 0;
  for (const HourglassCase& c : hourglass_cases()) {
    const GrainPair& p = c.pair;
    const double a = c.outer, w = c.waist * a;
    const double length = p.R1 + p.R2 + p.gap - test::height_over_girth(p.R1, a) - test::height_over_girth(p.R2, a);
    double V = M_PI * length * (2 * w * w + a * a) / 3;
    for (double R : {p.R1, p.R2}) {
      const double h = R - test::height_over_girth(R, a);
      V -= M_PI * h * h * (3 * R - h) / 3;
    }
    if (p.gap < 0.0) V += lens_volume(p.R1, p.R2, p.distance());
    const Hourglass h(p, a, c.waist, c.inner);
    waisted += c.waist < 0.8;
    // the closed form with an inner radius is what the quadrature below is for
    if (c.inner == 0.0) worst.add(std::fabs(h.volume() - V) / (M_PI * length * a * a), c.name());
    quadrature.add(std::fabs(h.volume() / test::volume_of_revolution(h, {}) - 1.0), c.name());
  }
  EXPECT_GT(waisted, 100);
  expect_within(worst, 1e-11, "volume");
  expect_within(quadrature, 1e-11, "volume by quadrature");
}

TEST(Hourglass, OutlineIsAHyperbolaFromSphereToSphere) {
  for (const HourglassCase& c : hourglass_cases()) {
    const Hourglass h(c.pair, c.outer, c.waist, c.inner);
    const double lo = h.lowest(), hi = h.highest(), middle = 0.5 * (lo + hi);
    EXPECT_NEAR(h.top(lo) / c.outer, 1.0, 1e-13) << c.name();
    EXPECT_NEAR(h.top(hi) / c.outer, 1.0, 1e-13) << c.name();
    EXPECT_NEAR(h.top(middle) / (c.waist * c.outer), 1.0, 1e-13) << c.name();
    for (int s = 0; s < 2; ++s) {
      const double z = (s ? hi : lo) - c.pair.height(s), R = c.pair.radius(s);
      EXPECT_NEAR((z * z + c.outer * c.outer) / (R * R), 1.0, 1e-13) << c.name();
    }
    for (int i = 1; i < 40; ++i) {
      const double z = lo + (hi - lo) * i / 40, r = h.top(z);
      EXPECT_GE(r, h.neck() * (1 - 1e-15)) << c.name();
      EXPECT_NEAR(r / h.top(lo + hi - z), 1.0, 1e-13) << c.name();
      for (int s = 0; s < 2; ++s) {
        const double height = z - c.pair.height(s), R = c.pair.radius(s);
        EXPECT_GE(height * height + r * r, R * R * (1 - 1e-12)) << c.name();
      }
    }
  }
}

TEST(Hourglass, ClearanceBoxAndArea) {
  test::Random random(161);
  for (const HourglassCase& c : hourglass_cases()) {
    SCOPED_TRACE(c.name());
    const bool film = c.waist * c.outer < 1.01 * test::circle_of_contact(c.pair);  // too thin to hit it by chance
    if (c.inner == 0.0 && !film) test::expect_consistent(Hourglass(c.pair, c.outer, c.waist, c.inner), random, 400);
  }
}

TEST(Hourglass, OuterForVolumeInverts) {
  test::expect_inverts(
      hourglass_cases(), &HourglassCase::outer,
      [](const HourglassCase& c) { return Hourglass(c.pair, c.outer, c.waist, c.inner).volume(); },
      [](const HourglassCase& c, double V) { return Hourglass::outer_for_volume(c.pair, V, c.waist, c.inner); }, 1e-9, "outer radius");
}

// The message names the largest volume. It fits, and a little more does not.
TEST(Hourglass, LargestVolumeFits) {
  const GrainPair p{5e-3, 5e-3, 1e-4, Vector(0, 0, 1)};
  const double waist = 0.6;
  const std::string why = test::shape_error([&] { Hourglass::outer_for_volume(p, 1e-6, waist, 0.0); });
  const std::string words = "at most ";
  ASSERT_NE(why.find(words), std::string::npos) << why;
  const double most = std::stod(why.substr(why.find(words) + words.size()));
  const double outer = Hourglass::outer_for_volume(p, most * (1.0 - 1e-5), waist, 0.0);
  EXPECT_EQ(test::shape_error([&] { Hourglass(p, outer, waist, 0.0); }), "");
  EXPECT_NE(test::shape_error([&] { Hourglass(p, outer * (1.0 + 2e-5), waist, 0.0); }).find("cuts into the grains"), std::string::npos);
  EXPECT_NE(test::shape_error([&] { Hourglass::outer_for_volume(p, 1e-12, 1.5, 0.0); }).find("must lie in (0, 1]"), std::string::npos);
}

TEST(Hourglass, WithoutAWaistIsFlat) {
  for (const GrainPair& p : test::pairs()) {
    const Hourglass h(p, 2e-3, 1.0, 1.2e-3);
    const Flat flat(p, 2e-3, 1.2e-3);
    EXPECT_EQ(h.volume(), flat.volume());
    const auto a = fill_with_points(h, 1.5e-4), b = fill_with_points(flat, 1.5e-4);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_LT((a[i].X - b[i].X).norm(), 1e-12) << test::name_of(p);
      EXPECT_NEAR(a[i].volume, b[i].volume, 1e-12 * b[i].volume);
      EXPECT_EQ(a[i].link_count, b[i].link_count);
    }
  }
}

// Equal grains along an axis: mirrored at each plane, and with x and y changed, the points are the same.
TEST(Hourglass, PointsAreSymmetric) {
  const double spacing = 1e-4;
  const Hourglass h({5e-3, 5e-3, 5e-4, Vector(0, 0, 1)}, 2e-3, 0.6, 5e-4);
  const auto points = fill_with_points(h, spacing);
  const auto cell_of = [&](const Vector& x) {
    return std::array<int, 3>{int(std::floor(x[0] / spacing)), int(std::floor(x[1] / spacing)), int(std::floor(x[2] / spacing))};
  };
  std::map<std::array<int, 3>, const FillPoint*> at;
  double V = 0;
  for (const FillPoint& p : points) {
    at[cell_of(p.X)] = &p;
    V += p.volume;
  }
  EXPECT_NEAR(V / h.volume(), 1.0, 1e-12);
  for (const FillPoint& p : points)
    for (const Vector& image : {Vector(-p.X[0], p.X[1], p.X[2]), Vector(p.X[0], -p.X[1], p.X[2]), Vector(p.X[0], p.X[1], -p.X[2]),
                                Vector(p.X[1], p.X[0], p.X[2])}) {
      const auto found = at.find(cell_of(image));
      ASSERT_NE(found, at.end());
      EXPECT_LT((found->second->X - image).norm(), 1e-9 * spacing);
      EXPECT_NEAR(found->second->volume, p.volume, 1e-12 * p.volume);
    }
}

TEST(Hourglass, RefusesWhatIsNoBody) {
  const GrainPair p{5e-3, 3e-3, 0.0, Vector(0, 0, 1)}, overlap{5e-3, 5e-3, -2e-4, Vector(0, 0, 1)},
      apart{5e-3, 5e-3, 1e-3, Vector(0, 0, 1)};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](const GrainPair& pair, double outer, double waist, double inner) {
    return test::shape_error([&] { Hourglass(pair, outer, waist, inner); });
  };
  EXPECT_EQ(error(p, 1e-3, 0.8, 0.0), "");
  EXPECT_EQ(error(apart, 1e-3, 0.1, 0.0), "");
  for (double bad : {0.0, -1e-3, 3.001e-3, nan}) EXPECT_NE(error(p, bad, 0.8, 0.0).find("outer radius"), std::string::npos) << bad;
  for (double bad : {0.0, -0.5, 1.001, nan}) EXPECT_NE(error(p, 1e-3, bad, 0.0).find("must lie in (0, 1]"), std::string::npos) << bad;
  for (double bad : {-1e-6, 0.8e-3, nan}) EXPECT_NE(error(p, 1e-3, 0.8, bad).find("inner radius"), std::string::npos) << bad;
  EXPECT_NE(error(overlap, 1.1e-3, 0.9, 0.0).find("overlap of the grains"), std::string::npos);
  // For touching grains and small radii the least waist is sqrt(1 - (1 + S/B)/4). S and B are the smaller and larger radius of the
  // grains. The waist that the message names is allowed, and a smaller one is not.
  const std::string narrow = error(p, 1e-3, 0.5, 0.0);
  const double least = std::stod(narrow.substr(narrow.find("at least ") + 9));
  EXPECT_NEAR(least, std::sqrt(1 - (1 + 3.0 / 5.0) / 4), 0.02) << narrow;
  EXPECT_EQ(error(p, 1e-3, least + 1e-5, 0.0), "");
  EXPECT_NE(error(p, 1e-3, least - 1e-5, 0.0), "");
  const auto volume_error = [&](const GrainPair& pair, double V, double waist, double inner) {
    return test::shape_error([&] { Hourglass::outer_for_volume(pair, V, waist, inner); });
  };
  for (double bad : {0.0, -1e-9, 1.0, nan}) EXPECT_NE(volume_error(p, bad, 0.8, 0.0).find("does not fit"), std::string::npos) << bad;
  EXPECT_NE(volume_error(p, 1e-11, 0.8, 1e-3).find("at least"), std::string::npos);
  EXPECT_NE(volume_error(overlap, 1e-9, 0.3, 0.0).find("nearer to 1"), std::string::npos);
  EXPECT_NE(volume_error(p, 1e-9, 0.8, 2.99e-3).find("nearer to 1"), std::string::npos);
}

}  // namespace
}  // namespace mpdem
