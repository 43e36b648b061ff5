// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Warnings at the first run: numbers that no cement has, averages wider than the bonds, scatter that has no effect.
#ifndef MPDEM_STYLES_FIXES_CEMENT_WARNINGS_H
#define MPDEM_STYLES_FIXES_CEMENT_WARNINGS_H

#include <string>

#include "../../cement/engine/cement.h"
#include "lammps.h"

namespace mpdem {

// Collective. who: name of the command.
void warn_of_cement(LAMMPS_NS::LAMMPS* lmp, const std::string& who, Cement& c);

}  // namespace mpdem

#endif
