// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "vti_elasticity.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace mpdem {

namespace {
double delta(const VtiConstants& c) { return (1.0 - c.nu_p) - 2.0 * c.nu_zp * c.nu_zp * c.Ep / c.Ez; }
}  // namespace

std::string VtiConstants::violated_condition() const {
  std::ostringstream why;
  // Written so that a NaN fails every condition.
  if (!(Ep > 0.0)) why << "Ep = " << Ep << " must be positive";
  else if (!(Ez > 0.0)) why << "Ez = " << Ez << " must be positive";
  else if (!(Gzp > 0.0)) why << "Gzp = " << Gzp << " must be positive";
  else if (!(nu_p > -1.0 && nu_p < 1.0)) why << "nu_p = " << nu_p << " must lie between -1 and 1";
  else if (!(delta(*this) > 0.0))
    why << "nu_zp = " << nu_zp << " must satisfy nu_zp^2 < (1 - nu_p) Ez / (2 Ep) = " << (1.0 - nu_p) * Ez / (2.0 * Ep);
  else if (!std::isfinite(Ep + Ez + Gzp)) why << "the moduli must be finite";
  return why.str();
}

VtiElasticity::VtiElasticity(const VtiConstants& c) : constants(c) {
  const double d = delta(c);
  const double r = c.nu_zp * c.nu_zp * c.Ep / c.Ez;
  C33 = c.Ez * (1.0 - c.nu_p) / d;
  C13 = c.nu_zp * c.Ep / d;
  C11 = c.Ep * (1.0 - r) / ((1.0 + c.nu_p) * d);
  C12 = c.Ep * (c.nu_p + r) / ((1.0 + c.nu_p) * d);
  C44 = c.Gzp;
  C66 = 0.5 * c.Ep / (1.0 + c.nu_p);
}

double VtiElasticity::fastest_wave(double density) const { return std::sqrt(std::max({C11, C33, C44, C66}) / density); }

double VtiElasticity::largest_stiffness() const {
  // The shears are eigenvectors. The axial part couples xx + yy with zz.
  const double a = C11 + C12, b = C33;
  const double half = 0.5 * (a + b);
  const double axial = half + std::sqrt(0.25 * (a - b) * (a - b) + 2.0 * C13 * C13);
  return std::max({axial, 2.0 * C44, 2.0 * C66});
}

}  // namespace mpdem
