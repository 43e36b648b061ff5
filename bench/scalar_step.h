// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Yardstick: the pass of `total` kinematics as it is usually written. One point at a time, all
// 27 nodes in a triple loop, compiled without vector instructions, the elastic part of the law
// and the test for damage. Same equations, store and results to rounding.
#ifndef MPDEM_BENCH_SCALAR_STEP_H
#define MPDEM_BENCH_SCALAR_STEP_H

#include "free_body.h"

namespace mpdem::bench {

struct ScalarPoint {
  double X[3], volume, F[3][3], q[4], strain[6];  // as in PointBlock
  int base[3];
  int column[9];
};

std::vector<ScalarPoint> scalar_points(const FreeBody& s);

// Adds the internal force at the end of the step; returns the number of points over the bound
// of TensorDamage::square_bound.
long scalar_advance(std::vector<ScalarPoint>& points, const double* velocity, double* force, double h, const TensorDamage& law, double dt);

}  // namespace mpdem::bench

#endif
