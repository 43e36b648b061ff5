// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// From what a pass over the points leaves to the accelerations of nodes and grains: points that failed let go, links and places pull, nodes that
// ranks share are summed, damping, weight and faces of cracks act, grains and their added mass are solved for, and what the cement does to the
// grains goes to them. Forces of nodes are in the axes of the body of their bond. What is given up or rubbed away is booked.
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

  // In a step, around the pass over the points of all bonds: what it dissipates and gives up begins with zero, and goes to the books.
  void begin_pass() { pass_.dissipated = pass_.released = 0.0; }
  void end_pass();
  AdvanceResult& pass() { return pass_; }  // of the bond at work, for kernels
  const PassTicks& ticks() const { return pass_.ticks; }
  void clear_ticks() { pass_.ticks = PassTicks(); }

  // Of a bond, after the pass over its points: which of them failed; what held them lets go, and the host is told.
  void take_failed(Bond& b);
  void let_go(Bond& b);
  // Forces of links, places and closed cracks of a bond, on nodes that have those of its points.
  void add_link_forces(Bond& b);
  // Bonds that ranks do not cut need not wait for others: complete_early() then completes them right after the forces of their links.
  void begin_completing();
  void complete_early(Bond& b);
  // Collective. All else that acts, of bonds that are not complete yet, and the accelerations of all.
  void complete();
  // Collective. Of the state at the start of a run, whose internal forces are on the nodes.
  void find_at_start();
  // Collective. Once accelerations are known: forces of the cement on the grains.
  void react();

 private:
  void follow_links(Bond& b);
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
  bool completes_early_ = false;  // in this step
};

}  // namespace mpdem

#endif
