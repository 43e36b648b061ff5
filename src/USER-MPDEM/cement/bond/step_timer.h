// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// CPU time of each phase of a step on this rank, and wall time of all phases together, in seconds. On a busy machine the
// CPU time is what the step would take on an idle one.
//
// The CPU clock is a system call, so it is read only where the phases of a step begin and end. In between, the wall
// clock finds the shares of the phases. If a step took less CPU time than wall time, it waited for the processor, most
// likely once: the difference is taken from its longest interval between two starts.
#ifndef MPDEM_CEMENT_BOND_STEP_TIMER_H
#define MPDEM_CEMENT_BOND_STEP_TIMER_H

#include <mpi.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <numeric>

namespace mpdem {

class StepTimer {
 public:
  enum Phase { kPoints, kNodes, kHalo, kCoupling, kCondensing, kLayout, kOutput, kPhases };

  // The time from here to the next start() or stop() counts for `phase`.
  void start(Phase phase) {
    if (held_) return;
    const double t = MPI_Wtime();
    if (running_ >= 0) end_interval(t);
    else cpu_since_ = cpu_now();
    running_ = phase;
    since_ = t;
  }
  // Until stop(), the time counts for this phase, whatever other code starts.
  void hold(Phase phase) {
    start(phase);
    held_ = true;
  }
  void stop() {
    held_ = false;
    if (running_ < 0) return;
    end_interval(MPI_Wtime());
    running_ = -1;
    const double cpu = cpu_now() - cpu_since_, wall = std::accumulate(wall_.begin(), wall_.end(), 0.0);
    wall_seconds_ += wall;
    const double waited = std::min(longest_, std::max(0.0, wall - cpu));
    wall_[phase_of_longest_] -= waited;
    for (int p = 0; p < kPhases && wall > waited; ++p) seconds_[p] += cpu * wall_[p] / (wall - waited);
    wall_.fill(0.0);
    longest_ = 0.0;
  }
  void clear() { *this = StepTimer(); }
  const std::array<double, kPhases>& seconds() const { return seconds_; }
  double cpu_seconds() const { return std::accumulate(seconds_.begin(), seconds_.end(), 0.0); }
  double wall_seconds() const { return wall_seconds_; }

 private:
  void end_interval(double now) {
    const double length = now - since_;
    wall_[running_] += length;
    if (length <= longest_) return;
    longest_ = length;
    phase_of_longest_ = running_;
  }
  static double cpu_now() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }

  std::array<double, kPhases> seconds_{}, wall_{};  // wall_: since the phases of this step began
  int running_ = -1;
  int phase_of_longest_ = 0;
  bool held_ = false;
  double since_ = 0.0, cpu_since_ = 0.0, wall_seconds_ = 0.0, longest_ = 0.0;  // longest_: interval of this step
};

}  // namespace mpdem

#endif
