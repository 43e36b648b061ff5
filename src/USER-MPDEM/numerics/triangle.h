// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Nearest point of a triangle, by the regions of C. Ericson, Real-Time Collision Detection (2005), section 5.1.5.
#ifndef MPDEM_NUMERICS_TRIANGLE_H
#define MPDEM_NUMERICS_TRIANGLE_H

#include <array>

namespace mpdem {

// Shares of the three corners a, b, c in the point of the triangle that is nearest to p. They sum to 1.
inline std::array<double, 3> nearest_in_triangle(const double* a, const double* b, const double* c, const double* p) {
  double ab[3], ac[3], ap[3], bp[3], cp[3];
  for (int d = 0; d < 3; ++d) {
    ab[d] = b[d] - a[d];
    ac[d] = c[d] - a[d];
    ap[d] = p[d] - a[d];
    bp[d] = p[d] - b[d];
    cp[d] = p[d] - c[d];
  }
  const auto dot = [](const double* u, const double* v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; };
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4, along = (d4 - d3) + (d5 - d6);
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) return {0.0, 1.0 - (d4 - d3) / along, (d4 - d3) / along};
  const double inverse = 1.0 / (va + vb + vc);
  return {va * inverse, vb * inverse, vc * inverse};
}

}  // namespace mpdem

#endif
