// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The stiffness of the points of one bond on its grid as an operator, which is never formed: one product is one gather and one scatter
// over the points. K is the secant stiffness in the present state: damage as it is, displacements on top of the present deformation.
// Failed points have none. Forces that the present stress exerts on a turn are left out.
#ifndef MPDEM_STIFFNESS_FORCE_H
#define MPDEM_STIFFNESS_FORCE_H

#include <vector>

#include "../material/law.h"
#include "grid.h"
#include "point_store.h"

namespace mpdem {

struct StiffPoints {
  bool failed_hold = false;                  // points that failed count as whole ones
  const std::vector<int>* blocks = nullptr;  // whose points count; null: all
};

// out -= K x: the internal force that a displacement x adds. Three numbers a node; tied nodes have theirs in x, and out is before
// EdgeTies::pull_back() and the sum over ranks.
void add_stiffness_force(const PointStore& points, const Grid& grid, const Law& law, const double* x, double* out, const StiffPoints& which = {});

// About the diagonal of K, one number a node: what the points add to `diagonal`. Ties burden the masters by the sizes of their weights. Before
// the sum over ranks.
void add_stiffness_diagonal(const PointStore& points, const Grid& grid, const Law& law, double* diagonal);

// Strain of each block by a displacement x, in the material frames.
std::vector<Sym3<vd>> strain_by(const PointStore& points, const Grid& grid, const double* x);

}  // namespace mpdem

#endif
