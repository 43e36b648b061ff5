// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_STYLES_ATOMS_LOCAL_ATOM_H
#define MPDEM_STYLES_ATOMS_LOCAL_ATOM_H

#include "atom.h"

namespace mpdem {

// Index of an atom of this rank by its ID, or -1. Once atoms were deleted, LIGGGHTS' map ends at the largest ID that is
// left, and LIGGGHTS reads beyond its end for larger ones.
inline int local_atom(LAMMPS_NS::Atom& atom, int tag) {
  const int i = tag <= atom.map_tag_max ? atom.map(tag) : -1;
  return i < atom.nlocal ? i : -1;
}

}  // namespace mpdem

#endif
