// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Grid to points: values and gradients of a nodal vector field at the eight points of a block. The nodes of a block are
// columns of consecutive nodes in the third direction (`column`: index of the first node of each). The sums are
// contracted one direction at a time.
//
// Type is the type of the shape functions (basis.h). Joined is kOneCell, or the code of the row of cells of the block
// (cells_in_a_row()).
#ifndef MPDEM_MPM_GATHER_H
#define MPDEM_MPM_GATHER_H

#include "../numerics/tensor3.h"
#include "basis.h"

namespace mpdem {

// G.a[c][d] = sum_I nodal_Ic dN_I/dX_d. A, B, C: sums over a plane of nodes of values, and of slopes in the second and third direction.
template <class Type, int Joined>
inline Mat3<vd> gather_gradient(const double* __restrict nodal, const int* column, const Weights<Type, Joined>& s) {
  using W = Weights<Type, Joined>;
  Mat3<vd> G;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) G.a[c][d] = vd{};  // `Mat3<vd> G{}` would keep the sums in memory instead of registers
  const auto add_plane = [&](int i) __attribute__((always_inline)) {
    vd A[3]{}, B[3]{}, C[3]{};
    for (int j = 0; j < W::kJ; ++j) {
      const double* p = nodal + 3 * static_cast<long>(column[W::kJ * i + j]);
      for (int c = 0; c < 3; ++c) {
        // Weights of a column sum to one and slopes to zero, so differences from one of its nodes suffice.
        const vd reference = splat(p[3 * kLeftOut + c]);
        vd a = reference, b{};
        for (int k = 0; k < W::kK; ++k) {
          if (k == kLeftOut) continue;
          const vd d = p[3 * k + c] - reference;
          a += d * s.w[2][k];
          b = k == 0 ? d * s.dw[2][k] : b + d * s.dw[2][k];
        }
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
  };
  // There is an instance of this function for one cell, and six for rows of cells. Unrolled loops in all of them would
  // fill the instruction cache.
  if constexpr (Joined == kOneCell) {
#pragma GCC unroll 4
    for (int i = 0; i < W::kI; ++i) add_plane(i);
  } else {
    for (int i = 0; i < W::kI; ++i) add_plane(i);
  }
  return G;
}

// out[c] = sum_I nodal_Ic N_I
template <class Type, int Joined>
inline void gather_value(const double* __restrict nodal, const int* column, const Weights<Type, Joined>& s, vd* out) {
  using W = Weights<Type, Joined>;
  for (int c = 0; c < 3; ++c) out[c] = vd{};
  for (int i = 0; i < W::kI; ++i) {
    vd A[3]{};
    for (int j = 0; j < W::kJ; ++j) {
      const double* p = nodal + 3 * static_cast<long>(column[W::kJ * i + j]);
      for (int c = 0; c < 3; ++c) {
        vd a = p[c] * s.w[2][0];
        for (int k = 1; k < W::kK; ++k) a += p[3 * k + c] * s.w[2][k];
        A[c] += s.w[1][j] * a;
      }
    }
    for (int c = 0; c < 3; ++c) out[c] += s.w[0][i] * A[c];
  }
}

// Scalar field: out = sum_I nodal_I N_I
template <class Type, int Joined>
inline vd gather_scalar(const double* __restrict nodal, const int* column, const Weights<Type, Joined>& s) {
  using W = Weights<Type, Joined>;
  vd sum{};
  for (int i = 0; i < W::kI; ++i) {
    vd A{};
    for (int j = 0; j < W::kJ; ++j) {
      const double* p = nodal + column[W::kJ * i + j];
      vd a = p[0] * s.w[2][0];
      for (int k = 1; k < W::kK; ++k) a += p[k] * s.w[2][k];
      A += s.w[1][j] * a;
    }
    sum += s.w[0][i] * A;
  }
  return sum;
}

// Gathers values and gradients at once: out[c] = sum_I nodal_Ic N_I, and G as in gather_gradient().
template <class Type, int Joined>
inline Mat3<vd> gather_value_and_gradient(const double* __restrict nodal, const int* column, const Weights<Type, Joined>& s, vd* out) {
  using W = Weights<Type, Joined>;
  Mat3<vd> G{};
  for (int c = 0; c < 3; ++c) out[c] = vd{};
  for (int i = 0; i < W::kI; ++i) {
    vd A[3]{}, B[3]{}, C[3]{};
    for (int j = 0; j < W::kJ; ++j) {
      const double* p = nodal + 3 * static_cast<long>(column[W::kJ * i + j]);
      for (int c = 0; c < 3; ++c) {
        vd a = p[c] * s.w[2][0], b = p[c] * s.dw[2][0];
        for (int k = 1; k < W::kK; ++k) {
          a += p[3 * k + c] * s.w[2][k];
          b += p[3 * k + c] * s.dw[2][k];
        }
        A[c] += s.w[1][j] * a;
        B[c] += s.dw[1][j] * a;
        C[c] += s.w[1][j] * b;
      }
    }
    for (int c = 0; c < 3; ++c) {
      out[c] += s.w[0][i] * A[c];
      G.a[c][0] += s.dw[0][i] * A[c];
      G.a[c][1] += s.w[0][i] * B[c];
      G.a[c][2] += s.w[0][i] * C[c];
    }
  }
  return G;
}

}  // namespace mpdem

#endif
