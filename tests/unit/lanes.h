// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Helpers that the unit tests share: Eigen matrices in and out of the lanes, reproducible random
// numbers, and the largest deviation seen with the place it was seen at.
#ifndef MPDEM_TESTS_LANES_H
#define MPDEM_TESTS_LANES_H

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "numerics/tensor3.h"
#include "numerics/simd.h"

namespace mpdem::test {

using Matrix = Eigen::Matrix3d;
using Vector = Eigen::Vector3d;

inline Matrix tensor(const Sym3<vd>& s, int l) {
  Matrix m;
  m << s.xx[l], s.xy[l], s.xz[l], s.xy[l], s.yy[l], s.yz[l], s.xz[l], s.yz[l], s.zz[l];
  return m;
}
inline Matrix tensor(const Sym3<double>& s) {
  Matrix m;
  m << s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz;
  return m;
}
inline Matrix tensor(const double* s) { return tensor(Sym3<double>{s[0], s[1], s[2], s[3], s[4], s[5]}); }
inline Sym3<double> sym3(const Matrix& m) { return {m(0, 0), m(1, 1), m(2, 2), m(1, 2), m(0, 2), m(0, 1)}; }

inline void set_tensor(Sym3<vd>& s, int l, const Matrix& m) {
  s.xx[l] = m(0, 0);
  s.yy[l] = m(1, 1);
  s.zz[l] = m(2, 2);
  s.yz[l] = m(1, 2);
  s.xz[l] = m(0, 2);
  s.xy[l] = m(0, 1);
}
inline Sym3<vd> on_all_lanes(const Matrix& m) {
  return {splat(m(0, 0)), splat(m(1, 1)), splat(m(2, 2)), splat(m(1, 2)), splat(m(0, 2)), splat(m(0, 1))};
}

inline Matrix matrix(const Mat3<vd>& m, int l) {
  Matrix r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = m.a[i][j][l];
  return r;
}
inline void set_matrix(Mat3<vd>& m, int l, const Matrix& r) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m.a[i][j][l] = r(i, j);
}

inline vmask only_lane(int l) {
  vmask m{};
  m[l] = -1;
  return m;
}

inline Matrix symmetric(const Matrix& m) { return 0.5 * (m + m.transpose()); }
inline double contract(const Matrix& a, const Matrix& b) { return a.cwiseProduct(b).sum(); }
inline Matrix rotation(const Vector& axis, double angle) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

// The distributions of the standard library differ between libraries; these do not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  std::uint64_t bits() { return engine_(); }
  double uniform(double from, double to) { return from + (to - from) * 0x1p-53 * static_cast<double>(engine_() >> 11); }
  int index(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  template <class T>
  void shuffle(std::vector<T>& v) {
    for (std::size_t i = v.size(); i > 1; --i) std::swap(v[i - 1], v[index(static_cast<int>(i))]);
  }
  Vector vector() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  Vector direction() {
    for (;;) {
      const Vector v = vector();
      if (v.norm() > 0.1 && v.norm() <= 1.0) return v.normalized();
    }
  }
  Matrix general() {
    Matrix m;
    for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = uniform(-1, 1);
    return m;
  }
  Matrix sym() { return symmetric(general()); }
  Matrix frame() { return rotation(direction(), uniform(-M_PI, M_PI)); }
  // Symmetric tensor with these principal values and random axes.
  Matrix with_values(const Vector& values) {
    const Matrix q = frame();
    return symmetric(q * values.asDiagonal() * q.transpose());
  }
  Matrix damage(double largest) { return with_values({uniform(0, largest), uniform(0, largest), uniform(0, largest)}); }

 private:
  std::mt19937_64 engine_;
};

// Largest of many deviations; a NaN stays.
class Worst {
 public:
  void add(double error, const std::string& where = {}) {
    ++count_;
    if (std::isnan(value_) || error <= value_) return;
    value_ = error;
    where_ = where;
  }
  void add(const Matrix& difference, double scale, const std::string& where = {}) {
    add(difference.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() / scale, where);
  }
  double value() const { return value_; }
  const std::string& where() const { return where_; }
  long count() const { return count_; }

 private:
  double value_ = 0.0;
  std::string where_;
  long count_ = 0;
};

// Expects the worst deviation within the tolerance. Also keeps the figure as a property `what` of the test, see --gtest_output.
inline void expect_within(const Worst& worst, double tolerance, const std::string& what) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3g of %.3g", worst.value(), tolerance);
  ::testing::Test::RecordProperty(what, text);
  EXPECT_GT(worst.count(), 0) << what << ": nothing was compared";
  EXPECT_LE(worst.value(), tolerance) << what << (worst.where().empty() ? "" : ", worst at ") << worst.where();
}
inline void expect_within(double error, double tolerance, const std::string& what) {
  Worst w;
  w.add(error);
  expect_within(w, tolerance, what);
}

}  // namespace mpdem::test

#endif
