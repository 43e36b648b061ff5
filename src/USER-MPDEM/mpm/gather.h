// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Grid to points: values and gradients of a nodal vector field at the eight points of a
// block. The 27 nodes are nine columns of three consecutive nodes (`column`, index of the
// first); the sums are contracted one direction at a time.
#ifndef MPDEM_GATHER_H
#define MPDEM_GATHER_H

#include "../material/tensor3.h"
#include "quadratic_bspline.h"

namespace mpdem {

// G.a[c][d] = sum_I nodal_Ic dN_I/dX_d
inline Mat3<vd> gather_gradient(const double* __restrict nodal, const int* column, const Weights& s) {
  Mat3<vd> G{};
  for (int i = 0; i < kSupport; ++i) {
    vd A[3]{}, B[3]{}, C[3]{};
    for (int j = 0; j < kSupport; ++j) {
      const double* p = nodal + 3 * static_cast<long>(column[3 * i + j]);
      for (int c = 0; c < 3; ++c) {
        const vd a = p[c] * s.w[2][0] + p[3 + c] * s.w[2][1] + p[6 + c] * s.w[2][2];
        const vd b = p[c] * s.dw[2][0] + p[3 + c] * s.dw[2][1] + p[6 + c] * s.dw[2][2];
        A[c] += s.w[1][j] * a;
        B[c] += s.dw[1][j] * a;
        C[c] += s.w[1][j] * b;
      }
    }
    for (int c = 0; c < 3; ++c) {
      G.a[c][0] += s.dw[0][i] * A[c];
      G.a[c][1] += s.w[0][i] * B[c];
      G.a[c][2] += s.w[0][i] * C[c];
    }
  }
  return G;
}

// out[c] = sum_I nodal_Ic N_I
inline void gather_value(const double* __restrict nodal, const int* column, const Weights& s, vd* out) {
  for (int c = 0; c < 3; ++c) out[c] = vd{};
  for (int i = 0; i < kSupport; ++i) {
    vd A[3]{};
    for (int j = 0; j < kSupport; ++j) {
      const double* p = nodal + 3 * static_cast<long>(column[3 * i + j]);
      for (int c = 0; c < 3; ++c)
        A[c] += s.w[1][j] * (p[c] * s.w[2][0] + p[3 + c] * s.w[2][1] + p[6 + c] * s.w[2][2]);
    }
    for (int c = 0; c < 3; ++c) out[c] += s.w[0][i] * A[c];
  }
}

}  // namespace mpdem

#endif
