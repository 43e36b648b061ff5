// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/meniscus.h"

#include <array>
#include <limits>

#include "bodies.h"

namespace mpdem {
namespace {

using test::Vector;

struct MeniscusCase {
  GrainPair pair;
  double filling, contact, inner;
  std::string name() const {
    return test::name_of(pair) + ", filling " + std::to_string(filling / test::kDegree) + ", contact " +
           std::to_string(contact / test::kDegree) + ", inner " + std::to_string(1e3 * inner) + " mm";
  }
};

std::vector<MeniscusCase> meniscus_cases() {
  std::vector<MeniscusCase> all;
  for (const GrainPair& p : test::pairs())
    for (double b : {25.0, 40.0, 60.0})
      for (double t : {0.0, 10.0, 25.0})
        for (double inner : {0.0, 0.5}) {
          MeniscusCase c{p, b * test::kDegree, t * test::kDegree, 0.0};
          const auto set_inner = [&] { c.inner = inner * Meniscus(p, c.filling, c.contact, 0.0).neck(); };
          if (test::shape_error(set_inner).empty()) all.push_back(c);
        }
  return all;
}

TEST(Meniscus, OutlineIsAnArcThatMeetsTheSpheresAtTheContactAngle) {
  test::Worst ends, angle, curvature;
  ASSERT_GT(meniscus_cases().size(), 100u);
  for (const MeniscusCase& c : meniscus_cases()) {
    const Meniscus m(c.pair, c.filling, c.contact, c.inner);
    const double lo = m.lowest(), hi = m.highest(), d = 2e-5 * (hi - lo);
    EXPECT_NEAR(m.filling_angle(0), c.filling, 1e-15);
    for (int s = 0; s < 2; ++s) {
      const double z = s == 0 ? lo : hi, b = m.filling_angle(s), R = c.pair.radius(s), into = s == 0 ? d : -d;
      ends.add(std::fabs(m.top(z) / (R * std::sin(b)) - 1.0), c.name());
      ends.add(std::fabs((z - c.pair.height(s)) / ((s == 0 ? R : -R) * std::cos(b)) - 1.0), c.name());
      // slope of the outline on the path off the sphere, by one-sided differences
      const auto top = [&](int k) { return m.top(z + k * into); };
      const double slope = (-11 * top(0) + 18 * top(1) - 9 * top(2) + 2 * top(3)) / (6 * d);
      // the sphere's falls under the angle 90 - b; the outline is flatter by the contact angle
      angle.add(std::fabs(std::atan(-slope) - (0.5 * M_PI - b - c.contact)), c.name());
    }
    // through three points of the outline a circle, wherever they are
    const auto radius = [&](double a, double b, double e) {
      const Vector P(a, m.top(a), 0), Q(b, m.top(b), 0), S(e, m.top(e), 0);
      return (P - Q).norm() * (Q - S).norm() * (S - P).norm() / (2 * (Q - P).cross(S - P).norm());
    };
    const double w = hi - lo, whole = radius(lo, lo + 0.5 * w, hi);
    curvature.add(std::fabs(radius(lo + 0.1 * w, lo + 0.3 * w, lo + 0.6 * w) / whole - 1.0), c.name());
    curvature.add(std::fabs(radius(lo + 0.4 * w, lo + 0.7 * w, lo + 0.9 * w) / whole - 1.0), c.name());
    // the neck is the least radius
    double least = 1e300;
    for (int i = 0; i <= 2000; ++i) least = std::min(least, m.top(std::min(lo + w * i / 2000, hi)));
    EXPECT_LE(m.neck(), least * (1 + 1e-14));
    EXPECT_GE(m.neck(), least * (1 - 1e-5));
  }
  expect_within(ends, 1e-12, "ends on the spheres");
  expect_within(angle, 1e-6, "contact angle");
  expect_within(curvature, 1e-8, "curvature");
}

TEST(Meniscus, VolumeAgainstQuadrature) {
  test::Worst worst, own;
  for (const MeniscusCase& c : meniscus_cases()) {
    const Meniscus m(c.pair, c.filling, c.contact, c.inner);
    const double V = test::volume_of_revolution(m, {});
    worst.add(std::fabs(m.volume() / V - 1.0), c.name());
    own.add(std::fabs(volume_by_quadrature(m) / V - 1.0), c.name());
  }
  expect_within(worst, 1e-12, "volume");
  expect_within(own, 1e-12, "volume_by_quadrature");
}

// The closed form is for equal spheres and contact angle 0.
TEST(Meniscus, ClosedFormOfEqualSpheres) {
  test::Worst worst;
  for (double gap : {0.0, 3e-4})
    for (double b : {20 * test::kDegree, 35 * test::kDegree, 70 * test::kDegree}) {
      const double R = 5e-3, rho = (R + 0.5 * gap) / std::cos(b) - R;
      const double r0 = (R + rho) * std::sin(b), z = rho * std::cos(b);
      const double V =
          2 * M_PI * ((r0 * r0 + rho * rho) * z - z * z * z / 3 - r0 * rho * rho * (std::sin(b) * std::cos(b) + M_PI / 2 - b)) -
          2 * M_PI / 3 * R * R * R * std::pow(1 - std::cos(b), 2) * (2 + std::cos(b));
      const Meniscus m({R, R, gap, Vector(0, 0, 1)}, b, 0.0, 0.0);
      worst.add(std::fabs(m.volume() / V - 1.0));
      worst.add(std::fabs(m.neck() / (r0 - rho) - 1.0));
    }
  expect_within(worst, 1e-11, "volume and neck");
}

TEST(Meniscus, ContentOfAPairOfBeads) {
  const GrainPair beads{5e-3, 5e-3, 0.0, Vector(0, 0, 1)};
  const double table[][3] = {{0.001, 16.8, 1.289}, {0.01, 32.4, 2.251}, {0.05, 52.7, 3.313},
                             {0.11, 67.5, 4.007},  {0.17, 77.6, 4.455}, {0.25, 87.7, 4.900}};
  for (const auto& row : table) {
    const double b = Meniscus::filling_for_volume(beads, test::volume_of_content(row[0], 5e-3), 0.0, 0.0);
    EXPECT_NEAR(b / test::kDegree, row[1], 0.051) << row[0];
    EXPECT_NEAR(1e3 * Meniscus(beads, b, 0.0, 0.0).neck(), row[2], 0.0006) << row[0];
  }
}

// If grain 2 is smaller, not every filling angle of grain 1 has a meniscus.
TEST(Meniscus, FillingAngleInverts) {
  test::Worst volume, neck;
  std::vector<std::string> refused_cases;
  for (const MeniscusCase& c : meniscus_cases()) {
    const Meniscus m(c.pair, c.filling, c.contact, c.inner);
    const std::string refused = test::shape_error([&] {
      const double from_volume = Meniscus::filling_for_volume(c.pair, m.volume(), c.contact, c.inner);
      const double from_neck = Meniscus::filling_for_neck(c.pair, m.neck(), c.contact, c.inner);
      volume.add(std::fabs(from_volume / c.filling - 1.0), c.name());
      neck.add(std::fabs(from_neck / c.filling - 1.0), c.name());
    });
    if (!refused.empty()) refused_cases.push_back(c.name() + ": " + refused);
  }
  EXPECT_TRUE(refused_cases.empty()) << refused_cases.size() << " refused, the first " << refused_cases.front();
  expect_within(volume, 1e-10, "from the volume");
  expect_within(neck, 1e-10, "from the neck");
}

TEST(Meniscus, ClearanceBoxAndArea) {
  test::Random random(151);
  for (const MeniscusCase& c : meniscus_cases()) {
    SCOPED_TRACE(c.name());
    test::expect_consistent(Meniscus(c.pair, c.filling, c.contact, c.inner), random, 500);
  }
}

// Where spheres overlap, there is no meniscus inside the circle in which they meet. Just outside of it there is one.
TEST(Meniscus, BeginsWhereOverlappingSpheresMeet) {
  int overlaps = 0;
  for (double ratio : {0.5, 1.0, 2.3})
    for (double overlap : {0.02, 0.1, 0.2})
      for (double contact : {0.0, 20.0, 45.0}) {
        const double R1 = 1e-3, R2 = ratio * R1;
        const GrainPair p{R1, R2, -overlap * std::min(R1, R2), Vector(0, 0, 1)};
        const double edge = std::asin(p.contact_radius() / R1);
        const auto error = [&](double b) {
          return test::shape_error([&] { Meniscus(p, b, contact * test::kDegree, p.contact_radius()); });
        };
        for (double b : {0.3, 0.7, 0.99})
          EXPECT_NE(error(b * edge).find("no meniscus"), std::string::npos) << b << " " << ratio << " " << overlap;
        EXPECT_EQ(error(1.01 * edge), "") << ratio << " " << overlap << " " << contact;
        ++overlaps;
      }
  EXPECT_EQ(overlaps, 27);
}

// The second grain is small. There is no meniscus where the outline would have to bulge out to reach it.
TEST(Meniscus, DoesNotBulge) {
  for (const auto& [R2, gap, filling, contact] : {std::array<double, 4>{0.2742, 0.077, 33.4925, 42.4596},
                                                  {0.5573, -0.006, 50.5722, 34.5115},
                                                  {0.3386, 0.1983, 39.6063, 37.0614},
                                                  {0.4352, 0.0463, 23.0181, 66.403}}) {
    const GrainPair p{1e-3, 1e-3 * R2, 1e-3 * gap, Vector(0, 0, 1)};
    const double b = filling * test::kDegree, t = contact * test::kDegree;
    EXPECT_NE(test::shape_error([&, gap = gap] { Meniscus(p, b, t, p.contact_radius()); }).find("no meniscus"), std::string::npos)
        << filling;
  }
}

TEST(Meniscus, RefusesWhatIsNoBody) {
  const GrainPair p{5e-3, 5e-3, 0.0, Vector(0, 0, 1)}, wide{5e-3, 5e-3, 5e-3, Vector(0, 0, 1)};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](const GrainPair& pair, double b, double t, double inner) {
    return test::shape_error([&] { Meniscus(pair, b * test::kDegree, t * test::kDegree, inner); });
  };
  EXPECT_EQ(error(p, 30, 0, 0), "");
  for (double bad : {0.0, -10.0, 90.0, nan}) EXPECT_NE(error(p, bad, 0, 0).find("filling angle"), std::string::npos) << bad;
  for (double bad : {-1.0, 90.0, nan}) EXPECT_NE(error(p, 30, bad, 0).find("contact angle"), std::string::npos) << bad;
  EXPECT_NE(error(p, 70, 30, 0).find("filling angle 70 degrees must lie between 0 and 60"), std::string::npos) << error(p, 70, 30, 0);
  EXPECT_NE(error(p, 20, 95, 0).find("contact angle 95 degrees must lie in [0, 90)"), std::string::npos);
  EXPECT_NE(error(wide, 12, 25, 0).find("filling angle 12 and contact angle 25 degrees spans a gap of 0.005"), std::string::npos)
      << error(wide, 12, 25, 0);
  EXPECT_NE(error(wide, 10, 0, 0).find("gap"), std::string::npos);
  for (double bad : {-1e-6, 3e-3, nan}) EXPECT_NE(error(p, 30, 0, bad).find("inner radius"), std::string::npos) << bad;
  for (double bad : {0.0, -1e-9, 1.0, nan}) {
    const std::string volume = test::shape_error([&] { Meniscus::filling_for_volume(p, bad, 0, 0); });
    const std::string neck = test::shape_error([&] { Meniscus::filling_for_neck(p, bad, 0, 0); });
    EXPECT_NE(volume.find("volume"), std::string::npos) << bad;
    EXPECT_NE(neck.find("neck"), std::string::npos) << bad;
  }
}

TEST(Meniscus, MeetsVolumesFromTheLeastToTheLargest) {
  test::expect_volumes_in_range(
      [](const GrainPair& pair, double V, double inner) { return Meniscus::filling_for_volume(pair, V, 0.0, inner); },
      [](const GrainPair& pair, double size, double inner) { return Meniscus(pair, size, 0.0, inner).volume(); });
}

}  // namespace
}  // namespace mpdem
