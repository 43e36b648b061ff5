// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Functions of PenaltyLinks that read and store states of a traction law, for the files that have its loops.
#ifndef MPDEM_COUPLING_LINK_STATES_H
#define MPDEM_COUPLING_LINK_STATES_H

#include <cstring>

#include "penalty_links.h"

namespace mpdem {

template <class L>
typename L::State PenaltyLinks::state(const L&, std::size_t block) const {
  typename L::State s{};
  if constexpr (L::kFields > 0) {
    static_assert(sizeof s == L::kFields * sizeof(vd), "a state is its fields");
    std::memcpy(&s, &states_[L::kFields * block], sizeof s);
  }
  return s;
}

template <class L>
std::uint8_t PenaltyLinks::store_state(const L&, std::size_t i, const typename L::State& now, const TractionUpdate& u, PointStore& points,
                                       LinkStep& step) {
  const LinkBlock& b = blocks_[i];
  const std::uint8_t attached = link_flags_[i].attached;
  std::memcpy(&states_[L::kFields * i], &now, sizeof now);
  std::uint8_t freed = 0;
  for (int l = 0; l < kLanes; ++l) {
    if (!(attached >> l & 1) || !u.grown[l]) continue;
    for (int k = 0; k < L::kFields; ++k) points.links[b.link[l]].state[k] = states_[L::kFields * i + k][l];
    if (!u.debond[l]) continue;
    freed |= static_cast<std::uint8_t>(1u << l);
    step.debond.push_back(b.link[l]);
  }
  return freed;
}

}  // namespace mpdem

#endif
