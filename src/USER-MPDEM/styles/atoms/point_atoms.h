// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Makes material points atoms: points of new cement, and points of bonds that had only a pattern so far
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

  // Makes room for this many more points on this rank. more: will others follow?
  void reserve(double points, bool more);
  // Adds a point of this rank, at x in the box. image: number of periods between its true place and x. head: what it
  // has in common with others of its bond.
  int add(const PointRecord& r, const TemplateHead& head, int tag, double* x, const int* image);
  // Collective. Tells LIGGGHTS what it has to know of all points that this object made. Their IDs begin with first_tag.
  // created: their number on all ranks.
  void finish(int first_tag, double created);
  int made() const;  // number made on this rank

 private:
  LAMMPS_NS::AtomVecMpdem* avec_;
  int before_;
};

// Collective. The list of neighbours has the history of contacts, by places of ghosts that new points will take. Grains
// in contact across ranks or a periodic boundary would forget how far they have slid. So the history is kept by IDs
// instead.
void keep_contact_history(LAMMPS_NS::LAMMPS* lmp);

// Collective. Returns the largest ID of an atom.
int last_tag(LAMMPS_NS::LAMMPS* lmp);

// Collective. Makes the points of these rows of the table, ascending, whose bonds have a pattern. Points are where
// their first grain took them as a rigid body. Returns how many were made. Throws BadState if some cannot be made.
double make_points(LAMMPS_NS::LAMMPS* lmp, const std::vector<int>& rows);

}  // namespace mpdem

#endif
