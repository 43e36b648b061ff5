// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// How nodes and points move in a step. With total kinematics the reference stays, nodes drift and points follow. With
// updated kinematics the reference is the present, and velocities go from nodes to points and back in every step. The
// choice is that of Formulation, and holds for all bonds.
#ifndef MPDEM_CEMENT_STEP_KINEMATICS_H
#define MPDEM_CEMENT_STEP_KINEMATICS_H

#include <memory>

#include "added_masses.h"
#include "layout_manager.h"
#include "nodal_forces.h"
#include "../bond/scene.h"
#include "../bond/shared_nodes.h"
#include "work_of_step.h"

namespace mpdem {

// Parts on which kinematics act.
struct KinematicsContext {
  Scene& scene;
  SharedNodes& shared;
  AddedMasses& added;
  LayoutManager& layout_manager;
  NodalForces& forces;
  const WorkOfStep& work;
};

class Kinematics {
 public:
  virtual ~Kinematics() = default;

  // Collective. Follow the time step with the added mass: at the start of a run, and where the step changes in its
  // course.
  virtual void start_run() = 0;
  virtual void change_step() = 0;
  // Collective. Takes a step up to the forces of points and links: nodes drift, points take their strain, damage and
  // stress, links of failed points let go. Leaves internal forces and those of links on the nodes of this rank.
  virtual void advance() = 0;
  // Collective. Books the transfer of the step. Call once accelerations are known.
  virtual void account_for_accelerations() {}
  // Collective. Finds the internal force of the present state.
  virtual void find_internal_force() = 0;

 protected:
  explicit Kinematics(const KinematicsContext& context)
      : scene_(context.scene),
        shared_(context.shared),
        added_(context.added),
        layout_manager_(context.layout_manager),
        forces_(context.forces),
        work_(context.work) {}

  Scene& scene_;
  SharedNodes& shared_;
  AddedMasses& added_;
  LayoutManager& layout_manager_;
  NodalForces& forces_;
  const WorkOfStep& work_;
};

std::unique_ptr<Kinematics> make_total(const KinematicsContext& context);
std::unique_ptr<Kinematics> make_reprojected(const KinematicsContext& context);
std::unique_ptr<Kinematics> make_renewed(const KinematicsContext& context);
std::unique_ptr<Kinematics> make_updated(const KinematicsContext& context);

// Finds velocities of nodes that have mass from their momentum.
void take_momentum(Grid& grid);

}  // namespace mpdem

#endif
