// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The consistent mass M of the points, M_IJ = sum_p m_p N_I N_J, beside the lumped mass M_L of the nodes, which are its row
// sums. M is never formed: one product is one gather and one scatter over the points.
//
// With `mass_order` k the nodes are accelerated by the first k terms of
//   M^-1 = sum over j of (1 - M_L^-1 M)^j M_L^-1,
// as in the FMPM(k) of J. A. Nairn and C. C. Hammerquist (Comput. Methods Appl. Mech. Eng. 377 (2021) 113667).
// The eigenvalues of M_L^-1 M lie in [0, 1]. So the inverse stays symmetric and positive definite, is at most k times that of the
// lumped mass, and k times the largest eigenvalue of M_L^-1 K bounds that of the step.
//
// A tied node takes part as the mean of its heirs, which have its mass (edge_ties.h). So the row sums of M stay M_L, and momentum is kept.
#ifndef MPDEM_CONSISTENT_MASS_H
#define MPDEM_CONSISTENT_MASS_H

#include <vector>

#include "grid.h"
#include "point_store.h"

namespace mpdem {

// out += scale M field, three numbers a node, of the points of this rank. Values of tied nodes go to their heirs.
void add_consistent_mass(const PointStore& points, const Grid& grid, double density, double scale, std::vector<double> field, std::vector<double>& out);

}  // namespace mpdem

#endif
