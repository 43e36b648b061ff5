// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Points to grid: the transposes of gather.h. The eight points of a block share their 27
// nodes, so the lanes are summed in registers and a node is touched once a block.
#ifndef MPDEM_SCATTER_H
#define MPDEM_SCATTER_H

#include "../material/tensor3.h"
#include "quadratic_bspline.h"

namespace mpdem {

namespace detail {

// Adds the lane sums of nine vectors to nine consecutive doubles; the ninth of each
// column waits in `rest` so that all reductions run eight at a time.
inline void add_column(double* p, const vd* nine, vd* rest, int column) {
  const vd s = sum_lanes_of_8(nine);
  for (int l = 0; l < kLanes; ++l) p[l] += s[l];
  rest[column] = nine[8];
}

inline void add_rest(double* nodal, const int* column, const vd* rest) {
  const vd s = sum_lanes_of_8(rest);
  for (int l = 0; l < kLanes; ++l) nodal[3 * static_cast<long>(column[l]) + 8] += s[l];
  nodal[3 * static_cast<long>(column[8]) + 8] += sum_lanes(rest[8]);
}

}  // namespace detail

// nodal_Ic += sum over the points of T.a[c][d] dN_I/dX_d
inline void scatter_gradient(double* __restrict nodal, const int* column, const Weights& s, const Mat3<vd>& T) {
  vd rest[9];
  for (int i = 0; i < kSupport; ++i) {
    vd A[3], B[3], C[3];
    for (int c = 0; c < 3; ++c) {
      A[c] = T.a[c][0] * s.dw[0][i];
      B[c] = T.a[c][1] * s.w[0][i];
      C[c] = T.a[c][2] * s.w[0][i];
    }
    for (int j = 0; j < kSupport; ++j) {
      vd nine[9];
      for (int c = 0; c < 3; ++c) {
        const vd a = A[c] * s.w[1][j] + B[c] * s.dw[1][j];
        const vd b = C[c] * s.w[1][j];
        for (int k = 0; k < kSupport; ++k) nine[3 * k + c] = a * s.w[2][k] + b * s.dw[2][k];
      }
      detail::add_column(nodal + 3 * static_cast<long>(column[3 * i + j]), nine, rest, 3 * i + j);
    }
  }
  detail::add_rest(nodal, column, rest);
}

// nodal_Ic += sum over the points of T[c] N_I
inline void scatter_value(double* __restrict nodal, const int* column, const Weights& s, const vd* T) {
  vd rest[9];
  for (int i = 0; i < kSupport; ++i)
    for (int j = 0; j < kSupport; ++j) {
      const vd wij = s.w[0][i] * s.w[1][j];
      vd nine[9];
      for (int c = 0; c < 3; ++c) {
        const vd a = T[c] * wij;
        for (int k = 0; k < kSupport; ++k) nine[3 * k + c] = a * s.w[2][k];
      }
      detail::add_column(nodal + 3 * static_cast<long>(column[3 * i + j]), nine, rest, 3 * i + j);
    }
  detail::add_rest(nodal, column, rest);
}

// Scalar field: nodal_I += sum over the points of T N_I. Set-up only.
inline void scatter_scalar(double* __restrict nodal, const int* column, const Weights& s, vd T) {
  for (int i = 0; i < kSupport; ++i)
    for (int j = 0; j < kSupport; ++j)
      for (int k = 0; k < kSupport; ++k)
        nodal[column[3 * i + j] + k] += sum_lanes(T * s.w[0][i] * s.w[1][j] * s.w[2][k]);
}

}  // namespace mpdem

#endif
