// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Tutorial 9: pulls points with the law of linear_damage.h by uniaxial stress along the axis until they fail, without LIGGGHTS. The
// output is a table: strain, stress in Pa by the law and by its closed form, damage, and the sum of dissipated and released energy, J/m3.
#include <cstdio>

#include "linear_damage.h"

using namespace mpdem;

int main() {
  const VtiConstants calcite{50.83e9, 28.79e9, 0.2744, 0.2581, 14.86e9};
  const double e0 = 7e-4, ductility = 4.0;
  LawValues words;
  words.set("e0", e0);
  words.set("ductility", ductility);
  const LinearDamage law{VtiElasticity(calcite), words};

  LinearDamage::State state{};
  Sym3<vd> before{};
  double spent = 0.0;
  std::printf("strain,stress_Pa,closed_form_Pa,damage,energy_J_m3\n");
  const double step = 5e-6;
  for (int n = 1; n < 1000; ++n) {
    const double e = n * step, across = -calcite.nu_zp * e;
    const Sym3<vd> strain{splat(across), splat(across), splat(e), vd{}, vd{}, vd{}};
    const LawUpdate u = law.update(before, strain, state, splat_mask(true), splat(1.0), 1.0);
    before = strain;
    spent += u.dissipated[0] + u.released[0];
    const double closed = e < e0 ? e : e0 * (ductility * e0 - e) / (ductility * e0 - e0);
    if (n % 20 == 0 || u.failed[0])
      std::printf("%.6g,%.6g,%.6g,%.4f,%.6g\n", e, u.stress.zz[0], u.failed[0] ? 0.0 : calcite.Ez * closed, law.largest_damage(state)[0],
                  spent);
    if (u.failed[0]) break;
  }
  return 0;
}
