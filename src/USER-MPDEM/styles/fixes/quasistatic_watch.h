// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Warns, once, if failure of cement begins in a motion that is not quasi-static. The measure is the kinetic share of
// the energy before the first points, columns or links fail, or before damage has dissipated a tenth of the energy of
// the cement, which is where a single bond has its peak load. It is the median of the last checks, since softening
// cement moves before it fails. Checks at which less than a tenth of the energy had been put in do not count: the load had
// hardly begun. If none counts the load was fast, and the larger of that median and the share at the next check counts.
// Up to the first failure only the script causes motion. Later, failure itself causes bursts of motion at any speed of
// loading. So new failures are judged only after the motion has died away.
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
  // who: name of the command. limit: share above which it warns; 0: never.
  QuasistaticWatch(LAMMPS_NS::LAMMPS* lmp, std::string who, double limit) : lmp_(lmp), who_(std::move(who)), limit_(limit) {}

  // Call it when a point, column or link failed on this rank.
  void note_failure() { failed_ = true; }
  // Collective. Call these at the start of a run, and at checks and the end of a run. any_failed: was there failure
  // before this run?
  void start_run(Cement& c, bool any_failed);
  void check(Cement& c);

 private:
  using Shares = Report::EnergyShares;
  void keep(const Shares& share);
  double median_share(const Shares& now) const;
  void warn(const Cement& c, double share);

  LAMMPS_NS::LAMMPS* lmp_;
  std::string who_;
  double limit_;
  bool started_ = false, checked_ = false;  // a run began; there was a check in a run
  bool failed_ = false;                     // failure on this rank since the last check
  bool damaged_ = false;                    // damage has dissipated a tenth of the energy
  bool calm_ = false;                       // no failure since there was almost no motion
  bool reported_flag_ = false;
  std::vector<Shares> shares_;  // at the last checks
  bigint at_ = 0;               // step of the last of them
};

}  // namespace mpdem

#endif
