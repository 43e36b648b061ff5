// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "surface_modes.h"

#include <algorithm>
#include <cmath>

namespace mpdem {

SurfaceModes::SurfaceModes(double inner, double outer, int degree, int orders)
    : inner_(inner), outer_(outer), degree_(degree), orders_(orders) {
  for (int m = 0; m <= orders; ++m) {
    harmonics_.push_back({m, false});
    if (m > 0) harmonics_.push_back({m, true});
  }
  if (inner > 0.0) {
    radials_ = degree + 1;
    for (int h = 0; h < static_cast<int>(harmonics_.size()); ++h)
      for (int a = 0; a <= degree; ++a) modes_.push_back({a, h});
    return;
  }
  for (int m = 0; m <= orders; ++m)
    for (int a = 0; 2 * a + m <= 2 * degree; ++a) order_of_radial_.push_back(m);
  radials_ = static_cast<int>(order_of_radial_.size());
  for (int h = 0; h < static_cast<int>(harmonics_.size()); ++h)
    for (int a = 0; a < radials_; ++a)
      if (order_of_radial_[a] == harmonics_[h].order) modes_.push_back({a, h});
}

// Legendre polynomials are Jacobi polynomials with m = 0. Recurrence: Abramowitz and Stegun (1964), 22.7.1.
void SurfaceModes::find_radials(double cosine, double* radial) const {
  const double top = std::cos(inner_), bottom = std::cos(outer_), share = std::clamp((top - cosine) / (top - bottom), 0.0, 1.0);
  const double x = 2.0 * share - 1.0;
  for (int m = 0, first = 0; first < radials_; ++m) {
    const double norm = std::pow(share, 0.5 * m) / std::sqrt(top - bottom);
    double P = 1.0, before = 0.0;
    int a = 0;
    for (; first + a < radials_ && (inner_ > 0.0 || order_of_radial_[first + a] == m); ++a) {
      radial[first + a] = norm * std::sqrt(2.0 * a + m + 1.0) * P;  // the integral of (rho^m P)^2 over share is 1/(2 a + m + 1)
      const double n = a + 1.0, s = 2.0 * n + m;
      const double next = n == 1.0 ? 0.5 * ((2.0 + m) * x - m)
                                   : ((s - 1.0) * (s * (s - 2.0) * x - m * m) * P - 2.0 * (n - 1.0) * (n + m - 1.0) * s * before) /
                                         (2.0 * n * (n + m) * (s - 2.0));
      before = P;
      P = next;
    }
    first += a;
  }
}

void SurfaceModes::find_harmonics(double c, double s, double* harmonic) const {
  const double norm = 1.0 / std::sqrt(M_PI);
  double cm = 1.0, sm = 0.0;
  for (const Harmonic& h : harmonics_) {
    if (h.order > 0 && !h.sine) {
      const double next = cm * c - sm * s;
      sm = sm * c + cm * s;
      cm = next;
    }
    *harmonic++ = h.order == 0 ? std::sqrt(0.5) * norm : norm * (h.sine ? sm : cm);
  }
}

}  // namespace mpdem
