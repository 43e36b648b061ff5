// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Numbers below 2e-308 count as zero while an object of this class lives. Ahead of a wave the motion of nodes falls off to such
// numbers, and the processor takes a hundred cycles for each of them. On other processors than x86 an object does nothing.
#ifndef MPDEM_NUMERICS_FLUSH_DENORMALS_H
#define MPDEM_NUMERICS_FLUSH_DENORMALS_H

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace mpdem {

class FlushDenormals {
 public:
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;
#if defined(__SSE2__)
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | kResultsAreZero | kOperandsAreZero); }
  ~FlushDenormals() { _mm_setcsr(before_); }

 private:
  static constexpr unsigned kResultsAreZero = 0x8000, kOperandsAreZero = 0x0040;
  unsigned before_;
#else
  FlushDenormals() {}
#endif
};

}  // namespace mpdem

#endif
