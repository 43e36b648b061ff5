// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "coupling_history.h"

#include <cmath>

#include "../parallel/agree.h"

namespace mpdem {

std::string CouplingHistory::take(const std::string& id, const std::string& cement, double cell, const PenaltyParameters& p) {
  if (!id_.empty() && id != id_) return text_of("cement '", cement, "' is coupled by fix '", id_, "' already; unfix one of them");
  if (ran_.kind == LinksSoFar::kNone)
    return text_of("cement '", cement, "' made steps without a fix mpm/couple, in which the grains went elsewhere, and its links "
                                       "would tear; keep one fix mpm/couple from the first step on, or create the cement anew in a new scene "
                                       "(write_cement, create_cement ... file)");
  if (ran_.kind == LinksSoFar::kLinks) {
    constexpr double kAsPrinted = 1e-5;
    const auto differ = [](double a, double b) { return std::fabs(a - b) > kAsPrinted * b; };
    if (p.at_surface != ran_.at_surface)
      return text_of("'at ", p.at_surface ? "surface" : "points", "', but the steps before were made with 'at ",
                                         ran_.at_surface ? "surface" : "points", "', and the load of the bonds would jump; use that");
    if (differ(p.kn, ran_.kn) || differ(p.kt, ran_.kt))
      return text_of("'kn' and 'kt' over 'length' are ", p.kn, " and ", p.kt, ", but were ", ran_.kn, " and ", ran_.kt,
                                         " in the steps before, and the load of the bonds would jump; use 'kn ", ran_.kn * cell, " kt ",
                                         ran_.kt * cell, "' with 'length cell', as in these");
  }
  id_ = id;
  return "";
}

void CouplingHistory::remember(const PenaltyParameters* p) {
  ran_.kind = p ? LinksSoFar::kLinks : LinksSoFar::kNone;
  if (!p) return;
  ran_.kn = p->kn;
  ran_.kt = p->kt;
  ran_.at_surface = p->at_surface;
}

}  // namespace mpdem
