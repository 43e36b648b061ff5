// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Points to grid: the transposes of gather.h. The eight points of a block share their nodes. So the lanes are summed in
// registers, and a node is updated once for each block.
#ifndef MPDEM_MPM_SCATTER_H
#define MPDEM_MPM_SCATTER_H

#include <cstring>

#include "../numerics/tensor3.h"
#include "gather.h"

namespace mpdem {

namespace detail {

// p[l] += s[first + l] for all l below the number of lanes of a Part.
template <class Part>
inline void add_part(double* p, const vd& s, int first) {
  Part sum, more;
  std::memcpy(&sum, p, sizeof sum);
  std::memcpy(&more, reinterpret_cast<const char*>(&s) + first * sizeof(double), sizeof more);
  sum += more;
  std::memcpy(p, &sum, sizeof sum);
}

// p[l] += s[first + l] for l below N, with vector instructions. The compiler would split a loop into single lanes.
template <int N>
inline void add_lanes(double* p, const vd& s, int first = 0) {
  using v2 = double __attribute__((vector_size(16)));
  using v4 = double __attribute__((vector_size(32)));
  if constexpr (N >= 8) {
    add_part<vd>(p, s, first);
  } else if constexpr (N >= 4) {
    add_part<v4>(p, s, first);
    add_lanes<N - 4>(p + 4, s, first + 4);
  } else if constexpr (N >= 2) {
    add_part<v2>(p, s, first);
    add_lanes<N - 2>(p + 2, s, first + 2);
  } else if constexpr (N == 1) {
    add_part<double>(p, s, first);
  }
}

// Adds the contributions of a block to the nodes of its columns. A column has kK nodes in a row, so 3 kK consecutive
// doubles. Each of them gets the sum over the lanes of one vector. Lanes are summed for eight vectors at a time
// (sum_lanes_of_8()). A column of the quadratic basis has nine vectors: the ninth of each column waits in `rest_` until
// eight columns have given one.
template <class W>
class ColumnSums {
 public:
  // Number of vectors of a column, and the same with padding where they are summed in whole groups of eight.
  static constexpr int kValues = 3 * W::kK, kPadded = kValues < 8 ? 8 : kValues > 12 ? 16 : kValues;

  ColumnSums(double* nodal, const int* column) : nodal_(nodal), column_(column) {}

  // Adds the values of column c. Call it for columns 0, 1, 2, ... in this order, then finish(). `values` has kPadded vectors;
  // those beyond kValues are zero.
  void add(int c, const vd* values) {
    add_lanes<kFirst>(place(c), sum_lanes_of_8(values));
    if constexpr (kFull) {
      add_lanes<kOver>(place(c) + 8, sum_lanes_of_8(values + 8));
    } else if constexpr (kOver > 0) {
      const int at = c * kOver % 8;
      for (int l = 0; l < kOver; ++l) rest_[at + l] = values[8 + l];
      if (at + kOver == 8) add_rest(c, 8 / kOver);
    }
  }

  // Adds the vectors that still wait.
  void finish() {
    constexpr int kColumns = W::kI * W::kJ, kLeft = kFull ? 0 : kColumns * kOver % 8;
    if constexpr (kLeft == 1) {
      place(kColumns - 1)[8] += sum_lanes(rest_[0]);
    } else if constexpr (kLeft > 0) {
      for (int l = kLeft; l < 8; ++l) rest_[l] = vd{};
      add_rest(kColumns - 1, kLeft / kOver);
    }
  }

