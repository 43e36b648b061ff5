// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Linear hat functions on a uniform grid: two nodes a direction, base = floor(X/h). Their gradient jumps between cells,
// so forces jump where points cross cells. A node at the edge of the cement can have almost no mass and receive full
// force (Sulsky, Chen & Schreyer, Comput. Methods Appl. Mech. Engng 118 (1994) 179).
#ifndef MPDEM_MPM_LINEAR_HAT_H
#define MPDEM_MPM_LINEAR_HAT_H

#include "../numerics/simd.h"

namespace mpdem {

struct LinearHat {
  static constexpr const char* kName = "linear";  // see basis.h
  static constexpr int kSupport = 2;
  static constexpr double kShift = 0.0;   // base = floor(X/h - kShift)
  static constexpr double kMiddle = 0.5;  // middle of the cell, from base
  static constexpr double kAffine = 0.0, kSteepest = 0.0, kConstrainedBelow = 0.12;
  static constexpr bool kMayJoinCells = true;

  // t = X/h - base in [0, 1]
  static void factors(vd t, double inverse_h, vd* w, vd* dw) {
    w[0] = 1.0 - t;
    w[1] = t;
    dw[0] = splat(-inverse_h);
    dw[1] = splat(inverse_h);
  }
};

}  // namespace mpdem

#endif
