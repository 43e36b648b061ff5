// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Lists of laws as types: damage laws (laws.h), and traction laws of links (coupling/traction_laws.h). The class of an
// object is found once a pass, so loops are compiled for each class and make no virtual call. The header also has the
// options that follow the name of a law in a script.
#ifndef MPDEM_MATERIAL_LAW_LIST_H
#define MPDEM_MATERIAL_LAW_LIST_H

#include <map>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <typeinfo>
#include <vector>

namespace mpdem {

template <class... L>
struct LawList {};

// Calls f with `law` as an object of its own class. Throws std::logic_error if that is not in the list.
template <class L, class... Rest, class Base, class F>
decltype(auto) pick_law(LawList<L, Rest...>, const Base& law, F& f) {
  if constexpr (sizeof...(Rest) > 0) {
    if (typeid(law) != typeid(L)) return pick_law(LawList<Rest...>(), law, f);
  } else if (typeid(law) != typeid(L)) {
    throw std::logic_error(std::string("law ") + law.name() + " is not in the list of its header");
  }
  return f(static_cast<const L&>(law));
}

// Index of a class in a list, from 1 on.
template <class Wanted, class L, class... Rest>
constexpr int number_of(LawList<L, Rest...>) {
  if constexpr (std::is_same_v<Wanted, L>) return 1;
  else return 1 + number_of<Wanted>(LawList<Rest...>());
}

// An option of a script after the name of a law, with a number or one of `choices`.
struct LawOption {
  std::string name;
  bool (*allowed)(double);           // null if there are choices
  std::string range;                 // text "must ..." about the allowed numbers
  std::string needed_for;            // what the number is, for the error if it is missing; empty if the option may be left out
  std::vector<std::string> choices;  // the value is the index in this list; empty: a number
};

// Values of the given options.
class LawValues {
 public:
  void set(const std::string& word, double value) { value_[word] = value; }
  bool has(const std::string& word) const { return value_.count(word) != 0; }
  double get(const std::string& word, double otherwise) const {
    const auto at = value_.find(word);
    return at == value_.end() ? otherwise : at->second;
  }

 private:
  std::map<std::string, double> value_;
};

inline bool is_positive(double v) { return v > 0.0; }
inline bool is_not_negative(double v) { return v >= 0.0; }
inline bool is_inside_0_1(double v) { return v > 0.0 && v < 1.0; }
inline bool is_in_0_1_with_1(double v) { return v > 0.0 && v <= 1.0; }

// A law in a script: its name and its options.
struct NamedLaw {
  std::string name;
  std::vector<LawOption> words;
};

}  // namespace mpdem

#endif
