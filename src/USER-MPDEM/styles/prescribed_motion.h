// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Tells which part of the motion of a grain fixes prescribe, whatever else acts on it. `fix move` integrates the
// components that its script leaves out (NULL) like `fix nve`. Neither turns a grain by its torque.
#ifndef MPDEM_PRESCRIBED_MOTION_H
#define MPDEM_PRESCRIBED_MOTION_H

#include <string>

namespace LAMMPS_NS {
class Fix;
class LAMMPS;
}

namespace mpdem {

struct PrescribedMotion {
  bool translation[3] = {false, false, false}, rotation = false;

  bool all() const { return translation[0] && translation[1] && translation[2] && rotation; }
};

PrescribedMotion prescribed_motion(LAMMPS_NS::LAMMPS* lmp, int atom);
// Names the fix that changes the force of a free grain in a way that its cement does not follow, or is empty. The text goes
// after "bonded grain 1 is ". cement_fix: place of fix mpm in the list of fixes.
std::string trouble_with_forces(LAMMPS_NS::LAMMPS* lmp, int atom, int cement_fix);
// Does the fix move free grains by the velocity Verlet steps that sub-steps take, or prescribe their motion?
bool moves_as_substeps_do(const LAMMPS_NS::Fix& fix);

}  // namespace mpdem

#endif
