// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "elastic_sphere.h"

#include <cmath>

namespace mpdem {

SphereResponse sphere_response(int degree, double nu) {
  SphereResponse a;
  if (degree == 0) {
    a.rr = (1.0 - 2.0 * nu) / (2.0 * (1.0 + nu));
    return a;
  }
  if (degree == 1) {  // the body force balances N = t_r + 2 t_s
    const double of_N = -(1.0 - 2.0 * nu) / (6.0 - 4.0 * nu), scale = 4.0 * (1.0 + nu);
    const double U = (1.0 - 2.0 * nu) / (2.0 * (3.0 - 2.0 * nu));
    const double c_r = of_N / scale, c_s = (1.0 + 2.0 * of_N) / scale;
    a.rr = c_r * (8.0 * nu - 4.0) + 0.8 * U;
    a.rs = c_s * (8.0 * nu - 4.0) + 1.6 * U;
    a.sr = c_r * (4.0 - 4.0 * nu) - 0.2 * U;
    a.ss = c_s * (4.0 - 4.0 * nu) - 0.4 * U;
    a.tt = 1.0 / 7.0;
    return a;
  }
  const double l = degree, f = 1.0 / (2.0 * (l - 1.0) * (l * l + l + 1.0 + nu * (2.0 * l + 1.0)));
  const double cross = (1.0 - 2.0 * nu) * l - 2.0 + nu;
  a.rr = f * (2.0 * (1.0 - nu) * l * l + nu * l + 2.0 * nu - 1.0);
  a.rs = -f * l * (l + 1.0) * cross;
  a.sr = -f * cross;
  a.ss = f * (2.0 * (1.0 - nu) * l * l - (1.0 - 3.0 * nu) * l + 1.0 + nu);
  a.tt = 1.0 / (l - 1.0);
  return a;
}

LegendreFunctions::LegendreFunctions(int order, const std::vector<double>& angles) : order_(order), degree_(order), before_(angles.size()) {
  double scale = 1.0 / (4.0 * M_PI) * (order > 0 ? 2.0 : 1.0);
  for (int k = 1; k <= order; ++k) scale *= (2.0 * k + 1.0) / (2.0 * k);
  for (double angle : angles) {
    cosine_.push_back(std::cos(angle));
    sine_.push_back(std::sin(angle));
    P_.push_back(std::sqrt(scale) * std::pow(sine_.back(), order));
  }
  slope_.resize(P_.size());
  find_slope();
}

void LegendreFunctions::next() {
  const double l = ++degree_, m = order_;
  const double a = std::sqrt((4.0 * l * l - 1.0) / (l * l - m * m)),
               b = l > m + 1.0 ? std::sqrt(((l - 1.0) * (l - 1.0) - m * m) / (4.0 * (l - 1.0) * (l - 1.0) - 1.0)) : 0.0;
  for (std::size_t i = 0; i < P_.size(); ++i) {
    const double P = a * (cosine_[i] * P_[i] - b * before_[i]);
    before_[i] = P_[i];
    P_[i] = P;
  }
  find_slope();
}

void LegendreFunctions::find_slope() {
  const double l = degree_, m = order_, c = l > 0.0 ? std::sqrt((2.0 * l + 1.0) / (2.0 * l - 1.0) * (l * l - m * m)) : 0.0;
  for (std::size_t i = 0; i < P_.size(); ++i) slope_[i] = (l * cosine_[i] * P_[i] - c * before_[i]) / sine_[i];
}

}  // namespace mpdem
