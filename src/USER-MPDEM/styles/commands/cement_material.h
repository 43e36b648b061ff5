// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Command cement_material: defines a cement besides that of fix mpm, for create_cement. See doc/cement_material.md.
#ifdef COMMAND_CLASS

CommandStyle(cement_material, CementMaterial)

#else

#ifndef MPDEM_STYLES_COMMANDS_CEMENT_MATERIAL_H
#define MPDEM_STYLES_COMMANDS_CEMENT_MATERIAL_H

#include "pointers.h"

namespace LAMMPS_NS {

class CementMaterial : protected Pointers {
 public:
  explicit CementMaterial(LAMMPS* lmp) : Pointers(lmp) {}
  void command(int narg, char** arg);
};

}  // namespace LAMMPS_NS

#endif
#endif
