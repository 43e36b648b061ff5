// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Draws the factors of the points of a bond (material/scatter.h), and their softening.
#ifndef MPDEM_MPM_POINT_SCATTER_H
#define MPDEM_MPM_POINT_SCATTER_H

#include <array>
#include <vector>

#include "bond_record.h"
#include "point_store.h"

namespace mpdem {

// These set columns of the store for all points of the bond with this record. The store must know its law.
// find_softening(): the softening by position. find_scatter(): factors. scatter_softening(): softening for the drawn energies,
// call it after find_softening().
void find_softening(PointStore& points, const BondRecord& record);
void find_scatter(PointStore& points, const BondRecord& record);
void scatter_softening(PointStore& points, const BondRecord& record);

// The factor on the strength of points of a block, in units of stress, that was drawn; 1 without scatter.
vd drawn_strength(const PointStore& points, int b);

// Factor on the strength of each of some interfaces at these positions, in the axes of the bond. Empty if the scatter has no rule for it.
std::vector<double> interface_factors(const Scatter& scatter, const BondRecord& record, const std::vector<std::array<double, 3>>& at);

}  // namespace mpdem

#endif
