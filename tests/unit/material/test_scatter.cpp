// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/scatter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace mpdem {
namespace {

ScatterRule rule(ScatterRule::Distribution distribution, double parameter, double length = 0.0, int seed = 7) {
  ScatterRule r;
  r.distribution = distribution;
  r.parameter = parameter;
  r.length = length;
  r.seed = seed;
  return r;
}

double normal_probability(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

// Largest distance of the distribution of numbers from one that is given, times the root of their count (Kolmogorov).
template <class F>
double distance(std::vector<double> numbers, F probability) {
  std::sort(numbers.begin(), numbers.end());
  const double n = static_cast<double>(numbers.size());
  double most = 0.0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double p = probability(numbers[i]);
    most = std::max({most, std::fabs(p - static_cast<double>(i) / n), std::fabs(p - static_cast<double>(i + 1) / n)});
  }
  return most * std::sqrt(n);
}

constexpr double kOneIn1e5 = 2.47;  // distance() exceeds this with a probability of 1e-5

TEST(Scatter, NumbersAreNormalAndIndependent) {
  std::vector<double> numbers;
  double product = 0.0;
  for (int i = 0; i < 20000; ++i) {
    numbers.push_back(normal_number(3, 0, i, i + 1, 0));
    product += numbers.back() * normal_number(3, 0, i, i + 2, 0);
  }
  EXPECT_LT(distance(numbers, normal_probability), kOneIn1e5);
  EXPECT_LT(std::fabs(product) / std::sqrt(20000.0), 4.5);
}

// Moments by quadrature over z, and quantiles.
TEST(Scatter, FactorsHaveMeanOneAndTheirDistribution) {
  for (const ScatterRule& r : {rule(ScatterRule::weibull, 3.0), rule(ScatterRule::weibull, 12.0), rule(ScatterRule::lognormal, 0.4)}) {
    double sum = 0.0, squares = 0.0;
    const double dz = 1e-3;
    for (double z = -12.0; z < 12.0; z += dz) {
      const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI) * dz;
      sum += density * r.factor(z);
      squares += density * r.factor(z) * r.factor(z);
    }
    EXPECT_NEAR(sum, 1.0, 1e-6);
    const double m = r.parameter, g = std::tgamma(1.0 + 1.0 / m);
    EXPECT_NEAR(squares - sum * sum, r.distribution == ScatterRule::weibull ? std::tgamma(1.0 + 2.0 / m) / (g * g) - 1.0 : m * m, 1e-5);
  }
  // Probability of survival exp(-x^m) for x = factor times gamma.
  const ScatterRule w = rule(ScatterRule::weibull, 6.0);
  for (double z : {-8.0, -3.0, 0.0, 2.0, 8.0})
    EXPECT_NEAR(std::log(-std::log(normal_probability(-z))) / 6.0, std::log(w.factor(z) * std::tgamma(1.0 + 1.0 / 6.0)),
                z < -7.0 ? 0.1 : 1e-10);
}

GaussianField field(int seed, double length, double size) { return GaussianField(seed, length, {-size, -size, -size}, {size, size, size}); }

TEST(Scatter, FieldIsNormalAtEachPosition) {
  std::vector<double> numbers;
  const double x[3] = {0.137, -0.41, 0.93};
  for (int seed = 1; seed <= 2000; ++seed) numbers.push_back(GaussianField(seed, 1.0, {0.1, -0.5, 0.9}, {0.2, -0.4, 1.0}).at(x));
  EXPECT_LT(distance(numbers, normal_probability), kOneIn1e5);
}

// Over many seeds the correlation at distance r is exp(-(r/L)^2), along any direction and from any place on the lattice.
TEST(Scatter, CorrelationFollowsTheLength) {
  const double direction[2][3] = {{1.0, 0.0, 0.0}, {0.6, 0.48, 0.64}};
  for (const auto& n : direction)
    for (double r : {0.25, 0.5, 1.0, 1.5, 2.5}) {
      double sum = 0.0;
      const int seeds = 3000;
      for (int seed = 1; seed <= seeds; ++seed) {
        const GaussianField f(seed, 1.0, {0.1, 0.3, 0.2}, {0.2 + r * n[0], 0.4 + r * n[1], 0.3 + r * n[2]});
        const double a[3] = {0.11, 0.3, 0.21}, b[3] = {a[0] + r * n[0], a[1] + r * n[1], a[2] + r * n[2]};
        sum += f.at(a) * f.at(b);
      }
      const double expected = std::exp(-r * r);
      EXPECT_NEAR(sum / seeds, expected, 4.0 * std::sqrt((1.0 + expected * expected) / seeds)) << r;
    }
}

// The value does not depend on the box that was asked for.
TEST(Scatter, FieldIsAFunctionOfPositionAlone) {
  const double x[3] = {0.3, 0.2, -0.4};
  EXPECT_EQ(field(5, 0.7, 1.0).at(x), field(5, 0.7, 3.3).at(x));
  EXPECT_NE(field(5, 0.7, 1.0).at(x), field(6, 0.7, 1.0).at(x));
}

// The strength of the weakest of the points of a cube falls somewhat faster than edge^(-3/m), that of points that are independent:
// low values of a smooth field come in regions, whose number has a factor that grows slowly with their rareness.
TEST(Scatter, SizeEffect) {
  const ScatterRule r = rule(ScatterRule::weibull, 6.0);
  double mean[3];
  for (int size = 0; size < 3; ++size) {
    const double edge = 2 << size, step = 0.5;
    const int seeds = 60;
    double sum = 0.0;
    for (int seed = 1; seed <= seeds; ++seed) {
      const GaussianField f(seed + 1000 * (2 << size), 1.0, {0.0, 0.0, 0.0}, {edge, edge, edge});
      double least = 1e9;
      for (double x = 0.5 * step; x < edge; x += step)
        for (double y = 0.5 * step; y < edge; y += step)
          for (double z = 0.5 * step; z < edge; z += step) {
            const double at[3] = {x, y, z};
            least = std::min(least, f.at(at));
          }
      sum += std::log(r.factor(least));
    }
    mean[size] = sum / seeds;
  }
  for (int size = 1; size < 3; ++size) {
    const double slope = (mean[size] - mean[size - 1]) / std::log(2.0) / (-3.0 / r.parameter);
    EXPECT_GT(slope, 1.0);
    EXPECT_LT(slope, 1.3);
  }
}

TEST(Scatter, RulesOfAPropertyMultiply) {
  Scatter both, of_bond, of_field;
  of_bond.rules = {rule(ScatterRule::weibull, 6.0)};
  of_field.rules = {rule(ScatterRule::lognormal, 0.3, 0.5)};
  both.rules = {of_bond.rules[0], of_field.rules[0]};
  const std::array<double, 3> low{-1, -1, -1}, high{1, 1, 1};
  const double x[3] = {0.1, 0.2, 0.3};
  const auto factor = [&](const Scatter& s, int first, int second) {
    return ScatterOfBond(s, first, second, low, high).factor(Scattered::strength, x);
  };
  EXPECT_EQ(factor(both, 4, 9), factor(of_bond, 4, 9) * factor(of_field, 4, 9));
  EXPECT_EQ(factor(both, 4, 9), factor(both, 9, 4));
  EXPECT_NE(factor(of_bond, 4, 9), factor(of_bond, 4, 10));
  EXPECT_EQ(factor(of_field, 4, 9), factor(of_field, 1, 2));
  EXPECT_EQ(ScatterOfBond(both, 4, 9, low, high).factor(Scattered::moduli, x), 1.0);
}

}  // namespace
}  // namespace mpdem
