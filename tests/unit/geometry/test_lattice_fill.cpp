// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/lattice_fill.h"

#include <algorithm>
#include <array>
#include <map>

#include "bodies.h"
#include "geometry/flat.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::Vector;

struct FilledCase {
  std::string name;
  GrainPair pair;
  double outer, inner, spacing;
};

std::vector<FilledCase> filled_cases() {
  const Vector z(0, 0, 1), skew = Vector(1.0, -2.0, 0.7).normalized();
  return {
      {"equal, touching", {5e-3, 5e-3, 0.0, z}, 2.332e-3, 0.0, 1e-4}, {"equal, ring", {5e-3, 5e-3, 0.0, z}, 2e-3, 1e-3, 7e-5},
      {"equal, apart", {5e-3, 5e-3, 3e-4, z}, 1.5e-3, 0.0, 8e-5},     {"equal, overlapping", {5e-3, 5e-3, -5e-5, z}, 2e-3, 0.0, 9e-5},
      {"skew", {5e-3, 5e-3, 0.0, skew}, 2e-3, 0.8e-3, 8e-5},          {"skew, unequal, apart", {5e-3, 3e-3, 2e-4, skew}, 1.4e-3, 0.0, 8e-5},
      {"unequal", {5e-3, 2e-3, 0.0, z}, 1.6e-3, 0.3e-3, 8e-5}};
}

TEST(LatticeFill, VolumeAndAreaAreThoseOfTheShape) {
  test::Worst volume, area, on_sphere;
  for (const FilledCase& c : filled_cases()) {
    const Flat shape(c.pair, c.outer, c.inner);
    const std::vector<FillPoint> points = fill_with_points(shape, c.spacing);
    double V = 0, A[2] = {0, 0};
    for (const FillPoint& p : points) {
      EXPECT_GT(p.volume, 0.0);
      V += p.volume;
      EXPECT_TRUE(p.link_count >= 0 && p.link_count <= 2);
      for (int i = 0; i < p.link_count; ++i) {
        EXPECT_GT(p.link[i].area, 0.0);
        A[p.link[i].side] += p.link[i].area;
        const double R = c.pair.radius(p.link[i].side);
        on_sphere.add(std::fabs((p.link[i].foot - c.pair.centre(p.link[i].side)).norm() / R - 1.0), c.name);
      }
      if (p.link_count == 2) {
        EXPECT_NE(p.link[0].side, p.link[1].side);
      }
    }
    volume.add(std::fabs(V / shape.volume() - 1.0), c.name);
    for (int s = 0; s < 2; ++s) area.add(std::fabs(A[s] / shape.attached_area(s) - 1.0), c.name);
  }
  expect_within(volume, 1e-12, "volume");
  expect_within(area, 1e-12, "area");
  expect_within(on_sphere, 1e-13, "foot points on the sphere");
}

std::array<int, 3> cell_of(const Vector& x, double spacing) {
  return {static_cast<int>(std::floor(x[0] / spacing)), static_cast<int>(std::floor(x[1] / spacing)),
          static_cast<int>(std::floor(x[2] / spacing))};
}

TEST(LatticeFill, OnePointACellInAscendingOrder) {
  for (const FilledCase& c : filled_cases()) {
    const Flat shape(c.pair, c.outer, c.inner);
    const std::vector<FillPoint> points = fill_with_points(shape, c.spacing);
    const std::vector<FillPoint> again = fill_with_points(shape, c.spacing);
    ASSERT_EQ(points.size(), again.size());
    double whole = 0;
    int misplaced = 0, far = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const FillPoint& p = points[i];
      if (i > 0) misplaced += !(cell_of(points[i - 1].X, c.spacing) < cell_of(p.X, c.spacing));
      whole = std::max(whole, p.volume);
      // a foot point is found within a few cells of its point
      for (int k = 0; k < p.link_count; ++k) far += (p.link[k].foot - p.X).norm() > 4 * c.spacing;
      EXPECT_EQ(p.X, again[i].X);
      EXPECT_EQ(p.volume, again[i].volume);
      EXPECT_EQ(p.link_count, again[i].link_count);
      for (int k = 0; k < p.link_count; ++k) EXPECT_EQ(p.link[k].foot, again[i].link[k].foot);
    }
    EXPECT_EQ(misplaced, 0) << c.name;
    EXPECT_EQ(far, 0) << c.name;
    // the scaling to the exact volume is small
    EXPECT_NEAR(whole / (c.spacing * c.spacing * c.spacing), 1.0, 0.01) << c.name;
  }
}

