// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Scatter of the properties of a cement: factors with a mean of 1, drawn from a distribution. A rule draws one value for
// each bond, or a field in space. All rules of one property act together, as a product.
//
// A value of a bond is a function of the seed and of the IDs of its two grains. A field is a function of the seed and of
// the position at creation. So values are the same on any number of ranks and after a restart, and need no memory.
//
// The field comes from white noise on a lattice, smoothed by a Gaussian kernel w (the moving average method):
//
//   z(x) = sum_n w(x - x_n) g_n / sqrt(sum_n w(x - x_n)^2),   w(r) = exp(-2 r^2/L^2)
//
// where g_n are independent standard normal numbers. So z is standard normal at every x, exactly, and its correlation at
// distance r is exp(-(r/L)^2). The lattice has the spacing L/2, the standard deviation of w, where the sums are independent
// of the position of the lattice to 1e-4. The kernel ends at four standard deviations. A factor has the same probability
// under its distribution as z has under the normal distribution (a translation field).
#ifndef MPDEM_MATERIAL_SCATTER_H
#define MPDEM_MATERIAL_SCATTER_H

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace mpdem {

// strength: of the cement, in units of stress. energy: of a crack. moduli: all of them alike. interface: the strength where
// cement touches a grain.
enum class Scattered { strength, energy, moduli, interface };
constexpr int kScatteredProperties = 4;

// Standard normal number, a function of a seed and four whole numbers.
double normal_number(std::uint64_t seed, std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d);

struct ScatterRule {
  Scattered what = Scattered::strength;
  enum Distribution { weibull, lognormal } distribution = weibull;
  double parameter = 1.0;  // weibull: its modulus; lognormal: coefficient of variation
  double length = 0.0;     // correlation length of a field; 0: one value per bond
  int seed = 1;

  // The factor that belongs to a standard normal number z. Its mean is 1.
  double factor(double z) const;
  bool operator==(const ScatterRule& r) const {
    return what == r.what && distribution == r.distribution && parameter == r.parameter && length == r.length && seed == r.seed;
  }
};

// A Gaussian field in a box, with its noise in memory.
class GaussianField {
 public:
  GaussianField(int seed, double length, const std::array<double, 3>& low, const std::array<double, 3>& high);
  double at(const double* x) const;  // x must be in the box

 private:
  static constexpr int kReach = 4;  // reach of the kernel, in spacings of the lattice
  double inverse_spacing_;
  std::uint64_t seed_;
  std::array<std::int64_t, 3> first_;  // node with the least indices
  std::array<std::size_t, 3> count_;
  std::vector<double> noise_;
};

class Scatter {
 public:
  std::vector<ScatterRule> rules;

  bool has(Scattered what) const;
  bool has_field() const;       // some rule has a correlation length
  double least_length() const;  // the least of the correlation lengths, 0 without fields
  bool operator==(const Scatter& s) const { return rules == s.rules; }
};

// Factors of one bond.
class ScatterOfBond {
 public:
  // low, high: box around the points that will be asked for, in the coordinates of the scene at creation. scatter must outlive
  // this object.
  ScatterOfBond(const Scatter& scatter, int first_grain, int second_grain, const std::array<double, 3>& low,
                const std::array<double, 3>& high);
  double factor(Scattered what, const double* x) const;

 private:
  const Scatter& scatter_;
  double of_bond_[kScatteredProperties];
  std::vector<GaussianField> fields_;
  std::vector<int> field_of_rule_;  // -1: none
};

}  // namespace mpdem

#endif
