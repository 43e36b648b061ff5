// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "scatter.h"

#include <algorithm>
#include <cmath>

namespace mpdem {

namespace {

// The last steps of splitmix64 (S. Vigna): each bit of the result depends on all bits of x.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

// A number in (0, 1).
double uniform(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53; }

// -log of the probability of a larger number than z.
double log_exceedance(double z) {
  const double half = std::sqrt(0.5);
  return z < 0.0 ? -std::log1p(-0.5 * std::erfc(-half * z)) : -std::log(0.5 * std::erfc(half * z));
}

constexpr std::int64_t kOfBond = 0, kOfField = 1;  // streams of numbers

}  // namespace

// Box & Muller, of which one number is taken.
double normal_number(std::uint64_t seed, std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
  std::uint64_t h = mixed(seed);
  for (std::int64_t n : {a, b, c, d}) h = mixed(h ^ static_cast<std::uint64_t>(n));
  return std::sqrt(-2.0 * std::log(uniform(h))) * std::cos(2.0 * M_PI * uniform(mixed(h)));
}

double ScatterRule::factor(double z) const {
  if (distribution == weibull) return std::pow(log_exceedance(z), 1.0 / parameter) / std::tgamma(1.0 + 1.0 / parameter);
  const double variance = std::log1p(parameter * parameter);
  return std::exp(std::sqrt(variance) * z - 0.5 * variance);
}

GaussianField::GaussianField(int seed, double length, const std::array<double, 3>& low, const std::array<double, 3>& high)
    : inverse_spacing_(2.0 / length), seed_(static_cast<std::uint64_t>(seed)) {
  for (int d = 0; d < 3; ++d) {
    first_[d] = static_cast<std::int64_t>(std::floor(low[d] * inverse_spacing_)) - kReach + 1;
    const std::int64_t last = static_cast<std::int64_t>(std::floor(high[d] * inverse_spacing_)) + kReach;
    count_[d] = static_cast<std::size_t>(last - first_[d] + 1);
  }
  noise_.reserve(count_[0] * count_[1] * count_[2]);
  const auto index = [&](int d, std::size_t n) { return first_[d] + static_cast<std::int64_t>(n); };
  for (std::size_t i = 0; i < count_[0]; ++i)
    for (std::size_t j = 0; j < count_[1]; ++j)
      for (std::size_t k = 0; k < count_[2]; ++k) noise_.push_back(normal_number(seed_, kOfField, index(0, i), index(1, j), index(2, k)));
}

double GaussianField::at(const double* x) const {
  double weight[3][2 * kReach], squares = 1.0;
  std::size_t from[3];
  for (int d = 0; d < 3; ++d) {
    const double t = x[d] * inverse_spacing_, cell = std::floor(t);
    from[d] = static_cast<std::size_t>(static_cast<std::int64_t>(cell) - kReach + 1 - first_[d]);
    double sum = 0.0;
    for (int n = 0; n < 2 * kReach; ++n) {
      const double r = t - (cell - kReach + 1 + n);
      weight[d][n] = std::exp(-0.5 * r * r);
      sum += weight[d][n] * weight[d][n];
    }
    squares *= sum;
  }
  double z = 0.0;
  for (int i = 0; i < 2 * kReach; ++i)
    for (int j = 0; j < 2 * kReach; ++j) {
      const double* row = &noise_[((from[0] + i) * count_[1] + from[1] + j) * count_[2] + from[2]];
      double sum = 0.0;
      for (int k = 0; k < 2 * kReach; ++k) sum += weight[2][k] * row[k];
      z += weight[0][i] * weight[1][j] * sum;
    }
  return z / std::sqrt(squares);
}

bool Scatter::has(Scattered what) const {
  return std::any_of(rules.begin(), rules.end(), [what](const ScatterRule& r) { return r.what == what; });
}

bool Scatter::has_field() const { return least_length() > 0.0; }

double Scatter::least_length() const {
  double least = 0.0;
  for (const ScatterRule& r : rules)
    if (r.length > 0.0 && (least == 0.0 || r.length < least)) least = r.length;
  return least;
}

ScatterOfBond::ScatterOfBond(const Scatter& scatter, int first_grain, int second_grain, const std::array<double, 3>& low,
                             const std::array<double, 3>& high)
    : scatter_(scatter) {
  std::fill(of_bond_, of_bond_ + kScatteredProperties, 1.0);
  for (const ScatterRule& r : scatter.rules) {
    field_of_rule_.push_back(-1);
    if (r.length > 0.0) {
      field_of_rule_.back() = static_cast<int>(fields_.size());
      fields_.emplace_back(r.seed, r.length, low, high);
    } else {
      of_bond_[static_cast<int>(r.what)] *= r.factor(normal_number(
          static_cast<std::uint64_t>(r.seed), kOfBond, std::min(first_grain, second_grain), std::max(first_grain, second_grain), 0));
    }
  }
}

double ScatterOfBond::factor(Scattered what, const double* x) const {
  double product = of_bond_[static_cast<int>(what)];
  for (std::size_t n = 0; n < field_of_rule_.size(); ++n)
    if (scatter_.rules[n].what == what && field_of_rule_[n] >= 0)
      product *= scatter_.rules[n].factor(fields_[static_cast<std::size_t>(field_of_rule_[n])].at(x));
  return product;
}

}  // namespace mpdem
