// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Coulomb friction of all contacts: debonded cement on its grains, faces of cracks, failed points whose crack is
// closed, and pieces of cement on other bodies. An elastic slip e has the tangential force kt e. The force is at most
// mu times the normal force. If it would be larger, a share of e becomes slip that is not elastic.
#ifndef MPDEM_MATERIAL_COULOMB_H
#define MPDEM_MATERIAL_COULOMB_H

#include "../numerics/simd.h"

namespace mpdem {

// Share of the elastic slip that slides. most: mu times the normal force, not negative. size: the tangential force if
// nothing slides. A tangential force above the most by rounding alone slides by nothing.
constexpr double kRoundingOfSlip = 1.0 + 1e-9;
inline double sliding_share(double most, double size) { return size > kRoundingOfSlip * most ? 1.0 - most / size : 0.0; }
inline vd sliding_share(const vd& most, const vd& size) { return select(size > kRoundingOfSlip * most, 1.0 - most / size, vd{}); }

}  // namespace mpdem

#endif
