// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include <set>
#include <vector>

#include "lanes.h"
#include "mpm/gather.h"
#include "mpm/lane_by_lane.h"
#include "mpm/scatter.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::Vector;

constexpr double kH = 0.37, kInverse = 1.0 / kH;
constexpr int kNodes = 96;

// A block of points in one cell, the columns of its nodes scattered over an array.
template <class Type>
struct Block {
  static constexpr int S = Type::kSupport;
  vd X[3];
  int base[3], column[S * S];

  explicit Block(test::Random& random) {
    for (int d = 0; d < 3; ++d) base[d] = random.index(41) - 20;
    for (int l = 0; l < kLanes; ++l)
      for (int d = 0; d < 3; ++d) X[d][l] = kH * (base[d] + Type::kShift + random.uniform(0, 1));
    std::vector<int> starts;
    for (int i = 0; i + S <= kNodes; i += S) starts.push_back(i);
    for (int& c : column) {
      const int pick = random.index(static_cast<int>(starts.size()));
      c = starts[pick];
      starts.erase(starts.begin() + pick);
    }
  }
  Weights<Type> weights() const { return Weights<Type>(X, base, kInverse); }
  Vector point(int l) const { return {X[0][l], X[1][l], X[2][l]}; }

  template <class F>
  void for_nodes(F f) const {
    for (int i = 0; i < S; ++i)
      for (int j = 0; j < S; ++j)
        for (int k = 0; k < S; ++k) f(column[S * i + j] + k, i, j, k, Vector(kH * (base[0] + i), kH * (base[1] + j), kH * (base[2] + k)));
  }
};

template <class Type>
class Transfers : public ::testing::Test {};
using Types = ::testing::Types<LinearHat, QuadraticBspline, CubicBspline>;
TYPED_TEST_SUITE(Transfers, Types);

TEST(Weights, CellOfAPoint) {
  const double shift[3] = {cell_shift(Basis::linear), cell_shift(Basis::quadratic), cell_shift(Basis::cubic)};
  const double X[] = {0.01, 0.49, 0.51, -0.49, -0.51, 7.2};
  const int base[3][6] = {{0, 0, 0, -1, -1, 7}, {-1, -1, 0, -1, -2, 6}, {-1, -1, -1, -2, -2, 6}};
  for (int b = 0; b < 3; ++b)
    for (int i = 0; i < 6; ++i) EXPECT_EQ(support_base(X[i] * kH, kInverse, shift[b]), base[b][i]);
}

// The base is found by itself. Beside the same product a compiler would have no reason to contract it.
__attribute__((noinline)) int one_base(double X, double inverse_h) { return support_base(X, inverse_h, 0.5); }

// Bases are found as in penalty_links.cpp: of a lane, in all directions, which a compiler does at once.
struct ThreeDirections {
  vd X[3];
  double inverse_h;
};
__attribute__((noinline)) void three_bases(const ThreeDirections& p, int l, Basis basis, int* base) {
  for (int d = 0; d < 3; ++d) base[d] = support_base(p.X[d][l], p.inverse_h, cell_shift(basis));
}

// A point on a face of cells has to get the same cell everywhere, however the compiler arranges the arithmetic there.
TEST(Weights, CellOfAPointOnAFaceIsTheSameEverywhere) {
  test::Random random(7);
  int contracted = 0;
  for (int n = 0; n < 20000; ++n) {
    const double h = random.uniform(1e-5, 1e-3), inverse_h = 1.0 / h;
    const int cell = static_cast<int>(random.uniform(-60.0, 60.0));
    const double X = (cell + 0.5) * h;
    volatile double in_halves = X * (2.0 * inverse_h);
    const int expected = static_cast<int>(std::floor(0.5L * (static_cast<long double>(in_halves) - 1.0L)));
    ASSERT_EQ(one_base(X, inverse_h), expected) << "X " << X << ", h " << h;
    const ThreeDirections p{{splat(X), splat(X), splat(X)}, inverse_h};
    int base[3];
    three_bases(p, n % kLanes, Basis::quadratic, base);
    for (int d = 0; d < 3; ++d) ASSERT_EQ(base[d], expected) << "X " << X << ", h " << h;
    volatile double product = X * inverse_h;
    contracted += std::floor(std::fma(X, inverse_h, -0.5)) != std::floor(product - 0.5);
  }
  EXPECT_GT(contracted, 100);  // so that the numbers tell the two apart
}

