// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Interface of the Lagrangian formulations, total and updated, for the rest of the engine: whether points remain in the
// cells of their grid, whether they give their velocity to nodes, and what separates the nodes of two pieces of a bond.
// All bonds have the same formulation, for as long as there is cement. The formulation makes the objects that do the work:
// Kinematics for the step, NodeSplitting for the pieces of a bond.
//
// The defaults are those of `kinematics total`: points remain in the cells where they were made. The subclasses are in
// cement/step/formulations.cpp.
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
  // Makes the object that separates the nodes of the pieces of a bond.
  virtual std::unique_ptr<NodeSplitting> splits() const = 0;

  // Largest stable dt^2 lambda with lumped mass, where lambda is the largest eigenvalue. The default 4 is the limit of
  // central differences. It is halved where a transfer removes modes completely.
  virtual double stability_limit() const { return 4.0; }
  // Returns `bound` if only this upper bound of the eigenvalue stays valid in later steps, else 0.
  virtual double lasting_eigenvalue(double /* bound */) const { return 0.0; }

  // Width in cells of the margin around cells with points that also gets nodes.
  virtual int margin() const { return 0; }
  // True if a block may have points of several cells in a row.
  virtual bool joins_cells() const { return true; }
  // True if a bond needs a new layout after its atoms were exchanged between ranks.
  virtual bool needs_layout(const Bond& b) const { return b.changed(); }
  // Call after the layout of a bond.
  virtual void follow_layout(Bond& b) const { b.average.set_points_fixed(true); }
  // Call once the nodes of a new bond have their velocity.
  virtual void start(Bond&) const {}
  // Sorts links by the slots of their points. Returns true if the host may not know the present slots of points.
  virtual bool sort_links(Bond&) const { return false; }
  // Shares the memory of lists of a bond with bonds that have equal lists, unless the lists change as points move.
  virtual void share(Bond& b, AlikeLists& alike) const { b.share(alike); }
  // Removes the debonded links that lost their added mass during a run, as a new layout would.
  virtual void remove_dropped(Bond& b, const BondRecord& record) const { b.links.remove_dropped(b.points, record); }
};

}  // namespace mpdem

#endif
