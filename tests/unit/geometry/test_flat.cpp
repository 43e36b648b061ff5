// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/flat.h"

#include <limits>

#include "bodies.h"

namespace mpdem {
namespace {

using test::Vector;

struct FlatCase {
  GrainPair pair;
  double outer, inner;
  std::string name() const { return test::name_of(pair) + ", outer " + std::to_string(1e3 * outer) + " mm"; }
};

std::vector<FlatCase> flat_cases() {
  std::vector<FlatCase> all;
  for (const GrainPair& p : test::pairs()) {
    const double largest = std::min(p.R1, p.R2), least = test::circle_of_contact(p);
    for (double a : {0.02, 0.4, 0.9, 1.0}) {
      const double outer = least + a * (largest - least);
      for (double b : {0.0, 0.5, 0.99}) all.push_back({p, outer, b * outer});
    }
  }
  return all;
}

// r = R sin a, with R of the smaller grain, keeps the integrand smooth up to its girth.
double volume_by_quadrature_of(const FlatCase& c) {
  const GrainPair& p = c.pair;
  const double R = std::min(p.R1, p.R2), from = std::max(c.inner, test::circle_of_contact(p));
  const auto drop = [](double radius, double r) { return r * r / (radius + std::sqrt(std::max(radius * radius - r * r, 0.0))); };
  return test::integrate(
      [&](double a) {
        const double r = R * std::sin(a);
        return 2 * M_PI * r * (p.gap + drop(p.R1, r) + drop(p.R2, r)) * R * std::cos(a);
      },
      std::asin(from / R), std::asin(std::min(c.outer / R, 1.0)));
}

TEST(Flat, VolumeAgainstQuadrature) {
  test::Worst worst;
  for (const FlatCase& c : flat_cases()) {
    const double V = Flat(c.pair, c.outer, c.inner).volume();
    worst.add(std::fabs(V - volume_by_quadrature_of(c)) / V, c.name());
  }
  expect_within(worst, 1e-12, "volume");
}

TEST(Flat, AttachedAreaAgainstQuadrature) {
  test::Worst worst;
  for (const FlatCase& c : flat_cases()) {
    const Flat flat(c.pair, c.outer, c.inner);
    for (int s = 0; s < 2; ++s) {
      const double R = c.pair.radius(s), from = std::max(c.inner, test::circle_of_contact(c.pair));
      const double A = test::integrate([&](double a) { return 2 * M_PI * R * R * std::sin(a); }, std::asin(from / R),
                                       std::asin(std::min(c.outer / R, 1.0)));
      worst.add(std::fabs(flat.attached_area(s) / A - 1.0), c.name());
    }
  }
  expect_within(worst, 1e-12, "area");
}

TEST(Flat, OuterForVolumeInverts) {
  test::Worst worst;
  for (const FlatCase& c : flat_cases()) {
    const double V = Flat(c.pair, c.outer, c.inner).volume();
    worst.add(std::fabs(Flat::outer_for_volume(c.pair, V * (1 - 1e-15), c.inner) / c.outer - 1.0), c.name());
  }
  expect_within(worst, 1e-10, "outer radius");
}

TEST(Flat, ContentOfAPairOfBeads) {
  const GrainPair beads{5e-3, 5e-3, 0.0, Vector(0, 0, 1)};
  const double table[][3] = {{0.001, 0.966, 1.320}, {0.01, 9.66, 2.332}, {0.05, 48.3, 3.440},
                             {0.11, 106, 4.132},    {0.17, 164, 4.551},  {0.25, 242, 4.927}};
  for (const auto& row : table) {
    const double V = test::volume_of_content(row[0], 5e-3);
    EXPECT_NEAR(1e9 * V / row[1], 1.0, 0.005);
    EXPECT_NEAR(1e3 * Flat::outer_for_volume(beads, V, 0.0), row[2], 0.0006) << row[0];
  }
  // most that fits: (2 pi/3) R^3, 27.1 % by mass
  const Flat most(beads, 5e-3, 0.0);
  EXPECT_NEAR(most.volume() / (2 * M_PI / 3 * 125e-9), 1.0, 1e-13);
  EXPECT_NEAR(most.volume() / test::volume_of_content(1.0, 5e-3), 0.271, 0.0005);
}

TEST(Flat, InsideIsWhatTheCylinderHoldsBetweenTheSpheres) {
  test::Random random(141);
  int inside = 0;
  for (const FlatCase& c : flat_cases()) {
    if (c.outer < 1e-3 || c.inner > 0.9 * c.outer) continue;
    const Flat flat(c.pair, c.outer, c.inner);
    const GrainPair& p = c.pair;
    int wrong = 0;
    for (int i = 0; i < 500; ++i) {
      const double r = 1.1 * c.outer * std::sqrt(random.uniform(0, 1));
      const double z = (i % 2 ? 1.0 : 6.0) * (p.gap + 2e-3) * random.uniform(-1, 1);
      bool expected = r <= c.outer && r >= c.inner && z > -(p.R1 + 0.5 * p.gap) && z < p.R2 + 0.5 * p.gap;
      for (int s = 0; s < 2; ++s) {
        const double h = z - (s ? p.R2 + 0.5 * p.gap : -(p.R1 + 0.5 * p.gap));
        expected = expected && r * r + h * h >= p.radius(s) * p.radius(s);
      }
      inside += expected;
      wrong += flat.inside(test::place(p, z, r, random.uniform(0, 6.3))) != expected;
    }
    EXPECT_EQ(wrong, 0) << c.name();
  }
  EXPECT_GT(inside, 1000);
}

TEST(Flat, ClearanceBoxAndArea) {
  test::Random random(142);
  for (const FlatCase& c : flat_cases()) {
    SCOPED_TRACE(c.name());
    if (c.inner < 0.9 * c.outer) test::expect_consistent(Flat(c.pair, c.outer, c.inner), random, 1000);
  }
}

TEST(Flat, Thickness) {
  for (const FlatCase& c : flat_cases()) {
    const Flat flat(c.pair, c.outer, c.inner);
    const GrainPair& p = c.pair;
    const auto gap_at = [&](double r) { return p.R1 + p.R2 + p.gap - test::height_over_girth(p.R1, r) - test::height_over_girth(p.R2, r); };
    EXPECT_NEAR(flat.largest_thickness(), gap_at(c.outer), 1e-14);
    EXPECT_NEAR(flat.smallest_thickness(), gap_at(std::max(c.inner, test::circle_of_contact(p))), 1e-14);
    EXPECT_NE(flat.describe().find("flat"), std::string::npos);
  }
}

TEST(Flat, RefusesWhatIsNoBody) {
  const GrainPair p{5e-3, 3e-3, 0.0, Vector(0, 0, 1)}, overlap{5e-3, 5e-3, -2e-4, Vector(0, 0, 1)};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](const GrainPair& pair, double outer, double inner) { return test::shape_error([&] { Flat(pair, outer, inner); }); };
  EXPECT_EQ(error(p, 1e-3, 0.0), "");
  for (double bad : {0.0, -1e-3, 3.001e-3, nan}) EXPECT_NE(error(p, bad, 0.0).find("outer radius"), std::string::npos) << bad;
  for (double bad : {-1e-6, 1e-3, 2e-3, nan}) EXPECT_NE(error(p, 1e-3, bad).find("inner radius"), std::string::npos) << bad;
  EXPECT_NE(error(overlap, 0.9e-3, 0.0).find("overlap"), std::string::npos);
  EXPECT_EQ(error(overlap, 1.1e-3, 0.0), "");
  const auto volume_error = [&](double V, double inner) { return test::shape_error([&] { Flat::outer_for_volume(p, V, inner); }); };
  for (double bad : {0.0, -1e-9, 1.0, nan}) EXPECT_NE(volume_error(bad, 0.0).find("volume"), std::string::npos) << bad;
  EXPECT_NE(volume_error(1e-9, 2.99e-3).find("volume"), std::string::npos);
}

}  // namespace
}  // namespace mpdem
