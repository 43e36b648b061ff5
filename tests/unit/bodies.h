// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Helpers for the tests of cement shapes: a quadrature of their own, pairs of grains, and what every
// shape has to fulfil.
#ifndef MPDEM_TESTS_BODIES_H
#define MPDEM_TESTS_BODIES_H

#include <algorithm>
#include <sstream>
#include <vector>

#include "geometry/shape.h"
#include "lanes.h"

namespace mpdem::test {

constexpr double kDegree = M_PI / 180;

// Adaptive Gauss-Legendre quadrature with ten points a piece. A piece is halved until the halves agree to
// 1e-14 of the whole, or to `floor` where the whole may vanish.
template <class F>
double integrate(F f, double a, double b, double floor = 0.0) {
  static const double x[5] = {0.14887433898163122, 0.43339539412924721, 0.67940956829902444, 0.86506336668898454, 0.97390652851717174};
  static const double w[5] = {0.29552422471475287, 0.26926671930999635, 0.21908636251598204, 0.14945134915058059, 0.06667134430868814};
  struct Rule {
    F& f;
    double operator()(double lo, double hi) const {
      const double m = 0.5 * (lo + hi), h = 0.5 * (hi - lo);
      double sum = 0;
      for (int i = 0; i < 5; ++i) sum += w[i] * (f(m - h * x[i]) + f(m + h * x[i]));
      return h * sum;
    }
    double refine(double lo, double hi, double whole, double tolerance, int depth) const {
      const double m = 0.5 * (lo + hi), left = (*this)(lo, m), right = (*this)(m, hi);
      if (depth == 0 || std::fabs(left + right - whole) <= tolerance) return left + right;
      return refine(lo, m, left, tolerance, depth - 1) + refine(m, hi, right, tolerance, depth - 1);
    }
  };
  const Rule rule{f};
  const double whole = rule(a, b);
  return rule.refine(a, b, whole, std::max(1e-14 * std::fabs(whole), floor), 40);
}

// Pairs of equal and unequal grains. They are apart, touch or overlap, along an axis and not.
inline std::vector<GrainPair> pairs() {
  std::vector<GrainPair> all;
  const Vector skew = Vector(1.0, -2.0, 0.7).normalized();
  for (double R2 : {5e-3, 3e-3, 20e-3})
    for (double gap : {0.0, 2e-4, -2e-4})
      for (const Vector& n : {Vector(0, 0, 1), skew}) all.push_back({5e-3, R2, gap, n});
  return all;
}

inline std::string name_of(const GrainPair& p) {
  std::ostringstream s;
  s << "R2 " << p.R2 << ", gap " << p.gap << ", n " << p.n.transpose();
  return s.str();
}

// Height of the surface of a sphere over its girth, at radius r.
inline double height_over_girth(double R, double r) { return std::sqrt(std::max((R - r) * (R + r), 0.0)); }

// Radius at which the surfaces of overlapping grains meet, found by bisection.
inline double circle_of_contact(const GrainPair& p) {
  if (p.gap >= 0.0) return 0.0;
  double lo = 0.0, hi = std::min(p.R1, p.R2);
  for (int i = 0; i < 200; ++i) {
    const double m = 0.5 * (lo + hi);
    const double t = p.R1 + p.R2 + p.gap - height_over_girth(p.R1, m) - height_over_girth(p.R2, m);
    (t < 0.0 ? lo : hi) = m;
  }
  return hi;
}

// A place near the pair's gap, given by height along the line of centres and distance from it.
inline Vector place(const GrainPair& p, double z, double r, double angle) {
  const Vector e1 = p.n.unitOrthogonal(), e2 = p.n.cross(e1);
  return z * p.n + r * (std::cos(angle) * e1 + std::sin(angle) * e2);
}

// Checks that the clearance is never more than the distance to the surface, and that the box encloses the bond.
inline void expect_consistent(const Shape& shape, Random& random, int samples = 4000) {
  const Vector box = shape.half_extent();
  int inside = 0, wrong = 0, outside_box = 0;
  for (int i = 0; i < samples; ++i) {
    const double margin = 0.2 * (shape.highest() - shape.lowest());
    double z = random.uniform(shape.lowest() - margin, shape.highest() + margin);
    double r = 1.2 * shape.widest() * std::sqrt(random.uniform(0, 1));
    if (i % 2) {  // next to a grain
      const int s = random.index(2);
      const double a = 1.2 * shape.covered_angle(s) * std::sqrt(random.uniform(0, 1));
      const double R = shape.pair().radius(s) + shape.largest_thickness() * random.uniform(-0.1, 1.1);
      z = shape.pair().height(s) + (s == 0 ? 1 : -1) * R * std::cos(a);
      r = R * std::fabs(std::sin(a));
    }
    const Vector x = place(shape.pair(), z, r, random.uniform(0, 2 * M_PI));
    const bool in = shape.inside(x);
    inside += in;
    outside_box += in && ((x.cwiseAbs() - box).maxCoeff() > 0.0);
    const double c = shape.clearance(x);
    if (!(c >= 0.0)) ++wrong;
    for (int k = 0; k < 10; ++k) wrong += shape.inside(x + 0.9999 * c * random.direction()) != in;
  }
  EXPECT_GT(inside, 0) << shape.describe();
  EXPECT_EQ(wrong, 0) << shape.describe();
  EXPECT_EQ(outside_box, 0) << shape.describe();
  // areas follow from the angles
  for (int s = 0; s < 2; ++s) {
    double from, to;
    shape.attached_band(s, from, to);
    EXPECT_LE(0.0, from);
    EXPECT_LT(from, to);
    const double R = shape.pair().radius(s);
    const double area = integrate([&](double a) { return 2 * M_PI * R * R * std::sin(a); }, from, to);
    EXPECT_NEAR(shape.attached_area(s) / area, 1.0, 1e-12);
  }
}

// Volume that the outline top(z) holds outside the grains and the inner radius, summed slice by slice. The
// breaks split the height where the outline has corners.
inline double volume_of_revolution(const Shape& shape, std::vector<double> breaks) {
  const GrainPair& p = shape.pair();
  breaks.push_back(shape.lowest());
  breaks.push_back(shape.highest());
  for (int s = 0; s < 2; ++s) {
    const double R = p.radius(s), rim = height_over_girth(R, std::min(R, shape.inner()));
    for (double offset : {-R, -rim, 0.0, rim, R}) breaks.push_back(p.height(s) + offset);
  }
  std::sort(breaks.begin(), breaks.end());
  const auto slice = [&](double z) {
    double in2 = z > p.height(0) && z < p.height(1) ? shape.inner() * shape.inner() : 0.0;
    for (int s = 0; s < 2; ++s) {
      const double h = std::fabs(z - p.height(s)), R = p.radius(s);
      in2 = std::max(in2, (R - h) * (R + h));
    }
    const double out = shape.top(z);
    return M_PI * std::max(out * out - in2, 0.0);
  };
  double V = 0;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double from = std::max(breaks[i], shape.lowest()), to = std::min(breaks[i + 1], shape.highest());
    if (to > from) V += integrate(slice, from, to);
  }
  return V;
}

