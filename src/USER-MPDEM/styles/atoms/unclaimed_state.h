// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Per-atom state of other fixes between read_restart and the first run. LIGGGHTS stores it in atom->extra until a fix
// of the same ID and style is defined, which reads it for every atom. Points made in between have no state in the file,
// and LIGGGHTS gives new atoms none (create_atoms refuses to work then). They get a neutral row: no contacts, and zeros
// as values. Before the first run, the fixes that read it set their own defaults, as for points made later. No command
// can have set a value before (`set` refuses to).
#ifndef MPDEM_STYLES_ATOMS_UNCLAIMED_STATE_H
#define MPDEM_STYLES_ATOMS_UNCLAIMED_STATE_H

#include <vector>

#include "lammps.h"

namespace LAMMPS_NS {

class UnclaimedState {
 public:
  // Returns whether the state of fixes in a restart file, `size` numbers, has one record for each fix of the file.
  static bool fits(LAMMPS* lmp, const double* state, int size);
  // Collective. Adds neutral rows for the local atoms from index `first` on, whose IDs are at least `first_tag`.
  void add(LAMMPS* lmp, int first, int first_tag);
  // Replaces the neutral rows by the defaults of the fixes.
  void finish(LAMMPS* lmp);

 private:
  std::vector<double> neutral_row(LAMMPS* lmp, int atoms) const;

  int first_tag_ = 0;        // lowest ID of points with a neutral row; 0: none
  std::vector<double> row_;  // the neutral row
};

}  // namespace LAMMPS_NS

#endif
