// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Does the scene go together with its cement? Loss is an error: points and grains that are gone, values that are no
// numbers. What LIGGGHTS lets pass silently, since `thermo_modify lost`
// ignores and a run full of NaN ends like any other. who: the command, for complaints. All collective.
#ifndef MPDEM_CEMENT_CHECKS_H
#define MPDEM_CEMENT_CHECKS_H

#include <string>
#include <vector>

#include "../cement/options.h"
#include "../coupling/traction_law.h"
#include "atom_vec_mpdem.h"
#include "fix.h"

namespace LAMMPS_NS {
class FixGravity;
}

namespace mpdem {

struct CementPoints {
  LAMMPS_NS::bigint expected;
  double density;  // common to all
};

// Box, units, types, group and density of the points; nobody else may move them.
CementPoints check_scene(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::Fix* fix, const LAMMPS_NS::AtomVecMpdem& avec);
void check_box(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<Body>& table);
void check_cell(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<Body>& table, double cell);
void check_axis(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<Body>& table, const CementOptions& o);
// Positions and velocities of the points, as atoms show them.
std::vector<double> motion_shown(LAMMPS_NS::LAMMPS* lmp, const LAMMPS_NS::AtomVecMpdem& avec);
// The state is in the points; atoms only show it, and a command that moved them in between would be without effect. Collective. shown: before the
// state was shown again; way, change: of place and of velocity that are rounding.
void check_points_left_alone(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, const std::vector<double>& shown,
                             double way, double change);
// started: bodies of the table that moved before.
void check_created_positions(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, double cell, int started);
void count_points(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, LAMMPS_NS::bigint expected);
// Empty if all are well. Of this rank.
std::string grain_that_is_not_finite(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec);
std::string axis_name(AxisRule rule, const double* direction);

// Cement of a file may have links with damage, and skins, which only a law with damage of links goes on from.
void check_links(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, const TractionLaw& law);

// Gravity acts on the cement as on the grains: its fix, or null. Any other force on material points would be
// without effect, of which this warns.
LAMMPS_NS::FixGravity* find_gravity(LAMMPS_NS::LAMMPS* lmp, const LAMMPS_NS::Fix* fix, const LAMMPS_NS::AtomVecMpdem& avec);

}  // namespace mpdem

#endif
