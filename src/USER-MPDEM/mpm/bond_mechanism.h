// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// What one mechanism has of a bond, and where it takes part in a step. A bond has parts of those mechanisms alone that act in
// its scene, in the order in which they act (cement/layout/mechanisms.h). So the step asks for none of them by name, and what a scene
// does not use takes neither time nor memory. Calls are per bond; loops over points and nodes are behind them.
//
// A part refers to blocks of points and nodes by their numbers. A new layout makes all parts of a bond anew.
#ifndef MPDEM_MPM_BOND_MECHANISM_H
#define MPDEM_MPM_BOND_MECHANISM_H

#include <cstddef>
#include <string>
#include <vector>

#include "grid.h"
#include "point_store.h"
#include "power.h"

namespace mpdem {

struct BondEnd;

// A bond at work, in its own axes.
struct BondAtWork {
  PointStore& points;
  Grid& grid;
  BondEnd* ends;  // the first of its two sides; the second follows it
  const BondRecord& record;
  const SharedList<double>& added_mass;  // of the nodes, or empty
  double dt = 0.0;                       // the step; 0: the forces of the state are found anew, nothing moves
  double kick = 0.0;                     // time from the middle of this step to that of the next one
};

// Energies that a call takes.
struct Losses {
  double released = 0.0, frictional = 0.0;
};

class BondMechanism {
 public:
  virtual ~BondMechanism() = default;

  // Points failed in this step (slots, ascending), and links of the store let go with them.
  virtual void points_failed(const BondAtWork&, const std::vector<int>& /* slots */, const std::vector<int>& /* links */, Losses&) {}
  // Links of the store let go of points that hold.
  virtual void links_debonded(const BondAtWork&, const std::vector<int>& /* links */, Losses&) {}

  // Adds forces to nodes and grains. Nodes have the forces of their points and links. Tied nodes have not handed on theirs yet.
  virtual void add_force(const BondAtWork&, Losses&) {}
  // Adds forces to nodes that have those of all ranks and of their slaves.
  virtual void add_damping(const BondAtWork&) {}
  // Adds forces to nodes whose other forces are complete. Collective among the ranks that share the nodes.
  virtual void add_contact(const BondAtWork&) {}
  // Adds row sums of the stiffness to two numbers a node, for the added mass, as PenaltyLinks::add_stiffness() does.
  virtual void add_stiffness(const Grid&, const BondEnd*, double* /* penalty */) const {}

  // Adds energy that points store, and energy between them and the grains.
  virtual void add_energy(const PointStore&, const Grid&, const BondEnd*, double& /* of_points */, double& /* of_coupling */) const {}
  // Power of loads of the host that the part brought to the nodes in this step, on nodes that move with the field `velocity`.
  virtual double load_power(const Grid&, const std::vector<double>& /* velocity */) const { return 0.0; }
  // Add the power that damping and friction take from the nodes.
  virtual void add_damping_power(const Grid&, const BondEnd*, Power&) const {}
  virtual void add_friction_power(const Grid&, Power&) const {}

  // Grains to which nodes hold changed: nodes_held() of coupling/relative_damping.h, empty for a bond that is whole.
  virtual void follow_grains(const Grid&, const BondRecord&, const std::vector<char>& /* held */) {}
  // Collective among the ranks that share the nodes. Returns what is wrong with the state, or an empty text. step: its number.
  virtual std::string trouble(const PointStore&, Grid&, long /* step */) const { return std::string(); }
  virtual std::size_t memory_usage() const = 0;
};

}  // namespace mpdem

#endif
