// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "unclaimed_state.h"

#include <mpi.h>

#include <algorithm>
#include <climits>
#include <vector>

#include "atom.h"
#include "fix.h"
#include "memory.h"
#include "modify.h"

namespace LAMMPS_NS {

// In a row of atom->extra, the data of each fix begin with their length. Values have the same length for all atoms. A
// contact history grows with the contacts. Zeros of any length are one without contacts, so the shortest is taken.

bool UnclaimedState::fits(LAMMPS* lmp, const double* state, int size) {
  if (size > lmp->atom->nextra_store) return false;
  int at = 0;
  for (int n = 0; n < lmp->modify->nfix_restart_peratom; ++n) {
    const double length = at < size ? state[at] : 0.0;
    if (!(length >= 1.0 && length <= size - at)) return false;
    at += static_cast<int>(length);
  }
  return at == size;
}

std::vector<double> UnclaimedState::neutral_row(LAMMPS* lmp, int atoms) const {
  const int fixes = lmp->modify->nfix_restart_peratom;
  std::vector<int> shortest(fixes, INT_MAX);
  for (int i = 0; i < atoms; ++i) {
    const double* part = lmp->atom->extra[i];
    for (int n = 0; n < fixes; part += static_cast<int>(*part), ++n) shortest[n] = std::min(shortest[n], static_cast<int>(*part));
  }
  MPI_Allreduce(MPI_IN_PLACE, shortest.data(), fixes, MPI_INT, MPI_MIN, lmp->world);
  std::vector<double> row;
  for (int n = 0; n < fixes; ++n) {
    row.push_back(shortest[n]);
    row.insert(row.end(), shortest[n] - 1, 0.0);
  }
  return row;
}

void UnclaimedState::add(LAMMPS* lmp, int first, int first_tag) {
  Atom* atom = lmp->atom;
  if (atom->nextra_store == 0) return;
  if (first_tag_ == 0) {
    row_ = neutral_row(lmp, first);
    first_tag_ = first_tag;
  }
  lmp->memory->grow(atom->extra, atom->nmax, atom->nextra_store, "atom:extra");
  for (int i = first; i < atom->nlocal; ++i) std::copy(row_.begin(), row_.end(), atom->extra[i]);
}

void UnclaimedState::finish(LAMMPS* lmp) {
  if (first_tag_ == 0) return;
  const Atom* atom = lmp->atom;
  for (int m = 0; m < lmp->modify->nfix; ++m) {
    Fix* fix = lmp->modify->fix[m];
    if (!fix->recent_restart || !fix->restart_peratom || !fix->create_attribute) continue;
    fix->pre_set_arrays();
    for (int i = 0; i < atom->nlocal; ++i)
      if (atom->tag[i] >= first_tag_) fix->set_arrays(i);
  }
  first_tag_ = 0;
}

}  // namespace LAMMPS_NS
