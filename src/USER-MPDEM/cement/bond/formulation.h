// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The Lagrangian formulation, total or updated, as far as the parts of the engine have to know of it: do points stay in
// the cells of their grid, do they give their velocity to nodes, and what becomes of the nodes between pieces of a bond.
// The choice holds for all bonds, and for as long as there is cement. The class Kinematics takes the step, and this one
// makes it.
//
// The answers of this class are those of `total`: points stay in the cells where they were made. The classes are in
// step/formulations.cpp.
#ifndef MPDEM_CEMENT_BOND_FORMULATION_H
#define MPDEM_CEMENT_BOND_FORMULATION_H

#include <memory>

#include "bond.h"
#include "options.h"

namespace mpdem {

class Kinematics;
class NodeSplitting;
struct KinematicsContext;

class Formulation {
 public:
  virtual ~Formulation() = default;

  virtual std::unique_ptr<Kinematics> kinematics(const KinematicsContext& context) const = 0;
  // What keeps the nodes of pieces of a bond apart.
  virtual std::unique_ptr<NodeSplitting> splits() const = 0;

  // Largest dt^2 lambda of a step with lumped mass, and lambda the largest eigenvalue. For a mode that a transfer
  // removes altogether, it is half of what the central difference allows.
  virtual double stability_limit() const { return 4.0; }
  // Returns the bound of the eigenvalue if it alone holds for the steps to come, else 0.
  virtual double lasting_eigenvalue(double /* bound */) const { return 0.0; }

  // Number of cells around those with points for which a grid has nodes.
  virtual int margin() const { return 0; }
  // May a block have points of several cells in a row?
  virtual bool joins_cells() const { return true; }
  // Does a bond have to be laid out after an exchange?
  virtual bool needs_layout(const Bond& b) const { return b.changed(); }
  // Call after the layout of a bond.
  virtual void follow_layout(Bond& b) const { b.average.let_points_stand(true); }
  // Call when the nodes of a new bond have their velocity.
  virtual void start(Bond&) const {}
  // Sorts links by the slots of their points. Returns whether points may have other slots than those that the host knows.
  virtual bool sort_links(Bond&) const { return false; }
  // Shares lists of a bond with those that have equal ones, for as long as they stay.
  virtual void share(Bond& b, AlikeLists& alike) const { b.share(alike); }
  // Call when links lost their inertia in the course of a run. Leaves them out as a new layout does.
  virtual void remove_dropped(Bond& b, const BondRecord& record) const { b.links.remove_dropped(b.points, record); }
};

}  // namespace mpdem

#endif
