// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// fix check/timestep/mpm: compares the time step with the largest stable one of the cement every N steps, and warns or
// stops. See doc/fix_check_timestep_mpm.md.
#ifdef FIX_CLASS

FixStyle(check / timestep / mpm, FixCheckTimestepMpm)

#else

#ifndef MPDEM_STYLES_FIXES_FIX_CHECK_TIMESTEP_MPM_H
#define MPDEM_STYLES_FIXES_FIX_CHECK_TIMESTEP_MPM_H

#include <array>
#include <string>

#include "fix.h"

namespace LAMMPS_NS {

class FixCheckTimestepMpm : public Fix {
 public:
  FixCheckTimestepMpm(LAMMPS* lmp, int narg, char** arg);
  int setmask() override;
  void init() override;
  void setup(int vflag) override;
  void end_of_step() override;
  double compute_vector(int n) override;

 private:
  void check();
  class FixMpm* cement_ = nullptr;
  std::string cement_id_;
  double fraction_ = 0.0;  // share of the stable step above which it warns or stops
  bool stop_ = false;
  double limit_ = 0.0, share_ = 0.0;         // stable step at the last check, and the time step over it
  double of_grains_ = 0.0;                   // limit by grains on their bonds, found for scene_
  std::array<double, 3> scene_ = {0, 0, 0};  // number of bonds, number of sub-steps, checksum of the inertia of free grains
};

}  // namespace LAMMPS_NS

#endif
#endif
