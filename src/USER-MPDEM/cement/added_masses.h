// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The added mass of all bonds (coupling/added_mass.h): found anew where links, nodes, the time step or the largest eigenvalue change. Lists that bonds
// have alike become one then, see numerics/shared_list.h. Energies are this rank's share.
#ifndef MPDEM_CEMENT_ADDED_MASSES_H
#define MPDEM_CEMENT_ADDED_MASSES_H

#include <vector>

#include "scene.h"
#include "stable_step.h"

namespace mpdem {

class AddedMasses {
 public:
  AddedMasses(Scene& scene, StableStep& stable_step) : scene_(scene), stable_step_(stable_step) {}

  bool any() const { return any_; }  // on any rank
  bool hangs_on_eigenvalue() const { return stable_step_.eigenvalue_is_known(); }  // or on its bound
  // Collective, after a layout. Of all bonds, or of these; without links there are none.
  void refresh() { refresh(scene_.all_rows()); }
  void refresh(const std::vector<int>& rows);
  // Collective. The layout of these bonds changed in a run; event: why. Throws BadState if the step is too long now.
  void follow(const std::vector<int>& rows, const char* event, const StableStep::Patches* patches = nullptr);
  // Collective. Places of these bonds let go of other points: where they are elsewhere, so is their stiffness.
  void follow_places(const std::vector<int>& rows);
  // Collective. Links that let go give up their added mass in the course of a run.
  void drop_inert();
  void drop_inert(Bond& b) const;
  // Of these bonds; of those of them that are in motion, `later` of the acceleration ahead of the stored velocities.
  double energy(const std::vector<int>& rows) const;
  double energy_ahead(const std::vector<int>& rows, double later) const;

 private:
  Scene& scene_;
  StableStep& stable_step_;
  AlikeLists alike_;
  bool any_ = false;
};

}  // namespace mpdem

#endif
