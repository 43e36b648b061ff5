// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Symmetric positive definite matrix of unknowns in groups, each of which is coupled with itself and with the groups
// before and after it. Cholesky factorisation with dense groups. The work is about 7/3 of the sum of the cubes of their
// sizes, and the memory twice the sum of their squares.
#ifndef MPDEM_NUMERICS_BLOCK_TRIDIAGONAL_H
#define MPDEM_NUMERICS_BLOCK_TRIDIAGONAL_H

#include <Eigen/Dense>
#include <vector>

namespace mpdem {

class BlockTridiagonal {
 public:
  BlockTridiagonal() = default;
  // All entries are zero at first.
  explicit BlockTridiagonal(const std::vector<int>& sizes) {
    for (std::size_t g = 0; g < sizes.size(); ++g) {
      diagonal_.push_back(Eigen::MatrixXd::Zero(sizes[g], sizes[g]));
      if (g + 1 < sizes.size()) below_.push_back(Eigen::MatrixXd::Zero(sizes[g + 1], sizes[g]));
    }
  }

  // The entries of a group, of which only the lower triangle counts, and those of the rows of group g + 1 and the
  // columns of group g.
  Eigen::MatrixXd& diagonal(int g) { return diagonal_[g]; }
  Eigen::MatrixXd& below(int g) { return below_[g]; }

  // Replaces the matrix by its factor. A row of zeros counts as one of the unit matrix. Returns false if a pivot is not
  // above `least` times the entry on the diagonal. The factor is of no use then.
  bool factorise(double least) {
    for (std::size_t g = 0; g < diagonal_.size(); ++g) {
      Eigen::MatrixXd& D = diagonal_[g];
      for (int i = 0; i < D.rows(); ++i)
        if (D(i, i) == 0.0) D(i, i) = 1.0;
    }
    std::vector<Eigen::VectorXd> of_matrix;
    for (const Eigen::MatrixXd& D : diagonal_) of_matrix.push_back(D.diagonal());
    for (std::size_t g = 0; g < diagonal_.size(); ++g) {
      Eigen::MatrixXd& D = diagonal_[g];
      if (g > 0) D.selfadjointView<Eigen::Lower>().rankUpdate(below_[g - 1], -1.0);
      Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(D);  // in place
      if (factor.info() != Eigen::Success || !(D.diagonal().array().square() > least * of_matrix[g].array()).all()) return false;
      if (g < below_.size()) D.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below_[g]);
    }
    return true;
  }

  // Replaces x by the solution for the right-hand side x, ordered by group. Call factorise() before.
  void solve(Eigen::VectorXd& x) const {
    Eigen::Index at = 0;
    for (std::size_t g = 0; g < diagonal_.size(); ++g) {
      auto part = x.segment(at, diagonal_[g].rows());
      diagonal_[g].triangularView<Eigen::Lower>().solveInPlace(part);
      at += part.size();
      if (g < below_.size()) x.segment(at, below_[g].rows()).noalias() -= below_[g] * part;
    }
    for (std::size_t g = diagonal_.size(); g-- > 0;) {
      at -= diagonal_[g].rows();
      auto part = x.segment(at, diagonal_[g].rows());
      if (g < below_.size()) part.noalias() -= below_[g].transpose() * x.segment(at + part.size(), below_[g].rows());
      diagonal_[g].triangularView<Eigen::Lower>().transpose().solveInPlace(part);
    }
  }

 private:
  std::vector<Eigen::MatrixXd> diagonal_, below_;
};

}  // namespace mpdem

#endif