// Points and links under a symmetry of lattice and bond; `swapped`: grains change places.
void expect_symmetric(const std::vector<FillPoint>& points, const FilledCase& c, const Matrix& Q, bool swapped, test::Worst& worst) {
  std::map<std::array<int, 3>, const FillPoint*> at;
  for (const FillPoint& p : points) at[cell_of(p.X, c.spacing)] = &p;
  for (const FillPoint& p : points) {
    const auto it = at.find(cell_of(Q * p.X, c.spacing));
    ASSERT_NE(it, at.end()) << c.name;
    const FillPoint& q = *it->second;
    worst.add((Q * p.X - q.X).norm() / c.spacing, c.name);
    worst.add(std::fabs(p.volume - q.volume) / (c.spacing * c.spacing * c.spacing), c.name);
    ASSERT_EQ(p.link_count, q.link_count) << c.name;
    for (int i = 0; i < p.link_count; ++i)
      for (int j = 0; j < q.link_count; ++j) {
        if (q.link[j].side != (swapped ? 1 - p.link[i].side : p.link[i].side)) continue;
        worst.add((Q * p.link[i].foot - q.link[j].foot).norm() / c.spacing, c.name + ", foot");
        worst.add(std::fabs(p.link[i].area - q.link[j].area) / (c.spacing * c.spacing), c.name + ", area");
      }
  }
}

TEST(LatticeFill, SymmetricWithTheLattice) {
  test::Worst worst;
  const Matrix quarter = test::rotation({0, 0, 1}, 0.5 * M_PI);
  const Matrix exact_quarter = quarter.array().round();
  for (const FilledCase& c : filled_cases()) {
    if (c.pair.n[2] != 1.0) continue;
    const std::vector<FillPoint> points = fill_with_points(Flat(c.pair, c.outer, c.inner), c.spacing);
    expect_symmetric(points, c, Vector(-1, 1, 1).asDiagonal(), false, worst);
    expect_symmetric(points, c, Vector(1, -1, 1).asDiagonal(), false, worst);
    expect_symmetric(points, c, exact_quarter, false, worst);
    if (c.pair.R1 == c.pair.R2) expect_symmetric(points, c, Vector(1, 1, -1).asDiagonal(), true, worst);
  }
  expect_within(worst, 1e-12, "asymmetry over spacing");
}

// A bond in any direction with equal grains is its own image under inversion, as the lattice is.
TEST(LatticeFill, SymmetricUnderInversionInAnyDirection) {
  test::Worst worst;
  for (const FilledCase& c : filled_cases())
    if (c.pair.R1 == c.pair.R2) {
      const std::vector<FillPoint> points = fill_with_points(Flat(c.pair, c.outer, c.inner), c.spacing);
      expect_symmetric(points, c, -Matrix::Identity(), true, worst);
    }
  expect_within(worst, 1e-12, "asymmetry over spacing");
}

// First moments of volume and area against the exact ones, in units of the spacing.
TEST(LatticeFill, CentroidIsThatOfTheShape) {
  test::Worst along, across, area_along, area_across, second;
  for (const FilledCase& c : filled_cases()) {
    const Flat shape(c.pair, c.outer, c.inner);
    const GrainPair& p = c.pair;
    const double from = std::max(c.inner, test::circle_of_contact(p));
    const auto z = [&](int s, double r) {
      const double h = test::height_over_girth(p.radius(s), r);
      return s == 0 ? -(p.R1 + 0.5 * p.gap) + h : p.R2 + 0.5 * p.gap - h;
    };
    const auto moment_at = [&](double r) { return M_PI * r * (z(1, r) - z(0, r)) * (z(1, r) + z(0, r)); };
    const auto polar_at = [&](double r) { return 2 * M_PI * r * r * r * (z(1, r) - z(0, r)); };
    const double exact = test::integrate(moment_at, from, c.outer, 1e-9 * c.spacing * shape.volume());
    const double polar = test::integrate(polar_at, from, c.outer);
    Vector moment = Vector::Zero(), foot[2] = {Vector::Zero(), Vector::Zero()};
    double inertia = 0;
    for (const FillPoint& q : fill_with_points(shape, c.spacing)) {
      moment += q.volume * q.X;
      inertia += q.volume * (q.X.squaredNorm() - std::pow(q.X.dot(p.n), 2));
      for (int i = 0; i < q.link_count; ++i) foot[q.link[i].side] += q.link[i].area * q.link[i].foot;
    }
    const Vector x = moment / shape.volume();
    along.add(std::fabs(x.dot(p.n) - exact / shape.volume()) / c.spacing, c.name);
    across.add((x - x.dot(p.n) * p.n).norm() / c.spacing, c.name);
    second.add(std::fabs(inertia / polar - 1.0), c.name);
    for (int s = 0; s < 2; ++s) {
      const double R = p.radius(s), a = std::asin(from / R), b = std::asin(c.outer / R);
      // height of the spherical zone's centroid
      const double h = R * 0.5 * (std::cos(a) + std::cos(b)), at = p.centre(s).dot(p.n) + (s == 0 ? h : -h);
      const Vector f = foot[s] / shape.attached_area(s);
      area_along.add(std::fabs(f.dot(p.n) - at) / c.spacing, c.name);
      area_across.add((f - f.dot(p.n) * p.n).norm() / c.spacing, c.name);
    }
  }
  expect_within(along, 5e-3, "centroid along the bond");
  expect_within(across, 1e-3, "centroid across");
  expect_within(second, 5e-3, "polar moment of inertia");
  expect_within(area_along, 1e-2, "centroid of the area along the bond");
  expect_within(area_across, 1e-4, "centroid of the area across");
}

