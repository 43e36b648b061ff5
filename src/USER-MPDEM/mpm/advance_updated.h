// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The pass over the points of a step with `updated` kinematics. The reference is the present, so weights are new in
// every step, and points go from cell to cell. One pass goes from grid to points to grid: each block takes velocity
// and velocity gradient from the nodes, moves, finds its stress, and gives mass, momentum and internal force
//   f_I = - sum_p V_p tau_p grad N_I(x_p)
// to the nodes where it now is. After the pass, points that left their cell go into a block of the new cell. So a
// block has points of one cell alone, and nothing is sorted. The grid has nodes some cells ahead of the points.
#ifndef MPDEM_MPM_ADVANCE_UPDATED_H
#define MPDEM_MPM_ADVANCE_UPDATED_H

#include <vector>

#include "advance_points.h"
#include "transfer.h"

namespace mpdem {

class UpdatedPass {
 public:
  // Number of cells around those with points for which the grid must have nodes at every bind().
  static constexpr int kMargin = 3;

  // Must be called after points or grid were laid out anew.
  void bind(const PointStore& points, const Grid& grid);

  // Gives points that have no velocity yet the velocity of the nodes.
  static void start(PointStore& points, const Grid& grid, int first_row);

  // Needs grid.velocity at the middle of the step. With flip, the caller must have added dt_v times grid.acceleration
  // to it. Overwrites grid.mass, grid.momentum and grid.force with the sums of this rank.
  void advance(PointStore& points, Grid& grid, const Law& law, double density, double dt, double dt_v, const Transfer& transfer,
               const AdvanceOptions& options, AdvanceResult& result);

  // Gives mass, momentum and force of the points to the nodes. Moves no point.
  static void project(const PointStore& points, Grid& grid, const Law& law, double density, const Transfer& transfer);

  // Slot of a point before and after the last step. A point changes its slot when it goes to another cell, or to
  // another block of its cell.
  struct Move {
    int from, to;
  };
  std::size_t blocks_when_arranged = 0;  // number of point blocks that the last layout made, which the host of the pass notes
  int crossings() const { return crossings_; }
  // True if a point is near the end of the margin. The grid must then be laid out anew before the next step.
  bool layout_is_stale() const { return stale_; }
  // Tag of a point that went beyond the nodes of the grid, or whose place is not finite. 0 if there is none.
  int lost() const { return lost_; }
  std::size_t memory_usage() const {
    return sizeof(int) * (first_in_cell_.capacity() + next_in_cell_.capacity() + targets_.capacity()) +
           sizeof(Move) * (moves_.capacity() + packed_.capacity()) + sizeof(Traveller) * on_the_way_.capacity() + hold_.memory_usage() +
           fresh_.capacity();
  }

 private:
  template <class Type, class L>
  void pass(PointStore& points, Grid& grid, const L& law, double density, double dt, double dt_v, const Transfer& transfer,
            const AdvanceOptions& options, AdvanceResult& result);
  void relocate(PointStore& points, const Grid& grid, AdvanceResult& result);
  bool pack(PointStore& points, const Grid& grid, int node);

  // The blocks of a cell are a list. The first node of the cell leads to the first block, and each block to the next one. -1 ends the list.
  std::vector<int> first_in_cell_, next_in_cell_;
  std::vector<Move> moves_, packed_;
  struct Traveller {
    int node, base[3], column[kMostColumns];  // of the new cell; node is -1 if the grid has no such cell
  };
  std::vector<Traveller> on_the_way_;
  PointStore hold_;                  // holds points between the old and the new block
  std::vector<int> targets_;         // blocks that took in points
  std::vector<std::uint8_t> fresh_;  // lanes of each block that took in points
  bool stale_ = false;
  int lost_ = 0, crossings_ = 0;
};

// Makes the present the reference of points that had `total` kinematics: X becomes the present place and F the
// identity. The store must have a motion (PointStore::let_move), which keeps the first places.
void move_to_present(PointStore& points, const Grid& grid);

}  // namespace mpdem

#endif
