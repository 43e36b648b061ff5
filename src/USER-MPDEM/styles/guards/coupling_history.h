// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How the cement of fix mpm is coupled, now and in earlier steps. Links store the relative position of grain and
// cement. After steps without links, or with other stiffness, the load of the bonds would jump.
#ifndef MPDEM_STYLES_GUARDS_COUPLING_HISTORY_H
#define MPDEM_STYLES_GUARDS_COUPLING_HISTORY_H

#include <string>

#include "../../cement/layout/cement_restart.h"
#include "../../coupling/penalty_links.h"

namespace mpdem {

class CouplingHistory {
 public:
  // Call it at the start of a run, before couplings register.
  void forget() { id_.clear(); }
  // Registers a coupling of this ID for the cement `cement`. Returns why it cannot be used, or an empty text.
  std::string take(const std::string& id, const std::string& cement, double cell, const PenaltyParameters& p);
  // Call it in the first step of a run.
  void remember(const PenaltyParameters* p);
  // needed: false with `coupling none`.
  void need(bool needed) { needed_ = needed; }
  // Returns why cement without a coupling must not run, or an empty text. restored: does it come from a restart file?
  std::string trouble_without(bool restored) const;

  const LinkSettings& so_far() const { return ran_; }
  void restore(const LinkSettings& ran) { ran_ = ran; }

 private:
  std::string words_so_far() const;
  std::string id_;
  LinkSettings ran_;
  bool needed_ = true;
};

}  // namespace mpdem

#endif
