// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Forces of LIGGGHTS' contacts between grains, one by one. LIGGGHTS stores no list of them. It passes them to a compute
// of style pair/gran/local while it evaluates them once more, which changes neither forces nor histories. This class
// takes the role of such a compute, whether the script has one or not. Contacts with walls are not included.
#ifndef MPDEM_STYLES_ATOMS_CONTACT_FORCES_H
#define MPDEM_STYLES_ATOMS_CONTACT_FORCES_H

#include <memory>
#include <vector>

#include "../../cement/engine/report.h"
#include "../../mpm/bond_record.h"
#include "lammps.h"

namespace mpdem {

class ContactForces {
 public:
  explicit ContactForces(LAMMPS_NS::LAMMPS* lmp);
  ~ContactForces();

  // Collective. Within a run only, since it uses LIGGGHTS' neighbour list. Sums the forces of contacts in which at
  // least one grain has cement; each contact counts on one rank. Uses the present velocities, while those of the step
  // are half a step older.
  Report::Magnitudes of_bonded(const std::vector<BondRecord>& table);

 private:
  class Listener;

  LAMMPS_NS::LAMMPS* lmp_;
  std::unique_ptr<Listener> listener_;
};

}  // namespace mpdem

#endif
