// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Checks whether the scene goes together with its cement. Loss is an error: points and grains that are gone, and values
// that are no numbers. LIGGGHTS lets these pass silently, since `thermo_modify lost` ignores and a run full of NaN ends
// like any other. who: name of the command, for complaints. All functions that check are collective.
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
  double density;  // one density for all points; 0 if there are none
};

// Checks box, units, types, group and density of the points. Nothing but `fix` may move them. may_leave: deleted points are looked at
// later (leaving_atoms.h).
CementPoints check_scene(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::Fix* fix, const LAMMPS_NS::AtomVecMpdem& avec, bool may_leave);
void check_box(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<Body>& table);
void check_cell(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<Body>& table, double cell);
void check_axis(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<Body>& table, const CementOptions& o);
// Returns positions and velocities of the points, as atoms show them.
std::vector<double> motion_shown(LAMMPS_NS::LAMMPS* lmp, const LAMMPS_NS::AtomVecMpdem& avec);
// Collective. The state is in the points. Atoms only show it, so a command that moved atoms in between would be without
// effect. shown: what they showed before the state was shown again. way, change: changes of place and of velocity that
// count as rounding.
void check_points_left_alone(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, const std::vector<double>& shown,
                             double way, double change);
// started: number of bodies of the table that moved before.
void check_created_positions(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, double cell, int started);
void count_points(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, LAMMPS_NS::bigint expected);
// Returns a complaint about a grain of this rank, or an empty text if all are well. Forces and torques are looked at if they are known.
std::string grain_that_is_not_finite(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, bool forces_known);
std::string axis_name(AxisRule rule, const double* direction);

// Cement of a file may have links with damage, and skins. Only a law with damage of links can go on from these.
void check_links(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec, const TractionLaw& law);

// Collective. Returns the fixes of the gravity that acts on the cement as on the grains. Their sum is its gravity. Stops
// if one has a part of the points in its group. Warns of any other force on material points, which would be without
// effect.
std::vector<LAMMPS_NS::FixGravity*> gravities(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const LAMMPS_NS::Fix* fix, const LAMMPS_NS::AtomVecMpdem& avec);

}  // namespace mpdem

#endif
