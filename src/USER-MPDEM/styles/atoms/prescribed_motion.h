// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Components of the motion of a grain that fixes prescribe, whatever loads act on it. `fix move` integrates the
// components that its script leaves out (NULL) like `fix nve`; neither of them rotates a grain by its torque.
#ifndef MPDEM_STYLES_ATOMS_PRESCRIBED_MOTION_H
#define MPDEM_STYLES_ATOMS_PRESCRIBED_MOTION_H

namespace LAMMPS_NS {
class LAMMPS;
}

namespace mpdem {

struct PrescribedMotion {
  bool translation[3] = {false, false, false}, rotation = false;

  bool all() const { return translation[0] && translation[1] && translation[2] && rotation; }
};

PrescribedMotion prescribed_motion(LAMMPS_NS::LAMMPS* lmp, int atom);

}  // namespace mpdem

#endif
