// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Per-atom state of fixes that waits in atom->extra from read_restart to the first run, until a fix of the same ID and
// style is defined and takes it for every atom there is. Points that are made in between have no state in the file, and
// LIGGGHTS gives new atoms none either (create_atoms refuses to work then). They get a row of their own: no contacts,
// and zeros in place of values. Before the first run, the fixes that took it set their own default, as they do for
// points that are made after them. No command can have set a value before (`set` refuses to).
#ifndef MPDEM_STYLES_ATOMS_WAITING_STATE_H
#define MPDEM_STYLES_ATOMS_WAITING_STATE_H

#include <vector>

#include "lammps.h"

namespace LAMMPS_NS {

class WaitingState {
 public:
  // Returns whether state of fixes from a restart file, `size` numbers, has as many parts as the file has fixes.
  static bool fits(LAMMPS* lmp, const double* state, int size);
  // Collective. Adds rows for the local atoms from `first` on, whose IDs are at least `first_tag`.
  void add(LAMMPS* lmp, int first, int first_tag);
  // Sets defaults of fixes in place of what `add` gave.
  void finish(LAMMPS* lmp);

 private:
  std::vector<double> neutral_row(LAMMPS* lmp, int atoms) const;

  int first_tag_ = 0;  // lowest ID of points with such a row; 0: there are none
  std::vector<double> row_;
};

}  // namespace LAMMPS_NS

#endif
