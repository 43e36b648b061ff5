// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Symmetric and general 3x3 tensors over a scalar type T, which is `double` or the eight-lane `vd`. Symmetric storage
// order: xx, yy, zz, yz, xz, xy (tensor components, no factor of two in the shears).
#ifndef MPDEM_NUMERICS_TENSOR3_H
#define MPDEM_NUMERICS_TENSOR3_H

namespace mpdem {

template <class T>
struct Sym3 {
  T xx, yy, zz, yz, xz, xy;
};

template <class T>
struct Mat3 {
  T a[3][3];
};

template <class T>
inline Sym3<T> operator+(const Sym3<T>& a, const Sym3<T>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.yz + b.yz, a.xz + b.xz, a.xy + b.xy};
}
template <class T>
inline Sym3<T> operator-(const Sym3<T>& a, const Sym3<T>& b) {
  return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.yz - b.yz, a.xz - b.xz, a.xy - b.xy};
}
template <class T>
inline Sym3<T> operator*(const T& s, const Sym3<T>& b) {
  return {s * b.xx, s * b.yy, s * b.zz, s * b.yz, s * b.xz, s * b.xy};
}

// a : b
template <class T>
inline T contract(const Sym3<T>& a, const Sym3<T>& b) {
  const T shear = a.yz * b.yz + a.xz * b.xz + a.xy * b.xy;
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + (shear + shear);
}

template <class T>
inline T trace(const Sym3<T>& a) {
  return a.xx + a.yy + a.zz;
}

template <class T>
inline T determinant(const Sym3<T>& a) {
  return a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) + a.xz * (a.xy * a.yz - a.yy * a.xz);
}

// sym(a b) of two symmetric tensors
template <class T>
inline Sym3<T> sym_product(const Sym3<T>& a, const Sym3<T>& b) {
  const T half = T{} + 0.5;
  return {a.xx * b.xx + a.xy * b.xy + a.xz * b.xz,
          a.xy * b.xy + a.yy * b.yy + a.yz * b.yz,
          a.xz * b.xz + a.yz * b.yz + a.zz * b.zz,
          half * (a.xy * b.xz + a.yy * b.yz + a.yz * b.zz + b.xy * a.xz + b.yy * a.yz + b.yz * a.zz),
          half * (a.xx * b.xz + a.xy * b.yz + a.xz * b.zz + b.xx * a.xz + b.xy * a.yz + b.xz * a.zz),
          half * (a.xx * b.xy + a.xy * b.yy + a.xz * b.yz + b.xx * a.xy + b.xy * a.yy + b.xz * a.yz)};
}

// q s q^T
template <class T>
inline Sym3<T> rotate(const Mat3<T>& q, const Sym3<T>& s) {
  T b[3][3];
  for (int i = 0; i < 3; ++i) {
    b[i][0] = q.a[i][0] * s.xx + q.a[i][1] * s.xy + q.a[i][2] * s.xz;
    b[i][1] = q.a[i][0] * s.xy + q.a[i][1] * s.yy + q.a[i][2] * s.yz;
    b[i][2] = q.a[i][0] * s.xz + q.a[i][1] * s.yz + q.a[i][2] * s.zz;
  }
  const auto dot = [&](int i, int j) { return b[i][0] * q.a[j][0] + b[i][1] * q.a[j][1] + b[i][2] * q.a[j][2]; };
  return {dot(0, 0), dot(1, 1), dot(2, 2), dot(1, 2), dot(0, 2), dot(0, 1)};
}

template <class T>
inline Mat3<T> transpose(const Mat3<T>& m) {
  return {{{m.a[0][0], m.a[1][0], m.a[2][0]}, {m.a[0][1], m.a[1][1], m.a[2][1]}, {m.a[0][2], m.a[1][2], m.a[2][2]}}};
}

// q^T s q
template <class T>
inline Sym3<T> rotate_back(const Mat3<T>& q, const Sym3<T>& s) {
  return rotate(transpose(q), s);
}

template <class T>
inline Mat3<T> product(const Mat3<T>& a, const Mat3<T>& b) {
  Mat3<T> c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c.a[i][j] = a.a[i][0] * b.a[0][j] + a.a[i][1] * b.a[1][j] + a.a[i][2] * b.a[2][j];
  return c;
}

// s m
template <class T>
inline Mat3<T> product(const Sym3<T>& s, const Mat3<T>& m) {
  return product(Mat3<T>{{{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}}}, m);
}

// Upper triangle of m, which must be symmetric.
template <class T>
inline Sym3<T> upper(const Mat3<T>& m) {
  return {m.a[0][0], m.a[1][1], m.a[2][2], m.a[1][2], m.a[0][2], m.a[0][1]};
}

// sym(a b^T)
template <class T>
inline Sym3<T> sym_product_transposed(const Mat3<T>& a, const Mat3<T>& b) {
  const auto dot = [&](int i, int j) { return a.a[i][0] * b.a[j][0] + a.a[i][1] * b.a[j][1] + a.a[i][2] * b.a[j][2]; };
  return {dot(0, 0), dot(1, 1), dot(2, 2), 0.5 * (dot(1, 2) + dot(2, 1)), 0.5 * (dot(0, 2) + dot(2, 0)), 0.5 * (dot(0, 1) + dot(1, 0))};
}

// Cofactor matrix: det(m) m^-T
template <class T>
inline Mat3<T> cofactor(const Mat3<T>& m) {
  Mat3<T> c;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c.a[i][j] = m.a[i1][j1] * m.a[i2][j2] - m.a[i1][j2] * m.a[i2][j1];
    }
  }
  return c;
}

template <class T>
inline Mat3<T> inverse(const Mat3<T>& m) {
  const Mat3<T> c = cofactor(m);
  const T det = m.a[0][0] * c.a[0][0] + m.a[0][1] * c.a[0][1] + m.a[0][2] * c.a[0][2];
  const T r = 1.0 / det;
  Mat3<T> inv;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) inv.a[i][j] = c.a[j][i] * r;
  return inv;
}

template <class T>
inline T determinant(const Mat3<T>& m) {
  return m.a[0][0] * (m.a[1][1] * m.a[2][2] - m.a[1][2] * m.a[2][1]) - m.a[0][1] * (m.a[1][0] * m.a[2][2] - m.a[1][2] * m.a[2][0]) +
         m.a[0][2] * (m.a[1][0] * m.a[2][1] - m.a[1][1] * m.a[2][0]);
}

}  // namespace mpdem

#endif
