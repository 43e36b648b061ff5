// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rotations as matrices. Unit quaternions are w, x, y, z. Rotations by the identity return their argument unchanged.
#ifndef MPDEM_NUMERICS_ROTATION_H
#define MPDEM_NUMERICS_ROTATION_H

#include <array>

#include "tensor3.h"

namespace mpdem {

template <class T>
Mat3<T> rotation_of(const T* q) {
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  return {{{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
           {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)},
           {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)}}};
}

// Returns the rotation by q and then by p.
template <class T>
std::array<T, 4> quaternion_product(const T* p, const T* q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3], p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]};
}

// turned() returns R v, and turned_back() returns R^T v.
inline std::array<double, 3> turned(const Mat3<double>& R, const double* v) {
  std::array<double, 3> t;
  for (int i = 0; i < 3; ++i) t[i] = R.a[i][0] * v[0] + R.a[i][1] * v[1] + R.a[i][2] * v[2];
  return t;
}
inline std::array<double, 3> turned_back(const Mat3<double>& R, const double* v) {
  std::array<double, 3> t;
  for (int i = 0; i < 3; ++i) t[i] = R.a[0][i] * v[0] + R.a[1][i] * v[1] + R.a[2][i] * v[2];
  return t;
}

}  // namespace mpdem

#endif
