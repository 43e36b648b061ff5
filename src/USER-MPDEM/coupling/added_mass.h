// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Added mass of the nodes of one bond. It makes the penalty of the links semi-implicit.
//
// If the row sum k of the penalty stiffness is too stiff for the time step, the inertia of the node is raised just
// enough. A damper g acts on the velocity of half a step ago and counts as a spring 2 g/dt. A step is stable if
//   k dt^2 + 2 g dt <= 4 m.
// Added mass c is the inertia of the motion u - R of the node against its grain, where R is the rigid motion of the
// grain at the node. The force on the node is -c (u - R)''. The opposite force acts on the grain at the position of the
// node, so momentum and angular momentum are exact.
//
// A free grain moves under the load of its links, and then the node's own mass does part of the work of c. For any t
//   (u - R)^2 <= (1 + t) u^2 + (1 + 1/t) R^2.
// So the stiffness of links to a free grain is multiplied by 1 + t, with t the mass of the cement over the inertia of the
// grain (`mass_ratio`). The kinetic energy of the grain then covers the rest. grain_accelerations.h has the accelerations of
// free grains.
#ifndef MPDEM_COUPLING_ADDED_MASS_H
#define MPDEM_COUPLING_ADDED_MASS_H

#include <array>
#include <vector>

#include "../mpm/grid.h"
#include "eight_nodes.h"
#include "../mpm/bond_mechanism.h"
#include "bond_ends.h"
#include "penalty_links.h"

namespace mpdem {

// `ends` points to end 0 of the bond. End 1 follows it.
class AddedMass {
 public:
  // The time step and the largest eigenvalue of the cement. Eigenvalues are squares of angular frequencies.
  struct Stability {
    double dt = 0;
    double lambda = 0;             // largest eigenvalue of the cement
    bool lambda_is_bound = false;  // lambda is a bound for a grid without constrained nodes, see Grid::constraint_factor()
    double bound = 4;              // largest stable dt^2 lambda
  };
  // Collective among the ranks that share the nodes. Finds the least mass c that keeps the central difference stable
  // when the penalty k of links and mechanisms acts in addition to the cement: dt^2 (lambda m + k) <= bound (m + c) at
  // every node. Most nodes need no added mass.
  void find(const PenaltyLinks& links, Grid& grid, const BondEnd* ends, const Stability& s,
            const std::vector<std::unique_ptr<BondMechanism>>& mechanisms = {});

  // Added mass of a node, due to links on any rank.
  struct OfNode {
    int node;
    double mass[2];  // added mass due to the links to each grain
  };
  std::vector<OfNode> shares() const;
  // Added mass of eight nodes, one per lane. Bonds of one shape have the rest in common, which is in EightNodes.
  struct EightMasses {
    vd mass[2];  // 0 in the lanes beyond the last share; these lanes have the node of the first share
    vd added;    // added mass of the nodes, for both grains
  };
  const std::vector<EightMasses>& masses() const { return masses_; }
  const SharedList<EightNodes>& nodes() const { return nodes_; }
  bool empty() const { return masses_.empty(); }
  const SharedList<double>& of_nodes() const { return mass_; }

  // Slows nodes against the grains where the added mass exceeds that in `before`, so that the energy of this relative
  // motion is kept. Velocities are ahead of the stored ones by `later` times the acceleration, and apply to the coming
  // step dt, which the grains have made already. The momentum that nodes lose goes to the grains over this step, as a
  // transfer force. Returns the energy that the cement loses beyond its work on the grains, without that of the added
  // mass.
  double slow_nodes(const std::vector<OfNode>& before, Grid& grid, BondEnd* ends, double later, double dt) const;

  // Adds to the nodes the force that accelerates the added mass with its grains, without its reaction.
  void move_added_mass(Grid& grid, const BondEnd* ends) const;
  // Finds the accelerations of the nodes. The forces on nodes must be summed over ranks. Added mass moves with its
  // grain: the force for this is added to the nodes, and its reaction to the grains, before their sum over ranks.
  void accelerate(Grid& grid, BondEnd* ends) const;
  // Added mass follows the jumps of its grains as it follows their accelerations: a node of mass m takes the share c/(m
  // + c) of a jump. Adds this share times `rate` to the accelerations of nodes, and its reaction times grain_rate to the
  // jump forces on the grains. A rate is one over the time in which the change of velocity takes place. weight:
  // acceleration by gravity that acts on the mass of nodes.
  struct Followed {
    double of_weight = 0.0, of_inertial_force = 0.0;  // power of these forces on the changes of velocity, on nodes that this rank counts
  };
  Followed follow_jumps(Grid& grid, BondEnd* ends, double rate, double grain_rate, const std::array<double, 3>& weight) const;
  // Adds the jumps as forces on nodes and grains. at_start: the added mass moved with the nodes so far, so its jump is
  // the velocity of the grains less that of the nodes.
  void add_jumps(Grid& grid, BondEnd* ends, bool at_start) const;
  // Adds to the grains the reaction to a transfer, which changes the velocity of nodes as the acceleration scale *
  // field does.
  void add_reaction(const Grid& grid, const std::vector<double>& field, double scale, BondEnd* ends) const;

  // Work of the reaction of add_reaction() on the grains, divided by its scale.
  double work_of_reaction(const Grid& grid, const BondEnd* ends, const std::vector<double>& field) const;
  // Power of added mass times its acceleration relative to the grains, on the velocity `field` of the nodes.
  double power(const Grid& grid, const BondEnd* ends, const std::vector<double>& field) const;
  // Kinetic energy relative to the grains, c/2 v.w. v is the stored velocity plus `early` times the acceleration, w the
  // same with `late`.
  double energy(const Grid& grid, const BondEnd* ends, double early = 0.0, double late = 0.0) const;
  // Kinetic energy relative to the grains at the end of a drift whose grains have moved already. The velocities of the
  // grains exclude the last jumps. Those of nodes include `later` times the acceleration.
  double energy_ahead(const Grid& grid, const BondEnd* ends, double later) const;
  // Adds the added mass at each end to mass[2], for the nodes that this rank counts.
  void add_to_ends(const Grid& grid, double* mass) const;

  // Shares lists with bonds that have equal ones.
  void share(AlikeLists& alike);
  std::size_t memory_usage() const;

 private:
  void accelerate_with_grains(Grid& grid, BondEnd* ends) const;    // replaces forces on nodes with added mass by accelerations
  void keep(const std::vector<OfNode>& shares, const Grid& grid);  // lays out masses_, nodes_ and without_
  SharedList<double> mass_;                                        // added mass of each node, for both grains
  std::vector<EightMasses> masses_;
  SharedList<EightNodes> nodes_;
  SharedList<std::array<int, 2>> without_;  // ranges of nodes that are not constrained and have no added mass
};

}  // namespace mpdem

#endif