// Text of the ShapeError that f throws, empty if it throws none.
template <class F>
std::string shape_error(F f) {
  try {
    f();
  } catch (const ShapeError& e) {
    return e.what();
  }
  return {};
}

// Volumes from the least to the largest are met. Others are refused, with a message that names both.
template <class Solve, class Volume>
void expect_volumes_in_range(Solve size_for, Volume volume_of) {
  for (const double gap : {0.0, 2e-4, 1e-3})
    for (const double inner : {0.0, 5e-4}) {
      const GrainPair pair{3e-3, 5e-3, gap, Eigen::Vector3d(0, 0, 1)};
      const auto error = [&](double V) { return shape_error([&] { size_for(pair, V, inner); }); };
      const auto named = [](const std::string& why, const std::string& word) {
        return std::stod(why.substr(why.find(word) + word.size()));
      };
      const double least = named(error(1.0), "at least "), most = named(error(1.0), "at most ");
      EXPECT_LT(least, 0.2 * most);
      if (gap > 0.0) {
        EXPECT_GT(least, 1e-6 * most);
        EXPECT_NE(error(0.999 * least).find("at least"), std::string::npos) << gap << " " << inner;
      }
      for (const double V : {std::max(1.001 * least, 1e-7 * most), 0.999 * most})
        EXPECT_NEAR(volume_of(pair, size_for(pair, V, inner), inner) / V, 1.0, 1e-9) << gap << " " << inner;
    }
}

// Finds from the volume of each case the size that the case has.
template <class Case, class Volume, class SizeOf>
void expect_inverts(const std::vector<Case>& cases, double Case::*size, Volume volume, SizeOf size_of, double tolerance, const char* what) {
  Worst worst;
  for (const Case& c : cases) worst.add(std::fabs(size_of(c, volume(c)) / (c.*size) - 1.0), c.name());
  expect_within(worst, tolerance, what);
}

// Volume of cement in a pair of grains, content by mass of the grains: glass, calcite.
inline double volume_of_content(double content, double R) { return content * 2500.0 * 2.0 * (4.0 / 3.0) * M_PI * R * R * R / 2710.0; }

}  // namespace mpdem::test

#endif
