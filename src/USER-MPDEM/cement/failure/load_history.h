// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Does a bond still carry something? A bond whose grains are connected may not. Struts between slanted cracks, held at
// either grain by points that are nearly through, turn like a linkage. No threshold of their damage or their section
// tells them from a bond that softens. The secant stiffness of the bond as its grains feel it does. With the mean load
// Q and the mean relative motion q of the grains over a window of time,
//
//   a bond is broken when |Q| < 1 % of the largest |Q| of any window so far, while |q| is more than it was in that window,
//
// and some of its weakest section is gone. Q is force and moment about the middle of the bond, half from either grain.
// q is displacement of that point and rotation. Both are in axes that go half-way with both grains. The radius l of the
// area of cement at the grains makes moments and rotations comparable:
//
//   |Q|^2 = F^2 + (M/l)^2,   |q|^2 = d^2 + (l theta)^2.
//
// A window ends at the first check after a shear wave has been across the bond and back, 4 l over its speed. So the
// ringing of the bond is in the window.
//
// * A bond that is unloaded comes back along its secant, since damage leaves no strain behind: |q| falls with |Q|, and
//   the bond holds. The same is true when its load changes sign, in cycles about zero (both means vanish), and when it
//   rings freely.
// * The largest load may have been one of compression that the bond never bears in tension. Then more motion is needed
//   than that load took.
// * A broken bond stays broken: it has let go once in the direction in which it was loaded. Its forces are left as they
//   are, so what still connects the grains carries again if they are pressed together. With friction, what slides
//   carries more than 1 % or is separated.
//
// Means are linear in the steps. So the result does not depend on which grain is the first, on the axes of the box, or
// on ranks. The watch looks where debris is looked for, at the checks.
#ifndef MPDEM_CEMENT_FAILURE_LOAD_HISTORY_H
#define MPDEM_CEMENT_FAILURE_LOAD_HISTORY_H

#include <mpi.h>

#include <array>
#include <vector>

#include "../bond/bonded_grains.h"

namespace mpdem {

class LoadHistory {
 public:
  static constexpr double kGone = 0.01;  // share of the largest load
  static constexpr int kSums = 13;       // time, then load and motion times time
  using Sums = std::array<double, kSums>;
  static double radius_of(const BondRecord& record);                                       // l of the formula above
  static double window_path(const BondRecord& record) { return 4.0 * radius_of(record); }  // way of a shear wave in a window

  // Largest load of a row of the table, and the motion with it. The same on all ranks.
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
  // Call at the end of a step. Adds loads and motion of the sides of this rank, for bonds that are not condensed.
  // Damage of condensed bonds does not grow.
  void add(const BondedGrains& grains, const std::vector<BondRecord>& table, double dt);
  // Collective. Ends the windows that are long enough. Returns rows that carry nothing any more, ascending, the same on
  // all ranks.
  std::vector<int> find_failed(MPI_Comm comm, const std::vector<BondRecord>& table, double shear_speed);

  // Collective. Returns sums over all ranks, for restart files, and leaves them to the first. See EnergyBalance.
  std::vector<Sums> gather_on_first(MPI_Comm comm);
  const Largest& largest(std::size_t row) const { return largest_[row]; }
  void restore(std::vector<Largest> largest, std::vector<Sums> sums) {
    largest_ = std::move(largest);
    sums_ = std::move(sums);
  }

 private:
  std::vector<Sums> sums_of_all(MPI_Comm comm) const;

  std::vector<Largest> largest_;
  std::vector<Sums> sums_;  // sums over the present window, of this rank
};

}  // namespace mpdem

#endif
