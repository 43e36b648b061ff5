// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// One mechanism of a bond, such as damping or contact: its data, and the calls by which it takes part in a step. A bond
// has only the mechanisms that its scene uses, in the order in which they act (cement/layout/mechanisms.h). So the step
// names none of them, and an unused one costs nothing. Calls are per bond, with loops over points and nodes inside.
//
// A mechanism refers to blocks of points and to nodes by index. A new layout makes all mechanisms of a bond anew.
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

// A bond during a step, in its own axes.
struct BondContext {
  PointStore& points;
  Grid& grid;
  BondEnd* ends;  // the first of its two ends; the second follows it
  const BondRecord& record;
  const SharedList<double>& added_mass;  // added mass of each node, for both grains; empty without added mass
  double dt = 0.0;                       // the step; 0: only the forces of the present state are found
  double kick = 0.0;                     // time over which the forces of this call will change the velocities
};

// Energies that a call releases, or dissipates by friction.
struct Losses {
  double released = 0.0, frictional = 0.0;
};

class BondMechanism {
 public:
  virtual ~BondMechanism() = default;

  // Called for points that failed in this step (slots, ascending), with the links of the store that debonded with them.
  virtual void points_failed(const BondContext&, const std::vector<int>& /* slots */, const std::vector<int>& /* links */, Losses&) {}
  // Called for links of the store that debonded from intact points.
  virtual void links_debonded(const BondContext&, const std::vector<int>& /* links */, Losses&) {}

  // Adds forces to nodes and grains. Nodes already have the forces of their points and links. Constrained nodes have
  // not passed theirs to their masters yet.
  virtual void add_force(const BondContext&, Losses&) {}
  // Adds forces to nodes whose forces include those of all ranks and of the nodes constrained to them.
  virtual void add_damping(const BondContext&) {}
  // Adds forces to nodes whose other forces are complete. Collective among the ranks that share the nodes.
  virtual void add_contact(const BondContext&) {}
  // Adds row sums of the stiffness to two numbers per node, one for each grain, for the added mass. See PenaltyLinks::add_stiffness().
  virtual void add_stiffness(const Grid&, const BondEnd*, double* /* penalty */) const {}

  // Adds the energy stored in points, and that of the coupling between them and the grains.
  virtual void add_energy(const PointStore&, const Grid&, const BondEnd*, double& /* of_points */, double& /* of_coupling */) const {}
  // Power of the host's loads that the mechanism applied to the nodes in this step, for these nodal velocities.
  virtual double load_power(const Grid&, const std::vector<double>& /* velocity */) const { return 0.0; }
  // Add the power that damping and friction dissipate at the nodes.
  virtual void add_damping_power(const Grid&, const BondEnd*, Power&) const {}
  virtual void add_friction_power(const Grid&, Power&) const {}

  // Called when the grains to which nodes are connected changed. connected: connected_grains_of_nodes() of coupling/relative_damping.h,
  // empty for a bond that is not separated.
  virtual void follow_grains(const Grid&, const BondRecord&, const std::vector<char>& /* connected */) {}
  // True if the motion left the range of the mechanism, so that the separated bond has to go on as rigid pieces.
  // Collective among the ranks that share the nodes.
  virtual bool has_ended(const PointStore&, Grid&) const { return false; }
  // Returns what is wrong with the state, or an empty text. Collective among the ranks that share the nodes.
  virtual std::string trouble(const PointStore&, Grid&, long /* step */) const { return std::string(); }
  virtual std::size_t memory_usage() const = 0;
};

}  // namespace mpdem

#endif
