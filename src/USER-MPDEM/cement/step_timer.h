// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Wall time of the phases of a step on this rank.
#ifndef MPDEM_STEP_TIMER_H
#define MPDEM_STEP_TIMER_H

#include <mpi.h>

#include <array>

namespace mpdem {

class StepTimer {
 public:
  enum Phase { kPoints, kNodes, kHalo, kCoupling, kLayout, kOutput, kPhases };

  // What follows counts for `phase` until the next call; stop() counts for none.
  void start(Phase phase) {
    const double t = MPI_Wtime();
    if (running_ >= 0) seconds_[running_] += t - since_;
    running_ = phase;
    since_ = t;
  }
  void stop() {
    if (running_ >= 0) seconds_[running_] += MPI_Wtime() - since_;
    running_ = -1;
  }
  void clear() {
    seconds_.fill(0.0);
    running_ = -1;
  }
  const std::array<double, kPhases>& seconds() const { return seconds_; }

 private:
  std::array<double, kPhases> seconds_{};
  int running_ = -1;
  double since_ = 0.0;
};

}  // namespace mpdem

#endif
