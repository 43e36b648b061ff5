// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The one pass over the points of a step with `updated` kinematics: the reference is the
// present, weights are new in every step, points go from cell to cell. Fused from grid to
// points to grid: each block takes velocity and its gradient from the nodes, moves, finds its
// stress and gives mass, momentum and internal force
//   f_I = - sum_p V_p tau_p grad N_I(x_p)
// to the nodes where it now is. Points that left their cell are taken out of their block and
// put into one of the new cell afterwards, so blocks stay blocks of one cell without sorting;
// the grid has nodes some cells ahead of the points.
#ifndef MPDEM_ADVANCE_UPDATED_H
#define MPDEM_ADVANCE_UPDATED_H

#include <vector>

#include "advance_points.h"
#include "transfer.h"

namespace mpdem {

class UpdatedPass {
 public:
  // Cells around those with points that the grid must have at every bind().
  static constexpr int kMargin = 3;

  // After points or grid were laid out anew.
  void bind(const PointStore& points, const Grid& grid);

  // Velocities of the points from those of the nodes, for points that have none yet.
  static void start(PointStore& points, const Grid& grid, int first_body);

  // Needs grid.velocity at the middle of the step and, for flip, that acceleration times dt_v
  // went into it. Overwrites grid.mass, grid.momentum and grid.force with this rank's sums.
  void advance(PointStore& points, Grid& grid, const Law& law, double density, double dt, double dt_v,
               const Transfer& transfer, const AdvanceOptions& options, AdvanceResult& result);

  // Mass, momentum and force of the points as they are.
  static void project(const PointStore& points, Grid& grid, const Law& law, double density,
                      const Transfer& transfer);

  // Points that changed their slot in the last step, by going to another cell or to another block of
  // theirs: slot before, slot after; ascending.
  struct Move {
    int from, to;
  };
  const std::vector<Move>& moves() const { return moves_; }
  int crossings() const { return crossings_; }
  // Some point is near the end of the margin: lay out the grid anew before the next step.
  bool layout_is_stale() const { return stale_; }
  // Tag of a point that went further than the nodes reach or is not finite, 0: none.
  int lost() const { return lost_; }

 private:
  template <class Type, class L>
  void pass(PointStore& points, Grid& grid, const L& law, double density, double dt, double dt_v,
            const Transfer& transfer, const AdvanceOptions& options, AdvanceResult& result);
  void relocate(PointStore& points, const Grid& grid, AdvanceResult& result);
  bool pack(PointStore& points, const Grid& grid, int node);

  // Blocks of a cell: the first, by its first node, and the next of each block; -1: none.
  std::vector<int> first_in_cell_, next_in_cell_;
  std::vector<Move> moves_, packed_;
  struct Traveller {
    int node, base[3], column[kMostColumns];  // of the new cell; node -1: there is none
  };
  std::vector<Traveller> on_the_way_;
  PointStore hold_;                   // the points meanwhile
  std::vector<int> targets_;          // blocks that points came into
  std::vector<std::uint8_t> fresh_;   // their new lanes, of every block
  bool stale_ = false;
  int lost_ = 0, crossings_ = 0;
};

// The present becomes the reference: points of `total` kinematics go where they are, their
// deformation gradient starts anew. They need a motion.
void move_to_present(PointStore& points, const Grid& grid);

}  // namespace mpdem

#endif
