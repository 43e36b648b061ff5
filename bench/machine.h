// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// What one core of this machine can do, the measure for the rates of the step.
#ifndef MPDEM_BENCH_MACHINE_H
#define MPDEM_BENCH_MACHINE_H

#include <cstddef>

namespace mpdem::bench {

// a = b + s c over three arrays of n doubles each (McCalpin's STREAM triad). Bytes as STREAM
// counts them: 24 n.
void triad(double* a, const double* b, const double* c, double s, std::size_t n);

// The widest vector of the target. Two pipes take four to five cycles each, so ten chains keep them busy, and twelve leave
// room in sixteen registers.
#if defined(__AVX512F__)
constexpr int kWidest = 8;
#elif defined(__AVX__)
constexpr int kWidest = 4;
#else
constexpr int kWidest = 2;
#endif
// n multiply-adds on each of kChains independent vectors: 2 kWidest kChains n flops.
constexpr int kChains = 12;
double multiply_add(double seed, long n);

}  // namespace mpdem::bench

#endif
