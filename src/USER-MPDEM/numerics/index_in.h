// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds an entry that must be in a list.
#ifndef MPDEM_NUMERICS_INDEX_IN_H
#define MPDEM_NUMERICS_INDEX_IN_H

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "text_of.h"

namespace mpdem {

// Returns the index of the first entry e with of(e) == key in a list in which of() ascends. Throws std::logic_error
// with the name of what is sought if there is none.
template <class List, class Key, class Of>
std::size_t index_in(const List& ascending, const Key& key, Of of, const char* name) {
  const auto at = std::lower_bound(ascending.begin(), ascending.end(), key, [&](const auto& e, const Key& k) { return of(e) < k; });
  if (at == ascending.end() || of(*at) != key)
    throw std::logic_error(text_of("there is no ", name, " ", key, " in a list that should have it"));
  return static_cast<std::size_t>(at - ascending.begin());
}

template <class List, class Key>
std::size_t index_in(const List& ascending, const Key& key, const char* name) {
  return index_in(
      ascending, key, [](const auto& e) { return e; }, name);
}

}  // namespace mpdem

#endif
