// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Gradients and values at the points of a block that stand in columns, and forces of their stress (see gather.h and
// scatter.h). Lanes 2n and 2n + 1 are the lower and the upper point of column n. All lower points are at one height,
// and so are all upper ones. A lattice with two points per cell in each direction gives such blocks. If the columns are
// also the corners of a rectangle, with n = 2a + b, the points are those of a box. Each node and direction then has two
// different weights; across columns at any positions it has four. Lanes are summed over the points of a column, and
// over the columns of a rectangle, as soon as the weights are known, and are split only when needed (sum factorisation
// of spectral elements, Orszag 1980). This takes less than half of the multiplications of eight points at any
// positions, which limit the speed of the kernels.
//
// Intermediate vectors have the lanes 2 component + c, with c = 1 for upper points. Lanes 6 and 7 are not used.
#ifndef MPDEM_MPM_COLUMNS_H
#define MPDEM_MPM_COLUMNS_H

#include <cstdint>
#include <cstring>

#include "../numerics/tensor3.h"
#include "basis.h"

namespace mpdem {

// Regular arrangement of the points of a block; none: any positions in the cell.
enum class Lattice : std::uint8_t { none, columns, box };

template <class Type, Lattice kLattice>
struct ColumnWeights {
  static_assert(Type::kSupport == 3, "columns of three nodes");
  vd across[3], across_slope[3];  // [node], lane 4 d + column, d = 0 or 1
  vd w[3], dw[3];                 // along the columns

