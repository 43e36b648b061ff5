// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Position of a node at creation in bond coordinates, and the six static fields there: row = component, column =
// motion.
#ifndef MPDEM_CEMENT_CONDENSED_CONDENSED_FIELDS_H
#define MPDEM_CEMENT_CONDENSED_CONDENSED_FIELDS_H

#include <Eigen/Dense>

#include "../../mpm/grid.h"
#include "static_bond.h"

namespace mpdem {

inline Eigen::Vector3d position_of(const Grid& grid, int i) {
  return grid.h * Eigen::Vector3d(grid.keys[i].at(0), grid.keys[i].at(1), grid.keys[i].at(2));
}

inline Eigen::Matrix<double, 3, 6> fields_at(const StaticBond& fields, int i) {
  Eigen::Matrix<double, 3, 6> u;
  for (int j = 0; j < 6; ++j)
    for (int d = 0; d < 3; ++d) u(d, j) = fields.displacement[j][3 * i + d];
  return u;
}

}  // namespace mpdem

#endif
