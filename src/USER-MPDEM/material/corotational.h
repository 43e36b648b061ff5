// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Incremental Jaumann rate in a co-rotated frame (Hughes & Winget, Int. J. Numer.
// Meth. Engng 15 (1980) 1862). The frame q turns with the spin of the material; strain
// and damage are kept in its components, so stress, damage and elastic axes convect
// with one and the same spin and the stress is a function of the state, never summed.
// Exact for a finite rigid rotation in one step, second order in a simple shear.
#ifndef MPDEM_COROTATIONAL_H
#define MPDEM_COROTATIONAL_H

#include "../numerics/simd.h"
#include "../numerics/tensor3.h"

namespace mpdem {

// Unit quaternion (w, x, y, z), rotates material components to global ones.
struct Frame {
  vd w, x, y, z;
};

inline Mat3<vd> rotation_matrix(const Frame& q) {
  const vd xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const vd xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const vd wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{{1.0 - 2.0 * (yy + zz), 2.0 * (xy - wz), 2.0 * (xz + wy)},
           {2.0 * (xy + wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz - wx)},
           {2.0 * (xz - wy), 2.0 * (yz + wx), 1.0 - 2.0 * (xx + yy)}}};
}

// Frame after the Cayley rotation of axial vector v: q <- (1, v/2)/|.| q
inline Frame spin(const Frame& q, vd vx, vd vy, vd vz) {
  const vd x = 0.5 * vx, y = 0.5 * vy, z = 0.5 * vz;
  const Frame p{q.w - x * q.x - y * q.y - z * q.z, q.x + x * q.w + y * q.z - z * q.y,
                q.y + y * q.w + z * q.x - x * q.z, q.z + z * q.w + x * q.y - y * q.x};
  // Normalising p itself keeps |q| = 1 over any number of steps; without spin q keeps its bits.
  const vd r = 1.0 / sqrt(p.w * p.w + p.x * p.x + p.y * p.y + p.z * p.z);
  const vd n = select((x == 0.0) & (y == 0.0) & (z == 0.0), splat(1.0), r);
  return {n * p.w, n * p.x, n * p.y, n * p.z};
}

// Advances frame and co-rotated strain over a step in which the deformation gradient
// goes from F to F + dF. The gradient with respect to the mid-point configuration is
//   G = 2 (f - 1)(f + 1)^-1,  f = (F + dF) F^-1,  that is  G = dF (F + dF/2)^-1.
inline void advance_strain(const Mat3<vd>& F, const Mat3<vd>& dF, Frame& q, Sym3<vd>& strain) {
  Mat3<vd> mid;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) mid.a[i][j] = F.a[i][j] + 0.5 * dF.a[i][j];
  const Mat3<vd> G = product(dF, inverse(mid));
  const Sym3<vd> de{G.a[0][0],
                    G.a[1][1],
                    G.a[2][2],
                    0.5 * (G.a[1][2] + G.a[2][1]),
                    0.5 * (G.a[0][2] + G.a[2][0]),
                    0.5 * (G.a[0][1] + G.a[1][0])};
  const vd wx = 0.5 * (G.a[2][1] - G.a[1][2]);
  const vd wy = 0.5 * (G.a[0][2] - G.a[2][0]);
  const vd wz = 0.5 * (G.a[1][0] - G.a[0][1]);
  const Frame half = spin(q, 0.5 * wx, 0.5 * wy, 0.5 * wz);
  strain = strain + rotate_back(rotation_matrix(half), de);
  q = spin(q, wx, wy, wz);
}

}  // namespace mpdem

#endif