  ColumnWeights(const vd* X, const int* base, double inverse_h) {
    const double i = base[0], j = base[1];
    const vd xy = __builtin_shufflevector(X[0], X[1], 0, 2, 4, 6, 8, 10, 12, 14);
    Type::factors(xy * inverse_h - vd{i, i, i, i, j, j, j, j}, inverse_h, across, across_slope);
    Type::factors(X[2] * inverse_h - base[2], inverse_h, w, dw);
  }
  double weight(int d, int node, int column) const { return across[node][4 * d + column]; }
  double slope(int d, int node, int column) const { return across_slope[node][4 * d + column]; }
};

namespace detail {

// Sorts three components by column: U[n] has those of column n, in the lanes of the header.
inline void by_column(const vd& x, const vd& y, const vd& z, vd (&U)[4]) {
  const vd low = __builtin_shufflevector(x, y, 0, 1, 2, 3, 8, 9, 10, 11);
  const vd high = __builtin_shufflevector(x, y, 4, 5, 6, 7, 12, 13, 14, 15);
  U[0] = __builtin_shufflevector(low, z, 0, 1, 4, 5, 8, 9, 8, 9);
  U[1] = __builtin_shufflevector(low, z, 2, 3, 6, 7, 10, 11, 10, 11);
  U[2] = __builtin_shufflevector(high, z, 0, 1, 4, 5, 12, 13, 12, 13);
  U[3] = __builtin_shufflevector(high, z, 2, 3, 6, 7, 14, 15, 14, 15);
}

// Inverts by_column().
inline void by_component(const vd (&U)[4], vd& x, vd& y, vd& z) {
  const vd low = __builtin_shufflevector(U[0], U[1], 0, 1, 2, 3, 8, 9, 10, 11);
  const vd high = __builtin_shufflevector(U[2], U[3], 0, 1, 2, 3, 8, 9, 10, 11);
  x = __builtin_shufflevector(low, high, 0, 1, 4, 5, 8, 9, 12, 13);
  y = __builtin_shufflevector(low, high, 2, 3, 6, 7, 10, 11, 14, 15);
  const vd near = __builtin_shufflevector(U[0], U[1], 4, 5, 4, 5, 12, 13, 12, 13);
  const vd far = __builtin_shufflevector(U[2], U[3], 4, 5, 4, 5, 12, 13, 12, 13);
  z = __builtin_shufflevector(near, far, 0, 1, 4, 5, 8, 9, 12, 13);
}

// Adds to the three nodes of a column. of0, of1 and of2: contributions of lower and upper points to nodes 0, 1 and 2.
inline void add_column(double* place, const vd& of0, const vd& of1, const vd& of2) {
  const vd near01 = __builtin_shufflevector(of0, of1, 0, 2, 4, 8, 10, 12, 0, 2),
           far01 = __builtin_shufflevector(of0, of1, 1, 3, 5, 9, 11, 13, 1, 3);
  const vd near = __builtin_shufflevector(near01, of2, 0, 1, 2, 3, 4, 5, 8, 10);
  const vd far = __builtin_shufflevector(far01, of2, 0, 1, 2, 3, 4, 5, 9, 11);
  vd sum;
  std::memcpy(&sum, place, sizeof sum);
  sum += near + far;
  std::memcpy(place, &sum, sizeof sum);
  place[8] += of2[4] + of2[5];
}

}  // namespace detail

// Number of columns with different weights along the second direction: all four, or in a box the two of a = 0.
constexpr int own_columns(Lattice lattice) { return lattice == Lattice::box ? 2 : 4; }

// G.a[c][d] = sum_I nodal_Ic dN_I/dX_d. First sums along the columns of nodes (a: values, b: slopes), then over j, then over i. A, B, C
// are sums over j: of values, slopes in the second direction, and slopes along the column. Neither this function nor scatter_gradient()
// is inlined, so that the compiler reads single weights as memory operands, without instructions of their own.
template <class Type, Lattice kLattice>
__attribute__((noinline)) inline Mat3<vd> gather_gradient(const double* __restrict nodal, const int* column,
                                                          const ColumnWeights<Type, kLattice>& s) {
  constexpr int kOwn = own_columns(kLattice);
  vd U[3][4], middle[3][kOwn];  // middle: sums at the nodes left out (kLeftOut), from which those of the others are measured
  const int order[3] = {kLeftOut, 0, 2};
#pragma GCC unroll 3
  for (int n = 0; n < 3; ++n) {
    const int i = order[n];
    vd a[3], b[3];
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      vd first, last;
      const double* p = nodal + 3 * static_cast<long>(column[3 * i + j]);
      std::memcpy(&first, p, sizeof first);
      std::memcpy(&last, p + 1, sizeof last);
      const vd one = __builtin_shufflevector(first, first, 3, 3, 4, 4, 5, 5, 5, 5);
      const vd d0 = __builtin_shufflevector(first, first, 0, 0, 1, 1, 2, 2, 2, 2) - one;
      const vd d2 = __builtin_shufflevector(last, last, 5, 5, 6, 6, 7, 7, 7, 7) - one;
      a[j] = one + d0 * s.w[0] + d2 * s.w[2];
      b[j] = d0 * s.dw[0] + d2 * s.dw[2];
    }
    const vd a0 = a[0] - a[1], a2 = a[2] - a[1], b0 = b[0] - b[1], b2 = b[2] - b[1];
#pragma GCC unroll 4
    for (int q = 0; q < kOwn; ++q) {
      vd A = a[1] + a0 * s.weight(1, 0, q) + a2 * s.weight(1, 2, q);
      vd B = a0 * s.slope(1, 0, q) + a2 * s.slope(1, 2, q);
      vd C = b[1] + b0 * s.weight(1, 0, q) + b2 * s.weight(1, 2, q);
      if (i == kLeftOut) {
        middle[0][q] = A;
        middle[1][q] = B;
        middle[2][q] = C;
        continue;
      }
      A -= middle[0][q];
      B -= middle[1][q];
      C -= middle[2][q];
#pragma GCC unroll 2
      for (int at = q; at < 4; at += kOwn) {
        U[0][at] = i == 0 ? A * s.slope(0, i, at) : U[0][at] + A * s.slope(0, i, at);
        U[1][at] = (i == 0 ? middle[1][q] : U[1][at]) + B * s.weight(0, i, at);
        U[2][at] = (i == 0 ? middle[2][q] : U[2][at]) + C * s.weight(0, i, at);
      }
    }
  }
  Mat3<vd> G;
  for (int d = 0; d < 3; ++d) detail::by_component(U[d], G.a[0][d], G.a[1][d], G.a[2][d]);
  return G;
}

