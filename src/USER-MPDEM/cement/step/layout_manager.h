// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Decides when bonds are laid out (layout.h), and what a layout carries over. The motion of nodes is carried over, or
// comes from a restart file or from points that are new. All that depends on the nodes of a bond starts anew. All
// functions are collective, except those of one bond and points_were_made(). BadState is thrown on all ranks if a grid
// takes more memory than it may, or if a restart file does not have all nodes.
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

  // Finds the parts that get nodes of their own at the start, in bonds that are new or whose points were made. Copies
  // of nodes come to other ranks with the points of their bond.
  NewLayersOfBonds layers_at_start();
  // Call when copies of the nodes of bonds came to other ranks with their points.
  void bring_copies();
  // Call when the host has made points of these rows of the table.
  void points_were_made(const std::vector<int>& rows) { fresh_points_.insert(fresh_points_.end(), rows.begin(), rows.end()); }
  // Stores the axis of the elasticity of bodies that have points without a frame, or points yet to be made.
  void remember_axis();

  struct How {
    bool arrange = true;  // false: blocks stay as they are
    bool splits = false;  // true: the layout is made because nodes split, or parts came apart
  };
  // Lays out these rows of the table, ascending. Bonds that change their parts do so with `parts`. The added mass of
  // these rows is cleared, and the sides of grains are still those of before: find both anew.
  void lay_out(const std::vector<int>& rows, NewLayersOfBonds layers, const How& how);
  // Calls lay_out() and finds the added mass too. Bonds and grains must be on the ranks where they were.
  void lay_out_again(const std::vector<int>& rows, NewLayersOfBonds layers, const How& how);
  const std::vector<int>& fresh_points() const { return fresh_points_; }

  // start_anew() makes anew what depends on the nodes of a bond. follow_grains() tells the parts of the bond to which grain
  // each side of it holds.
  void start_anew(Bond& b);
  void follow_grains(Bond& b) const;
  // Brings the slots of points up to date, which fall behind while points change cells (`updated` kinematics).
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

// Lays out copies of all bonds. fresh: see Arrangement::fresh_points(). penalty: parameters of the links, or null for
// no links.
std::vector<BondLayout> layouts_of_copies(const Scene& scene, const Discontinuities& divisions, const RestoredNodes& restored,
                                          const std::vector<int>& fresh, const PenaltyParameters* penalty);

}  // namespace mpdem

#endif
