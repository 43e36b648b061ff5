// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Detects bonds that are connected but no longer carry load. Ligaments between inclined cracks, attached to either
// grain by almost failed points, may rotate like a linkage. No threshold of damage or section distinguishes them from a
// bond that softens, but the secant stiffness between the grains does. With the mean load Q and the mean relative
// motion q of the grains over a window of time,
//
//   a bond is broken when |Q| < 1 % of the largest |Q| of any window so far, while |q| exceeds that of that window,
//
// and its ligament is reduced (Cracks::record_failures()). Q is force and moment about the middle of the bond, half
// from either grain. q is the displacement of that point and the rotation. Both are in axes that rotate by the mean of
// both grains. The radius l of the attached area makes moments and rotations comparable:
//
//   |Q|^2 = F^2 + (M/l)^2,   |q|^2 = d^2 + (l theta)^2.
//
// A window ends at the first check after a shear wave has crossed the bond and returned, a time of 4 l over its speed,
// so that free vibration of the bond is averaged.
//
// * An unloaded bond returns along its secant, since damage leaves no residual strain: |q| decreases with |Q|, and the
//   bond is not broken. The same is true when its load changes sign, in cycles about zero (both means vanish), and in
//   free vibration.
// * The largest load may have been a compression that the bond cannot carry in tension. Then the bond is broken only once
//   it has moved further than under that load.
// * A broken bond stays broken: it has failed once in the direction of its load. Its forces are not changed, so what
//   still connects the grains carries load again if they are pressed together. With friction, a sliding bond carries
//   more than 1 % or is separated.
//
// Means are linear in the steps, so the result does not depend on the order of the grains, axes of the box, and ranks.
#ifndef MPDEM_CEMENT_FAILURE_LOAD_HISTORY_H
#define MPDEM_CEMENT_FAILURE_LOAD_HISTORY_H

#include <mpi.h>

#include <array>
#include <vector>

#include "../bond/bonded_grains.h"

namespace mpdem {

class LoadHistory {
 public:
  static constexpr double kBrokenLoadRatio = 0.01;  // limit of |Q| over the largest |Q|
  static constexpr int kSums = 13;                  // time, then load and motion times time
  using Sums = std::array<double, kSums>;
  static double radius_of(const BondRecord& record);                                       // l of the formula above
  static double window_path(const BondRecord& record) { return 4.0 * radius_of(record); }  // of a shear wave, in a window

  // Largest |Q| of a bond, and |q| of that window. The same on all ranks.
  struct Largest {
    double load = 0.0, motion = 0.0;  // units: force, length

    template <class Self, class Visitor>
    static constexpr void describe(Self& l, Visitor& visit) {
      visit("the largest load of a bond", l.load, kNotNegative);
      visit("the motion with the largest load of a bond", l.motion, kNotNegative);
    }
  };

  void add_bonds(std::size_t rows) {
    largest_.resize(rows);
    sums_.resize(rows, Sums{});
  }
  // Call at the end of a step. Adds loads and motion at the bond ends that this rank owns, for resolved bonds. The
  // damage of condensed bonds does not grow.
  void add(const BondedGrains& grains, const std::vector<BondRecord>& table, double dt);
  // Collective. Ends the windows that are long enough. Returns the rows that meet the criterion above, ascending, the
  // same on all ranks. shear_speed: speed of shear waves in the cement.
  std::vector<int> find_failed(MPI_Comm comm, const std::vector<BondRecord>& table, double shear_speed);

  // Collective. Returns the sums over all ranks, for restart files. The first rank then has them all, others have none.
  std::vector<Sums> gather_on_first(MPI_Comm comm);
  const Largest& largest(std::size_t row) const { return largest_[row]; }
  void restore(std::vector<Largest> largest, std::vector<Sums> sums) {
    largest_ = std::move(largest);
    sums_ = std::move(sums);
  }

 private:
  std::vector<Sums> sums_of_all(MPI_Comm comm) const;

  std::vector<Largest> largest_;
  std::vector<Sums> sums_;  // share of this rank in the present window
};

}  // namespace mpdem

#endif
