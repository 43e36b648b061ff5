// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds the accelerations of nodes and grains from what a pass over the points leaves. Points that failed let go. Links
// and places pull. Nodes that ranks share are summed. Damping, weight and faces of cracks act. Grains and their added
// mass are solved for. What the cement does to the grains goes to them. Forces of nodes are in the axes of the body of
// their bond. What is given up or rubbed away is booked.
#ifndef MPDEM_CEMENT_STEP_NODAL_FORCES_H
#define MPDEM_CEMENT_STEP_NODAL_FORCES_H

#include <vector>

#include "added_masses.h"
#include "../condensed/condensed_bonds.h"
#include "../failure/cracks.h"
#include "../bond/scene.h"
#include "../bond/shared_nodes.h"

namespace mpdem {

class NodalForces {
 public:
  NodalForces(Scene& scene, SharedNodes& shared, const AddedMasses& added, CondensedBonds& condensed, Cracks& cracks)
      : scene_(scene), shared_(shared), added_(added), condensed_(condensed), cracks_(cracks) {}

  // Call before the pass over the points of all bonds. kick: time from the middle of the last step to that of this one.
  void begin(double kick);
  // Call after that pass. Books what it dissipates and gives up.
  void end_pass();
  AdvanceResult& pass() { return pass_; }  // result of the bond at work, for kernels
  const PassTicks& ticks() const { return pass_.ticks; }
  void clear_ticks() { pass_.ticks = PassTicks(); }

  // Call after the pass over the points of a bond. take_failed() notes which of them failed. debond() frees what held
  // them, and tells the host.
  void take_failed(Bond& b);
  void debond(Bond& b);
  // Adds the other forces to a bond whose nodes have those of its points: links, places, closed cracks, the film. The
  // forces of a bond that ranks do not cut are complete then.
  void add_forces(Bond& b);
  // Collective. Completes the forces of bonds that ranks cut, and finds the accelerations of all.
  void find_accelerations();
  // Collective. Finds forces and accelerations at the start of a run. Internal forces must be on the nodes.
  void find_at_start();
  // Collective. Adds the forces of the cement to the grains, once accelerations are known.
  void react();

 private:
  BondAtWork at_work(Bond& b);
  void follow_links(Bond& b);
  void advance_film(Bond& b);
  void end_forces(Bond& b);
  void complete(Bond& b);
  bool grains_need_accelerations() const { return (added_.any() || condensed_.any()) && scene_.grains.any_free(); }
  void find_grain_accelerations();
  void add_inertial_forces();
  void share_impulses();

  Scene& scene_;
  SharedNodes& shared_;
  const AddedMasses& added_;
  CondensedBonds& condensed_;
  Cracks& cracks_;
  AdvanceResult pass_;
  double kick_ = 0.0;
};

}  // namespace mpdem

#endif
