// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Forces of LIGGGHTS' contacts between grains, one by one. LIGGGHTS keeps no list of them. It tells them to a compute of the
// style pair/gran/local while it finds them once more, which changes neither forces nor histories. This class listens in the
// place of such a compute, whether the script has one or not. Contacts with walls are not among them.
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

  // Collective, within a run alone, since it uses LIGGGHTS' list of neighbours. Sums the forces of contacts of which one grain has
  // cement at least; each contact is on one rank. Velocities are those of now, while those of the step lie half a step before.
  Report::Magnitudes of_bonded(const std::vector<BondRecord>& table);

 private:
  class Listener;

  LAMMPS_NS::LAMMPS* lmp_;
  std::unique_ptr<Listener> listener_;
};

}  // namespace mpdem

#endif
