// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Symmetric matrices of six rows over `double`, or over the eight-lane `vd` with one matrix a lane. They are stored as
// the lower triangle by rows, 21 numbers.
#ifndef MPDEM_NUMERICS_SYM6_H
#define MPDEM_NUMERICS_SYM6_H

namespace mpdem {

// Index of the entry (i, j) of a symmetric matrix of any size in its lower triangle by rows.
constexpr int lower_triangle(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

constexpr int kSym6 = 21;

// Inverts a positive definite matrix by its factors L D L^T.
template <class T>
inline void invert_sym6(const T* m, T* inverse) {
  T L[6][6], r[6];  // L: below the diagonal the factor, later its inverse; r: 1/D
  for (int j = 0; j < 6; ++j) {
    T d = m[lower_triangle(j, j)];
    T scaled[6];
    for (int k = 0; k < j; ++k) {
      scaled[k] = L[j][k] / r[k];
      d -= L[j][k] * scaled[k];
    }
    r[j] = 1.0 / d;
    for (int i = j + 1; i < 6; ++i) {
      T s = m[lower_triangle(i, j)];
      for (int k = 0; k < j; ++k) s -= L[i][k] * scaled[k];
      L[i][j] = s * r[j];
    }
  }
  for (int j = 0; j < 6; ++j)
    for (int i = j + 1; i < 6; ++i) {
      T s = L[i][j];
      for (int k = j + 1; k < i; ++k) s += L[i][k] * L[k][j];
      L[i][j] = -s;
    }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) {
      T s = j == i ? r[i] : r[i] * L[i][j];
      for (int k = i + 1; k < 6; ++k) s += r[k] * L[k][i] * L[k][j];
      inverse[lower_triangle(i, j)] = s;
    }
}

// y += m x
template <class T>
inline void add_product_sym6(const T* m, const T* x, T* y) {
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) y[i] += m[lower_triangle(i, j)] * x[j];
}

}  // namespace mpdem

#endif
