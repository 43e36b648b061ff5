// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Damping that leads a loaded bond to rest without holding its grains back: every node is
// slowed relative to the velocity it would have if the cement followed its two grains,
//   f = -rate m (v - (1 - s) v_1(x) - s v_2(x)),   s = d_1/(d_1 + d_2),
// v_g the rigid motion of grain g at the node and d_g its distance from the grain's surface
// at creation. Grains take the reaction by the same shares, so momentum is kept. The rate is a
// share of twice the angular frequency of a shear wave across the thickest place,
// 2 pi c_s/thickness, which is critical damping of about the slowest motion.
//
// Once a bond has come apart each half follows its own grain alone, and loose pieces are left alone: the
// force of one grain at the place of another, in flight, has a lever arm that grows until the step is
// unstable. For the same reason nodes that are farther than kReach radii from a grain are.
#ifndef MPDEM_RELAXATION_H
#define MPDEM_RELAXATION_H

#include <vector>

#include "../mpm/grid.h"
#include "grain_sides.h"

namespace mpdem {

// Of one bond. `side` is always the first of its two sides, the second is behind it.
class Relaxation {
 public:
  Relaxation() = default;
  // After the layout of the grid. critical_share: of critical damping; apart: the bond came apart.
  Relaxation(const Grid& grid, const Body& body, bool apart, double critical_share, double shear_speed);
  static double rate(const Body& body, double critical_share, double shear_speed);

  // Adds force to nodes (after their sum over ranks) and reaction to grains (before theirs).
  void add_force(Grid& grid, GrainSide* side) const;
  // Power that it takes of nodes that count on this rank: the force is that of the stored velocity,
  // the velocity is so long of the acceleration later.
  double power(const Grid& grid, const GrainSide* side, double later) const;

 private:
  struct Node {
    int at;
    double share[2];  // of the grains in its motion
    double r[2][3];   // from their centres
    double v[3];      // against them
    double scale;     // rate times inertia
  };
  // Calls f(node) for those that are damped.
  template <class F>
  void for_each_node(const Grid& grid, const GrainSide* side, F f) const;
  struct Range {
    int first, last;  // nodes of a part
    double rate;
  };
  std::vector<Range> ranges_;
  std::vector<double> share_;  // s of each node
  double reach2_[2] = {0, 0};  // squares of the reach
};

}  // namespace mpdem

#endif
