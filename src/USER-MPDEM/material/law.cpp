// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "law.h"

#include "../numerics/text_of.h"

namespace mpdem {

std::string Law::report_of_strength() const {
  const VtiConstants& c = elasticity_.constants;
  const char* names[2] = {"along the axis", "in the plane  "};
  const double E[2] = {c.Ez, c.Ep};
  std::string text;
  for (int i = 0; i < 2; ++i) {
    const ImpliedStrength s = implied_strength(E[i]);
    text += text_of("  implies   ", names[i], ": tensile strength ", s.tensile_strength, ", strain at onset ", s.onset_strain,
                    ", at failure ", s.failure_strain, "\n");
  }
  return text;
}

bool Law::any_scatter(Scattered what) const {
  for (int n = 0; n < materials(); ++n)
    if (of_material(n).scatter().has(what)) return true;
  return false;
}

bool Law::any_scatter() const {
  for (int n = 0; n < materials(); ++n)
    if (!of_material(n).scatter().rules.empty()) return true;
  return false;
}

std::optional<Localisation> Law::crack_band() const {
  const std::optional<SofteningCurve> curve = softening_curve();
  return curve && length_ > 0.0 ? localise(*curve, cutoff()) : std::nullopt;
}

std::string Law::report_of_band(double cell) const {
  const std::optional<Localisation> band = crack_band();
  std::string text = text_of("  nonlocal  length ", length_, ", ", length_ / cell, " cells");
  if (!band) return text + "; the band of a crack is not known for these parameters\n";
  const ImpliedStrength s = implied_strength(elasticity_.constants.Ez);
  return text + text_of("; a crack takes ", band->energy * s.tensile_strength * s.onset_strain * length_, " per area in a band of ",
                        band->width * length_, ", ", band->width * length_ / cell, " cells",
                        softens_by_position() ? "\n" : "; along a grain half of it\n");
}

}  // namespace mpdem
