// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The points around a point of a lattice, and which of them are connected. Only node_splitter.cpp uses it.
#ifndef MPDEM_FRACTURE_POINTS_AROUND_H
#define MPDEM_FRACTURE_POINTS_AROUND_H

#include "phantom_nodes.h"

namespace mpdem {

inline bool connected(const SplitterPoint& a, const SplitterPoint& b, int face) {
  return a.nearer == b.nearer || a.middle || b.middle || touches(a.space[face] + b.space[face ^ 1]);
}

inline GridIndex grid_index(const int* p) { return {p[0], p[1], p[2]}; }

// Masks of the 26 points around a point. Bit q = 9 x + 3 y + z is the point at x, y, z, each from 0 to 2. intact: the intact points.
// faces: those connected to the middle point over a face. paths_: for each face, those connected to the point across it.
class NodeSplitter::Around {
 public:
  static constexpr int kPlaces = 27, kMiddle = 13;
  static int step(int face) { return (face % 2 == 0 ? -1 : 1) * (face < 2 ? 9 : face < 4 ? 3 : 1); }

  Around(const NodeSplitter& lattice, int i) : p_(lattice.points_) {
    for (int q = 0; q < kPlaces; ++q) {
      GridIndex c = grid_index(p_[i].cell);
      for (int d = 0; d < 3; ++d) c[d] += axis(q, d) - 1;
      const auto at = q == kMiddle ? lattice.at_.end() : lattice.at_.find(c);
      const bool is_intact = at != lattice.at_.end() && !p_[at->second].failed;
      point_at[q] = is_intact ? at->second : -1;
      intact |= static_cast<unsigned>(is_intact) << q;
    }
    for (int face = 0; face < 6; ++face) {
      for (int q = 0; q < kPlaces; ++q) {
        const int there = axis(q, face / 2) + (face % 2 == 0 ? -1 : 1);
        if (point_at[q] < 0 || there < 0 || there > 2 || point_at[q + step(face)] < 0) continue;
        paths_[face] |= static_cast<unsigned>(may_connect(point_at[q], point_at[q + step(face)], face)) << q;
      }
      const int beside = kMiddle + step(face);
      if (point_at[beside] >= 0 && may_connect(i, point_at[beside], face)) faces |= 1u << beside;
    }
  }

  // True if the points of `faces` in the mask are connected to each other over points of the mask.
  bool are_connected(unsigned mask) const {
    const unsigned ends = faces & mask;
    if ((ends & (ends - 1)) == 0) return true;
    unsigned reached = ends & -ends;
    for (unsigned before = 0; before != reached && (ends & ~reached);) {
      before = reached;
      for (int face = 0; face < 6; ++face) {
        const unsigned from = reached & paths_[face];
        reached |= mask & (step(face) < 0 ? from >> -step(face) : from << step(face));
      }
    }
    return (ends & ~reached) == 0;
  }

  int point_at[kPlaces];
  unsigned intact = 0, faces = 0;

 private:
  static int axis(int q, int d) { return d == 0 ? q / 9 : d == 1 ? q / 3 % 3 : q % 3; }
  bool may_connect(int a, int b, int face) const { return p_[a].piece == p_[b].piece && connected(p_[a], p_[b], face); }
  const std::vector<SplitterPoint>& p_;
  unsigned paths_[6] = {};
};

}  // namespace mpdem

#endif
