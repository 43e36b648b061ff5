// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rotations as matrices. Unit quaternions are w, x, y, z. Rotations by the identity return their argument to the bit.
#ifndef MPDEM_ROTATION_H
#define MPDEM_ROTATION_H

#include <array>

#include "tensor3.h"

namespace mpdem {

inline Mat3<double> rotation_of(const double* q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
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
