// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Contact of cement with grains and walls of LIGGGHTS and with other cement, by contact/piece_contact.h: gives it the
// motion of the grains, and adds its forces to theirs before fix mpm reads them as loads of the host. Fragments have their
// motion from fix mpm, and give it their forces. The rank in whose part of the box a fragment is finds its contacts.
#ifndef MPDEM_STYLES_ATOMS_CEMENT_CONTACTS_H
#define MPDEM_STYLES_ATOMS_CEMENT_CONTACTS_H

#include <vector>

#include "../../cement/engine/cement.h"
#include "../../contact/piece_contact.h"
#include "atom_vec_mpdem.h"
#include "wall_faces.h"

namespace mpdem {

class CementContacts {
 public:
  explicit CementContacts(LAMMPS_NS::LAMMPS* lmp) : lmp_(lmp), walls_(lmp) {}

  // Collective. Call it at the start of a run, before loads are read. The scene has contact if its coupling has friction.
  void start_run(LAMMPS_NS::AtomVecMpdem& avec, Cement& cement);
  // Collective. Adds the forces of a step to the grains.
  void add_forces(LAMMPS_NS::AtomVecMpdem& avec, Cement& cement, double dt);
  // Collective. Call it at the end of a step, before grains move: takes the surfaces of bonds that changed.
  void take_changes(LAMMPS_NS::AtomVecMpdem& avec, Cement& cement);
  // Call it when atoms moved to other ranks or have other indices.
  void atoms_moved() { search_is_due_ = true; }

 private:
  void find_changes(LAMMPS_NS::AtomVecMpdem& avec, Cement& cement);
  void take_surfaces(Cement& cement);
  void check_reach(Cement& cement) const;
  void read_bodies(LAMMPS_NS::AtomVecMpdem& avec, Cement& cement);
  void add_fragments(Cement& cement);
  void search(LAMMPS_NS::AtomVecMpdem& avec, Cement& cement);

  LAMMPS_NS::LAMMPS* lmp_;
  LiggghtsWalls walls_;
  std::vector<int> atoms_;           // of the grains of this rank
  std::vector<int> fragments_;       // numbers of the fragments of this rank
  std::vector<ContactBody> bodies_;  // grains and fragments in this order
  // Of each bond, when its surface was taken.
  struct Taken {
    bool apart = false;
    int points = 0;
    double seen = 0.0;  // Cement::seen_of_fragments()
    bool operator!=(const Taken& b) const { return apart != b.apart || points != b.points || seen != b.seen; }
  };
  std::vector<Taken> taken_;
  double changes_ = 0.0;
  bool active_ = false, search_is_due_ = true;
  bool nodes_moved_ = true;  // nodes have the positions of the grains, see Cement::motions_of_fragments()
};

}  // namespace mpdem

#endif
