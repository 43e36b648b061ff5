// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Command delete_bond: removes all cement of bonds between runs, joined or not. See doc/delete_bond.md.
#ifdef COMMAND_CLASS

CommandStyle(delete_bond, DeleteBond)

#else

#ifndef MPDEM_STYLES_COMMANDS_DELETE_BOND_H
#define MPDEM_STYLES_COMMANDS_DELETE_BOND_H

#include <vector>

#include "pointers.h"

namespace mpdem {
class Arguments;
}

namespace LAMMPS_NS {

class DeleteBond : protected Pointers {
 public:
  explicit DeleteBond(LAMMPS* lmp) : Pointers(lmp) {}
  void command(int narg, char** arg);

 private:
  std::vector<int> rows_of_pair(mpdem::Arguments& args) const;
  std::vector<int> rows_of_group(mpdem::Arguments& args) const;
};

}  // namespace LAMMPS_NS

#endif
#endif
