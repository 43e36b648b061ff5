// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_CROSS_MATRIX_H
#define MPDEM_CROSS_MATRIX_H

#include <Eigen/Dense>

namespace mpdem {

// The matrix [r] with [r] v = r x v.
inline Eigen::Matrix3d cross(const Eigen::Vector3d& r) {
  Eigen::Matrix3d m;
  m << 0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0;
  return m;
}

}  // namespace mpdem

#endif
