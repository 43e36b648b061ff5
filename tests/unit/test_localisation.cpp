// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "material/localisation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lanes.h"
#include "material/tensor_damage.h"

namespace mpdem {
namespace {

Localisation band(double m) {
  DamageParameters p;
  p.B0 = 1.0;
  p.exponent = m;
  return localise(softening_curve(p), p.Dcut).value();
}

TEST(Localisation, Print) {
  for (double m : {-0.5, 0.0, 1.0, 2.0}) std::printf("%g %.6f %.6f\n", m, band(m).energy, band(m).width);
  DamageParameters p; p.B0=1; 
  for (double g: {3.0, 10.0, 40.0, 60.0}) printf("%g %g\n", g, nonlocal_exponent(p, g*std::sqrt(2.0), 1.0));
}

}  // namespace
}  // namespace mpdem
