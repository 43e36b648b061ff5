// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Checks whether cement goes together with the words of fix mpm and fix mpm/couple. who: name of the command, for complaints.
// All functions that check are collective. host_guards.h has what LIGGGHTS is told besides.
#ifndef MPDEM_STYLES_GUARDS_CEMENT_CHECKS_H
#define MPDEM_STYLES_GUARDS_CEMENT_CHECKS_H

#include <string>
#include <vector>

#include "../../cement/bond/options.h"
#include "../../coupling/traction_law.h"
#include "../atoms/atom_vec_mpdem.h"

namespace mpdem {

void check_cell(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<BondRecord>& table, double cell);
void check_axis(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<BondRecord>& table, const CementOptions& o);
std::string axis_name(AxisRule rule, const double* direction);

// Cement of a file may have links with damage, and skins. Only a law with damage of links can go on from these.
void check_links(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, const TractionLaw& law);

}  // namespace mpdem

#endif