// The bases have a shift of none, of one half and of one cell.
TEST(Weights, CellsOfTheBases) {
  for (double X : {-2.6, -2.4, -0.6, -0.4, 0.4, 0.6, 2.4, 2.6})
    for (double shift : {0.0, 0.5, 1.0})
      EXPECT_EQ(support_base(X * 0.25, 4.0, shift), static_cast<int>(std::floor(X - shift))) << X << ", shift " << shift;
}

TYPED_TEST(Transfers, PartitionOfUnityAndLinearReproduction) {
  test::Random random(71);
  test::Worst unity, linear, unity_slope, linear_slope, negative;
  for (int n = 0; n < 200; ++n) {
    const Block<TypeParam> b(random);
    const Weights<TypeParam> s = b.weights();
    for (int d = 0; d < 3; ++d)
      for (int l = 0; l < kLanes; ++l) {
        double sum = 0, moment = 0, slope = 0, slope_moment = 0;
        for (int i = 0; i < TypeParam::kSupport; ++i) {
          const double w = s.w[d][i][l], dw = s.dw[d][i][l], x = b.base[d] + i;  // in cells
          sum += w;
          moment += w * x;
          slope += dw * kH;
          slope_moment += dw * kH * x;
          negative.add(-w);
        }
        unity.add(std::fabs(sum - 1.0));
        linear.add(std::fabs(moment - b.X[d][l] * kInverse));
        unity_slope.add(std::fabs(slope));
        linear_slope.add(std::fabs(slope_moment - 1.0));
      }
  }
  expect_within(unity, 1e-13, "sum of weights - 1");
  expect_within(linear, 1e-13, "position");
  expect_within(unity_slope, 1e-13, "sum of gradients");
  expect_within(linear_slope, 1e-13, "gradient of the position");
  expect_within(negative, 0.0, "negative weight");
}

// Central differences are exact for a quadratic; those of a cubic are off by step^2/6 times its
// third derivative, at most 3/h^3.
TYPED_TEST(Transfers, GradientsAreThoseOfTheWeights) {
  test::Random random(72);
  test::Worst worst;
  const double step = 1e-3 * kH;
  for (int n = 0; n < 100; ++n) {
    const Block<TypeParam> b(random);
    Block<TypeParam> ahead = b, behind = b;
    for (int d = 0; d < 3; ++d) {
      ahead.X[d] += step;
      behind.X[d] -= step;
    }
    const Weights<TypeParam> s = b.weights(), a = ahead.weights(), p = behind.weights();
    for (int d = 0; d < 3; ++d)
      for (int i = 0; i < TypeParam::kSupport; ++i)
        for (int l = 0; l < kLanes; ++l) worst.add(kH * std::fabs((a.w[d][i][l] - p.w[d][i][l]) / (2 * step) - s.dw[d][i][l]));
  }
  expect_within(worst, TypeParam::kSupport == 4 ? 0.51e-6 : 2e-11, "gradient");
}

TYPED_TEST(Transfers, ValueAndGradientAreContinuousAcrossCells) {
  constexpr int S = TypeParam::kSupport;
  vd X[3];
  for (int d = 0; d < 3; ++d) X[d] = splat((2 + TypeParam::kShift) * kH);  // where the cells 1 and 2 meet
  const int low[3] = {1, 1, 1}, high[3] = {2, 2, 2};
  const Weights<TypeParam> a(X, low, kInverse), b(X, high, kInverse);
  for (int d = 0; d < 3; ++d) {
    EXPECT_NEAR(double(a.w[d][0][0]), 0.0, 1e-15);
    EXPECT_NEAR(double(b.w[d][S - 1][0]), 0.0, 1e-15);
    for (int i = 0; i < S - 1; ++i) {
      EXPECT_NEAR(double(a.w[d][i + 1][0]), double(b.w[d][i][0]), 1e-15);
      if (S > 2) {  // a linear hat function has a kink there
        EXPECT_NEAR(double(a.dw[d][i + 1][0]), double(b.dw[d][i][0]), 1e-14);
      }
    }
  }
}

