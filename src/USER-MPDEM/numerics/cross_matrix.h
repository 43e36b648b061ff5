// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_NUMERICS_CROSS_MATRIX_H
#define MPDEM_NUMERICS_CROSS_MATRIX_H

#include <Eigen/Dense>

#include "tensor3.h"

namespace mpdem {

inline Eigen::Matrix3d matrix_of(const Mat3<double>& m) {
  Eigen::Matrix3d r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = m.a[i][j];
  return r;
}

// The matrix [r] with [r] v = r x v.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d m;
  m << 0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0;
  return m;
}

}  // namespace mpdem

#endif
