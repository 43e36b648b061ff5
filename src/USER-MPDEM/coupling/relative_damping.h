// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Damping that brings a loaded bond to rest without slowing its grains. Every node is slowed relative to the velocity
// that it would have if the cement followed its two grains,
//   f = -rate m (v - (1 - s) v_0(x) - s v_1(x)),   s = d_0/(d_0 + d_1),
// with v_g the rigid motion of grain g at the node, and d_g the distance of the node from the surface of the grain at
// creation. Grains take the reaction by the same shares, so momentum is kept. The rate is a share of twice the angular
// frequency of a shear wave across the largest thickness, 2 pi c_s/thickness. This is about the critical damping of the
// slowest motion.
//
// In a separated bond, each piece follows only the grain to which it is connected, and fragments are not damped. In
// flight the force of a grain at a distant node would have a lever arm that grows until the step is unstable. For the
// same reason a node that is farther than kReach radii from a grain is not damped.
#ifndef MPDEM_COUPLING_RELATIVE_DAMPING_H
#define MPDEM_COUPLING_RELATIVE_DAMPING_H

#include <vector>

#include "../mpm/bond_mechanism.h"
#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "../mpm/power.h"
#include "eight_nodes.h"
#include "bond_ends.h"

namespace mpdem {

// Collective among the ranks that share nodes. For each node the bits (as in PointRecord::connected) of the grains to
// which points with this node in their support were connected at the last check of their bond. Points that failed since
// then count, so the result is the same until the next check. A copy that is constrained to a single node has the bits
// of that node.
std::vector<char> connected_grains_of_nodes(const PointStore& points, Grid& grid);

// s of each node. Below 0 for a fragment, which follows no grain. connected: connected_grains_of_nodes() of a separated bond, else empty.
std::vector<double> shares_of_second_grain(const Grid& grid, const BondRecord& record, const std::vector<char>& connected);

// Damping of one bond. `ends` points to end 0 of the bond. End 1 follows it.
class RelativeDamping : public BondMechanism {
 public:
  RelativeDamping() = default;
  // critical_share: share of critical damping. Nothing is damped before follow_grains().
  RelativeDamping(const BondRecord& record, double critical_share, double shear_speed);
  void follow_grains(const Grid& grid, const BondRecord& record, const std::vector<char>& connected) override;
  void add_damping(const BondContext& b) override { slow_nodes(b.grid, b.ends); }
  void add_damping_power(const Grid& grid, const BondEnd* ends, Power& sum) const override { sum.add(power(grid, ends)); }
  static double rate(double thickness, double critical_share, double shear_speed);

  // Adds the force to nodes after their sum over ranks, and the reaction to grains before their sum over ranks.
  void slow_nodes(Grid& grid, BondEnd* ends) const;
  // Power that damping dissipates at the nodes that this rank counts (mpm/power.h): its force with the velocity, and
  // with the acceleration. The force is that of the stored velocity.
  Power power(const Grid& grid, const BondEnd* ends) const;
  std::size_t memory_usage() const override { return eights_.capacity() * sizeof(Eight); }

 private:
  struct Eight {
    EightNodes nodes;
    vd share;  // s
  };
  struct Moving {
    vd share[2];  // shares of the grains in the motion of the nodes
    vd r[2][3];   // vectors from the centres of the grains
    vd v[3];      // relative to the motion of the grains
    vd scale;     // rate times inertia; 0: not damped
  };
  Moving move(const Eight& e, const Grid& grid, const BondEnd* ends) const;
  double rate_ = 0.0;
  std::vector<Eight> eights_;  // nodes that follow a grain
  double reach2_[2] = {0, 0};  // squares of the reach
};

}  // namespace mpdem

#endif
