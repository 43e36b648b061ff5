// SPDX-License-Identifier: GPL-2.0-or-later
// Finds axes for a transversely isotropic material whose third axis is given.
#ifndef MPDEM_GEOMETRY_FRAME_ALONG_H
#define MPDEM_GEOMETRY_FRAME_ALONG_H

#include <Eigen/Geometry>
#include <cmath>

namespace mpdem {

// The smallest rotation that takes the axis z to `axis`, a unit vector. If `axis` is -z, it is half a turn around x.
// Accurate to rounding in every direction, unlike Eigen's FromTwoVectors, which is off by 1e-7 near -z.
inline Eigen::Quaterniond frame_along(const Eigen::Vector3d& axis) {
  const double across = std::hypot(axis.x(), axis.y());
  const Eigen::Vector3d around = across > 0.0 ? Eigen::Vector3d(-axis.y() / across, axis.x() / across, 0.0) : Eigen::Vector3d::UnitX();
  return Eigen::Quaterniond(Eigen::AngleAxisd(std::atan2(across, axis.z()), around));
}

}  // namespace mpdem

#endif
