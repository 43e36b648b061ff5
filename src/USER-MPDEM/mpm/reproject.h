// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rebuilds the nodal velocity from what the points see of it, value and affine part (APIC,
// Jiang, Schroeder, Selle, Teran & Stomakhin, ACM Trans. Graph. 34 (2015) 51):
//   v_p = sum N_I v_I,   C_p = (4/h^2) sum N_I v_I (X_I - X_p)^T,
//   v_I <- (sum m_p N_I (v_p + C_p (X_I - X_p)) + c_I v_I) / (m_I + c_I),
// c_I the added mass of the penalty. Linear fields pass unchanged, momentum and moment of
// momentum (those of the added mass, which is the grains', included) are kept; motion that
// the points cannot represent is removed. The map is symmetric in the inner product of the
// nodes' inertia with eigenvalues in [0,1], so it may come after any number of steps. (Its
// FLIP variant may not: every ten steps it feeds energy into a spinning bond.)
#ifndef MPDEM_REPROJECT_H
#define MPDEM_REPROJECT_H

#include <vector>

#include "grid.h"
#include "point_store.h"

namespace mpdem {

// Collective. jump: change of the nodal velocities.
void reproject_velocity(const PointStore& points, Grid& grid, double density, std::vector<double>& jump);

}  // namespace mpdem

#endif
