// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The static stiffness of all bonds (static_bond.h). Each rank solves the bonds that are whole on it, equal ones once.
// All ranks together solve the bonds that several ranks share, one after the other.
#ifndef MPDEM_CEMENT_CONDENSED_STIFFNESS_OF_BONDS_H
#define MPDEM_CEMENT_CONDENSED_STIFFNESS_OF_BONDS_H

#include <vector>

#include "../layout/layout.h"
#include "../bond/scene.h"

namespace mpdem {

// Result for one bond, the same on all ranks, in the axes of the box. `middle` may lie beyond a periodic boundary.
struct StiffnessOfBond {
  double middle[3], axis[3];
  double K[36];     // 6 by 6, see static_bond.h
  double products;  // applications of the operator; 0: the result was taken from an equal bond
};

// Collective. Returns a row for each bond of the table. layouts: layouts with links of the bonds with points on this
// rank. The scene must have its grains and link parameters. Throws BadState if a grain is gone or a solution does not
// converge.
std::vector<StiffnessOfBond> stiffness_of_bonds(const Scene& scene, std::vector<BondLayout> layouts);

// Collective. The stiffness of the undamaged films alone. Empty if no bond has a film.
std::vector<StiffnessOfBond> stiffness_of_films(const Scene& scene);

}  // namespace mpdem

#endif
