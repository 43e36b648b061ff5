// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Inertia and positions of eight nodes with added mass, one per lane, for loops over all added mass in every step.
#ifndef MPDEM_COUPLING_EIGHT_INERTIAS_H
#define MPDEM_COUPLING_EIGHT_INERTIAS_H

#include "../numerics/simd.h"
#include "added_mass.h"

namespace mpdem {

struct EightInertias {
  const EightNodes& nodes;
  vd inertia;  // mass of each node with its added mass
  vd x[3];     // positions of the nodes

  EightInertias(const AddedMass::EightMasses& masses, const EightNodes& nodes, const Grid& grid)
      : nodes(nodes), inertia(nodes.take_scalar(grid.mass.data()) + masses.added) {
    nodes.find_places(grid, x);
  }

  // Vectors from the centre of a grain.
  void lever_arm(const BondEnd& s, vd* r) const {
    for (int d = 0; d < 3; ++d) r[d] = x[d] - s.x[d];
  }
};

}  // namespace mpdem

#endif
