// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "machine.h"

namespace mpdem::bench {

void triad(double* __restrict a, const double* __restrict b, const double* __restrict c, double s, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + s * c[i];
}

double multiply_add(double seed, long n) {
  using Wide = double __attribute__((vector_size(8 * kWidest)));
  Wide v[kChains];
  for (int k = 0; k < kChains; ++k) v[k] = Wide{} + (seed + k);
  const Wide x = Wide{} + (1.0 - 1e-9 * seed), y = Wide{} + 1e-9 * seed;
  for (long i = 0; i < n; ++i) {
#pragma GCC unroll 12
    for (int k = 0; k < kChains; ++k) v[k] = v[k] * x + y;
  }
  double sum = 0.0;
  for (const Wide& w : v)
    for (int l = 0; l < kWidest; ++l) sum += w[l];
  return sum;
}

}  // namespace mpdem::bench