 private:
  // Number of vectors that are summed at once, and of those beyond eight.
  static constexpr int kFirst = kValues < 8 ? kValues : 8, kOver = kValues - kFirst;
  static constexpr bool kFull = kOver > 4;  // more than four vectors beyond eight do not wait: they are a group of their own
  static_assert(kFull || kOver == 0 || 8 % kOver == 0, "columns fill the rest without a gap");
  // Adds the kept sums of the last `columns` columns, the last of which is c.
  void add_rest(int c, int columns) {
    const vd s = sum_lanes_of_8(rest_);
    for (int n = 0; n < columns; ++n) add_lanes<kOver>(place(c - columns + 1 + n) + 8, s, kOver * n);
  }
  double* place(int c) const { return nodal_ + 3 * static_cast<long>(column_[c]); }
  double* nodal_;
  const int* column_;
  vd rest_[8];
};

}  // namespace detail

// nodal_Ic += sum over the points of T.a[c][d] dN_I/dX_d. T: for example -V P, see weighted_piola(). A, B, C: T times the
// factors of the first direction, for its derivative in the first, second and third direction. a, b: the same with the
// factors of the second direction, without and with the derivative in the third.
template <class Type, int Joined>
inline void scatter_gradient(double* __restrict nodal, const int* column, const Weights<Type, Joined>& s, const Mat3<vd>& T) {
  using W = Weights<Type, Joined>;
  detail::ColumnSums<W> sums(nodal, column);
#pragma GCC unroll 5
  for (int i = 0; i < W::kI; ++i) {
    vd A[3], B[3], C[3];
    for (int c = 0; c < 3; ++c) {
      A[c] = T.a[c][0] * s.dw[0][i];
      B[c] = T.a[c][1] * s.w[0][i];
      C[c] = T.a[c][2] * s.w[0][i];
    }
#pragma GCC unroll 5
    for (int j = 0; j < W::kJ; ++j) {
      vd values[detail::ColumnSums<W>::kPadded]{};
      for (int c = 0; c < 3; ++c) {
        const vd a = A[c] * s.w[1][j] + B[c] * s.dw[1][j];
        const vd b = C[c] * s.w[1][j];
        vd rest = a;  // the column receives a in all, so the node left out receives the remainder
        for (int k = 0; k < W::kK; ++k) {
          if (k == kLeftOut) continue;
          values[3 * k + c] = a * s.w[2][k] + b * s.dw[2][k];
          rest -= values[3 * k + c];
        }
        values[3 * kLeftOut + c] = rest;
      }
      sums.add(W::kJ * i + j, values);
    }
  }
  sums.finish();
}

// nodal_Ic += sum over the points of T[c] N_I
template <class Type, int Joined>
inline void scatter_value(double* __restrict nodal, const int* column, const Weights<Type, Joined>& s, const vd* T) {
  using W = Weights<Type, Joined>;
  detail::ColumnSums<W> sums(nodal, column);
  for (int i = 0; i < W::kI; ++i)
    for (int j = 0; j < W::kJ; ++j) {
      const vd wij = s.w[0][i] * s.w[1][j];
      vd values[detail::ColumnSums<W>::kPadded]{};
      for (int c = 0; c < 3; ++c) {
        const vd a = T[c] * wij;
        for (int k = 0; k < W::kK; ++k) values[3 * k + c] = a * s.w[2][k];
      }
      sums.add(W::kJ * i + j, values);
    }
  sums.finish();
}

// nodal_Ic += sum over the points of T[c] N_I + A.a[c][d] (X_Id - X_d) N_I. `moment` comes from with_moments().
template <class Type, int Joined>
inline void scatter_affine(double* __restrict nodal, const int* column, const Weights<Type, Joined>& moment, const vd* T,
                           const Mat3<vd>& A) {
  using W = Weights<Type, Joined>;
  detail::ColumnSums<W> sums(nodal, column);
  for (int i = 0; i < W::kI; ++i) {
    vd a[3], b[3], c3[3];
    for (int c = 0; c < 3; ++c) {
      a[c] = T[c] * moment.w[0][i] + A.a[c][0] * moment.dw[0][i];
      b[c] = A.a[c][1] * moment.w[0][i];
      c3[c] = A.a[c][2] * moment.w[0][i];
    }
    for (int j = 0; j < W::kJ; ++j) {
      vd values[detail::ColumnSums<W>::kPadded]{};
      for (int c = 0; c < 3; ++c) {
        const vd p = a[c] * moment.w[1][j] + b[c] * moment.dw[1][j];
        const vd q = c3[c] * moment.w[1][j];
        for (int k = 0; k < W::kK; ++k) values[3 * k + c] = p * moment.w[2][k] + q * moment.dw[2][k];
      }
      sums.add(W::kJ * i + j, values);
    }
  }
  sums.finish();
}

// Scalar field: nodal_I += sum over the points of T N_I.
template <class Type, int Joined>
inline void scatter_scalar(double* __restrict nodal, const int* column, const Weights<Type, Joined>& s, vd T) {
  using W = Weights<Type, Joined>;
  for (int i = 0; i < W::kI; ++i)
    for (int j = 0; j < W::kJ; ++j) {
      const vd a = T * s.w[0][i] * s.w[1][j];
      vd values[8]{};
      for (int k = 0; k < W::kK; ++k) values[k] = a * s.w[2][k];
      const vd r = sum_lanes_of_8(values);
      double* p = nodal + column[W::kJ * i + j];
      for (int k = 0; k < W::kK; ++k) p[k] += r[k];
    }
}

}  // namespace mpdem

#endif
