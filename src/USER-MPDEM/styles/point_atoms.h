// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How material points become atoms: those of new cement, and those of bonds that had a pattern alone so far (mpm/point_pattern.h).
#ifndef MPDEM_POINT_ATOMS_H
#define MPDEM_POINT_ATOMS_H

#include <vector>

#include "../cement/scene_box.h"
#include "atom_vec_mpdem.h"
#include "pointers.h"

namespace mpdem {

SceneBox scene_box(const LAMMPS_NS::Domain& domain);

class PointAtoms : protected LAMMPS_NS::Pointers {
 public:
  explicit PointAtoms(LAMMPS_NS::LAMMPS* lmp);

  // Room for this many more on this rank. more: will others follow?
  void reserve(double points, bool more);
  // A point of this rank, at x in the box, so many periods away from where it is. head: what it has in common with others of its bond.
  int add(const PointRecord& r, const PatternHead& head, int tag, double* x, const int* image);
  // Collective. What LIGGGHTS has to know of all that were made since this object; of IDs from first_tag on, so many on all ranks.
  void finish(int first_tag, double created);
  int made() const;  // on this rank

 private:
  LAMMPS_NS::AtomVecMpdem* avec_;
  int before_;
};

// Collective. The list of neighbours has the history of contacts, by places of ghosts that new points will take: grains in
// contact across ranks or a periodic boundary would forget how far they have slid. It is kept by IDs instead.
void keep_contact_history(LAMMPS_NS::LAMMPS* lmp);

// Collective. The largest ID of an atom.
int last_tag(LAMMPS_NS::LAMMPS* lmp);

// Collective. Points of these rows of the table, ascending, whose bonds have a pattern: where their first grain took them as a rigid body. Throws
// BadState if some cannot be made. Answers how many.
double make_points(LAMMPS_NS::LAMMPS* lmp, const std::vector<int>& rows);

}  // namespace mpdem

#endif
