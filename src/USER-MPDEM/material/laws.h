// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The laws of damage that there are. A new one takes its include and its place in `Laws`: the words of fix mpm, its
// messages, the kernels and the output follow. Its place is the last: restart files number the laws.
#ifndef MPDEM_LAWS_H
#define MPDEM_LAWS_H

#include <memory>
#include <type_traits>
#include <typeinfo>

#include "mazars_damage.h"
#include "no_damage.h"
#include "tensor_damage.h"

namespace mpdem {

template <class... L>
struct LawList {};

using Laws = LawList<NoDamage, TensorDamage, MazarsDamage>;

template <class L, class... Rest, class F>
decltype(auto) pick_law(LawList<L, Rest...>, const Law& law, F& f) {
  if constexpr (sizeof...(Rest) > 0) {
    if (typeid(law) != typeid(L)) return pick_law(LawList<Rest...>(), law, f);
  } else if (typeid(law) != typeid(L)) {
    throw std::logic_error(std::string("law ") + law.name() + " is not in the list of laws.h");
  }
  return f(static_cast<const L&>(law));
}

// Calls f with the law as an object of its own class, so that f is compiled for each of them. Once a pass over
// a bond, never inside a loop over points.
template <class F>
decltype(auto) with_law(const Law& law, F f) {
  return pick_law(Laws(), law, f);
}

template <class Wanted, class L, class... Rest>
constexpr int number_of(LawList<L, Rest...>) {
  if constexpr (std::is_same_v<Wanted, L>) return 1;
  else return 1 + number_of<Wanted>(LawList<Rest...>());
}
// From 1 on, in the order of `Laws`.
template <class L>
constexpr int kLawNumber = number_of<L>(Laws());
inline int law_number(const Law& law) {
  return with_law(law, [](const auto& l) { return kLawNumber<std::decay_t<decltype(l)>>; });
}

// What fix mpm needs to read a law from a script.
struct LawEntry {
  std::string name;
  std::vector<LawWord> words;
  std::unique_ptr<Law> (*make)(const VtiElasticity& elasticity, const LawValues& values);
};

template <class... L>
std::vector<LawEntry> entries_of(LawList<L...>) {
  return {LawEntry{L::kName, L::words(), [](const VtiElasticity& elasticity, const LawValues& values) -> std::unique_ptr<Law> {
                     return std::make_unique<L>(elasticity, values);
                   }}...};
}

inline const std::vector<LawEntry>& law_entries() {
  static const std::vector<LawEntry> all = entries_of(Laws());
  return all;
}

}  // namespace mpdem

#endif
