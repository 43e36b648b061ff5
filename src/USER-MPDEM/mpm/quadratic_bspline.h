// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Quadratic B-splines on a uniform grid of spacing h (Steffen, Kirby & Berzins, Int. J.
// Numer. Meth. Engng 76 (2008) 922). A point at X uses the three nodes base, base+1,
// base+2 of each direction, base = floor(X/h - 1/2); all points with the same base form
// a cell. Partition of unity, linear completeness, continuous gradient, so a node with
// next to no mass keeps a bounded force over mass.
#ifndef MPDEM_QUADRATIC_BSPLINE_H
#define MPDEM_QUADRATIC_BSPLINE_H

#include <cmath>

#include "simd.h"

namespace mpdem {

constexpr int kSupport = 3;

inline int support_base(double X, double inverse_h) { return static_cast<int>(std::floor(X * inverse_h - 0.5)); }

// 1-D factors of weights and gradients for the eight points of a block.
struct Weights {
  vd w[3][kSupport];   // [direction][node]
  vd dw[3][kSupport];  // per length

  Weights(const vd* X, const int* base, double inverse_h) {
    for (int d = 0; d < 3; ++d) {
      const vd t = X[d] * inverse_h - (base[d] + 1.0);  // in [-1/2, 1/2]
      const vd l = 0.5 - t, r = 0.5 + t;
      w[d][0] = 0.5 * l * l;
      w[d][1] = 0.75 - t * t;
      w[d][2] = 0.5 * r * r;
      dw[d][0] = -inverse_h * l;
      dw[d][1] = (-2.0 * inverse_h) * t;
      dw[d][2] = inverse_h * r;
    }
  }
};

}  // namespace mpdem

#endif
