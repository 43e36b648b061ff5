// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How nodes and points move in a step. Total: the reference stays, nodes drift, points follow. Updated: the reference is the
// present, velocities go from nodes to points and back in every step. Chosen once for all bonds.
#ifndef MPDEM_CEMENT_KINEMATICS_H
#define MPDEM_CEMENT_KINEMATICS_H

#include <memory>

#include "bond.h"

namespace mpdem {

class Cement;

class Kinematics {
 public:
  virtual ~Kinematics() = default;

  // Collective. A step up to the forces of points and links: nodes drift, points take their strain, damage and stress, links of
  // failed points let go. Leaves internal forces and those of links on the nodes of this rank.
  virtual void advance() = 0;
  // Collective. Once accelerations are known.
  virtual void account_for_accelerations() {}
  // Collective. Internal force of the present state.
  virtual void find_internal_force() = 0;
  // Points of a bond that is new take up the motion of its nodes.
  virtual void start_points(Bond&) {}
  // After a layout of the bond.
  virtual void bind(Bond&) {}

 protected:
  explicit Kinematics(Cement& cement) : cement_(cement) {}
  Cement& cement_;
};

std::unique_ptr<Kinematics> make_total(Cement& cement);
std::unique_ptr<Kinematics> make_updated(Cement& cement);

// Velocities of nodes that have mass from momentum.
void take_momentum(Grid& grid);

}  // namespace mpdem

#endif