// Returns sum_I nodal_I N_I of a scalar field.
template <class Type, Lattice kLattice>
inline vd gather_scalar(const double* __restrict nodal, const int* column, const ColumnWeights<Type, kLattice>& s) {
  vd sum{};
  for (int i = 0; i < 3; ++i) {
    vd A{};
    for (int j = 0; j < 3; ++j) {
      const double* p = nodal + column[3 * i + j];
      A += __builtin_shufflevector(s.across[j], s.across[j], 4, 4, 5, 5, 6, 6, 7, 7) * (p[0] * s.w[0] + p[1] * s.w[1] + p[2] * s.w[2]);
    }
    sum += __builtin_shufflevector(s.across[i], s.across[i], 0, 0, 1, 1, 2, 2, 3, 3) * A;
  }
  return sum;
}

// nodal_Ic += sum over the points of T.a[c][d] dN_I/dX_d
template <class Type, Lattice kLattice>
__attribute__((noinline)) inline void scatter_gradient(double* __restrict nodal, const int* column, const ColumnWeights<Type, kLattice>& s,
                                                       const Mat3<vd>& T) {
  constexpr int kOwn = own_columns(kLattice);
  vd U[3][4], middle[3][kOwn];  // middle: what the other nodes leave for the nodes left out (kLeftOut)
  for (int d = 0; d < 3; ++d) detail::by_column(T.a[0][d], T.a[1][d], T.a[2][d], U[d]);
  for (int q = 0; q < kOwn; ++q) {
    middle[0][q] = vd{};
    middle[1][q] = kOwn == 4 ? U[1][q] : U[1][q] + U[1][q + 2];
    middle[2][q] = kOwn == 4 ? U[2][q] : U[2][q] + U[2][q + 2];
  }
  const int order[3] = {0, 2, kLeftOut};
#pragma GCC unroll 3
  for (int n = 0; n < 3; ++n) {
    const int i = order[n];
    vd A[kOwn], B[kOwn], C[kOwn];
#pragma GCC unroll 4
    for (int q = 0; q < kOwn; ++q) {
      if (i == kLeftOut) {
        A[q] = middle[0][q];
        B[q] = middle[1][q];
        C[q] = middle[2][q];
        continue;
      }
      A[q] = U[0][q] * s.slope(0, i, q);
      B[q] = U[1][q] * s.weight(0, i, q);
      C[q] = U[2][q] * s.weight(0, i, q);
      if constexpr (kOwn == 2) {
        A[q] += U[0][q + 2] * s.slope(0, i, q + 2);
        B[q] += U[1][q + 2] * s.weight(0, i, q + 2);
        C[q] += U[2][q + 2] * s.weight(0, i, q + 2);
      }
      middle[0][q] -= A[q];
      middle[1][q] -= B[q];
      middle[2][q] -= C[q];
    }
    vd a_rest = A[0], b_rest = C[0];
    for (int q = 1; q < kOwn; ++q) {
      a_rest += A[q];
      b_rest += C[q];
    }
#pragma GCC unroll 3
    for (int m = 0; m < 3; ++m) {
      const int j = order[m];
      vd a = a_rest, b = b_rest;
      if (j != kLeftOut) {
        a = A[0] * s.weight(1, j, 0) + B[0] * s.slope(1, j, 0);
        b = C[0] * s.weight(1, j, 0);
        for (int q = 1; q < kOwn; ++q) {
          a += A[q] * s.weight(1, j, q) + B[q] * s.slope(1, j, q);
          b += C[q] * s.weight(1, j, q);
        }
        a_rest -= a;
        b_rest -= b;
      }
      const vd of0 = a * s.w[0] + b * s.dw[0], of2 = a * s.w[2] + b * s.dw[2];
      detail::add_column(nodal + 3 * static_cast<long>(column[3 * i + j]), of0, (a - of0) - of2, of2);
    }
  }
}

}  // namespace mpdem

#endif
