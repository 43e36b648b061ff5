// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Damping that leads a loaded bond to rest without holding its grains back. Every node is slowed relative to the
// velocity it would have if the cement followed its two grains,
//   f = -rate m (v - (1 - s) v_1(x) - s v_2(x)),   s = d_1/(d_1 + d_2),
// with v_g the rigid motion of grain g at the node, and d_g the distance of the node from the surface of the grain at
// creation. Grains take the reaction by the same shares, so momentum is kept. The rate is a share of twice the
// angular frequency of a shear wave across the thickest place, 2 pi c_s/thickness. This is critical damping of about
// the slowest motion.
//
// Once a bond has come apart, each piece follows only the grain that it still holds to, and loose pieces are not
// damped. The force of one grain at the place of another, in flight, would have a lever arm that grows until the step
// is unstable. For the same reason a node that is farther than kReach radii from a grain is not damped.
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

// For each node the bits (as in PointRecord::holds) of the grains to which points with this node in their support held
// when their bond was last examined. Points that failed since then count, so this is the same at any time until the next
// examination. A copy that is tied to one node has the bits of that node. Collective for the ranks that share nodes.
std::vector<char> nodes_held(const PointStore& points, Grid& grid);

// s of each node. Below 0 for a loose piece, which follows no grain. held: nodes_held() of a bond that came apart, else empty.
std::vector<double> shares_of_second_grain(const Grid& grid, const BondRecord& record, const std::vector<char>& held);

// Damping of one bond. `side` always points to the first of its two sides. The second follows it.
class RelativeDamping : public BondMechanism {
 public:
  RelativeDamping() = default;
  // critical_share: share of critical damping. Nothing is damped before follow_grains().
  RelativeDamping(const BondRecord& record, double critical_share, double shear_speed);
  void follow_grains(const Grid& grid, const BondRecord& record, const std::vector<char>& held) override;
  void add_damping(const BondAtWork& b) override { add_force(b.grid, b.ends); }
  void add_damping_power(const Grid& grid, const BondEnd* ends, Power& sum) const override { sum.add(power(grid, ends)); }
  static double rate(double thickness, double critical_share, double shear_speed);

  // Adds the force to nodes after their sum over ranks, and the reaction to grains before their sum over ranks.
  void add_force(Grid& grid, BondEnd* ends) const;
  // Power that damping takes from the nodes that this rank counts (mpm/power.h): its force with the velocity, and with
  // the acceleration. The force is that of the stored velocity.
  Power power(const Grid& grid, const BondEnd* ends) const;
  std::size_t memory_usage() const override { return eights_.capacity() * sizeof(Eight); }

 private:
  struct Eight {
    EightNodes nodes;
    vd share;  // s
  };
  // Eight nodes as they move.
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