// kAffine is the second moment, and where it has none the affine part is the gradient.
TYPED_TEST(Transfers, SecondMoment) {
  test::Random random(77);
  test::Worst worst;
  for (int n = 0; n < 100; ++n) {
    const Block<TypeParam> b(random);
    const Weights<TypeParam> s = b.weights(), m = with_moments(s, b.X, b.base, kH);
    for (int d = 0; d < 3; ++d)
      for (int l = 0; l < kLanes; ++l) {
        double first = 0, second = 0;
        for (int i = 0; i < TypeParam::kSupport; ++i) {
          const double r = (b.base[d] + i) * kH - b.X[d][l];
          first += m.dw[d][i][l];
          second += m.dw[d][i][l] * r;
          if (TypeParam::kAffine == 0.0) {
            const double t = b.X[d][l] * kInverse - b.base[d];
            worst.add(std::fabs(m.dw[d][i][l] - s.dw[d][i][l] * t * (1 - t) * kH * kH) / kH);
          }
        }
        worst.add(std::fabs(first) / kH);
        if (TypeParam::kAffine > 0.0) worst.add(std::fabs(second * TypeParam::kAffine / (kH * kH) - 1.0));
      }
  }
  expect_within(worst, 1e-12, "moments");
}

TYPED_TEST(Transfers, ScatterAffineIsValueAndMoment) {
  test::Random random(78);
  test::Worst worst;
  for (int n = 0; n < 100; ++n) {
    const Block<TypeParam> b(random);
    const Weights<TypeParam> s = b.weights(), m = with_moments(s, b.X, b.base, kH);
    vd T[3];
    Mat3<vd> A;
    for (int l = 0; l < kLanes; ++l) {
      test::set_matrix(A, l, random.general());
      for (int d = 0; d < 3; ++d) T[d][l] = random.uniform(-1, 1);
    }
    std::vector<double> one(3 * kNodes, 0.0), two(3 * kNodes, 0.0);
    scatter_affine(one.data(), b.column, m, T, A);
    scatter_value(two.data(), b.column, s, T);
    scatter_gradient(two.data(), b.column, m, A);
    for (int i = 0; i < 3 * kNodes; ++i) worst.add(std::fabs(one[i] - two[i]));
    vd v[3], w[3];
    const Mat3<vd> G = gather_gradient(one.data(), b.column, s), H = gather_value_and_gradient(one.data(), b.column, s, v);
    gather_value(one.data(), b.column, s, w);
    for (int l = 0; l < kLanes; ++l) {
      worst.add(kH * (test::matrix(G, l) - test::matrix(H, l)).norm());
      for (int d = 0; d < 3; ++d) worst.add(std::fabs(v[d][l] - w[d][l]));
    }
  }
  expect_within(worst, 1e-13, "difference");
}

TYPED_TEST(Transfers, GatherLinearFieldIsExact) {
  test::Random random(73);
  test::Worst value, gradient;
  for (int n = 0; n < 200; ++n) {
    const Block<TypeParam> b(random);
    const Matrix A = random.general();
    const Vector c = random.vector();
    std::vector<double> nodal(3 * kNodes, 1e30);
    b.for_nodes([&](int node, int, int, int, const Vector& x) {
      const Vector v = A * (x / kH) + c;
      for (int d = 0; d < 3; ++d) nodal[3 * node + d] = v[d];
    });
    const Weights<TypeParam> s = b.weights();
    vd out[3];
    gather_value(nodal.data(), b.column, s, out);
    const Mat3<vd> G = gather_gradient(nodal.data(), b.column, s);
    for (int l = 0; l < kLanes; ++l) {
      const Vector exact = A * (b.point(l) / kH) + c;
      value.add((Vector(out[0][l], out[1][l], out[2][l]) - exact).norm() / (b.point(l).norm() / kH + 1.0));
      gradient.add(kH * test::matrix(G, l) - A, b.point(l).norm() / kH + 1.0);
    }
  }
  expect_within(value, 1e-13, "value");
  expect_within(gradient, 1e-13, "gradient");
}

