// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Rebuilds the nodal velocity from what the points see of it, with the reference unchanged.
// Since the weights stay, a transfer (transfer.h) is a polynomial of one nodal map, the
// projection of the interpolated field
//   y v = (sum m_p N_I v(X_p) + c_I v_I) / (m_I + c_I),
// c_I the added mass of the penalty, which is symmetric in the inner product of the nodes'
// inertia with eigenvalues in [0, 1]; no point needs a velocity of its own:
//   pic      v <- y v
//   xpic m   v <- (1 - (1 - y)^m) v
//   apic     v <- (sum m_p N_I (v_p + C_p (X_I - X_p)) + c_I v_I) / (m_I + c_I)
//   flip A   v + dt a <- A (v + y dt a) + (1 - A) y (v + dt a), for every step only: with
//            more steps between, motion that y removes goes on in the displacements and feeds
//            energy into a spinning bond.
// Momentum is kept, and with apic moment of momentum; those of the added mass, which is the
// grains', included.
#ifndef MPDEM_REPROJECT_H
#define MPDEM_REPROJECT_H

#include <vector>

#include "grid.h"
#include "point_store.h"
#include "transfer.h"

namespace mpdem {

// Collective among the ranks that share nodes. jump: change of the nodal velocities. dt: of the coming kick, for flip.
// added_mass: of each node, or empty.
void reproject_velocity(const PointStore& points, Grid& grid, const std::vector<double>& added_mass, double density,
                        const Transfer& transfer, double dt, std::vector<double>& jump);

// Collective. v <- q(y) v, q as in transfer.h: what xpic m makes of the velocity before the
// acceleration comes in. Kept is the momentum that includes that of the added mass.
void filter_velocity(const PointStore& points, Grid& grid, const std::vector<double>& added_mass, double density, int order);

}  // namespace mpdem

#endif
