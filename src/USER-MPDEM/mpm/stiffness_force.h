// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The stiffness K of the points of one bond on its grid, as an operator: one product is one gather and one scatter over
// the points. K is the secant stiffness in the present state: damage is fixed, and displacements add to the present
// deformation. Failed points have no stiffness. The geometric stiffness of the present stress is left out.
#ifndef MPDEM_MPM_STIFFNESS_FORCE_H
#define MPDEM_MPM_STIFFNESS_FORCE_H

#include <vector>

#include "../material/law.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

struct StiffPoints {
  bool failed_as_undamaged = false;          // failed points have the stiffness of undamaged ones
  const std::vector<int>* blocks = nullptr;  // blocks whose points K has; null: all
};

// out -= K x: adds the internal force due to a displacement x, three numbers per node. x must have the values of
// constrained nodes. The caller applies ExtensionConstraints::gather_to_masters() to out, and the sum over ranks.
void add_stiffness_force(const PointStore& points, const Grid& grid, const Law& law, const double* x, double* out,
                         const StiffPoints& which = {});

// Adds an estimate of the diagonal of K to `diagonal`, one number per node. Stiffness of constrained nodes is added to
// their masters by the absolute weights. The caller sums over ranks.
void add_stiffness_diagonal(const PointStore& points, const Grid& grid, const Law& law, double* diagonal);

// Strain of each block due to a displacement x, in the material frames.
std::vector<Sym3<vd>> strain_by(const PointStore& points, const Grid& grid, const double* x);

}  // namespace mpdem

#endif
