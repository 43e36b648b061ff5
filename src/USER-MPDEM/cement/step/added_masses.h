// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The added mass of all bonds (coupling/added_mass.h). It is found anew when links, nodes, the time step or the largest
// eigenvalue change. Lists that are equal in several bonds are then stored once, see numerics/shared_list.h. Energies
// are the share of this rank.
#ifndef MPDEM_CEMENT_STEP_ADDED_MASSES_H
#define MPDEM_CEMENT_STEP_ADDED_MASSES_H

#include <vector>

#include "../bond/scene.h"
#include "stable_step.h"

namespace mpdem {

class AddedMasses {
 public:
  AddedMasses(Scene& scene, StableStep& stable_step) : scene_(scene), stable_step_(stable_step) {}

  bool any() const { return any_; }                                                // true if any rank has added mass
  bool hangs_on_eigenvalue() const { return stable_step_.eigenvalue_is_known(); }  // false: it depends on a bound of the eigenvalue
  // Collective. Finds the added mass of all bonds, or of these rows of the table, after a layout. Does nothing without
  // links.
  void refresh();
  void refresh(const std::vector<int>& rows);
  // Collective. Call when the layout of these bonds changed in a run. Finds all added mass anew if the known eigenvalue
  // changed. event: reason of the change, for the message. Throws BadState if the step is too long now.
  void follow(const std::vector<int>& rows, const char* event, const StableStep::Patches* patches = nullptr);
  // Collective, in steps in which the scene watches. Finds the added mass of bonds whose places moved on to other points
  // (rows of this rank), or came near to their grains or away from them.
  // Nodes that take up added mass are slowed, so that they gain no energy (AddedMass::take_up()).
  void follow_contacts(const std::vector<int>& moved);
  // Collective. Takes the added mass from links that let go in the course of a run.
  void drop_inert();
  void drop_inert(Bond& b) const;
  // Energy of the added mass of these bonds, with velocities that are ahead of the stored ones by `later` times the
  // acceleration. Bonds that are not in motion yet count nothing.
  double energy_ahead(const std::vector<int>& rows, double later) const;

 private:
  void find(const std::vector<Bond*>& bonds);
  bool update_added_mass(Bond& b) const;
  // Collective. Finds the added mass of these bonds anew after `action`. Call it between BondedGrains::clear_sudden_forces() and the drift.
  template <class Action>
  void take_up(const std::vector<int>& rows, Action action);

  Scene& scene_;
  StableStep& stable_step_;
  AlikeLists alike_;
  bool any_ = false;
};

}  // namespace mpdem

#endif
