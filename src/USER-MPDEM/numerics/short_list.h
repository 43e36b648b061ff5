// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A list of integers that are not negative, such as places of nodes. It takes two bytes for each while all of them fit into these,
// as they do in small bonds, and four bytes from the first one on that does not.
#ifndef MPDEM_SHORT_LIST_H
#define MPDEM_SHORT_LIST_H

#include <algorithm>
#include <cstdint>
#include <limits>
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
  void set(std::size_t i, int v) {
    if (wide_.empty() && fits(v)) narrow_.own()[i] = static_cast<Narrow>(v);
    else wide_list()[i] = v;
  }
  void resize(std::size_t size) {
    if (wide_.empty()) narrow_.own().resize(size);
    else wide_.own().resize(size);
  }
  // Calls f with a pointer to the integers of whichever width.
  template <class F>
  decltype(auto) with(F f) const {
    if (wide_.empty()) return f(narrow_.data());
    return f(wide_.data());
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
  SharedList<int> wide_;  // instead, if there are any
};

}  // namespace mpdem

#endif
