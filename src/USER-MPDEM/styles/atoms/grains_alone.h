// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// During its lifetime LIGGGHTS' list of the atoms of this rank ends with the grains, the group of `atom_modify first`;
// points are behind them. No atom may be made, moved in the list or sent in that time.
#ifndef MPDEM_STYLES_ATOMS_GRAINS_ALONE_H
#define MPDEM_STYLES_ATOMS_GRAINS_ALONE_H

#include "atom.h"

namespace mpdem {

class GrainsAlone {
 public:
  explicit GrainsAlone(LAMMPS_NS::Atom& atom) : atom_(atom), atoms_(atom.nlocal) { atom_.nlocal = atom_.nfirst; }
  ~GrainsAlone() { atom_.nlocal = atoms_; }
  GrainsAlone(const GrainsAlone&) = delete;
  GrainsAlone& operator=(const GrainsAlone&) = delete;

 private:
  LAMMPS_NS::Atom& atom_;
  const int atoms_;
};

}  // namespace mpdem

#endif
