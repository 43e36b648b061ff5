// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cement that leaves the scene. A point may leave if it is connected to no grain that stays: failed points, fragments,
// and points connected only to a grain that leaves. Fragments on nodes of such cement leave with it. A grain may leave
// when all its bonds are separated. A bond may leave as a whole when a command deleted all its points, if it is
// separated or both its grains are deleted too.
//
// Besides, cement is dropped: fragments by a rule (loose_cement.h), and all cement of a bond, joined or not, by a command.
//
// The host reports which grains are gone, which points are outside the box, and which it deleted. choose() finds which
// points leave, and what must not. carry_out() removes them from their bonds, lays these out again, and counts their
// energy, momentum and mass (EnergyBalance::Left). A row of the table stays when its grains and points are gone. It
// refers to no grain then, see BondRecord::has_grain().
#ifndef MPDEM_CEMENT_STEP_DEPARTURES_H
#define MPDEM_CEMENT_STEP_DEPARTURES_H

#include <map>
#include <vector>

#include "layout_manager.h"
#include "../condensed/condensed_bonds.h"
#include "condensing.h"
#include "loose_cement.h"
#include "../failure/discontinuities.h"
#include "../bond/scene.h"
#include "work_of_step.h"

namespace mpdem {

// What the host reports. Slots are those of this rank, by row of the table, ascending.
struct Departing {
  std::vector<int> grains;                  // IDs of bonded grains that are gone, ascending, the same on all ranks
  std::map<int, std::vector<int>> outside;  // points outside the box
  std::map<int, std::vector<int>> deleted;  // points that commands or fixes deleted
  LooseCement::Due dropped;                 // cement to be dropped: fragments, and bonds whose cement leaves as a whole
};

// What may leave of it, and what must not.
struct Leaving {
  std::vector<int> grains;                // those of Departing
  std::vector<int> rows;                  // rows from which something leaves, ascending, the same on all ranks
  std::map<int, std::vector<int>> slots;  // points that leave, of this rank
  double dropped_points = 0.0;            // of these points that are dropped, of this rank
  CementVolume dropped;
  int joined_grain = 0;  // a grain that must not leave, since its cement is connected to one that stays; 0: none; the same on all ranks
  std::vector<int> attached_outside, attached_deleted;  // IDs of points of this rank that must not leave for the same reason
  std::vector<int> rows_attached_outside;               // rows of attached_outside

  void add_attached_outside(int row, int tag) {
    rows_attached_outside.push_back(row);
    attached_outside.push_back(tag);
  }
};

class Departures {
 public:
  Departures(Scene& scene, Discontinuities& divisions, LayoutManager& layout_manager, CondensedBonds& condensed, Condensing& condensing,
             const WorkOfStep& work)
      : scene_(scene),
        discontinuities_(divisions),
        layout_manager_(layout_manager),
        condensed_(condensed),
        condensing_(condensing),
        work_(work),
        loose_cement_(scene, divisions.cracks) {}

  LooseCement& loose_cement() { return loose_cement_; }

  // Collective.
  Leaving choose(const Departing& departing);
  // Collective. Returns the IDs of the points of this rank that left. Ends of bonds stay bound as they were: bind them
  // again if grains left. Throws BadState if points went to other ranks since the last layout.
  std::vector<int> carry_out(const Leaving& leaving);

 private:
  // What leaves a row, on all ranks. all: nothing of it stays.
  struct Share {
    int row;
    double points;
    CementVolume cement;
    bool all;
  };
  // The pieces of a condensed bond, or the bond as a whole, with its ends before anything leaves.
  struct Pieces {
    int row = 0;
    bool whole = false, here[2] = {false, false};
    CondensedBonds::Ends ends[2] = {};
  };
  void choose_points(Bond& b, const std::vector<char>& held, const Departing& departing, bool as_a_whole, Leaving& leaving) const;
  void count_dropped(const LooseCement::Due& dropped, Leaving& leaving) const;
  std::vector<Share> shares(const Leaving& leaving) const;
  void add_resolved(const Bond& b, double sign, EnergyBalance::Left& left, double& ahead) const;
  Pieces pieces_of(int row) const;
  void add_pieces(const Pieces& pieces, double sign, EnergyBalance::Left& left, double& ahead) const;
  double ahead_of_grains(const std::vector<Share>& of_rows, const std::vector<int>& grains) const;
  double ahead_of_condensed(int row) const;
  std::vector<int> take_out(const std::vector<Share>& of_rows, const Leaving& leaving);

  Scene& scene_;
  Discontinuities& discontinuities_;
  LayoutManager& layout_manager_;
  CondensedBonds& condensed_;
  Condensing& condensing_;
  const WorkOfStep& work_;
  LooseCement loose_cement_;
};

}  // namespace mpdem

#endif
