// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// A bond at rest sleeps. While all its nodes on this rank have velocity zero, a pass over its points changes nothing,
// and its internal force is that of the step before. While its grains rest too, where they were, the force of its links
// stays as well. Both forces are kept and handed out again. Sleep is exact: a bond sleeps only once a pass has left
// every bit of its points as it was (a viscous law may go on at rest). `total` kinematics only.
#ifndef MPDEM_CEMENT_RESTING_H
#define MPDEM_CEMENT_RESTING_H

#include <vector>

#include "../coupling/grain_sides.h"
#include "../mpm/advance_points.h"

namespace mpdem {

class Resting {
 public:
  // Calls advance_points(), or leaves it out in sleep.
  void advance(PointStore& points, Grid& grid, const Law& law, double dt, const AdvanceOptions& options, AdvanceResult& result);
  // In sleep, hands out the kept forces of the links, too, and returns true. Otherwise returns false: add the forces of
  // the links and call keep_links(). Call it after advance(). Forces of the sides must be clear before.
  bool hand_out_links(Grid& grid, GrainSide* side);
  void keep_links(const Grid& grid, const GrainSide* side);

  bool asleep() const { return asleep_; }  // true if the bond slept in the last step
  std::size_t memory_usage() const { return sizeof(double) * (internal_force_.capacity() + force_.capacity()); }

 private:
  bool settle(PointStore& points, Grid& grid, const Law& law, double dt, const AdvanceOptions& options, AdvanceResult& result);

  bool asleep_ = false, rests_ = false, links_kept_ = false;  // rests_: and so do its grains
  std::vector<double> internal_force_, force_;  // kept forces on the nodes
  struct Side {
    double x[3];
    Mat3<double> R;
    double force[3], torque[3];
  };
  Side side_[2];
};

}  // namespace mpdem

#endif
