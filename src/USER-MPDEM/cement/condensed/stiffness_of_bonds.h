// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The static stiffness of all bonds. Bonds of one rank are solved there, one by one, equal ones once. Bonds that ranks
// cut are solved by all ranks together, one after the other. See static_bond.h.
#ifndef MPDEM_CEMENT_CONDENSED_STIFFNESS_OF_BONDS_H
#define MPDEM_CEMENT_CONDENSED_STIFFNESS_OF_BONDS_H

#include <vector>

#include "../layout/layout.h"
#include "../bond/scene.h"

namespace mpdem {

// Result for one bond, the same on all ranks. Places are in the coordinates of the box, maybe beyond a periodic side.
struct StiffnessOfBond {
  double middle[3], axis[3];
  double K[36];     // 6 by 6, see static_bond.h
  double products;  // products with the operator that it took; 0: the result of an equal bond was taken
};

// Collective. Returns a row for each bond of the table. layouts: layouts with links, of the bonds of this rank that
// have points. The scene needs links and has its grains. Throws BadState if a grain is gone or a solution is not found.
std::vector<StiffnessOfBond> stiffness_of_bonds(const Scene& scene, std::vector<BondLayout> layouts);

// Collective. The stiffness of the films alone, as if nothing were damaged. Empty if no bond has a film.
std::vector<StiffnessOfBond> stiffness_of_films(const Scene& scene);

}  // namespace mpdem

#endif
