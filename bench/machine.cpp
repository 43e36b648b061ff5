// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "machine.h"

#include "numerics/simd.h"

namespace mpdem::bench {

void triad(double* __restrict a, const double* __restrict b, const double* __restrict c, double s, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + s * c[i];
}

double multiply_add(double seed, long n) {
  // Named, so that they stay in registers: latency times width of two pipes needs ten or so
  // registers, and a `vd` takes two of 256 bits.
  vd a = splat(seed), b = a + 1.0, c = a + 2.0, d = a + 3.0, e = a + 4.0, f = a + 5.0;
  const vd x = splat(1.0 - 1e-9 * seed), y = splat(1e-9 * seed);
  for (long i = 0; i < n; ++i) {
    a = a * x + y;
    b = b * x + y;
    c = c * x + y;
    d = d * x + y;
    e = e * x + y;
    f = f * x + y;
  }
  return sum_lanes(a + b + c + d + e + f);
}

}  // namespace mpdem::bench
