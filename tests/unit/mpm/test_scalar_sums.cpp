// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Sums of scalars against sums over each point and node, with splines in the form of truncated powers.
#include "mpm/scalar_sums.h"

#include "cement.h"

namespace mpdem {
namespace {

using test::Cement;
using test::kCell;
using test::Vector;

// Centred B-spline of this degree at t, in cells: sum of (-1)^k C(degree + 1, k) (t + (degree + 1)/2 - k)_+^degree / degree!
// It is even, and on its left side few terms are not zero.
double spline(int degree, double t) {
  t = -std::fabs(t);
  if (t <= -0.5 * (degree + 1)) return 0.0;
  double sum = 0.0, factor = 1.0, factorial = 1.0;
  for (int k = 0; k <= degree + 1; ++k) {
    sum += factor * std::pow(std::max(0.0, t + 0.5 * (degree + 1) - k), degree);
    factor *= -static_cast<double>(degree + 1 - k) / (k + 1);
    if (k > 1 && k <= degree) factorial *= k;
  }
  return sum / factorial;
}

enum class Places { lattice, some_moved, anywhere };

// Points of a bond 3 by 4 cells across, whose columns are 1 to 22 cells long. Some places have two points.
std::vector<Vector> body(test::Random& random, Places places) {
  std::vector<Vector> X;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 8; ++j) {
      const int first = random.index(4) - 2, length = 2 + random.index(41);
      for (int k = first; k < first + length; ++k) {
        X.push_back(0.5 * kCell * Vector(i + 0.5, j - 3.5, k + 0.5));
        if (places == Places::anywhere || (places == Places::some_moved && random.index(5) == 0)) X.back() += 0.2 * kCell * random.vector();
        if (random.index(20) == 0) X.push_back(Vector(X.back()));
      }
    }
  return X;
}

class ScalarSumsOfPoints : public ::testing::TestWithParam<std::tuple<Basis, Places, bool>> {
 protected:
  double weight(int node, int b, int l) const {
    const PointBlock& p = c.points.blocks[b];
    const BlockMeta& m = c.points.meta[b];
    const Key& key = c.grid.keys[node];
    if (key.field() != field_of(m.row, m.layer)) return 0.0;
    double w = 1.0;
    for (int d = 0; d < 3 && w != 0.0; ++d) w *= spline(support(c.grid.basis) - 1, p.X[d][l] / kCell - key.at(d));
    return w;
  }
  // sum_I of w(node I, point) f(point) over the intact points
  template <class F>
  std::vector<double> direct(F f) const {
    std::vector<double> sum(c.grid.size(), 0.0);
    c.for_points([&](int b, int l) {
      if (c.points.meta[b].failed >> l & 1) return;
      const double value = f(b, l);
      for (int n = 0; n < c.grid.size(); ++n) sum[n] += weight(n, b, l) * value;
    });
    return sum;
  }
  // Adds to sums that are not zero, and to the room beyond the nodes.
  template <class F>
  void expect_sums(const std::vector<double>& expected, F add, const char* what) {
    std::vector<double> sum(c.grid.size() + ScalarSums::kRoom, 0.25 * volume);
    add(sum.data());
    test::Worst worst;
    for (std::size_t n = 0; n < sum.size(); ++n)
      worst.add(std::fabs(sum[n] - 0.25 * volume - (n < expected.size() ? expected[n] : 0.0)) / volume);
    expect_within(worst, 2e-14, what);
  }

  test::Random random{801};
  double volume = std::pow(kCell, 3) / 8;
  std::vector<Vector> X = body(random, std::get<1>(GetParam()));
  std::vector<int> layer = [this] {
    std::vector<int> p;
    for (const Vector& x : X) p.push_back(x[0] + 0.3 * x[2] > 2.1 * kCell);
    return p;
  }();
  Cement c{kCell, X, volume, Eigen::Quaterniond::Identity(), std::get<0>(GetParam()), 0, layer, std::get<2>(GetParam())};
};

TEST_P(ScalarSumsOfPoints, AreThoseOfEachPoint) {
  ScalarSums sums;
  for (const char* state : {"whole", "some failed"}) {
    SCOPED_TRACE(state);
    if (state == std::string("some failed"))
      c.for_points([&](int b, int l) {
        if (random.index(6) == 0 || c.points.blocks[b].X[1][l] > 1.5 * kCell) c.points.meta[b].failed |= static_cast<std::uint8_t>(1u << l);
      });
    c.for_points([&](int b, int l) { c.points.blocks[b].volume[l] = volume * random.uniform(0.2, 1.0); });
    sums.find(c.points, c.grid);
    if (std::get<1>(GetParam()) == Places::lattice) {
      EXPECT_EQ(sums.single(), 0);
    } else {
      EXPECT_GT(sums.single(), 100);
    }
    const auto volume_of = [&](int b, int l) { return c.points.blocks[b].volume[l]; };
    expect_sums(
        direct(volume_of), [&](double* sum) { sums.add_volumes(sum); }, "volumes");

    std::vector<vd> values(c.points.blocks.size());
    for (vd& v : values)
      for (int l = 0; l < kLanes; ++l) v[l] = volume * random.uniform(-1, 1);
    expect_sums(
        direct([&](int b, int l) { return values[b][l]; }), [&](double* sum) { sums.add_values([&](int b) { return values[b]; }, sum); },
        "values");

    std::vector<double> mean(c.grid.size() + ScalarSums::kRoom, 1e3);
    for (int n = 0; n < c.grid.size(); ++n) mean[n] = random.uniform(-1, 1);
    const auto interpolated = [&](int b, int l) {
      double f = 0.0;
      for (int n = 0; n < c.grid.size(); ++n) f += weight(n, b, l) * mean[n];
      return volume_of(b, l) * f;
    };
    expect_sums(
        direct(interpolated), [&](double* sum) { sums.add_means(mean.data(), sum); }, "means");
  }
}

std::string name_of_test(const ::testing::TestParamInfo<ScalarSumsOfPoints::ParamType>& info) {
  const auto [basis, places, joined] = info.param;
  const char* of_places[] = {"lattice", "some_moved", "anywhere"};
  return std::string(name_of(basis)) + "_" + of_places[static_cast<int>(places)] + (joined ? "_joined" : "");
}
INSTANTIATE_TEST_SUITE_P(ScalarSums, ScalarSumsOfPoints,
                         ::testing::Combine(::testing::Values(Basis::linear, Basis::quadratic, Basis::cubic),
                                            ::testing::Values(Places::lattice, Places::some_moved, Places::anywhere), ::testing::Bool()),
                         name_of_test);

}  // namespace
}  // namespace mpdem
