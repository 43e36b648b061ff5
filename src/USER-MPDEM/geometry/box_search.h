// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds the axis-parallel boxes that contain a position or intersect another box. Boxes are sorted into bins as wide as
// the widest of them, so the cost of a search depends on the boxes nearby and not on their total number.
#ifndef MPDEM_GEOMETRY_BOX_SEARCH_H
#define MPDEM_GEOMETRY_BOX_SEARCH_H

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "shape.h"

namespace mpdem {

using Box = Eigen::AlignedBox3d;

class BoxSearch {
 public:
  // Sets the boxes to search. Empty boxes are never found.
  explicit BoxSearch(std::vector<Box> boxes);

  const Box& box(int n) const { return boxes_[n]; }

  // Calls f(index of the box) for each box that contains x, ascending.
  template <class F>
  void holding(const Vector3& x, F f) const {
    if (!bounds_.contains(x)) return;
    const int b = bin(cell(x));
    for (int i = begin_[b]; i < begin_[b + 1]; ++i)
      if (boxes_[item_[i]].contains(x)) f(item_[i]);
  }

  // Calls f(index of the box) once for each box that intersects this one.
  template <class F>
  void meeting(const Box& other, F f) const {
    if (other.isEmpty() || !bounds_.intersects(other)) return;
    const Cell from = cell(other.min()), to = cell(other.max());
    for (int i = from[0]; i <= to[0]; ++i)
      for (int j = from[1]; j <= to[1]; ++j)
        for (int k = from[2]; k <= to[2]; ++k) {
          const Cell here{i, j, k};
          const int b = bin(here);
          for (int n = begin_[b]; n < begin_[b + 1]; ++n) {
            const Box& box = boxes_[item_[n]];
            if (!box.intersects(other)) continue;
            // Both boxes may reach several bins in common. The box is reported in the first of them.
            const Cell start = cell(box.min());
            bool first = true;
            for (int d = 0; d < 3; ++d) first = first && here[d] == std::max(start[d], from[d]);
            if (first) f(item_[n]);
          }
        }
  }

 private:
  using Cell = std::array<int, 3>;
  Cell cell(const Vector3& x) const {
    Cell c;
    for (int d = 0; d < 3; ++d) c[d] = static_cast<int>(std::clamp((x[d] - bounds_.min()[d]) / width_[d], 0.0, bins_[d] - 1.0));
    return c;
  }
  int bin(const Cell& c) const { return (c[0] * bins_[1] + c[1]) * bins_[2] + c[2]; }

  std::vector<Box> boxes_;
  Box bounds_;
  Vector3 width_ = Vector3::Ones();
  int bins_[3] = {1, 1, 1};
  std::vector<int> begin_, item_;  // item_: numbers of the boxes of all bins, one bin after the other; begin_: where each bin begins
};

}  // namespace mpdem

#endif
