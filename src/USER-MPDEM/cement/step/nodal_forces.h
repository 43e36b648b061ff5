// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Computes the accelerations of nodes and grains after a pass over the points. Failed points debond. Links and contact
// points add their forces. Nodes that ranks share are summed. Damping, weight and faces of cracks act. The
// accelerations of grains and of their added mass are solved for, and the loads of the cement are added to the grains.
// Nodal forces are in the axes of their bond. Released and frictional energies are counted.
#ifndef MPDEM_CEMENT_STEP_NODAL_FORCES_H
#define MPDEM_CEMENT_STEP_NODAL_FORCES_H

#include "added_masses.h"
#include "elastic_forces.h"
#include "../condensed/condensed_bonds.h"
#include "../failure/cracks.h"
#include "../bond/scene.h"
#include "../bond/shared_nodes.h"

namespace mpdem {

class NodalForces {
 public:
  NodalForces(Scene& scene, SharedNodes& shared, const AddedMasses& added, CondensedBonds& condensed, Cracks& cracks)
      : scene_(scene), shared_(shared), added_(added), condensed_(condensed), cracks_(cracks), elastic_(scene) {}

  // Call before the pass over the points of all bonds. kick: time over which the accelerations of these forces change velocities.
  void begin(double kick);
  // Call after that pass. Counts the energies that it dissipates and releases.
  void end_pass();
  // Where the pass over the points puts its results: the energies of all bonds add up, failed points are those of one bond.
  AdvanceResult& pass_result() { return pass_result_; }
  const PassTicks& ticks() const { return pass_result_.ticks; }
  void clear_ticks() { pass_result_.ticks = PassTicks(); }

  // Call after the pass over the points of a bond. take_failed() stores which of them failed. debond() debonds their
  // links, and reports to the host.
  void take_failed(Bond& b);
  void debond(Bond& b);
  // Adds the other forces to the internal forces of a bond: links, contact points, closed cracks, film. The forces of a
  // bond that ranks do not cut are complete then.
  void add_forces(Bond& b);
  // Collective. Completes the forces of bonds that ranks cut, and computes all accelerations.
  void find_accelerations();
  // Collective. Computes forces and accelerations at the start of a run. Internal forces must be on the nodes.
  void find_at_start();
  // Collective. Adds the loads of the cement to the grains, once accelerations are known.
  void react();

 private:
  // What the mechanisms of a bond work on.
  BondContext at_work(Bond& b);
  // Parts of add_forces(), in their order. note_links() counts energies of the traction law and reports debonded links.
  // add_other_forces() adds those of mechanisms and film. end_forces() gives forces of constrained nodes to their masters.
  void follow_links(Bond& b);
  void note_links(Bond& b);
  void add_other_forces(Bond& b);
  void advance_film(Bond& b);
  void end_forces(Bond& b);
  // The last forces of a bond, once those of other ranks are summed: damping, weight, the host, contact of crack faces.
  void complete(Bond& b);
  // Takes the place of add_other_forces() at the start of a run, when no state may change.
  void add_other_forces_at_start(Bond& b);
  // Added mass and condensed bonds move with the grains, and the energy of dampers depends on the relative acceleration.
  bool grains_need_accelerations() const {
    const bool has_dampers = scene_.penalty && scene_.penalty->damping > 0.0;
    return (added_.any() || condensed_.any() || has_dampers) && scene_.grains.any_free();
  }
  void find_grain_accelerations();
  void add_inertial_forces();  // with `mass_order 2`
  void share_impulses();       // with sub-steps, see coupling/shared_impulse.h

  Scene& scene_;
  SharedNodes& shared_;
  const AddedMasses& added_;
  CondensedBonds& condensed_;
  Cracks& cracks_;
  ElasticForces elastic_;
  bool starts_ = false;  // find_at_start() is at work
  AdvanceResult pass_result_;
  double kick_ = 0.0;
};

}  // namespace mpdem

#endif
