// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Finds the accelerations of nodes and grains from what a pass over the points leaves. Points that failed let go. Links
// and places pull. Nodes that ranks share are summed. Damping, weight and faces of cracks act. Grains and their added
// mass are solved for. What the cement does to the grains goes to them. Forces of nodes are in the axes of the body of
// their bond. What is given up or rubbed away is booked.
#ifndef MPDEM_CEMENT_NODAL_FORCES_H
#define MPDEM_CEMENT_NODAL_FORCES_H

#include <vector>

#include "added_masses.h"
#include "condensed_bonds.h"
#include "cracks.h"
#include "scene.h"
#include "shared_nodes.h"

namespace mpdem {

class NodalForces {
 public:
  NodalForces(Scene& scene, SharedNodes& shared, const AddedMasses& added, CondensedBonds& condensed, Cracks& cracks)
      : scene_(scene), shared_(shared), added_(added), condensed_(condensed), cracks_(cracks) {}

  // Enclose the pass over the points of all bonds in a step. begin_pass() sets what the pass dissipates and gives up to
  // zero. end_pass() books it.
  void begin_pass() { pass_.dissipated = pass_.released = 0.0; }
  void end_pass();
  AdvanceResult& pass() { return pass_; }  // result of the bond at work, for kernels
  const PassTicks& ticks() const { return pass_.ticks; }
  void clear_ticks() { pass_.ticks = PassTicks(); }

  // Call after the pass over the points of a bond. take_failed() notes which of them failed. let_go() frees what held
  // them, and tells the host.
  void take_failed(Bond& b);
  void let_go(Bond& b);
  // Adds forces of links, places and closed cracks of a bond to nodes that have those of its points.
  void add_link_forces(Bond& b);
  // Bonds that ranks do not cut need not wait for others. After begin_completing(), complete_early() completes them
  // right after the forces of their links.
  void begin_completing();
  void complete_early(Bond& b);
  // Collective. Adds all other forces to bonds that are not complete yet, and finds the accelerations of all.
  void complete();
  // Collective. Finds forces and accelerations at the start of a run. Internal forces must be on the nodes.
  void find_at_start();
  // Collective. Adds the forces of the cement to the grains, once accelerations are known.
  void react();

 private:
  void follow_links(Bond& b);
  void advance_film(Bond& b);
  void complete(Bond& b, double kick);
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
  bool completes_early_ = false;  // true in steps that complete bonds early
};

}  // namespace mpdem

#endif
