// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// When bonds are laid out (layout.h), and what is carried over: the motion of nodes, that of a restart file or of points that are new; what hangs on
// the nodes of a bond starts anew. All functions are collective, but for those of one bond and points_were_made(). BadState is thrown on all ranks
// if a grid takes more memory than it may, or a restart file does not have all nodes.
#ifndef MPDEM_CEMENT_ARRANGEMENT_H
#define MPDEM_CEMENT_ARRANGEMENT_H

#include <vector>

#include "added_masses.h"
#include "divisions.h"
#include "layout.h"
#include "restored_nodes.h"
#include "scene.h"
#include "shared_nodes.h"

namespace mpdem {

class Arrangement {
 public:
  Arrangement(Scene& scene, Divisions& divisions, RestoredNodes& restored, SharedNodes& shared, AddedMasses& added)
      : scene_(scene), divisions_(divisions), restored_(restored), shared_(shared), added_(added) {}

  // Parts that have nodes of their own: of bonds that are new in a run; of those whose points were made between two steps.
  NewPartsOfBonds parts_at_start();
  NewPartsOfBonds parts_of_fresh_points();
  // The host made points of these rows of the table.
  void points_were_made(const std::vector<int>& rows) { fresh_points_.insert(fresh_points_.end(), rows.begin(), rows.end()); }
  // The axis of the elasticity, of bodies some of whose points have no frame yet.
  void remember_axis();
  // Copies of the nodes of bonds came to other ranks with their points (`cracks split`).
  void bring_copies();

  struct How {
    bool arrange = true;  // false: blocks stay as they are
    bool splits = false;  // because nodes split
  };
  // These rows of the table, ascending; those that change their parts with these. Added mass and the sides of grains are still those of before.
  void lay_out(const std::vector<int>& rows, NewPartsOfBonds parts, const How& how);
  // The same with added mass, where bonds and grains are on the ranks where they were.
  void lay_out_again(const std::vector<int>& rows, NewPartsOfBonds parts, const How& how);
  // A layout of all bonds that changes nothing, with these links or without (null).
  std::vector<BondLayout> of_copies(const PenaltyParameters* penalty);

  // What hangs on the nodes of a bond; of that, damping and impulses, which go by the grain that each side of it holds to.
  void start_anew(Bond& b) const;
  void find_relaxation(Bond& b) const;
  // Slots of points, which fall behind while points change cells (`updated` kinematics).
  void sync_slots();

 private:
  NewPartsOfBonds parts_at_start(Splits& splits, Sheets& sheets) const;
  LayoutRequest request_of(Bond& b, NewPartsOfBonds& parts);
  void adopt(std::vector<BondLayout>& layouts);

  Scene& scene_;
  Divisions& divisions_;
  RestoredNodes& restored_;
  SharedNodes& shared_;
  AddedMasses& added_;
  std::vector<int> fresh_points_;  // rows of the table whose points the host made since the last layout
};

}  // namespace mpdem

#endif
