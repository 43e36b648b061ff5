// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The added mass of all bonds (coupling/added_mass.h). It is computed again when links, nodes, the time step or the
// largest eigenvalue change. Bonds with equal lists share one copy of them (numerics/shared_list.h). Energies are the
// share of this rank.
#ifndef MPDEM_CEMENT_STEP_ADDED_MASSES_H
#define MPDEM_CEMENT_STEP_ADDED_MASSES_H

#include <vector>

#include "../bond/scene.h"
#include "stable_step.h"

namespace mpdem {

class AddedMasses {
 public:
  AddedMasses(Scene& scene, StableStep& stable_step) : scene_(scene), stable_step_(stable_step) {}

  bool any() const { return any_; }                                                  // true if any rank has added mass
  bool depends_on_eigenvalue() const { return stable_step_.eigenvalue_is_known(); }  // else on a bound of it
  // Collective, after a layout. Finds the added mass of all bonds, or of these rows. Does nothing without links.
  void refresh();
  void refresh(const std::vector<int>& rows);
  // Collective. Call when the layout of these bonds changed during a run. Computes all added mass again if the known
  // eigenvalue changed. event: cause of the change, for the message. Throws BadState if the step is too long now.
  void follow(const std::vector<int>& rows, const char* event, const StableStep::Patches* patches = nullptr);
  // Collective. Acts only in topology steps (Scene::contacts_move()). Updates the added mass of bonds whose contact points
  // came near to their grains or went away from them, and of the rows `moved` of this rank, whose contact points are on
  // other material points. Nodes that get added mass are slowed and gain no energy (AddedMass::slow_nodes()).
  void follow_contacts(const std::vector<int>& moved);
  // Collective. Removes the added mass of links that debonded during a run.
  void drop_debonded();
  void drop_debonded(Bond& b) const;
  // Energy of the added mass of these bonds, with velocities ahead of the stored ones by `later` times the
  // acceleration. Bonds that no step has moved yet count zero.
  double energy_ahead(const std::vector<int>& rows, double later) const;

 private:
  void find(const std::vector<Bond*>& bonds);
  bool update_added_mass(Bond& b) const;
  // Collective. Computes the added mass of these bonds again after `action`. Call it between
  // BondedGrains::clear_sudden_forces() and the drift.
  template <class Action>
  void renew(const std::vector<int>& rows, Action action);

  Scene& scene_;
  StableStep& stable_step_;
  AlikeLists alike_;
  bool any_ = false;
};

}  // namespace mpdem

#endif
