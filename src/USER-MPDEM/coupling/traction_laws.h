// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The list of traction laws. Append a new law to the end of `TractionLaws`, since restart files number the laws. The
// options of fix mpm/couple, its messages and the loop over links follow from the list.
#ifndef MPDEM_COUPLING_TRACTION_LAWS_H
#define MPDEM_COUPLING_TRACTION_LAWS_H

#include <memory>

#include "../mpm/point_record.h"
#include "cohesive_traction.h"
#include "penalty_traction.h"

namespace mpdem {

using TractionLaws = LawList<PenaltyTraction, CohesiveTraction>;

// Calls f with the law as an object of its own class, so that f is compiled for each class. Call it once in a pass over
// a bond, not inside a loop over links.
template <class F>
decltype(auto) with_traction(const TractionLaw& law, F f) {
  return pick_law(TractionLaws(), law, f);
}

// Number of a law, from 1, in the order of `TractionLaws`.
inline int traction_law_number(const TractionLaw& law) {
  return with_traction(law, [](const auto& l) { return number_of<std::decay_t<decltype(l)>>(TractionLaws()); });
}

// Data with which fix mpm/couple reads a law from a script.
struct TractionEntry : NamedLaw {
  std::shared_ptr<TractionLaw> (*make)(TractionStiffness stiffness, const LawValues& values);
};

template <class... L>
std::vector<TractionEntry> traction_entries_of(LawList<L...>) {
  static_assert(((L::kFields <= kMostLinkFields) && ...), "raise kMostLinkFields of mpm/point_record.h, and the version of its records");
  return {TractionEntry{{L::kName, L::words()}, [](TractionStiffness stiffness, const LawValues& values) -> std::shared_ptr<TractionLaw> {
                          return std::make_shared<L>(stiffness, values);
                        }}...};
}

inline const std::vector<TractionEntry>& traction_entries() {
  static const std::vector<TractionEntry> all = traction_entries_of(TractionLaws());
  return all;
}

}  // namespace mpdem

#endif
