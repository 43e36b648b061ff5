// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The map M^-1 of energy equivalence: x = M^-1 : e solves phi x + x phi = 2 e with phi = A^-1, A = 1 - D. In the
// principal axes of D it multiplies e_ij by the harmonic mean of 1 - D_i and 1 - D_j. It needs no axes: the symmetric
// part of phi x is e, so that
//   phi x = e + W,   x = A (e + W),   A W + W A = e A - A e
// with a skew W. The axial vector of A W + W A is (tr A 1 - A) times that of W. So W has the axial vector K axial(e A - A e)
// with K = (tr A 1 - A)^-1. K has the eigenvalues 1/(A_i + A_j). The map is as accurate as A for every D, and without damage
// it leaves every bit of e.
#ifndef MPDEM_MATERIAL_EFFECTIVE_STRAIN_H
#define MPDEM_MATERIAL_EFFECTIVE_STRAIN_H

#include "../numerics/tensor3.h"

namespace mpdem {

// Axial vector w of a skew tensor W_ij = -eps_ijk w_k.
template <class T>
struct Axial {
  T x, y, z;
};

// Returns s + W for the skew tensor W with the axial vector w.
template <class T>
inline Mat3<T> plus(const Sym3<T>& s, const Axial<T>& w) {
  return {{{s.xx, s.xy - w.z, s.xz + w.y}, {s.xy + w.z, s.yy, s.yz - w.x}, {s.xz - w.y, s.yz + w.x, s.zz}}};
}

template <class T>
inline Axial<T> operator*(const Sym3<T>& k, const Axial<T>& w) {
  return {k.xx * w.x + k.xy * w.y + k.xz * w.z, k.xy * w.x + k.yy * w.y + k.yz * w.z, k.xz * w.x + k.yz * w.y + k.zz * w.z};
}

template <class T>
inline Axial<T> operator+(const Axial<T>& a, const Axial<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

// Axial vector of m - m^T.
template <class T>
inline Axial<T> twice_axial(const Mat3<T>& m) {
  return {m.a[2][1] - m.a[1][2], m.a[0][2] - m.a[2][0], m.a[1][0] - m.a[0][1]};
}

// Axial vector of e a - a e.
template <class T>
inline Axial<T> commutator(const Sym3<T>& e, const Sym3<T>& a) {
  return {e.xz * a.xy - a.xz * e.xy + e.yz * (a.yy - a.zz) + a.yz * (e.zz - e.yy),
          e.xy * a.yz - a.xy * e.yz + e.xz * (a.zz - a.xx) + a.xz * (e.xx - e.zz),
          e.yz * a.xz - a.yz * e.xz + e.xy * (a.xx - a.yy) + a.xy * (e.yy - e.xx)};
}

// Returns the product s m, which must be symmetric. Only its upper triangle is computed.
template <class T>
inline Sym3<T> symmetric_product(const Sym3<T>& s, const Mat3<T>& m) {
  return {s.xx * m.a[0][0] + s.xy * m.a[1][0] + s.xz * m.a[2][0], s.xy * m.a[0][1] + s.yy * m.a[1][1] + s.yz * m.a[2][1],
          s.xz * m.a[0][2] + s.yz * m.a[1][2] + s.zz * m.a[2][2], s.xy * m.a[0][2] + s.yy * m.a[1][2] + s.yz * m.a[2][2],
          s.xx * m.a[0][2] + s.xy * m.a[1][2] + s.xz * m.a[2][2], s.xx * m.a[0][1] + s.xy * m.a[1][1] + s.xz * m.a[2][1]};
}

template <class T>
inline Sym3<T> inverse(const Sym3<T>& m) {
  const T cxx = m.yy * m.zz - m.yz * m.yz, cyy = m.xx * m.zz - m.xz * m.xz, czz = m.xx * m.yy - m.xy * m.xy;
  const T cyz = m.xz * m.xy - m.xx * m.yz, cxz = m.xy * m.yz - m.yy * m.xz, cxy = m.xz * m.yz - m.zz * m.xy;
  const T r = 1.0 / (m.xx * cxx + m.xy * cxy + m.xz * cxz);
  return {r * cxx, r * cyy, r * czz, r * cyz, r * cxz, r * cxy};
}

template <class T>
class EffectiveStrain {
 public:
  explicit EffectiveStrain(const Sym3<T>& damage)
      : A_{1.0 - damage.xx, 1.0 - damage.yy, 1.0 - damage.zz, -damage.yz, -damage.xz, -damage.xy},
        K_(inverse(Sym3<T>{A_.yy + A_.zz, A_.xx + A_.zz, A_.xx + A_.yy, -A_.yz, -A_.xz, -A_.xy})) {}

  const Sym3<T>& A() const { return A_; }
  const Sym3<T>& K() const { return K_; }

  // Returns phi x = e + W for x = M^-1 : e.
  Mat3<T> amplified(const Sym3<T>& e) const { return plus(e, K_ * commutator(e, A_)); }
  // Returns x, given phi x = e + W.
  Sym3<T> reduced(const Mat3<T>& e_plus_W) const { return symmetric_product(A_, e_plus_W); }

  Sym3<T> operator()(const Sym3<T>& e) const { return reduced(amplified(e)); }

 private:
  Sym3<T> A_, K_;
};

}  // namespace mpdem

#endif
