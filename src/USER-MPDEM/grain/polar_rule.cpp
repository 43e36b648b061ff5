// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "polar_rule.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace mpdem {

// By the eigenvalues of the recurrence (Golub and Welsch, Math. Comp. 23 (1969) 221).
PolarRule polar_rule(double from, double to, int points) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(points, points);
  for (int k = 1; k < points; ++k) J(k, k - 1) = J(k - 1, k) = k / std::sqrt(4.0 * k * k - 1.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> e(J);
  PolarRule r;
  for (int i = 0; i < points; ++i) {
    r.angle.push_back(0.5 * (from + to) + 0.5 * (to - from) * e.eigenvalues()[i]);
    r.weight.push_back((to - from) * e.eigenvectors()(0, i) * e.eigenvectors()(0, i) * std::sin(r.angle.back()));
  }
  return r;
}

}  // namespace mpdem
