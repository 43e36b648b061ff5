// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Links of bonds at rest. While a body sleeps (mpm/resting.h) and its grains are where they were and do
// not move, the force on its nodes and grains is that of the step before; it is kept and handed out
// again. Exact: a body's links touch its own nodes and sides only, and nothing precedes them there but
// the internal force, which is that of the step before too.
#ifndef MPDEM_RESTING_LINKS_H
#define MPDEM_RESTING_LINKS_H

#include <vector>

#include "../mpm/resting.h"
#include "penalty_links.h"

namespace mpdem {

class RestingLinks {
 public:
  // After points, links, grid or sides were laid out anew: nothing is kept.
  void bind(const PenaltyLinks& links, const Resting& resting, const GrainSides& sides);

  // PenaltyLinks::add_force() in a step, after Resting::advance(); forces of the sides are clear.
  void add_force(const PenaltyLinks& links, const Resting& resting, bool skip_detached, Grid& grid, GrainSides& sides);

  int asleep() const { return asleep_; }  // bodies, in the last step

 private:
  struct Side {
    int at;  // index into GrainSides, -1: not held here
    double x[3];
    Mat3<double> R;
    double force[3], torque[3];
  };
  struct Bond {
    PenaltyLinks::BodyLinks links;
    std::vector<int> fields;  // indices into Resting::all()
    Side side[2];
    bool kept;
  };
  static bool grains_rest(const Bond& b, const GrainSides& sides);
  static bool grains_are_where_they_were(const Bond& b, const GrainSides& sides);
  void keep(Bond& b, const Resting& resting, const Grid& grid, const GrainSides& sides);
  void hand_out(const Bond& b, const Resting& resting, Grid& grid, GrainSides& sides) const;

  std::vector<Bond> bonds_;
  std::vector<double> force_;  // on the nodes of those kept
  int asleep_ = 0;
};

}  // namespace mpdem

#endif
