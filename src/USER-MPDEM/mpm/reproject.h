// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rebuilds the nodal velocity from its interpolation to the points. The reference is unchanged, so the weights stay,
// and a transfer (transfer.h) is a polynomial of one nodal map y, the projection of the interpolated field:
//   y v = (sum m_p N_I v(X_p) + c_I v_I) / (m_I + c_I),
// with c_I the added mass of the penalty. The map is symmetric in the inner product of the nodes' inertia, and its
// eigenvalues lie in [0, 1]. Points do not need velocities of their own:
//   xpic m   v <- (1 - (1 - y)^m) v
//   apic     v <- (sum m_p N_I (v_p + C_p (X_I - X_p)) + c_I v_I) / (m_I + c_I)
//   flip A   v + dt a <- A (v + y dt a) + (1 - A) y (v + dt a)
// flip must be applied in every step. Otherwise motion that y removes would continue in the displacements during the
// steps between, and feed energy into a spinning bond. Momentum is conserved. apic also conserves angular momentum.
// Both include those of the added mass, which belongs to the grains.
#ifndef MPDEM_MPM_REPROJECT_H
#define MPDEM_MPM_REPROJECT_H

#include <vector>

#include "grid.h"
#include "point_store.h"
#include "transfer.h"

namespace mpdem {

// Collective among the ranks that share nodes. jump: receives the change of the nodal velocities. dt: length of the
// coming kick, for flip. added_mass: for each node, or empty.
void reproject_velocity(const PointStore& points, Grid& grid, const SharedList<double>& added_mass, const CementDensity& density,
                        const Transfer& transfer, double dt, std::vector<double>& jump);

// Collective. v <- q(y) v with q as in transfer.h: xpic m as it acts on the velocity before the acceleration is added.
// Momentum is conserved, including that of the added mass.
void filter_velocity(const PointStore& points, Grid& grid, const SharedList<double>& added_mass, const CementDensity& density, int order);

}  // namespace mpdem

#endif
