// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// During its lifetime LIGGGHTS' list of the atoms of this rank ends with the grains, the group of `atom_modify first`;
// points are behind them. No atom may be made, moved in the list or sent in that time.
#ifndef MPDEM_STYLES_ATOMS_GRAINS_ONLY_H
#define MPDEM_STYLES_ATOMS_GRAINS_ONLY_H

#include "atom.h"

namespace mpdem {

class GrainsOnly {
 public:
  explicit GrainsOnly(LAMMPS_NS::Atom& atom) : atom_(atom), atoms_(atom.nlocal) { atom_.nlocal = atom_.nfirst; }
  ~GrainsOnly() { atom_.nlocal = atoms_; }
  GrainsOnly(const GrainsOnly&) = delete;
  GrainsOnly& operator=(const GrainsOnly&) = delete;

 private:
  LAMMPS_NS::Atom& atom_;
  const int atoms_;
};

}  // namespace mpdem

#endif
