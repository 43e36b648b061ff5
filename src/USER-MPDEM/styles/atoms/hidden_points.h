// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Hides the material points from the integrators. Points are behind the grains in LIGGGHTS' list of atoms, and no
// integrator moves them. While fixes integrate, the list ends with the grains, so that their loops skip the points.
// This is done only if all fixes and formulas that act in that time are known not to read points.
#ifndef MPDEM_STYLES_ATOMS_HIDDEN_POINTS_H
#define MPDEM_STYLES_ATOMS_HIDDEN_POINTS_H

#include <optional>
#include <string>

#include "fix.h"
#include "grains_only.h"

namespace mpdem {

class HiddenPoints {
 public:
  explicit HiddenPoints(LAMMPS_NS::LAMMPS* lmp) : lmp_(lmp) {}
  // Call at the start of a run. fix: the one that calls hide() before others integrate, and show() after them.
  void start(const LAMMPS_NS::Fix* fix);
  void hide();
  void show() { hidden_.reset(); }

 private:
  bool may_hide(const LAMMPS_NS::Fix* fix) const;
  LAMMPS_NS::LAMMPS* lmp_;
  bool hides_ = false;
  std::optional<GrainsOnly> hidden_;
};

// Returns whether a formula of LIGGGHTS depends on time, numbers and variables of this kind only.
bool is_of_time_alone(LAMMPS_NS::LAMMPS* lmp, const std::string& formula);

}  // namespace mpdem

#endif
