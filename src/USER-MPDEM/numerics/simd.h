// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Eight doubles as one value. A block of material points is eight points of one cell, one point per lane. So every kernel
// is written once, on `vd`, and the compiler maps it to the widest registers of the target (one AVX-512, two AVX2 or
// four SSE2 operations). It uses GCC and Clang vector extensions. Only bits() needs intrinsics, which compilers do not
// find by themselves.
#ifndef MPDEM_NUMERICS_SIMD_H
#define MPDEM_NUMERICS_SIMD_H

#include <cmath>
#include <cstdint>

#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace mpdem {

constexpr int kLanes = 8;

using vd = double __attribute__((vector_size(8 * kLanes)));
using vint = std::int32_t __attribute__((vector_size(4 * kLanes)));
using vmask = std::int64_t __attribute__((vector_size(8 * kLanes)));  // lane is 0 or -1

inline vd splat(double a) { return vd{a, a, a, a, a, a, a, a}; }
inline vmask splat_mask(bool a) { return vmask{} - static_cast<std::int64_t>(a); }

inline vd select(vmask m, vd a, vd b) { return m ? a : b; }

// One bit for each lane. The first lane is the lowest bit.
inline std::uint8_t bits(vmask m) {
#if defined(__AVX512DQ__)
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(m));
#elif defined(__AVX__)
  const __m256d low = reinterpret_cast<__m256d>(__builtin_shufflevector(m, m, 0, 1, 2, 3));
  const __m256d high = reinterpret_cast<__m256d>(__builtin_shufflevector(m, m, 4, 5, 6, 7));
  return static_cast<std::uint8_t>(_mm256_movemask_pd(low) | _mm256_movemask_pd(high) << 4);
#else
  unsigned r = 0;
  for (int l = 0; l < kLanes; ++l) r |= (m[l] ? 1u : 0u) << l;
  return static_cast<std::uint8_t>(r);
#endif
}
inline bool any(vmask m) { return bits(m) != 0; }

inline vd sqrt(vd a) {
  vd r;
  for (int l = 0; l < kLanes; ++l) r[l] = std::sqrt(a[l]);
  return r;
}
inline vd abs(vd a) { return a < 0.0 ? -a : a; }
inline vd max(vd a, vd b) { return a > b ? a : b; }
inline vd min(vd a, vd b) { return a < b ? a : b; }

// Applies a function without a vector form to each lane. Slow, so only for rare paths.
template <class F>
inline vd map_lanes(vd a, F f) {
  vd r;
  for (int l = 0; l < kLanes; ++l) r[l] = f(a[l]);
  return r;
}

inline double largest_lane(vd a) {
  double most = a[0];
  for (int l = 1; l < kLanes; ++l) most = most < a[l] ? a[l] : most;
  return most;
}

inline double sum_lanes(vd a) {
  using v4 = double __attribute__((vector_size(32)));
  using v2 = double __attribute__((vector_size(16)));
  const v4 s = __builtin_shufflevector(a, a, 0, 1, 2, 3) + __builtin_shufflevector(a, a, 4, 5, 6, 7);
  const v2 t = __builtin_shufflevector(s, s, 0, 1) + __builtin_shufflevector(s, s, 2, 3);
  return t[0] + t[1];
}

// Lane l of the result is the sum of the lanes of a[l]: three stages of pairwise adds.
__attribute__((always_inline)) inline vd sum_lanes_of_8(const vd* a) {
  vd s[4];
  for (int p = 0; p < 4; ++p)
    s[p] = __builtin_shufflevector(a[2 * p], a[2 * p + 1], 0, 8, 2, 10, 4, 12, 6, 14) +
           __builtin_shufflevector(a[2 * p], a[2 * p + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  vd t[2];
  for (int p = 0; p < 2; ++p)
    t[p] = __builtin_shufflevector(s[2 * p], s[2 * p + 1], 0, 1, 8, 9, 4, 5, 12, 13) +
           __builtin_shufflevector(s[2 * p], s[2 * p + 1], 2, 3, 10, 11, 6, 7, 14, 15);
  return __builtin_shufflevector(t[0], t[1], 0, 1, 2, 3, 8, 9, 10, 11) + __builtin_shufflevector(t[0], t[1], 4, 5, 6, 7, 12, 13, 14, 15);
}

}  // namespace mpdem

#endif
