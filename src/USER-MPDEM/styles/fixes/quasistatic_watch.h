// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Warns, once, if cement began to break in a motion that is not quasi-static. The measure is the kinetic share of the energy before
// the first points or columns fail, or links let go by themselves, or damage has dissipated a tenth of what was put into the
// cement: a single bond is at its peak then. It is the median of the last looks, since what softens moves before it fails. Until then
// nothing moves but what the script moves. Later, bursts of what breaks are
// motion too, at any speed of loading. So what breaks is judged again only once all is calm.
#ifndef MPDEM_STYLES_FIXES_QUASISTATIC_WATCH_H
#define MPDEM_STYLES_FIXES_QUASISTATIC_WATCH_H

#include <string>
#include <utility>
#include <vector>

#include "../../cement/engine/cement.h"
#include "lammps.h"
#include "lmptype.h"

namespace mpdem {

class QuasistaticWatch {
 public:
  using bigint = LAMMPS_NS::bigint;
  // who: name of the command. limit: share above which it warns; 0: it never does.
  QuasistaticWatch(LAMMPS_NS::LAMMPS* lmp, std::string who, double limit) : lmp_(lmp), who_(std::move(who)), limit_(limit) {}

  // Call where something failed on this rank.
  void note_failure() { failed_ = true; }
  // Collective. Call at the start of a run, at checks, and at the end of a run. any_failed: something failed before this run.
  void start_run(Cement& c, bool any_failed);
  void check(Cement& c);

 private:
  void keep(double share);
  double median_share() const;
  void warn(const Cement& c);

  LAMMPS_NS::LAMMPS* lmp_;
  std::string who_;
  double limit_;
  bool started_ = false, looked_ = false;  // a run began; there was a look in a run
  bool failed_ = false;                    // something failed on this rank since the last look
  bool damaged_ = false;                   // damage has dissipated much
  bool calm_ = false;                      // nothing broke since there was next to no motion
  bool told_ = false;
  std::vector<double> shares_;  // at the last looks
  bigint at_ = 0;               // step of the last of these
};

}  // namespace mpdem

#endif
