// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Wall time of each phase of a step on this rank, and CPU time of all phases together, in seconds. On a busy machine
// the CPU time is what the step would take on an idle one.
#ifndef MPDEM_CEMENT_BOND_STEP_TIMER_H
#define MPDEM_CEMENT_BOND_STEP_TIMER_H

#include <mpi.h>

#include <array>
#include <ctime>

namespace mpdem {

class StepTimer {
 public:
  enum Phase { kPoints, kNodes, kHalo, kCoupling, kLayout, kOutput, kPhases };

  // The time from here to the next start() or stop() counts for `phase`.
  void start(Phase phase) {
    const double t = MPI_Wtime();
    if (running_ >= 0) seconds_[running_] += t - since_;
    else cpu_since_ = cpu_now();
    running_ = phase;
    since_ = t;
  }
  void stop() {
    if (running_ < 0) return;
    seconds_[running_] += MPI_Wtime() - since_;
    cpu_seconds_ += cpu_now() - cpu_since_;
    running_ = -1;
  }
  void clear() {
    seconds_.fill(0.0);
    cpu_seconds_ = 0.0;
    running_ = -1;
  }
  const std::array<double, kPhases>& seconds() const { return seconds_; }
  double cpu_seconds() const { return cpu_seconds_; }

 private:
  // A system call, slower than MPI_Wtime(). So it is made only where the step begins and ends.
  static double cpu_now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }

  std::array<double, kPhases> seconds_{};
  int running_ = -1;
  double since_ = 0.0, cpu_since_ = 0.0, cpu_seconds_ = 0.0;
};

}  // namespace mpdem

#endif