TEST(LatticeFill, RefusesASpacingThatDoesNotFit) {
  const Flat thin({5e-3, 5e-3, 0.0, Vector(0, 0, 1)}, 2e-3, 0.0);
  EXPECT_NE(test::shape_error([&] { fill_with_points(thin, 2e-2); }).find("spacing"), std::string::npos);
  EXPECT_NE(test::shape_error([&] { fill_with_points(thin, 1e-12); }).find("spacing"), std::string::npos);
  const std::string many = test::shape_error([&] { fill_with_points(thin, 1e-4, 100.0); });
  EXPECT_NE(many.find("more than the 100 that there is memory for"), std::string::npos) << many;
}

// Two bonds side by side, at a distance at which samples lie in the plane between their middles, or do not: together
// they fill the union, whose height at (x, y) is that of the higher one.
TEST(LatticeFill, NeighboursFillTheUnionOnce) {
  const double R = 5e-3, outer = 1e-3, spacing = 5e-5;
  const GrainPair pair{R, R, 0.0, Vector(0, 0, 1)};
  const Flat shape(pair, outer, 0.0);
  for (double cells : {8.0 + 0.5 / 16, 8.0, 8.3}) {
    const double apart = 2.0 * cells * spacing;
    double V = 0;
    for (double side : {-1.0, 1.0})
      for (const FillPoint& p : fill_with_points(shape, spacing, 1e8, {{&shape, Vector(side * apart, 0, 0)}})) V += p.volume;
    const auto height = [&](double r) { return r < outer ? 2.0 * (R - std::sqrt(R * R - r * r)) : 0.0; };
    double expected = 0;
    const int n = 800;
    const double dx = (2.0 * outer + apart) / n, dy = 2.0 * outer / n;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double x = -outer + (i + 0.5) * dx, y = -outer + (j + 0.5) * dy;
        expected += std::max(height(std::hypot(x, y)), height(std::hypot(x - apart, y))) * dx * dy;
      }
    EXPECT_NEAR(V / expected, 1.0, 5e-4) << cells;
    EXPECT_LT(V, 1.9 * shape.volume());
  }
}

// Counts how often it is asked whether a place is inside.
class CountedFlat : public Flat {
 public:
  using Flat::Flat;
  double top(double z) const override {
    ++asked;
    return Flat::top(z);
  }
  mutable std::int64_t asked = 0;
};

// A thin ring takes the work of its own cells. Those in its hole lie at the surfaces of the grains, too, and are hundreds of times as many.
TEST(LatticeFill, ThinRing) {
  const GrainPair pair = pair_between(5e-3, 5e-3, Vector3(0, 0, 10e-3));
  constexpr double kSpacing = 1e-7;
  const double inner = pair.radius_of_thickness(2.0 * kSpacing);
  const CountedFlat ring(pair, Flat::outer_for_volume(pair, 1e-18, inner), inner);
  const std::vector<FillPoint> points = fill_with_points(ring, kSpacing, 1e9);
  EXPECT_GT(points.size(), 1000u);
  test::expect_within(static_cast<double>(ring.asked) / static_cast<double>(points.size()), 1500.0, "questions a point of a thin ring");
}

}  // namespace
}  // namespace mpdem
