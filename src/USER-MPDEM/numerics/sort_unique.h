// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Makes a list ascending, with each value once.
#ifndef MPDEM_NUMERICS_SORT_UNIQUE_H
#define MPDEM_NUMERICS_SORT_UNIQUE_H

#include <algorithm>
#include <vector>

namespace mpdem {

template <class T>
void sort_unique(std::vector<T>& values) {
  if (!std::is_sorted(values.begin(), values.end())) std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace mpdem

#endif
