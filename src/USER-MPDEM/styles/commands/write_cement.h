// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Command write_cement: writes material points as a text file that create_cement reads. See doc/write_cement.md.
#ifdef COMMAND_CLASS

CommandStyle(write_cement, WriteCement)

#else

#ifndef MPDEM_STYLES_COMMANDS_WRITE_CEMENT_H
#define MPDEM_STYLES_COMMANDS_WRITE_CEMENT_H

#include <string>
#include <vector>

#include "../words/arguments.h"
#include "pointers.h"

namespace LAMMPS_NS {

class WriteCement : protected Pointers {
 public:
  explicit WriteCement(LAMMPS* lmp) : Pointers(lmp) {}
  void command(int narg, char** arg);

 private:
  struct Now;
  Now gather(const std::vector<char>& chosen, const mpdem::Arguments& args) const;
  std::string write(const std::string& name, const std::vector<char>& chosen, const Now& now) const;
};

}  // namespace LAMMPS_NS

#endif
#endif
