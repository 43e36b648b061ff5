// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Added mass of the nodes of one bond, which makes the penalty of its links semi-implicit.
//
// Semi-implicit in the node: where the row sum of the penalty stiffness k is too stiff for
// the time step, the node's mass is raised just enough (Grid::set_added_mass). A damper g,
// which acts on the velocity of half a step ago, counts as a spring 2 g/dt: a step is stable
// if k dt^2 + 2 g dt <= 4 m. Added mass c is that of the motion u - R of the node against the grain (as if fixed to
// it there); the force -c (u - R)'' acts on the grain with the opposite sign at the node's place, so momentum and
// angular momentum stay exact. Where the node's own mass does part of the work of c but the grain R is free, since
// (u - R)^2 <= (1 + t) u^2 + (1 + 1/t) R^2 for any t, links count (1 + t)-fold, with t the mass of the cement over
// what the grain has of inertia against it (`mass_ratio`): the grain's own kinetic energy then covers the rest.
// Accelerations of free grains: grain_accelerations.h.
#ifndef MPDEM_ADDED_MASS_H
#define MPDEM_ADDED_MASS_H

#include <vector>

#include "../mpm/grid.h"
#include "grain_sides.h"
#include "penalty_links.h"

namespace mpdem {

// `side` is always the first of the two sides of the bond, the second is behind it.
class AddedMass {
 public:
  // What is known of the eigenvalues of the cement, squares of angular frequencies.
  struct Stability {
    double dt = 0;
    double lambda = 0;             // largest of the cement
    bool lambda_is_bound = false;  // of a grid without ties, see Grid::stable_inertia()
    double bound = 4;              // largest dt^2 lambda
  };
  // Collective among the ranks that share the nodes. The least mass that keeps the central difference stable when the
  // penalty of the links comes on top of the cement: every node gets dt^2 (lambda m + k) <= bound (m + c). Most nodes need none.
  void find(const PenaltyLinks& links, Grid& grid, const GrainSide* side, const Stability& s);

  // Added mass of a node, whoever has the links.
  struct Share {
    int node;
    double mass[2];  // of the links to either side
    double X[3];     // of the node, reference
    double sum() const { return mass[0] + mass[1]; }
    // From the centre of a grain.
    void lever_arm(const Grid& grid, const GrainSide& s, double* r) const {
      for (int d = 0; d < 3; ++d) r[d] = X[d] + grid.displacement[3 * node + d] - s.x[d];
    }
  };
  const std::vector<Share>& shares() const { return shares_; }
  bool empty() const { return shares_.empty(); }
  // Of each node.
  const std::vector<double>& of_nodes() const { return mass_; }

  // It moves with its grain: force on nodes, after their sum over ranks, that takes it along, and its reaction on
  // the grains, before theirs, with the acceleration that nodes will have by Grid::update_acceleration().
  void carry(Grid& grid, GrainSide* side) const;
  // It follows the jumps of its grains, as it follows their accelerations: c of a node of mass m takes it along with
  // c / (m + c) of them, rate times which is added to the accelerations. grain_rate times the reaction is added to the
  // forces of jumps on the grains.
  void follow_jumps(Grid& grid, GrainSide* side, double rate, double grain_rate) const;
  // The same as forces on nodes and grains; `at_start`: of added mass that moves with the
  // nodes so far, whose jump is the velocity of the grains less that of the nodes.
  void add_jumps(Grid& grid, GrainSide* side, bool at_start) const;
  // Reaction to a transfer that changes the velocity of nodes, by the acceleration scale * field.
  void add_reaction(const Grid& grid, const std::vector<double>& field, double scale, GrainSide* side) const;

  // Work of that reaction on the grains for a change `field` of the velocity of the nodes, over its scale.
  double work_of_reaction(const Grid& grid, const GrainSide* side, const std::vector<double>& field) const;
  // Power of its acceleration relative to the grains on the velocity `field` of the nodes.
  double power(const Grid& grid, const GrainSide* side, const std::vector<double>& field) const;
  // Kinetic energy relative to the grains, m/2 v.w with v and w the stored velocity after the times `early` and `late`
  // of the acceleration.
  double energy(const Grid& grid, const GrainSide* side, double early = 0.0, double late = 0.0) const;
  // The same before the jumps of the grains, with nodes after the time `later` of their
  // acceleration: what it is at the end of a drift whose grains have moved already.
  double energy_ahead(const Grid& grid, const GrainSide* side, double later) const;
  // Mass at either side, of the nodes that count on this rank.
  void add_to_sides(const Grid& grid, double* mass) const;

  std::size_t memory_usage() const;

 private:
  std::vector<double> mass_;  // a node
  std::vector<Share> shares_;
};

}  // namespace mpdem

#endif
