// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds numbers that no cement has, such as moduli in GPa among pressures in Pa, or a strength in the place of the
// threshold B0. These are warnings, since any number may be right in a study.
#ifndef MPDEM_STYLES_GUARDS_UNIT_CHECKS_H
#define MPDEM_STYLES_GUARDS_UNIT_CHECKS_H

#include <string>
#include <vector>

#include "../../material/law.h"
#include "../../mpm/bond_record.h"

namespace mpdem {

// Returns the texts of the warnings. units: si, cgs or micro; with others only the strain at failure is judged.
// density: of the cement, in these units.
std::vector<std::string> unlike_solids(const Law& law, double density, const std::string& units);
// The same for the moduli of elastic grains.
std::vector<std::string> unlike_grains(const std::vector<BondRecord>& table, const std::string& units);

}  // namespace mpdem

#endif
