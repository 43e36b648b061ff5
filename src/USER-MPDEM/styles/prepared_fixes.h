// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The fixes of the last run that was prepared. With `run ... pre no` LIGGGHTS calls fixes by their places in that run,
// and calls no init(). A fix that was removed, added or replaced since then leaves other fixes out without a word.
#ifndef MPDEM_PREPARED_FIXES_H
#define MPDEM_PREPARED_FIXES_H

#include <string>
#include <vector>

#include "lammps.h"

namespace LAMMPS_NS {

class PreparedFixes {
 public:
  // Call in the set-up of a run.
  void note(const LAMMPS* lmp);
  // Call at the start of a run without a set-up, the same on all ranks. Stops if the fixes are not those that were noted.
  void check_same(LAMMPS* lmp) const;

 private:
  struct Known {
    std::string id, style;
    bool created;  // LIGGGHTS clears this flag of a fix at the start of a run, but not of one that is made after that
  };
  std::string change(const LAMMPS* lmp) const;

  std::vector<Known> known_;
};

}  // namespace LAMMPS_NS

#endif
