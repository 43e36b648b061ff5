// SPDX-License-Identifier: GPL-2.0-or-later
#include "geometry/radial_axis.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mpdem {
namespace {

constexpr double kLayer = 0.1;

struct Pair {
  Vector3 centre[2];
  double radius[2];
  Vector3 axis(const Vector3& X) const { return radial_axis(X, centre, radius, kLayer); }
  Pair swapped() const { return {{centre[1], centre[0]}, {radius[1], radius[0]}}; }
};

const Pair kEqual{{{0, 0, -5}, {0, 0, 5}}, {5, 5}};
const Pair kUnequal{{{1, 2, -5}, {4, 2, 2}}, {5, 2.4}};

// Sine of the angle between lines.
double between(const Vector3& a, const Vector3& b) { return a.cross(b).norm(); }

double nearer_to_first(const Pair& p, const Vector3& X) {
  return ((X - p.centre[1]).norm() - p.radius[1]) - ((X - p.centre[0]).norm() - p.radius[0]);
}

// A place with this difference of the distances, found along the line of centres.
Vector3 place(const Pair& p, double difference, double aside) {
  const Vector3 n = (p.centre[1] - p.centre[0]).normalized(), across = n.unitOrthogonal();
  double lo = 0.0, hi = (p.centre[1] - p.centre[0]).norm();
  for (int i = 0; i < 100; ++i) {
    const double mid = 0.5 * (lo + hi);
    (nearer_to_first(p, p.centre[0] + mid * n + aside * across) > difference ? lo : hi) = mid;
  }
  return p.centre[0] + lo * n + aside * across;
}

TEST(RadialAxis, IsTheNormalOfTheNearerSphere) {
  for (const Pair& p : {kEqual, kUnequal})
    for (double aside : {0.0, 0.7, 1.9})
      for (double far : {0.5, 0.7, 4.0}) {
        const Vector3 first = place(p, far * kLayer * (1.0 + 1e-12), aside), second = place(p, -far * kLayer * (1.0 + 1e-12), aside);
        EXPECT_EQ(p.axis(first), (first - p.centre[0]).normalized());
        EXPECT_EQ(p.axis(second), (second - p.centre[1]).normalized());
      }
}

TEST(RadialAxis, HalvesTheAngleAtEqualDistance) {
  for (const Pair& p : {kEqual, kUnequal})
    for (double aside : {0.0, 0.7, 1.9}) {
      const Vector3 X = place(p, 0.0, aside), n0 = (X - p.centre[0]).normalized(), n1 = (X - p.centre[1]).normalized();
      const Vector3 a = p.axis(X);
      EXPECT_NEAR(a.norm(), 1.0, 1e-14);
      EXPECT_NEAR(a.dot(n0), -a.dot(n1), 1e-12);
      EXPECT_GT(a.dot(n0), 0.8);
      EXPECT_NEAR(a.dot(n0.cross(n1)), 0.0, 1e-14);  // in their plane
    }
  EXPECT_LT(between(kEqual.axis({0.3, -1.7, 0.0}), Vector3::UnitZ()), 1e-15);
}

// The angle against the first normal has no jump and no kink, at steps of a thousandth of a spacing.
TEST(RadialAxis, TurnsSmoothly) {
  const double step = 1e-3;
  for (const Pair& p : {kEqual, kUnequal}) {
    double last = 0.0, last_slope = 0.0;
    const double whole = between(p.axis(place(p, kLayer, 1.9)), p.axis(place(p, -kLayer, 1.9)));
    ASSERT_GT(whole, 0.1);
    for (int i = 0; i < 1600; ++i) {
      const Vector3 X = place(p, (0.8 - i * step) * kLayer, 1.9);
      const double angle = std::asin(between(p.axis(X), (X - p.centre[0]).normalized()));
      if (i > 1) {
        const double slope = (angle - last) / (step * whole);
        EXPECT_LT(std::fabs(slope), 2.0);
        EXPECT_LT(std::fabs(slope - last_slope), 8.0 * step);
        last_slope = slope;
      }
      last = angle;
    }
    EXPECT_NEAR(last_slope, 0.0, 0.05);
  }
}

TEST(RadialAxis, IsALineThatDoesNotKnowWhichSphereIsFirst) {
  for (const Pair& p : {kEqual, kUnequal})
    for (double aside : {0.0, 0.7, 1.9})
      for (double d : {-0.9, -0.5, -0.3, -1e-17, 0.0, 1e-17, 0.2, 0.5, 0.8}) {
        const Vector3 X = place(p, d * kLayer, aside);
        EXPECT_LT(between(p.axis(X), p.swapped().axis(X)), 1e-15);
      }
}

// Rounding of a point that is as near to both spheres does not rotate its axis.
TEST(RadialAxis, RoundingDoesNotTurnIt) {
  for (const Pair& p : {kEqual, kUnequal})
    for (double aside : {0.7, 1.9}) {
      const Vector3 X = place(p, 0.0, aside), a = p.axis(X);
      for (int d = 0; d < 3; ++d) {
        Vector3 Y = X;
        Y[d] = std::nextafter(Y[d], 10.0);
        EXPECT_LT(between(p.axis(Y), a), 3e-14);
      }
    }
}

// Overlapping spheres, and a point on the line of centres beyond the smaller one, where both normals are alike.
TEST(RadialAxis, IsAUnitVectorEverywhere) {
  const Pair overlap{{{0, 0, -4.6}, {0, 0, 4.6}}, {5, 5}};
  for (const Pair& p : {kEqual, kUnequal, overlap}) {
    const Vector3 n = (p.centre[1] - p.centre[0]).normalized(), across = n.unitOrthogonal();
    for (double along = -12.0; along < 12.0; along += 0.37)
      for (double aside : {0.0, 0.4, 3.0, 8.0}) EXPECT_NEAR(p.axis(p.centre[0] + along * n + aside * across).norm(), 1.0, 1e-14);
  }
}

}  // namespace
}  // namespace mpdem
