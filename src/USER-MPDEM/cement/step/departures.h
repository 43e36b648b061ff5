// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cement that leaves the scene. A point may go if it holds to no grain that stays. Such are points that failed, crumbs, and what holds
// to a grain that goes itself. Dust on nodes of such cement goes with it. A grain may go when all its bonds are separated. A bond
// may go as a whole when a command deleted all its points, if it is separated or both its grains are deleted too.
//
// The host tells which grains are gone, which points are out of the box, and which it deleted. choose() says which points leave,
// and what must not. carry_out() takes them out of their bonds, lays these out, and books what they had (EnergyBalance::Left). A row of
// the table stays when its grains and points are gone. It asks for no grain then, see Body::has_grain().
#ifndef MPDEM_CEMENT_STEP_DEPARTURES_H
#define MPDEM_CEMENT_STEP_DEPARTURES_H

#include <map>
#include <vector>

#include "layout_manager.h"
#include "../condensed/condensed_bonds.h"
#include "condensing.h"
#include "../failure/discontinuities.h"
#include "../bond/scene.h"
#include "work_of_step.h"

namespace mpdem {

// What the host finds. Slots are those of this rank, by row of the table, ascending.
struct Departing {
  std::vector<int> grains;                  // IDs of bonded grains that are gone, ascending, the same on all ranks
  std::map<int, std::vector<int>> outside;  // points that are out of the box
  std::map<int, std::vector<int>> deleted;  // points that commands or fixes deleted
};

struct Leaving {
  std::vector<int> grains;                // those of Departing
  std::vector<int> rows;                  // rows from which something leaves, ascending, the same on all ranks
  std::map<int, std::vector<int>> slots;  // points that leave, of this rank
  // What must not leave: a grain that is joined to one that stays, 0: none, the same on all ranks; IDs of points that hold to a
  // grain that stays, of this rank.
  int joined_grain = 0;
  std::vector<int> attached_outside, attached_deleted;
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
        work_(work) {}

  // Collective.
  Leaving choose(const Departing& departing);
  // Collective. Returns the IDs of the points of this rank that left. Sides of grains are as they were: bind them anew if grains went.
  // Throws BadState if points went to other ranks since the last layout.
  std::vector<int> carry_out(const Leaving& leaving);

 private:
  // What leaves a row, of all ranks. all: nothing of it stays.
  struct Share {
    int row;
    double points, volume;
    bool all;
  };
  // The pieces of a condensed bond, or the bond as a whole, with the sides that it has before anything leaves.
  struct Pieces {
    int row = 0;
    bool whole = false, here[2] = {false, false};
    CondensedBonds::Ends ends[2] = {};
  };
  void choose_points(Bond& b, const std::vector<char>& held, const Departing& departing, bool as_a_whole, Leaving& leaving) const;
  std::vector<Share> shares(const Leaving& leaving) const;
  void add_resolved(const Bond& b, double sign, EnergyBalance::Left& left, double& ahead) const;
  Pieces pieces_of(int row) const;
  void add_pieces(const Pieces& pieces, double sign, EnergyBalance::Left& left, double& ahead) const;
  double ahead_of_grains(const std::vector<Share>& of_rows, const std::vector<int>& grains) const;
  std::vector<int> take_out(const std::vector<Share>& of_rows, const Leaving& leaving);

  Scene& scene_;
  Discontinuities& discontinuities_;
  LayoutManager& layout_manager_;
  CondensedBonds& condensed_;
  Condensing& condensing_;
  const WorkOfStep& work_;
};

}  // namespace mpdem

#endif
