// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Elastic springs. They fail only with the point of the link. The traction is kn delta_n n + kt delta_t.
#ifndef MPDEM_COUPLING_PENALTY_TRACTION_H
#define MPDEM_COUPLING_PENALTY_TRACTION_H

#include "traction_law.h"

namespace mpdem {

class PenaltyTraction final : public TractionLawOf<PenaltyTraction> {
 public:
  static constexpr const char* kName = "penalty";
  static constexpr int kFields = 0;
  static constexpr bool kLeavesResidue = false;
  struct State {};

  explicit PenaltyTraction(TractionStiffness stiffness, const LawValues& = {}) : TractionLawOf(stiffness) {}
  static std::vector<LawOption> words() { return {}; }

  TractionSecant secant(const LinkSeparation&, State) const { return {splat(stiffness().kn), splat(stiffness().kt)}; }
  vd energy(const LinkSeparation& delta, State s) const { return secant(delta, s).energy(delta); }
};

}  // namespace mpdem

#endif