std::vector<double> random_field(test::Random& random, int n) {
  std::vector<double> v(n);
  for (double& x : v) x = random.uniform(-1, 1);
  return v;
}

TYPED_TEST(Transfers, GatherIsTheSumOverTheNodes) {
  test::Random random(74);
  test::Worst value, gradient;
  for (int n = 0; n < 100; ++n) {
    const Block<TypeParam> b(random);
    const std::vector<double> nodal = random_field(random, 3 * kNodes);
    const Weights<TypeParam> s = b.weights();
    vd out[3];
    gather_value(nodal.data(), b.column, s, out);
    const Mat3<vd> G = gather_gradient(nodal.data(), b.column, s);
    for (int l = 0; l < kLanes; ++l) {
      Vector u = Vector::Zero();
      Matrix g = Matrix::Zero();
      b.for_nodes([&](int node, int i, int j, int k, const Vector&) {
        const Vector v(nodal[3 * node], nodal[3 * node + 1], nodal[3 * node + 2]);
        const double x = s.w[0][i][l], y = s.w[1][j][l], z = s.w[2][k][l];
        u += x * y * z * v;
        g += v * Vector(s.dw[0][i][l] * y * z, x * s.dw[1][j][l] * z, x * y * s.dw[2][k][l]).transpose();
      });
      value.add((Vector(out[0][l], out[1][l], out[2][l]) - u).norm());
      gradient.add(test::matrix(G, l) - g, kInverse);
    }
  }
  expect_within(value, 1e-14, "value");
  expect_within(gradient, 1e-14, "gradient");
}

TYPED_TEST(Transfers, ScatterIsTheTransposeOfGather) {
  test::Random random(75);
  test::Worst value, gradient, scalar, outside;
  for (int n = 0; n < 200; ++n) {
    const Block<TypeParam> b(random);
    const Weights<TypeParam> s = b.weights();
    const std::vector<double> v = random_field(random, 3 * kNodes);
    std::vector<double> from_value(3 * kNodes, 0.0), from_gradient(3 * kNodes, 0.0), from_scalar(kNodes, 0.0);
    vd T[3], m, u[3];
    Mat3<vd> P;
    for (int l = 0; l < kLanes; ++l) {
      test::set_matrix(P, l, random.general());
      for (int d = 0; d < 3; ++d) T[d][l] = random.uniform(-1, 1);
      m[l] = random.uniform(0, 1);
    }
    scatter_value(from_value.data(), b.column, s, T);
    scatter_gradient(from_gradient.data(), b.column, s, P);
    scatter_scalar(from_scalar.data(), b.column, s, m);
    gather_value(v.data(), b.column, s, u);
    const Mat3<vd> G = gather_gradient(v.data(), b.column, s);
    double at_points = 0, at_points_gradient = 0, at_nodes = 0, at_nodes_gradient = 0;
    for (int d = 0; d < 3; ++d) at_points += sum_lanes(T[d] * u[d]);
    for (int i = 0; i < 9; ++i) at_points_gradient += sum_lanes(P.a[i / 3][i % 3] * G.a[i / 3][i % 3]);
    for (int i = 0; i < 3 * kNodes; ++i) {
      at_nodes += from_value[i] * v[i];
      at_nodes_gradient += from_gradient[i] * v[i];
    }
    value.add(std::fabs(at_points - at_nodes));
    gradient.add(kH * std::fabs(at_points_gradient - at_nodes_gradient));
    double total = 0;
    Vector moment = Vector::Zero(), exact = Vector::Zero();
    b.for_nodes([&](int node, int, int, int, const Vector& x) {
      total += from_scalar[node];
      moment += from_scalar[node] * x;
    });
    for (int l = 0; l < kLanes; ++l) exact += m[l] * b.point(l);
    scalar.add(std::fabs(total - sum_lanes(m)));
    scalar.add((moment - exact).norm() / 30.0);
    // nothing goes to nodes of others
    std::vector<char> mine(kNodes, 0);
    b.for_nodes([&](int node, int, int, int, const Vector&) { mine[node] = 1; });
    for (int node = 0; node < kNodes; ++node)
      if (!mine[node])
        for (int d = 0; d < 3; ++d)
          outside.add(std::fabs(from_value[3 * node + d]) + std::fabs(from_gradient[3 * node + d]) + from_scalar[node]);
  }
  expect_within(value, 1e-13, "value");
  expect_within(gradient, 1e-13, "gradient");
  expect_within(scalar, 1e-13, "scalar: sum and first moment");
  expect_within(outside, 0.0, "other nodes");
}

