// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// numerics/block_tridiagonal.h against a dense matrix.
#include "numerics/block_tridiagonal.h"

#include <gtest/gtest.h>

namespace mpdem {
namespace {

struct Sample {
  std::vector<int> sizes{3, 6, 1, 4};
  BlockTridiagonal matrix{sizes};
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(14, 14);
  Sample() {
    int at = 0;
    for (std::size_t g = 0; g < sizes.size(); ++g) {
      const int n = sizes[g];
      for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j) dense(at + i, at + j) = i == j ? 12.0 + i : std::sin(7.0 * i + 3.0 * j + static_cast<double>(g));
      matrix.diagonal(static_cast<int>(g)) = dense.block(at, at, n, n);
      if (g + 1 < sizes.size()) {
        for (int i = 0; i < sizes[g + 1]; ++i)
          for (int j = 0; j < n; ++j) dense(at + n + i, at + j) = std::cos(5.0 * i - 2.0 * j);
        matrix.below(static_cast<int>(g)) = dense.block(at + n, at, sizes[g + 1], n);
      }
      at += n;
    }
    dense = Eigen::MatrixXd(dense.selfadjointView<Eigen::Lower>());
  }
};

TEST(BlockTridiagonal, SolvesLikeADenseMatrix) {
  Sample s;
  ASSERT_TRUE(s.matrix.factorise(1e-8));
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(14, -1.0, 2.0);
  const Eigen::VectorXd b = x;
  s.matrix.solve(x);
  EXPECT_LT((s.dense * x - b).norm(), 1e-12);
}

TEST(BlockTridiagonal, TellsWhatIsNotPositive) {
  Sample zero, negative, nearly;
  // a row of zeros is left out
  zero.matrix.diagonal(2)(0, 0) = 0.0;
  zero.matrix.below(1).setZero();
  zero.matrix.below(2).setZero();
  ASSERT_TRUE(zero.matrix.factorise(1e-8));
  Eigen::VectorXd x = Eigen::VectorXd::Ones(14);
  x[9] = 0.0;
  zero.matrix.solve(x);
  EXPECT_EQ(x[9], 0.0);
  negative.matrix.diagonal(3)(1, 1) = -1.0;
  EXPECT_FALSE(negative.matrix.factorise(1e-8));
  // two equal rows but for a small number
  Eigen::MatrixXd& D = nearly.matrix.diagonal(0);
  D << 1.0, 0.0, 0.0, 1.0, 1.0 + 1e-10, 0.0, 0.0, 0.0, 1.0;
  nearly.matrix.below(0).setZero();
  EXPECT_FALSE(nearly.matrix.factorise(1e-8));
}

}  // namespace
}  // namespace mpdem
