// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Pass over the points in a step with `updated` kinematics (updated Lagrangian). The reference is the present
// configuration, so weights are new in every step, and points move from cell to cell. One pass goes from grid to points
// to grid: each block gathers velocity and velocity gradient from the nodes, moves, finds its stress, and scatters
// mass, momentum and internal force
//   f_I = - sum_p V_p tau_p grad N_I(x_p)
// to the nodes of its new position. After the pass, points that left their cell are moved to a block of the new cell.
// So a block has points of one cell alone, and nothing is sorted. The grid has nodes some cells ahead of the points.
#ifndef MPDEM_MPM_ADVANCE_UPDATED_H
#define MPDEM_MPM_ADVANCE_UPDATED_H

#include <vector>

#include "advance_points.h"
#include "transfer.h"

namespace mpdem {

class UpdatedPass {
 public:
  // At every bind() the grid must have the nodes of all cells within kMargin cells of a cell with points.
  static constexpr int kMargin = 3;

  // Must be called after each new layout of points or grid.
  void bind(const PointStore& points, const Grid& grid);

  // Interpolates the nodal velocity to the points of bonds from row first_row on, which have no velocity yet.
  static void start(PointStore& points, const Grid& grid, int first_row);

  // Does the pass of a step. dt: the step. dt_v: the kick. Needs grid.velocity at the middle of the step. With `flip`, the caller must
  // have added dt_v times grid.acceleration to it. Overwrites grid.mass, grid.momentum and grid.force with the sums of this rank.
  void advance(PointStore& points, Grid& grid, const Law& law, const CementDensity& density, double dt, double dt_v,
               const Transfer& transfer, const AdvanceOptions& options, AdvanceResult& result);

  // Scatters mass, momentum and force of the points to the nodes. Moves no point.
  static void project(const PointStore& points, Grid& grid, const Law& law, const CementDensity& density, const Transfer& transfer);

  // Slot of a point before and after the last step. A point changes its slot when it moves to another cell, or to
  // another block of its cell.
  struct Move {
    int from, to;
  };
  std::size_t blocks_of_layout = 0;             // number of blocks that the last layout made; set by the caller
  int crossings() const { return crossings_; }  // number of points that left their cell in the last step
  // True if a point is near the end of the margin. The grid then needs a new layout before the next step.
  bool layout_is_stale() const { return stale_; }
  // Tag of a point that moved beyond the nodes of the grid, or whose position is not finite. 0 if there is none.
  int lost() const { return lost_; }
  std::size_t memory_usage() const {
    return sizeof(int) * (first_in_cell_.capacity() + next_in_cell_.capacity() + targets_.capacity()) +
           sizeof(Move) * (moves_.capacity() + packed_.capacity()) + sizeof(MovingPoint) * in_transit_.capacity() + hold_.memory_usage() +
           fresh_.capacity();
  }

 private:
  template <class Type, class L>
  void pass(PointStore& points, Grid& grid, const L& law, const CementDensity& density, double dt, double dt_v, const Transfer& transfer,
            const AdvanceOptions& options, AdvanceResult& result);
  void relocate(PointStore& points, const Grid& grid, AdvanceResult& result);
  bool pack(PointStore& points, const Grid& grid, int node);

  // Linked lists of the blocks of each cell: first block by first node of the cell, next block by block; -1: none.
  std::vector<int> first_in_cell_, next_in_cell_;
  std::vector<Move> moves_, packed_;
  struct MovingPoint {
    int node, base[3], column[kMostColumns];  // first node, base and columns of the new cell; node is -1 if the grid has no such cell
  };
  std::vector<MovingPoint> in_transit_;
  PointStore hold_;                  // buffer for points between their old and new block
  std::vector<int> targets_;         // blocks that received points
  std::vector<std::uint8_t> fresh_;  // for each block: lanes that received points in this step
  bool stale_ = false;
  int lost_ = 0, crossings_ = 0;
};

// Makes the present configuration the reference of points that had `total` kinematics: X becomes the present position
// and F the identity. The store must have a motion (PointStore::start_motion), which keeps the original positions.
void move_to_present(PointStore& points, const Grid& grid);

}  // namespace mpdem

#endif