TYPED_TEST(Transfers, ScatterAddsToWhatIsThere) {
  test::Random random(76);
  const Block<TypeParam> b(random);
  const Weights<TypeParam> s = b.weights();
  vd T[3];
  for (vd& t : T)
    for (int l = 0; l < kLanes; ++l) t[l] = random.uniform(-1, 1);
  std::vector<double> once(3 * kNodes, 0.0), twice = random_field(random, 3 * kNodes);
  const std::vector<double> before = twice;
  scatter_value(once.data(), b.column, s, T);
  scatter_value(twice.data(), b.column, s, T);
  for (int i = 0; i < 3 * kNodes; ++i) EXPECT_NEAR(twice[i], before[i] + once[i], 1e-15);
}

// Points of different cells, each with columns of its own, some of them shared: sums over the nodes one by one.
TYPED_TEST(Transfers, LaneByLane) {
  constexpr int S = TypeParam::kSupport;
  test::Random random(83);
  test::Worst gathered, scattered;
  for (int n = 0; n < 50; ++n) {
    std::vector<Block<TypeParam>> of_lane;
    std::set<int> first;  // nodes, which are those of one cell
    while (of_lane.size() < kLanes) {
      const Block<TypeParam> b(random);
      if (first.insert(b.column[0]).second) of_lane.push_back(b);
    }
    of_lane[3] = of_lane[2];
    if (n % 3 == 1) of_lane[4] = of_lane[5] = of_lane[2];
    if (n % 3 == 2) of_lane[0] = of_lane[1] = of_lane[4] = of_lane[5] = of_lane[6] = of_lane[2];
    vd X[3], T[3], out[3];
    vint base[3];
    int column[kLanes * S * S];
    for (int l = 0; l < kLanes; ++l) {
      for (int d = 0; d < 3; ++d) {
        X[d][l] = of_lane[l].X[d][l];
        base[d][l] = of_lane[l].base[d];
        T[d][l] = random.uniform(-1, 1);
      }
      std::copy(of_lane[l].column, of_lane[l].column + S * S, column + S * S * l);
    }
    const Weights<TypeParam> s(X, base, kInverse);
    std::vector<double> nodal(3 * kNodes), sum(3 * kNodes, 0.5), expected(sum);
    for (double& v : nodal) v = random.uniform(-1, 1);
    const std::uint8_t which = static_cast<std::uint8_t>(random.index(256));
    gather_value_by_lane(nodal.data(), which, column, s, out);
    scatter_value_by_lane(sum.data(), which, column, s, T);
    for (int l = 0; l < kLanes; ++l) {
      double value[3] = {0, 0, 0};
      const Weights<TypeParam> w = of_lane[l].weights();
      of_lane[l].for_nodes([&](int node, int i, int j, int k, const Vector&) {
        if (!(which >> l & 1)) return;
        const double weight = w.w[0][i][l] * w.w[1][j][l] * w.w[2][k][l];
        for (int c = 0; c < 3; ++c) {
          value[c] += weight * nodal[3 * node + c];
          expected[3 * node + c] += weight * T[c][l];
        }
      });
      for (int c = 0; c < 3; ++c) gathered.add(std::fabs(out[c][l] - value[c]));
    }
    for (std::size_t i = 0; i < sum.size(); ++i) scattered.add(std::fabs(sum[i] - expected[i]));
  }
  expect_within(gathered, 1e-15, "value at a lane");
  expect_within(scattered, 3e-15, "sum at a node");
}

}  // namespace
}  // namespace mpdem
