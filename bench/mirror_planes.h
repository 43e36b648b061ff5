// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Planes of symmetry through nodes, for benchmarks with exact solutions: what points give to a
// node behind a plane goes to its image before it, normal components with the other sign, and
// the nodes behind repeat those before. The body then is a piece of an endless periodic one, so
// nothing but the method is measured.
#ifndef MPDEM_MIRROR_PLANES_H
#define MPDEM_MIRROR_PLANES_H

#include <vector>

#include "mpm/grid.h"

namespace mpdem {

class MirrorPlanes {
 public:
  // Node coordinates of the planes of a direction; a direction without is free.
  struct Pair {
    bool low = false, high = false;
    int at_low = 0, at_high = 0;
  };
  Pair pair[3];

  // After the layout of the grid.
  void bind(const Grid& grid) {
    const int n = grid.size();
    image_.resize(n);
    sign_.assign(3 * n, 1.0);
    for (int i = 0; i < n; ++i) {
      int at[3];
      for (int d = 0; d < 3; ++d) {
        const Pair& p = pair[d];
        int x = grid.keys[i][1 + d];
        double s = 1.0;
        for (bool moved = true; moved;) {
          moved = false;
          if (p.low && x < p.at_low) x = 2 * p.at_low - x, s = -s, moved = true;
          if (p.high && x > p.at_high) x = 2 * p.at_high - x, s = -s, moved = true;
        }
        if ((p.low && x == p.at_low) || (p.high && x == p.at_high)) s = 0.0;
        at[d] = x;
        sign_[3 * i + d] = s;
      }
      image_[i] = grid.base_node(grid.keys[i][0], at);
      if (image_[i] < 0) image_[i] = i;  // far from all points
    }
  }

  void fold_scalar(std::vector<double>& v) const {
    for (std::size_t i = 0; i < image_.size(); ++i)
      if (image_[i] != static_cast<int>(i)) v[image_[i]] += v[i];
    for (std::size_t i = 0; i < image_.size(); ++i) v[i] = v[image_[i]];
  }
  void fold_vector(std::vector<double>& v) const {
    for (std::size_t i = 0; i < image_.size(); ++i)
      if (image_[i] != static_cast<int>(i))
        for (int d = 0; d < 3; ++d) v[3 * image_[i] + d] += sign_[3 * i + d] * v[3 * i + d];
    repeat(v);
  }
  void repeat(std::vector<double>& v) const {
    for (std::size_t i = 0; i < image_.size(); ++i)
      for (int d = 0; d < 3; ++d) v[3 * i + d] = sign_[3 * i + d] * v[3 * image_[i] + d];
  }

 private:
  std::vector<int> image_;
  std::vector<double> sign_;
};

}  // namespace mpdem

#endif
