// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Splits the time of a pass over the points into gather, material and scatter. These are fused, block by block. So one
// block in 64 is timed, and the time of the whole pass is split in the proportion found. Ticks have no unit of their
// own.
#ifndef MPDEM_MPM_PASS_CLOCK_H
#define MPDEM_MPM_PASS_CLOCK_H

#include <chrono>
#include <cstdint>

namespace mpdem {

struct PassTicks {
  std::uint64_t gather = 0, material = 0, scatter = 0;
  unsigned blocks = 0;  // counts on from bond to bond, so that the timed block is not always the first of a bond
};

class PassClock {
 public:
  explicit PassClock(PassTicks& ticks) : ticks_(ticks) {}

  void start() {
    timed_ = ticks_.blocks++ % kEvery == 0;
    if (timed_) last_ = now();
  }
  void gathered() {
    if (timed_) lap(ticks_.gather);
  }
  void stressed() {
    if (timed_) lap(ticks_.material);
  }
  void scattered() {
    if (timed_) lap(ticks_.scatter);
  }

  // Work for many blocks is always timed. Its ticks are divided by kEvery, since other blocks are timed once in kEvery.
  void start_queue() { last_ = now(); }
  void queue_stressed() { lap(ticks_.material, kEvery); }
  void queue_scattered() { lap(ticks_.scatter, kEvery); }

 private:
  static std::uint64_t now() {
#if defined(__x86_64__)
    return __builtin_ia32_rdtsc();
#else
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
  }
  static constexpr int kEvery = 64;
  void lap(std::uint64_t& sum, int share = 1) {
    const std::uint64_t t = now();
    sum += (t - last_) / share;
    last_ = t;
  }
  PassTicks& ticks_;
  std::uint64_t last_ = 0;
  bool timed_ = false;
};

}  // namespace mpdem

#endif
