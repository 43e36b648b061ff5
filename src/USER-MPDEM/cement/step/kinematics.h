// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Motion of nodes and points in a step. With total kinematics the reference is fixed, nodes drift and points follow.
// With updated kinematics the present is the reference, and velocities go from nodes to points and back in every step.
// Formulation chooses one of them for all bonds.
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

// What kinematics act on.
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

  // Collective. Adapt the added mass to the time step, at the start of a run and when the step changes during it.
  virtual void start_run() = 0;
  virtual void change_step() = 0;
  // Collective. Advances a step up to the forces of points and links: nodes drift, points get their strain, damage and
  // stress, and links of failed points debond. Leaves internal forces and those of links on the nodes of this rank.
  virtual void advance() = 0;
  // Collective. Counts the energy of the transfer of the step. Call once accelerations are known.
  virtual void account_for_accelerations() {}
  // Collective. Computes the internal force of the present state.
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
std::unique_ptr<Kinematics> make_renewed_reference(const KinematicsContext& context);
std::unique_ptr<Kinematics> make_updated(const KinematicsContext& context);

// Computes the velocities of nodes with mass from their momentum.
void velocities_from_momentum(Grid& grid);

}  // namespace mpdem

#endif
