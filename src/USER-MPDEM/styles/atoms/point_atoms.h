// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Creates the atoms of material points: of new cement, and of bonds that had only a template of points so far
// (mpm/point_template.h).
#ifndef MPDEM_STYLES_ATOMS_POINT_ATOMS_H
#define MPDEM_STYLES_ATOMS_POINT_ATOMS_H

#include <vector>

#include "../../cement/creation/scene_box.h"
#include "atom_vec_mpdem.h"
#include "pointers.h"

namespace mpdem {

SceneBox scene_box(const LAMMPS_NS::Domain& domain);

class PointAtoms : protected LAMMPS_NS::Pointers {
 public:
  explicit PointAtoms(LAMMPS_NS::LAMMPS* lmp);

  // Reserves memory for this many more points on this rank. more: will others follow?
  void reserve(double points, bool more);
  // Adds a point of this rank at position x in the box. image: number of periods between its unwrapped position and x.
  // head: what all points of its bond have in common. Returns the index of the atom.
  int add(const PointRecord& r, const TemplateHead& head, int tag, double* x, const int* image);
  // Collective. Registers all points that this object made with LIGGGHTS: number of atoms, state of fixes, map of IDs.
  // first_tag: their lowest ID. created: their number on all ranks.
  void finish(int first_tag, double created);
  int made() const;  // number made on this rank

 private:
  LAMMPS_NS::AtomVecMpdem* avec_;
  int before_;
};

// Collective. Call before points are made. The neighbour list stores the history of contacts by indices of ghosts,
// which the new points will occupy. Grains in contact across ranks or a periodic boundary would lose their tangential
// displacement. So the history is stored by IDs instead.
void keep_contact_history(LAMMPS_NS::LAMMPS* lmp);

// Collective. Returns the largest ID of an atom.
int last_tag(LAMMPS_NS::LAMMPS* lmp);

// Collective. Makes the points of the bonds of these rows, ascending, from their templates. The points are where rigid
// motion with the first grain took them. Returns how many were made. Throws BadState if some cannot be made.
double make_points(LAMMPS_NS::LAMMPS* lmp, const std::vector<int>& rows);

}  // namespace mpdem

#endif
