// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Transversely isotropic (VTI) elasticity in the material frame. The axes x, y span the plane of isotropy (p), and z is
// the symmetry axis. Engineering constants are those of the compliance
//   S11 = S22 = 1/Ep, S33 = 1/Ez, S12 = -nu_p/Ep, S13 = S23 = -nu_zp/Ez,
//   S44 = S55 = 1/Gzp, S66 = 2 (1 + nu_p)/Ep,
// nu_zp = -eps_p/eps_z under sigma_z alone. Moduli in units of pressure.
#ifndef MPDEM_MATERIAL_VTI_ELASTICITY_H
#define MPDEM_MATERIAL_VTI_ELASTICITY_H

#include <string>

#include "../numerics/tensor3.h"

namespace mpdem {

struct VtiConstants {
  double Ep, Ez, nu_p, nu_zp, Gzp;

  static VtiConstants isotropic(double E, double nu) { return {E, E, nu, nu, 0.5 * E / (1.0 + nu)}; }

  // Text of the first condition that fails; empty if there is none. Five conditions are necessary and sufficient for a
  // positive energy of every strain. A sixth asks for finite moduli.
  std::string violated_condition() const;
};

struct VtiElasticity {
  double C11, C12, C13, C33, C44, C66;
  VtiConstants constants;  // constants that it was made from

  // The constants must be positive definite (VtiConstants::violated_condition).
  explicit VtiElasticity(const VtiConstants& c);

  template <class T>
  Sym3<T> stress(const Sym3<T>& e) const {
    return {C11 * e.xx + C12 * e.yy + C13 * e.zz,
            C12 * e.xx + C11 * e.yy + C13 * e.zz,
            C13 * (e.xx + e.yy) + C33 * e.zz,
            (2.0 * C44) * e.yz,
            (2.0 * C44) * e.xz,
            (2.0 * C66) * e.xy};
  }

  // Speed of the fastest plane wave along the axis or in the plane.
  double fastest_wave(double density) const;
  double softest_shear() const { return C44 < C66 ? C44 : C66; }

  // Largest eigenvalue of the stiffness as a map of symmetric tensors (Mandel form).
  double largest_stiffness() const;
};

}  // namespace mpdem

#endif
