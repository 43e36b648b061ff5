// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/coating.h"

#include <limits>

#include "bodies.h"

namespace mpdem {
namespace {

using test::Vector;

struct CoatingCase {
  GrainPair pair;
  double thickness, cap, inner;
  std::string name() const {
    return test::name_of(pair) + ", thickness " + std::to_string(1e3 * thickness) + " mm, cap " + std::to_string(cap / test::kDegree) +
           ", inner " + std::to_string(1e3 * inner) + " mm";
  }
};

std::vector<CoatingCase> coating_cases() {
  std::vector<CoatingCase> all;
  for (const GrainPair& p : test::pairs())
    for (double t : {1.2e-4, 5e-4})
      for (double cap : {45.0, 70.0, 90.0, 180.0})
        for (double inner : {0.0, 3e-4}) {
          const CoatingCase c{p, t, cap == 180.0 ? M_PI : cap * test::kDegree, inner};
          if (test::shape_error([&] { Coating(p, t, c.cap, inner); }).empty()) all.push_back(c);
        }
  return all;
}

// Volume found by rays from each grain's centre. A ray at polar angle a goes through the shell from R to R + t.
// The other grain takes its part out of the ray. For the second grain the shell of the first does so, too.
double volume_by_rays(const CoatingCase& c) {
  const GrainPair& p = c.pair;
  const double d = p.distance();
  double V = 0;
  for (int s = 0; s < 2; ++s) {
    const double R = p.radius(s), S = R + c.thickness, other = p.radius(1 - s) + (s == 1 ? c.thickness : 0.0);
    const auto ray = [&](double a) {
      double left = S * S * S - R * R * R;
      const double reach = other * other - d * d * std::sin(a) * std::sin(a);
      if (reach > 0.0 && a < 0.5 * M_PI) {
        const double middle = d * std::cos(a), half = std::sqrt(reach);
        const double from = std::max(R, middle - half), to = std::min(S, middle + half);
        if (to > from) left -= to * to * to - from * from * from;
      }
      return 2 * M_PI / 3 * std::sin(a) * left;
    };
    // where the ray's ends cross the other ball, and where it is tangent
    std::vector<double> at{0.0, c.cap};
    for (double r : {R, S}) {
      const double cosine = (r * r + d * d - other * other) / (2 * r * d);
      if (std::fabs(cosine) < 1.0 && std::acos(cosine) < c.cap) at.push_back(std::acos(cosine));
    }
    if (other < d && std::asin(other / d) < c.cap) at.push_back(std::asin(other / d));
    std::sort(at.begin(), at.end());
    for (std::size_t i = 0; i + 1 < at.size(); ++i) V += test::integrate(ray, at[i], at[i + 1]);
  }
  // the cylinder of the inner radius between the grains is taken out of the bond alone
  const double circle = test::circle_of_contact(p);
  if (c.inner > circle)
    V -= test::integrate(
        [&](double r) {
          const double gap = p.distance() - test::height_over_girth(p.R1, r) - test::height_over_girth(p.R2, r);
          return 2 * M_PI * r * gap;
        },
        circle, c.inner);
  return V;
}

TEST(Coating, VolumeAgainstQuadrature) {
  ASSERT_GT(coating_cases().size(), 60u);
  test::Worst worst, own;
  for (const CoatingCase& c : coating_cases()) {
    const Coating coating(c.pair, c.thickness, c.cap, c.inner);
    worst.add(std::fabs(coating.volume() / volume_by_rays(c) - 1.0), c.name());
    own.add(std::fabs(volume_by_quadrature(coating) / coating.volume() - 1.0), c.name());
  }
  expect_within(worst, 1e-12, "volume");
  expect_within(own, 1e-12, "volume_by_quadrature");
}

// Slices of a thin shell are differences of nearly equal disks, whose rounding no finer rule takes away.
TEST(Coating, VolumeOfThinShellsByQuadrature) {
  for (double share : {3e-4, 1e-4, 1e-5, 1e-6}) {
    const Coating coating({5e-3, 4e-3, 0.0, Vector(0, 0, 1)}, share * 5e-3, M_PI, 0.0);
    EXPECT_NEAR(volume_by_quadrature(coating) / coating.volume(), 1.0, 1e-15 / share) << share;
  }
}

TEST(Coating, ContentOfAPairOfBeads) {
  const GrainPair beads{5e-3, 5e-3, 0.0, Vector(0, 0, 1)};
  const double table[][3] = {{0.001, 0.0015, 0.124}, {0.01, 0.0153, 0.392}, {0.05, 0.076, 0.875},
                             {0.11, 0.165, 1.295},   {0.17, 0.252, 1.607},  {0.25, 0.364, 1.943}};
  for (const auto& row : table) {
    const double t = Coating::thickness_for_volume(beads, test::volume_of_content(row[0], 5e-3), M_PI, 0.0);
    EXPECT_NEAR(1e3 * t, row[1], row[1] < 0.02 ? 0.00005 : 0.0005) << row[0];
    EXPECT_NEAR(1e3 * Coating(beads, t, M_PI, 0.0).ring(), row[2], 0.0006) << row[0];
  }
}

TEST(Coating, ThicknessForVolumeInverts) {
  test::expect_inverts(
      coating_cases(), &CoatingCase::thickness, [](const CoatingCase& c) { return Coating(c.pair, c.thickness, c.cap, c.inner).volume(); },
      [](const CoatingCase& c, double V) { return Coating::thickness_for_volume(c.pair, V, c.cap, c.inner); }, 1e-10, "thickness");
}

TEST(Coating, InsideIsTheShellUpToTheCap) {
  test::Random random(161);
  int inside = 0;
  for (const CoatingCase& c : coating_cases()) {
    const Coating coating(c.pair, c.thickness, c.cap, c.inner);
    const GrainPair& p = c.pair;
    int wrong = 0;
    for (int i = 0; i < 1000; ++i) {
      const int from = random.index(2);
      // most places are near the shells
      const double R = p.radius(from) + c.thickness * random.uniform(-0.3, 1.3);
      const double a = random.uniform(0, M_PI) * random.uniform(0, 1);
      const double r = R * std::sin(a), z = p.height(from) + (from == 0 ? 1 : -1) * R * std::cos(a);
      bool expected = false;
      for (int s = 0; s < 2; ++s) {
        const double ahead = s == 0 ? z - p.height(0) : p.height(1) - z, away = std::hypot(r, ahead);
        expected = expected || (away <= p.radius(s) + c.thickness && std::atan2(r, ahead) <= c.cap);
      }
      for (int s = 0; s < 2; ++s) expected = expected && std::hypot(r, z - p.height(s)) >= p.radius(s);
      expected = expected && !(r < c.inner && z > p.height(0) && z < p.height(1));
      inside += expected;
      wrong += coating.inside(test::place(p, z, r, random.uniform(0, 6.3))) != expected;
    }
    EXPECT_EQ(wrong, 0) << c.name();
  }
  EXPECT_GT(inside, 1000);
}

TEST(Coating, ClearanceBoxAndArea) {
  test::Random random(162);
  for (const CoatingCase& c : coating_cases()) {
    SCOPED_TRACE(c.name());
    test::expect_consistent(Coating(c.pair, c.thickness, c.cap, c.inner), random, 1000);
  }
}

TEST(Coating, RefusesWhatIsNoBody) {
  const GrainPair p{5e-3, 3e-3, 0.0, Vector(0, 0, 1)}, apart{5e-3, 5e-3, 1e-3, Vector(0, 0, 1)};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](const GrainPair& pair, double t, double cap, double inner) {
    return test::shape_error([&] { Coating(pair, t, cap, inner); });
  };
  EXPECT_EQ(error(p, 1e-4, M_PI, 0), "");
  for (double bad : {0.0, -1e-4, 3.1e-3, nan}) EXPECT_NE(error(p, bad, M_PI, 0).find("thickness"), std::string::npos) << bad;
  for (double bad : {0.0, -1.0, 2.0, 4.0, nan}) EXPECT_NE(error(p, 1e-4, bad, 0).find("cap"), std::string::npos) << bad;
  EXPECT_NE(error(p, 1e-4, 1 * test::kDegree, 0).find("cap"), std::string::npos);
  EXPECT_NE(error(apart, 4e-4, M_PI, 0).find("gap"), std::string::npos);
  for (double bad : {-1e-6, 2e-3, nan}) EXPECT_NE(error(p, 1e-4, M_PI, bad).find("inner radius"), std::string::npos) << bad;
  // the ring in which the coatings meet may be wider than a small grain
  const GrainPair unequal{5e-3, 1e-3, 0.0, Vector(0, 0, 1)};
  EXPECT_EQ(error(unequal, 8e-4, M_PI, 9.9e-4), "");
  EXPECT_NE(error(unequal, 8e-4, M_PI, 1.5e-3).find("inside the smaller grain"), std::string::npos);
  for (double bad : {0.0, -1e-9, 1.0, nan}) {
    const std::string why = test::shape_error([&] { Coating::thickness_for_volume(p, bad, M_PI, 0); });
    EXPECT_NE(why.find("volume"), std::string::npos) << bad;
  }
  // what is wrong beside the volume is reported
  EXPECT_NE(test::shape_error([&] { Coating::thickness_for_volume(p, 1e-9, 2.0, 0); }).find("must lie in (0, 90]"), std::string::npos);
  EXPECT_NE(test::shape_error([&] { Coating::thickness_for_volume(p, 1e-9, M_PI, 3.5e-3); }).find("inner radius"), std::string::npos);
}

TEST(Coating, MeetsVolumesFromTheLeastToTheLargest) {
  test::expect_volumes_in_range(
      [](const GrainPair& pair, double V, double inner) { return Coating::thickness_for_volume(pair, V, M_PI, inner); },
      [](const GrainPair& pair, double size, double inner) { return Coating(pair, size, M_PI, inner).volume(); });
}

}  // namespace
}  // namespace mpdem
