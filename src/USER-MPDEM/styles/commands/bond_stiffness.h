// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Command bond_stiffness: writes the static stiffness of each bond as a table. See doc/bond_stiffness.md.
#ifdef COMMAND_CLASS

CommandStyle(bond_stiffness, BondStiffness)

#else

#ifndef MPDEM_STYLES_COMMANDS_BOND_STIFFNESS_H
#define MPDEM_STYLES_COMMANDS_BOND_STIFFNESS_H

#include <string>
#include <vector>

#include "pointers.h"

namespace mpdem {
struct StiffnessOfBond;
}

namespace LAMMPS_NS {

class BondStiffness : protected Pointers {
 public:
  explicit BondStiffness(LAMMPS* lmp) : Pointers(lmp) {}
  void command(int narg, char** arg);

 private:
  std::string write(const std::string& name, const std::vector<mpdem::StiffnessOfBond>& bonds) const;
};

}  // namespace LAMMPS_NS

#endif
#endif
