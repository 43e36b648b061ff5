// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The index of a node or of a cell: its three integers on a grid, with hash and comparison for tables. The primes of
// the hash are those of the spatial hash of Teschner et al. (2003).
#ifndef MPDEM_NUMERICS_GRID_INDEX_H
#define MPDEM_NUMERICS_GRID_INDEX_H

#include <array>
#include <cstddef>

namespace mpdem {

using GridIndex = std::array<int, 3>;

struct GridIndexHash {
  template <class Whole>
  std::size_t operator()(const std::array<Whole, 3>& p) const {
    return static_cast<std::size_t>(p[0]) * 73856093u ^ static_cast<std::size_t>(p[1]) * 19349663u ^
           static_cast<std::size_t>(p[2]) * 83492791u;
  }
};

// Compares number by number. The library compares such arrays as bytes, with a call.
struct SameGridIndex {
  bool operator()(const GridIndex& a, const GridIndex& b) const { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }
};

}  // namespace mpdem

#endif
