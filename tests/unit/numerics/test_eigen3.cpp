// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "numerics/eigen3.h"

#include <algorithm>
#include <functional>
#include <vector>

#include "damage_reference.h"

namespace mpdem {
namespace {

using test::Matrix;
using test::Vector;

// Runs over the tensors eight at a time.
void for_blocks(const std::vector<Matrix>& all, const std::function<void(const Sym3<vd>&, int first, int count)>& f) {
  for (std::size_t i = 0; i < all.size(); i += kLanes) {
    Sym3<vd> m = test::on_all_lanes(Matrix::Zero());
    const int count = static_cast<int>(std::min<std::size_t>(kLanes, all.size() - i));
    for (int l = 0; l < count; ++l) test::set_tensor(m, l, all[i + l]);
    f(m, static_cast<int>(i), count);
  }
}

void expect_decomposed(const std::vector<Matrix>& all, double tolerance) {
  test::Worst values, axes, rebuilt, top;
  for_blocks(all, [&](const Sym3<vd>& m, int first, int count) {
    const Spectral s = eigen(m);
    const Sym3<vd> again = compose(s.axes, s.value);
    const vd highest = largest(s);
    for (int l = 0; l < count; ++l) {
      const Matrix& a = all[first + l];
      const double norm = std::max(a.norm(), 1e-300);
      Vector v(s.value[0][l], s.value[1][l], s.value[2][l]);
      const Matrix q = test::matrix(s.axes, l);
      std::sort(v.data(), v.data() + 3);
      const Vector exact = Eigen::SelfAdjointEigenSolver<Matrix>(a / norm).eigenvalues();
      values.add((v / norm - exact).cwiseAbs().maxCoeff());
      top.add(std::fabs(highest[l] / norm - exact[2]));
      axes.add(q.transpose() * q - Matrix::Identity(), 1.0);
      rebuilt.add(test::tensor(again, l) - a, norm);
    }
  });
  expect_within(values, tolerance, "eigenvalues");
  expect_within(top, tolerance, "largest");
  expect_within(axes, tolerance, "orthonormal axes");
  expect_within(rebuilt, tolerance, "composition");
}

void expect_positive_part(const std::vector<Matrix>& all, double tolerance) {
  test::Worst worst, squares;
  for_blocks(all, [&](const Sym3<vd>& m, int first, int count) {
    const Sym3<vd> p = positive_part(m);
    const vd square = square_of_positive_part(m);
    for (int l = 0; l < count; ++l) {
      const Matrix& a = all[first + l];
      const double norm = a.norm() > 0.0 ? a.norm() : 1.0;
      const Matrix exact = norm * test::positive_part(a / norm);
      std::ostringstream where;
      where << "eigenvalues " << Eigen::SelfAdjointEigenSolver<Matrix>(a / norm).eigenvalues().transpose() << " of " << norm;
      worst.add(test::tensor(p, l) - exact, norm, where.str());
      if (norm > 1e-140 && norm < 1e140) squares.add(std::fabs(square[l] - exact.squaredNorm()) / (norm * norm), where.str());
    }
  });
  expect_within(worst, tolerance, "positive part");
  expect_within(squares, tolerance, "square of the positive part");
}

std::vector<Matrix> random_tensors(std::uint64_t seed, int n) {
  test::Random random(seed);
  std::vector<Matrix> all;
  for (int i = 0; i < n; ++i) all.push_back(random.sym());
  return all;
}

// Two or three equal principal values, zero among them, of either sign; random axes.
std::vector<Matrix> repeated_tensors() {
  test::Random random(22);
  std::vector<Matrix> all;
  for (int i = 0; i < 2000; ++i) {
    const double a = random.uniform(-1, 1), b = random.index(3) == 0 ? 0.0 : random.uniform(-1, 1);
    const Vector choices[] = {{a, a, b}, {a, b, b}, {a, a, a}, {a, 0, 0}, {a, -a, 0}, {a, a, -a}};
    all.push_back(random.with_values(choices[random.index(6)]));
  }
  return all;
}

std::vector<Matrix> diagonal_tensors() {
  test::Random random(23);
  std::vector<Matrix> all{Matrix::Zero(), Matrix::Identity(), -Matrix::Identity()};
  for (int i = 0; i < 300; ++i) {
    Vector v;
    for (int d = 0; d < 3; ++d) v[d] = random.index(3) - 1.0;
    if (i % 2) v = v.cwiseProduct(random.vector());
    all.push_back(v.asDiagonal());
  }
  return all;
}

std::vector<Matrix> scaled_tensors() {
  std::vector<Matrix> all = random_tensors(24, 2000);
  test::Random random(25);
  for (Matrix& m : all) m *= std::pow(10.0, random.uniform(-60, 60));
  return all;
}

// Two principal values differ by 1e-16 ... 1e-2 of their size.
std::vector<Matrix> nearly_double_tensors() {
  test::Random random(26);
  std::vector<Matrix> all;
  for (int i = 0; i < 8000; ++i) {
    const double a = random.uniform(-1, 1), split = std::pow(10.0, random.uniform(-16, -2));
    const double b = random.index(2) ? random.uniform(-1, 1) : -a * (1.0 + split);
    all.push_back(random.with_values({a, a * (1.0 + split), b}));
  }
  return all;
}

// One or two principal values are 1e-16 ... 1e-2 of the others, of either sign.
std::vector<Matrix> nearly_singular_tensors() {
  test::Random random(27);
  std::vector<Matrix> all;
  const auto small = [&] { return (random.index(2) ? 1.0 : -1.0) * std::pow(10.0, random.uniform(-16, -2)); };
  for (int i = 0; i < 8000; ++i) {
    const double a = random.uniform(-1, 1), b = random.index(2) ? small() : random.uniform(-1, 1);
    all.push_back(random.with_values({a, b, small()}));
  }
  return all;
}

// Principal values over sixteen decades, axes from next to the coordinates' to any.
std::vector<Matrix> graded_tensors() {
  test::Random random(28);
  std::vector<Matrix> all;
  for (int i = 0; i < 20000; ++i) {
    Vector v;
    for (int d = 0; d < 3; ++d) v[d] = (random.index(2) ? 1.0 : -1.0) * std::pow(10.0, random.uniform(-16, 0));
    const Matrix q = test::rotation(random.direction(), std::pow(10.0, random.uniform(-16, 0.5)));
    all.push_back(test::symmetric(q * v.asDiagonal() * q.transpose()));
  }
  return all;
}

TEST(Eigen3, RandomTensors) { expect_decomposed(random_tensors(21, 4000), 1e-14); }
TEST(Eigen3, RepeatedValues) { expect_decomposed(repeated_tensors(), 1e-14); }
TEST(Eigen3, NearlyDoubleValues) { expect_decomposed(nearly_double_tensors(), 1e-14); }
TEST(Eigen3, NearlySingular) { expect_decomposed(nearly_singular_tensors(), 1e-14); }
TEST(Eigen3, GradedValues) { expect_decomposed(graded_tensors(), 1e-14); }
TEST(Eigen3, TinyAndHuge) { expect_decomposed(scaled_tensors(), 1e-14); }

TEST(Eigen3, DiagonalTensorsAreExact) {
  const std::vector<Matrix> all = diagonal_tensors();
  for_blocks(all, [&](const Sym3<vd>& m, int first, int count) {
    const Spectral s = eigen(m);
    for (int l = 0; l < count; ++l) {
      EXPECT_EQ(test::matrix(s.axes, l), Matrix(Matrix::Identity()));
      for (int d = 0; d < 3; ++d) EXPECT_EQ(double(s.value[d][l]), all[first + l](d, d));
    }
  });
}

TEST(PositivePart, RandomTensors) { expect_positive_part(random_tensors(31, 8000), 1e-12); }
TEST(PositivePart, RepeatedValues) { expect_positive_part(repeated_tensors(), 1e-12); }
TEST(PositivePart, DiagonalTensors) { expect_positive_part(diagonal_tensors(), 1e-12); }
TEST(PositivePart, NearlyDoubleValues) { expect_positive_part(nearly_double_tensors(), 1e-12); }
TEST(PositivePart, NearlySingular) { expect_positive_part(nearly_singular_tensors(), 1e-12); }
TEST(PositivePart, GradedValues) { expect_positive_part(graded_tensors(), 1e-12); }
TEST(PositivePart, TinyAndHuge) { expect_positive_part(scaled_tensors(), 1e-12); }

// A little tension beside a large compression: what the square of the whole loses by a difference.
TEST(PositivePart, SquareBesideALargeNegativeValue) {
  test::Random random(41);
  for (double ratio : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) {
    std::vector<Matrix> all;
    std::vector<double> exact;
    for (int i = 0; i < 400; ++i) {
      const double a = ratio * random.uniform(0.1, 1), b = ratio * random.uniform(0.1, 1);
      all.push_back(random.with_values({-1.0, a, b}));
      exact.push_back(a * a + b * b);
    }
    test::Worst worst;
    for_blocks(all, [&](const Sym3<vd>& m, int first, int count) {
      const vd square = square_of_positive_part(m);
      for (int l = 0; l < count; ++l) worst.add(std::fabs(square[l] / exact[first + l] - 1.0));
    });
    expect_within(worst, 1e-14 / (ratio * std::max(ratio, 1e-2)), "square of the positive part, relative");
  }
}

TEST(PositivePart, SquareOfNanIsNan) {
  test::Random random(42);
  for (int k = 0; k < 6; ++k) {
    Sym3<vd> m = test::on_all_lanes(random.sym());
    vd* const component[] = {&m.xx, &m.yy, &m.zz, &m.yz, &m.xz, &m.xy};
    (*component[k])[3] = std::nan("");
    const vd square = square_of_positive_part(m);
    for (int l = 0; l < kLanes; ++l) EXPECT_EQ(std::isnan(square[l]), l == 3) << k;
  }
}

// The slow path for one lane is not to change what the others get.
TEST(PositivePart, LanesAreIndependent) {
  const std::vector<Matrix> all = random_tensors(32, 64), odd = nearly_double_tensors();
  test::Worst worst;
  for (std::size_t i = 0; i + kLanes <= all.size(); i += kLanes) {
    Sym3<vd> plain{}, mixed{};
    for (int l = 0; l < kLanes; ++l) {
      test::set_tensor(plain, l, all[i + l]);
      test::set_tensor(mixed, l, l % 2 ? odd[i + l] : all[i + l]);
    }
    const Sym3<vd> p = positive_part(plain), q = positive_part(mixed);
    for (int l = 0; l < kLanes; l += 2) worst.add(test::tensor(p, l) - test::tensor(q, l), 1.0);
  }
  expect_within(worst, 1e-15, "change");
}

}  // namespace
}  // namespace mpdem
