// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Incremental Jaumann rate in a co-rotated frame (Hughes & Winget, Int. J. Numer. Meth. Engng 15 (1980) 1862). The
// frame q rotates with the spin of the material. Strain and damage are kept in its components. So stress, damage and
// elastic axes convect with one and the same spin, and the stress is a function of the state, never summed. The update
// is exact for a finite rigid rotation in one step, and second order in a simple shear.
#ifndef MPDEM_MATERIAL_COROTATIONAL_H
#define MPDEM_MATERIAL_COROTATIONAL_H

#include "../numerics/simd.h"
#include "../numerics/tensor3.h"

namespace mpdem {

// Unit quaternion (w, x, y, z), rotates material components to global ones.
struct Frame {
  vd w, x, y, z;
};

// Rotation matrix of q. two: 2 over the square of the length of q, which need not be 1.
inline Mat3<vd> rotation_matrix(const Frame& q, vd two = splat(2.0)) {
  const vd xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const vd xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const vd wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{{1.0 - two * (yy + zz), two * (xy - wz), two * (xz + wy)},
           {two * (xy + wz), 1.0 - two * (xx + zz), two * (yz - wx)},
           {two * (xz - wy), two * (yz + wx), 1.0 - two * (xx + yy)}}};
}

// Returns the product of the quaternions (1, v/2) and q, which rotates by about v after q. Its length is not 1.
inline Frame unnormalised_product(const Frame& q, vd vx, vd vy, vd vz) {
  const vd x = 0.5 * vx, y = 0.5 * vy, z = 0.5 * vz;
  return {q.w - x * q.x - y * q.y - z * q.z, q.x + x * q.w + y * q.z - z * q.y, q.y + y * q.w + z * q.x - x * q.z,
          q.z + z * q.w + x * q.y - y * q.x};
}
inline vd square_of(const Frame& q) { return q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z; }

// After the rotation of a step, squared lengths of frames are close to 1. Series then replace divisions and roots,
// whose latency would delay the rest of a step. They are truncated where rounding is larger.
constexpr double kNextToOne = 5e-4;
inline bool all_next_to_one(vd square) { return !any(abs(square - 1.0) > kNextToOne); }
inline vd inverse_next_to_one(vd square) {
  const vd e = 1.0 - square;
  return 1.0 + e * (1.0 + e * (1.0 + e * (1.0 + e)));
}
inline vd inverse_root_next_to_one(vd square) {
  const vd e = 1.0 - square;
  return 1.0 + e * (0.5 + e * (0.375 + e * (0.3125 + e * 0.2734375)));
}

// Frame after the Cayley rotation by the axial vector v: (1, v/2)/|.| q, from p = unnormalised_product(q, v).
inline Frame spun(const Frame& p, vd vx, vd vy, vd vz) {
  // Normalising p itself, and not by (1 + v^2/4)^(1/2), keeps |q| = 1 over any number of steps. Without spin every bit of q stays.
  const vd square = square_of(p);
  const vd r = all_next_to_one(square) ? inverse_root_next_to_one(square) : 1.0 / sqrt(square);
  const vd n = select((vx == 0.0) & (vy == 0.0) & (vz == 0.0), splat(1.0), r);
  return {n * p.w, n * p.x, n * p.y, n * p.z};
}

// Advances frame and co-rotated strain over a step in which the deformation gradient goes from F to F + dF. The gradient of the
// displacement of the step, with respect to the configuration half-way, is
//   G = 2 (f - 1)(f + 1)^-1,  f = (F + dF) F^-1,  that is  G = dF (F + dF/2)^-1.
inline void advance_strain(const Mat3<vd>& F, const Mat3<vd>& dF, Frame& q, Sym3<vd>& strain) {
  Mat3<vd> mid;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) mid.a[i][j] = F.a[i][j] + 0.5 * dF.a[i][j];
  // The division is kept apart, so that the product does not wait for it.
  const Mat3<vd> c = cofactor(mid);
  const vd inverse = 1.0 / (mid.a[0][0] * c.a[0][0] + mid.a[0][1] * c.a[0][1] + mid.a[0][2] * c.a[0][2]);
  const Mat3<vd> G = product(dF, transpose(c));  // to be multiplied by `inverse`
  const vd half = 0.5 * inverse;
  const Sym3<vd> de{inverse * G.a[0][0],
                    inverse * G.a[1][1],
                    inverse * G.a[2][2],
                    half * (G.a[1][2] + G.a[2][1]),
                    half * (G.a[0][2] + G.a[2][0]),
                    half * (G.a[0][1] + G.a[1][0])};
  const vd wx = half * (G.a[2][1] - G.a[1][2]);
  const vd wy = half * (G.a[0][2] - G.a[2][0]);
  const vd wz = half * (G.a[1][0] - G.a[0][1]);
  // (1, w/4) q, the frame half-way, is the mean of q and p = (1, w/2) q. The length of q is 1, and p - q is
  // perpendicular to q.
  const Frame p = unnormalised_product(q, wx, wy, wz), twice_half{q.w + p.w, q.x + p.x, q.y + p.y, q.z + p.z};
  const vd square = 0.25 * (3.0 + square_of(p));
  const vd two = all_next_to_one(square) ? 0.5 * inverse_next_to_one(square) : 0.5 / square;
  strain = strain + rotate_back(rotation_matrix(twice_half, two), de);
  q = spun(p, wx, wy, wz);
}

}  // namespace mpdem

#endif
