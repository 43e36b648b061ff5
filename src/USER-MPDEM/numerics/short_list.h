// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A list of non-negative integers, such as indices of nodes. It takes two bytes for each while all of them fit into
// these, as they do in small bonds. From the first one that does not fit, it takes four bytes for each.
#ifndef MPDEM_NUMERICS_SHORT_LIST_H
#define MPDEM_NUMERICS_SHORT_LIST_H

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "shared_list.h"

namespace mpdem {

class ShortList {
 public:
  std::size_t size() const { return wide_.empty() ? narrow_.size() : wide_.size(); }
  bool empty() const { return size() == 0; }
  int operator[](std::size_t i) const { return wide_.empty() ? narrow_[i] : wide_[i]; }
  void push_back(int v) {
    if (wide_.empty() && fits(v)) narrow_.own().push_back(static_cast<Narrow>(v));
    else wide_list().push_back(v);
  }
  void resize(std::size_t size) {
    if (wide_.empty()) narrow_.own().resize(size);
    else wide_.own().resize(size);
  }
  // Calls f with a pointer to the integers, of two or four bytes each.
  template <class F>
  decltype(auto) with(F f) const {
    if (wide_.empty()) return f(narrow_.data());
    return f(wide_.data());
  }
  // Replaces each value v by place[v].
  void renumber(const std::vector<int>& place) {
    int most = 0;
    with([&](const auto* v) {
      for (std::size_t i = 0; i < size(); ++i) most = std::max(most, place[v[i]]);
    });
    const auto replace_in = [&place](auto& list) {
      for (auto& v : list) v = static_cast<std::decay_t<decltype(v)>>(place[v]);
    };
    if (empty()) return;
    if (wide_.empty() && fits(most)) replace_in(narrow_.own());
    else replace_in(wide_list());
  }
  // Appends the values [first, end) of another list, each with `more` added.
  void append(const ShortList& other, std::size_t first, std::size_t end, int more = 0) {
    other.with([&](const auto* from) {
      const auto append_to = [&](auto& list) {
        using Value = typename std::decay_t<decltype(list)>::value_type;
        const std::size_t old = list.size();
        list.resize(old + (end - first));
        std::transform(from + first, from + end, list.begin() + old, [more](int v) { return static_cast<Value>(v + more); });
      };
      if (first == end) return;
      if (wide_.empty() && fits(*std::max_element(from + first, from + end) + more)) append_to(narrow_.own());
      else append_to(wide_list());
    });
  }
  void shrink_to_fit() {
    narrow_.own().shrink_to_fit();
    wide_.own().shrink_to_fit();
  }
  void share(AlikeLists& alike) {
    alike.share(narrow_);
    alike.share(wide_);
  }
  std::size_t memory_usage() const { return narrow_.memory_usage() + wide_.memory_usage(); }

 private:
  using Narrow = std::uint16_t;
  static bool fits(int v) { return v <= std::numeric_limits<Narrow>::max(); }
  std::vector<int>& wide_list() {
    if (wide_.empty()) {
      wide_.own().assign(narrow_.begin(), narrow_.end());
      narrow_ = {};
    }
    return wide_.own();
  }

  SharedList<Narrow> narrow_;
  SharedList<int> wide_;  // used instead of narrow_ if it is not empty
};

}  // namespace mpdem

#endif
