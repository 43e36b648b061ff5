// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Forces of LIGGGHTS' contacts on grains, one by one. LIGGGHTS stores no list of them. It passes them to a compute of style
// pair/gran/local or wall/gran/local while it evaluates them once more, which changes neither forces nor histories. This
// class takes the role of such a compute, whether the script has one or not.
#ifndef MPDEM_STYLES_ATOMS_CONTACT_FORCES_H
#define MPDEM_STYLES_ATOMS_CONTACT_FORCES_H

#include <functional>
#include <memory>
#include <vector>

#include "../../cement/bond/grain_virial.h"
#include "../../cement/engine/report.h"
#include "../../mpm/bond_record.h"
#include "lammps.h"

namespace LAMMPS_NS {
class FixWallGran;
}

namespace mpdem {

class ContactForces {
 public:
  explicit ContactForces(LAMMPS_NS::LAMMPS* lmp);
  ~ContactForces();

  // Collective, within a run only, since they use LIGGGHTS' neighbour lists. They use the present velocities, while those of
  // the step are half a step older.
  //
  // Sums the forces of contacts between grains of which at least one has cement. Each contact counts on one rank.
  Report::Magnitudes of_bonded(const std::vector<BondRecord>& table);
  // Adds contacts between grains, and those with walls, planes and meshes. The point of a contact of two grains divides
  // their distance as their radii do. Each grain counts on its rank.
  void add_virials(GrainVirial& virial);

 private:
  class Listener;
  void listen_to_pairs();
  void listen_to_walls();
  void listen_to_meshes(LAMMPS_NS::FixWallGran& wall);
  void listen_to_primitive(LAMMPS_NS::FixWallGran& wall);

  LAMMPS_NS::LAMMPS* lmp_;
  std::unique_ptr<Listener> listener_;
};

}  // namespace mpdem

#endif
