// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Points to grid: the transposes of gather.h. The eight points of a block share their nodes,
// so the lanes are summed in registers and a node is touched once a block.
#ifndef MPDEM_SCATTER_H
#define MPDEM_SCATTER_H

#include "../numerics/tensor3.h"
#include "basis.h"

namespace mpdem {

namespace detail {

// Adds the lane sums of 3 kSupport vectors to as many consecutive doubles, column by column.
// Reductions run eight at a time; what is over of a column waits until there are eight.
template <class Type>
class ColumnSums {
 public:
  static constexpr int S = Type::kSupport, kValues = 3 * S;

  ColumnSums(double* nodal, const int* column) : nodal_(nodal), column_(column) {}

  // `values` holds kValues vectors, or eight of which the last are zero if those are fewer.
  void add(int c, const vd* values) {
    double* p = place(c);
    const vd s = sum_lanes_of_8(values);
    for (int l = 0; l < kFirst; ++l) p[l] += s[l];
    if constexpr (S == 3) {
      rest_[c] = values[8];
    } else if constexpr (S == 4) {
      for (int l = 0; l < 4; ++l) rest_[4 * (c % 2) + l] = values[8 + l];
      if (c % 2 == 1) {
        const vd t = sum_lanes_of_8(rest_);
        double* q = place(c - 1);
        for (int l = 0; l < 4; ++l) q[8 + l] += t[l];
        for (int l = 0; l < 4; ++l) p[8 + l] += t[4 + l];
      }
    }
  }

  void finish() {
    if constexpr (S == 3) {
      const vd s = sum_lanes_of_8(rest_);
      for (int l = 0; l < 8; ++l) place(l)[8] += s[l];
      place(8)[8] += sum_lanes(rest_[8]);
    }
  }

 private:
  static constexpr int kFirst = kValues < 8 ? kValues : 8;
  double* place(int c) const { return nodal_ + 3 * static_cast<long>(column_[c]); }
  double* nodal_;
  const int* column_;
  vd rest_[9];
};

}  // namespace detail

// nodal_Ic += sum over the points of T.a[c][d] dN_I/dX_d
template <class Type>
inline void scatter_gradient(double* __restrict nodal, const int* column, const Weights<Type>& s, const Mat3<vd>& T) {
  constexpr int S = Type::kSupport;
  detail::ColumnSums<Type> sums(nodal, column);
  for (int i = 0; i < S; ++i) {
    vd A[3], B[3], C[3];
    for (int c = 0; c < 3; ++c) {
      A[c] = T.a[c][0] * s.dw[0][i];
      B[c] = T.a[c][1] * s.w[0][i];
      C[c] = T.a[c][2] * s.w[0][i];
    }
    for (int j = 0; j < S; ++j) {
      vd values[S == 2 ? 8 : 3 * S]{};
      for (int c = 0; c < 3; ++c) {
        const vd a = A[c] * s.w[1][j] + B[c] * s.dw[1][j];
        const vd b = C[c] * s.w[1][j];
        for (int k = 0; k < S; ++k) values[3 * k + c] = a * s.w[2][k] + b * s.dw[2][k];
      }
      sums.add(S * i + j, values);
    }
  }
  sums.finish();
}

// nodal_Ic += sum over the points of T[c] N_I
template <class Type>
inline void scatter_value(double* __restrict nodal, const int* column, const Weights<Type>& s, const vd* T) {
  constexpr int S = Type::kSupport;
  detail::ColumnSums<Type> sums(nodal, column);
  for (int i = 0; i < S; ++i)
    for (int j = 0; j < S; ++j) {
      const vd wij = s.w[0][i] * s.w[1][j];
      vd values[S == 2 ? 8 : 3 * S]{};
      for (int c = 0; c < 3; ++c) {
        const vd a = T[c] * wij;
        for (int k = 0; k < S; ++k) values[3 * k + c] = a * s.w[2][k];
      }
      sums.add(S * i + j, values);
    }
  sums.finish();
}

// nodal_Ic += sum over the points of T[c] N_I + A.a[c][d] (X_Id - X_d) N_I, the affine part
// with `moment` from with_moments().
template <class Type>
inline void scatter_affine(double* __restrict nodal, const int* column, const Weights<Type>& moment, const vd* T,
                           const Mat3<vd>& A) {
  constexpr int S = Type::kSupport;
  detail::ColumnSums<Type> sums(nodal, column);
  for (int i = 0; i < S; ++i) {
    vd a[3], b[3], c3[3];
    for (int c = 0; c < 3; ++c) {
      a[c] = T[c] * moment.w[0][i] + A.a[c][0] * moment.dw[0][i];
      b[c] = A.a[c][1] * moment.w[0][i];
      c3[c] = A.a[c][2] * moment.w[0][i];
    }
    for (int j = 0; j < S; ++j) {
      vd values[S == 2 ? 8 : 3 * S]{};
      for (int c = 0; c < 3; ++c) {
        const vd p = a[c] * moment.w[1][j] + b[c] * moment.dw[1][j];
        const vd q = c3[c] * moment.w[1][j];
        for (int k = 0; k < S; ++k) values[3 * k + c] = p * moment.w[2][k] + q * moment.dw[2][k];
      }
      sums.add(S * i + j, values);
    }
  }
  sums.finish();
}

// Scalar field: nodal_I += sum over the points of T N_I.
template <class Type>
inline void scatter_scalar(double* __restrict nodal, const int* column, const Weights<Type>& s, vd T) {
  constexpr int S = Type::kSupport;
  for (int i = 0; i < S; ++i)
    for (int j = 0; j < S; ++j) {
      const vd a = T * s.w[0][i] * s.w[1][j];
      vd values[8]{};
      for (int k = 0; k < S; ++k) values[k] = a * s.w[2][k];
      const vd r = sum_lanes_of_8(values);
      double* p = nodal + column[S * i + j];
      for (int k = 0; k < S; ++k) p[k] += r[k];
    }
}

}  // namespace mpdem

#endif
