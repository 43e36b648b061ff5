// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Checks whether cement is compatible with the options of fix mpm and fix mpm/couple. who: name of the command, for
// error messages. All check functions are collective. host_guards.h checks LIGGGHTS' own settings.
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

// Cement of a file may have links with damage, and residue. Only a traction law with damage can continue from these.
void check_links(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, const TractionLaw& law);

}  // namespace mpdem

#endif
