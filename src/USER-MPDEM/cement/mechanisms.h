// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The mechanisms that take part in the step of a bond by a BondPart (mpm/bond_part.h), each where the scene wants it.
#ifndef MPDEM_CEMENT_MECHANISMS_H
#define MPDEM_CEMENT_MECHANISMS_H

#include "scene.h"
#include "splits.h"

namespace mpdem {

// Makes the parts of a bond that has a layout, in the order in which they act.
Bond::Parts parts_of(const Scene& scene, const Bond& b, const Splits& splits);

}  // namespace mpdem

#endif
