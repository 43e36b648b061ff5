// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Decides when bonds are laid out (layout.h), and what a layout keeps. The motion of nodes is kept, or comes from a
// restart file or from new points. All else that depends on the nodes of a bond is made again. All functions are
// collective, except those of one bond and points_were_made(). BadState is thrown on all ranks if a grid takes more
// memory than it may, or if a restart file lacks nodes.
#ifndef MPDEM_CEMENT_STEP_LAYOUT_MANAGER_H
#define MPDEM_CEMENT_STEP_LAYOUT_MANAGER_H

#include <vector>

#include "added_masses.h"
#include "../failure/discontinuities.h"
#include "../layout/layout.h"
#include "../layout/restored_nodes.h"
#include "../bond/scene.h"
#include "../bond/shared_nodes.h"

namespace mpdem {

class LayoutManager {
 public:
  LayoutManager(Scene& scene, Discontinuities& divisions, RestoredNodes& restored, SharedNodes& shared, AddedMasses& added)
      : scene_(scene), discontinuities_(divisions), restored_(restored), shared_(shared), added_(added) {}

  // Finds the layers that get nodes of their own at the start, in bonds that are new or whose points were made. Phantom
  // nodes move to other ranks with the points of their bond.
  NewLayersOfBonds layers_at_start();
  // Call when phantom nodes of bonds came to other ranks with their points.
  void move_phantom_nodes();
  // Call when the host has made points of these rows of the table.
  void points_were_made(const std::vector<int>& rows) { fresh_points_.insert(fresh_points_.end(), rows.begin(), rows.end()); }
  // Stores the options for the axis of the elasticity in the records of bonds that have none yet, but have points without
  // a frame or points made later.
  void remember_axis();

  struct How {
    bool arrange = true;  // false: blocks stay as they are
    bool splits = false;  // true: nodes split, or pieces separated
  };
  // Lays out these rows of the table, ascending. Bonds in `layers` change their layers. The added mass of these rows is
  // cleared, and the ends of bonds are still those of before: find both again.
  void lay_out(const std::vector<int>& rows, NewLayersOfBonds layers, const How& how);
  // Calls lay_out() and finds the added mass too. Bonds and grains must be on the same ranks as before.
  void lay_out_again(const std::vector<int>& rows, NewLayersOfBonds layers, const How& how);
  const std::vector<int>& fresh_points() const { return fresh_points_; }

  // start_anew() makes what depends on the nodes of a bond. follow_grains() passes to the mechanisms of the bond to
  // which grain each of its nodes is connected.
  void start_anew(Bond& b);
  void follow_grains(Bond& b) const;
  // Updates the slots of points, which are out of date while points change cells (`updated` kinematics).
  void sync_slots();

 private:
  LayoutRequest request_of(Bond& b, NewLayersOfBonds& layers);
  void install(std::vector<BondLayout>& layouts);

  Scene& scene_;
  Discontinuities& discontinuities_;
  RestoredNodes& restored_;
  SharedNodes& shared_;
  AddedMasses& added_;
  int layouts_ = 0;                // number of layouts of bonds so far
  std::vector<int> fresh_points_;  // rows of the table whose points the host made since the last layout
};

// Lays out copies of all bonds. fresh: see LayoutManager::fresh_points(). penalty: that of the links, null: no links.
std::vector<BondLayout> layouts_of_copies(const Scene& scene, const Discontinuities& divisions, const RestoredNodes& restored,
                                          const std::vector<int>& fresh, const PenaltyParameters* penalty);

}  // namespace mpdem

#endif
