// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The list of damage laws. A new law needs its include and the last entry in `Laws`, since restart files number the
// laws. The keywords of fix mpm, its messages, the kernels and the output follow from the list.
#ifndef MPDEM_MATERIAL_LAWS_H
#define MPDEM_MATERIAL_LAWS_H

#include <memory>

#include "law_list.h"
#include "mazars_damage.h"
#include "no_damage.h"
#include "tensor_damage.h"

namespace mpdem {

using Laws = LawList<NoDamage, TensorDamage, MazarsDamage>;

// Calls f with the law as an object of its own class, so that f is compiled for each class. Call it once in a pass over
// a bond, not inside a loop over points.
template <class F>
decltype(auto) with_law(const Law& law, F f) {
  return pick_law(Laws(), law, f);
}

// Number of a law, from 1, in the order of `Laws`.
template <class L>
constexpr int kLawNumber = number_of<L>(Laws());
inline int law_number(const Law& law) {
  return with_law(law, [](const auto& l) { return kLawNumber<std::decay_t<decltype(l)>>; });
}

// Data with which fix mpm reads a law from a script.
struct LawEntry : NamedLaw {
  std::unique_ptr<Law> (*make)(const VtiElasticity& elasticity, const LawValues& values);
};

template <class... L>
std::vector<LawEntry> entries_of(LawList<L...>) {
  return {LawEntry{{L::kName, L::words()}, [](const VtiElasticity& elasticity, const LawValues& values) -> std::unique_ptr<Law> {
                     return std::make_unique<L>(elasticity, values);
                   }}...};
}

inline const std::vector<LawEntry>& law_entries() {
  static const std::vector<LawEntry> all = entries_of(Laws());
  return all;
}

}  // namespace mpdem

#endif
