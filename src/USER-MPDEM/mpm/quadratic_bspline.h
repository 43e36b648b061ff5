// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Quadratic B-splines on a uniform grid: three nodes a direction, base = floor(X/h - 1/2) (Steffen, Kirby & Berzins,
// Int. J. Numer. Meth. Engng 76 (2008) 922). Their gradient is continuous, so force over mass stays bounded at a node
// with almost no mass.
#ifndef MPDEM_MPM_QUADRATIC_BSPLINE_H
#define MPDEM_MPM_QUADRATIC_BSPLINE_H

#include "../numerics/simd.h"

namespace mpdem {

struct QuadraticBspline {
  static constexpr const char* kName = "quadratic";  // see basis.h
  static constexpr int kSupport = 3;
  static constexpr double kShift = 0.5;   // base = floor(X/h - kShift)
  static constexpr double kMiddle = 1.0;  // middle of the cell, from base
  static constexpr double kAffine = 4.0, kSteepest = 6.0, kConstrainedBelow = 0.12;
  static constexpr bool kMayJoinCells = true;

  // t = X/h - base in [1/2, 3/2]
  static void factors(vd t, double inverse_h, vd* w, vd* dw) {
    const vd s = t - 1.0, l = 0.5 - s, r = 0.5 + s;
    w[0] = 0.5 * l * l;
    w[1] = 0.75 - s * s;
    w[2] = 0.5 * r * r;
    dw[0] = -inverse_h * l;
    dw[1] = (-2.0 * inverse_h) * s;
    dw[2] = inverse_h * r;
  }
};

}  // namespace mpdem

#endif
