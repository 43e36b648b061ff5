// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The time step of `timestep auto` and the sub-steps of `subcycle auto` of fix mpm. A step once found is kept as long
// as it is stable, since formulas in step*dt would jump with it. Cement that fails may raise or lower the stable step.
#ifndef MPDEM_STYLES_FIXES_AUTO_STEP_H
#define MPDEM_STYLES_FIXES_AUTO_STEP_H

#include <string>

#include "../../cement/engine/cement.h"
#include "fix.h"

namespace mpdem {

class AutoStep : protected LAMMPS_NS::Pointers {
 public:
  // who: name of the command. share: S of `timestep auto S`; 0 if the script sets the time step.
  AutoStep(LAMMPS_NS::LAMMPS* lmp, std::string who, double share) : Pointers(lmp), who_(std::move(who)), share_(share) {}

  // Number of sub-steps of the cement in a step.
  int substeps(const CementOptions& o) const;
  // Collective. Sets step and sub-steps. Call it in the init of fix `running`. Fixes that come before it, but for fix mpm
  // (own), are initialised again, since they have read the old step. Throws BadState.
  void set(Cement& c, const LAMMPS_NS::Fix* running, const LAMMPS_NS::Fix* own);
  // With `subcycle auto` prints the number of sub-steps if it changed, and stops if there are too many.
  void report_substeps(const CementOptions& o);

  void save(CementHead& head) const;
  void restore(const CementHead& head);

 private:
  double longest_step(Cement& c, double cement_step);
  void set_step(double limit, const EigenvalueEstimate& e, const LAMMPS_NS::Fix* running, const LAMMPS_NS::Fix* own);
  void warn_of_splitting(const CementOptions& o);

  std::string who_;
  double share_;
  double last_step_ = 0.0, last_share_ = 0.0;  // the step that was found last, and its share
  double longest_substep_ = 0.0;               // longest sub-step for `subcycle auto`; 0: not yet known
  int substeps_reported_ = 0;
  bool splitting_reported_ = false;
};

}  // namespace mpdem

#endif
