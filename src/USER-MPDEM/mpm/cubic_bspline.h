// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cubic B-splines on a uniform grid: four nodes a direction, base = floor(X/h) - 1.
#ifndef MPDEM_MPM_CUBIC_BSPLINE_H
#define MPDEM_MPM_CUBIC_BSPLINE_H

#include "../numerics/simd.h"

namespace mpdem {

struct CubicBspline {
  static constexpr const char* kName = "cubic";  // see basis.h
  static constexpr int kSupport = 4;
  static constexpr double kShift = 1.0;   // base = floor(X/h - kShift)
  static constexpr double kMiddle = 1.5;  // middle of the cell, from base
  static constexpr double kAffine = 3.0, kSteepest = 3.14, kConstrainedBelow = 0.05;
  static constexpr bool kMayJoinCells = false;

  // t = X/h - base in [1, 2]
  static void factors(vd t, double inverse_h, vd* w, vd* dw) {
    const vd r = t - 1.0, l = 1.0 - r;
    const vd r2 = r * r, l2 = l * l;
    w[0] = (1.0 / 6.0) * l2 * l;
    w[1] = 2.0 / 3.0 - r2 + 0.5 * r2 * r;
    w[2] = 2.0 / 3.0 - l2 + 0.5 * l2 * l;
    w[3] = (1.0 / 6.0) * r2 * r;
    dw[0] = (-0.5 * inverse_h) * l2;
    dw[1] = inverse_h * (1.5 * r2 - 2.0 * r);
    dw[2] = inverse_h * (2.0 * l - 1.5 * l2);
    dw[3] = (0.5 * inverse_h) * r2;
  }
};

}  // namespace mpdem

#endif
