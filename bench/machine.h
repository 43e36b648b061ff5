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

// n multiply-adds on each of kChains independent vectors: 2 kLanes kChains n flops.
constexpr int kChains = 6;
double multiply_add(double seed, long n);

}  // namespace mpdem::bench

#endif
