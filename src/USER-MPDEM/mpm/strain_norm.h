// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The root of the norm of strain that nonlocal damage averages, see drive_average.h. The norm is that of the drive of
// the law for the undamaged material, so it depends on the strain alone.
#ifndef MPDEM_MPM_STRAIN_NORM_H
#define MPDEM_MPM_STRAIN_NORM_H

#include "../material/law.h"

namespace mpdem {

// Returns e^(1/2) of drive_average.h for a drive, which is proportional to e^n with the degree n of the law.
template <class L>
vd root_of_drive(vd drive) {
  const vd root = sqrt(drive);
  return L::kDegree == 2 ? sqrt(root) : root;
}

// Not inlined, so that the root of a strain is bitwise identical wherever it is computed.
template <class L>
__attribute__((noinline)) vd root_of_norm(const L& law, const Sym3<vd>& strain) {
  return root_of_drive<L>(law.undamaged_drive(strain));
}

// Returns the factor by which a drive grows if its root_of_drive() grows by `factor`. With a root as argument it returns the
// drive.
template <class L>
vd drive_factor(vd factor) {
  const vd square = factor * factor;
  return L::kDegree == 2 ? square * square : square;
}

}  // namespace mpdem

#endif
