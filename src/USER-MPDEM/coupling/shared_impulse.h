// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Impulses on grains that their cement shares. Where the load of the host acts on a grain but once in several sub-steps, the cement would ring from it,
// and some of its modes would be in step. So such an impulse moves grains and cement together: with the change of acceleration A_s of the grains a node has
//
//   a = (1 - s) P_0 A_0 + s P_1 A_1,   P_g the rigid motion of grain g at the node, s as in relaxation.h,
//
// by the force m a, and c (a - P_g A_g) for its added mass c of grain g. The reaction of the first is on the grains by the same shares, that of the second
// on grain g, each at the place of the node: momentum and angular momentum are kept. The mass of the node is part of the mass matrix of the
// grains then, as of a condensed bond (grain_accelerations.h). Loose pieces follow no grain, nor does the part of m and c that is of points that failed:
// nothing would hold them back, and they would gain speed with each step.
//
// Where the cement moves along with the grains by these shares, the work of the impulse on nodes is what the reaction takes from the grains. Where it
// gives way it is not. So the books of energy have the work on the nodes.
#ifndef MPDEM_SHARED_IMPULSE_H
#define MPDEM_SHARED_IMPULSE_H

#include <vector>

#include "../mpm/grid.h"
#include "../mpm/point_store.h"
#include "added_mass.h"
#include "grain_accelerations.h"
#include "grain_sides.h"

namespace mpdem {

// Of one bond. `side` always points to the first of its two sides. The second follows it.
class SharedImpulse {
 public:
  SharedImpulse() = default;
  // To be made after the layout of the grid. held: as for shares_of_second_grain().
  SharedImpulse(const Grid& grid, const Body& body, const std::vector<char>& held);
  bool empty() const { return share_.empty(); }

  // Points failed since weigh().
  void forget() { stale_ = true; }
  // Finds the mass of the points that hold, of this rank, before a push. It is to be summed over ranks that share nodes.
  void weigh(const PointStore& points, const Grid& grid, double density);
  std::vector<double>& holding() { return holding_; }

  // Moments of the mass of the nodes that this rank counts: about either grain, m (1-s)^2 and m s^2, and m s (1-s) about both.
  void add_moments(const Grid& grid, const GrainSide* side, SideMoments* of_sides) const;
  // The change of acceleration of the grains is that of the sides. Adds the forces to nodes, whose sum over ranks is complete, and the
  // reaction to grains, whose sum is still to come.
  void push(Grid& grid, GrainSide* side, const AddedMass& added);
  // Of the last push, on nodes that move with the field `velocity`, those that this rank counts.
  double power(const Grid& grid, const std::vector<double>& velocity) const;

 private:
  double part_held(const Grid& grid, int node) const;

  std::vector<double> share_;  // of the second grain, below 0: of none
  std::vector<double> holding_, here_;  // mass of points that hold, of all ranks and of this one; empty: that of the nodes
  std::vector<double> force_;  // of the last push on the nodes
  bool stale_ = true;
};

}  // namespace mpdem

#endif
