// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `balance yes` of fix mpm: bonds on ranks beside that of their place (cement/work_shares.h). LIGGGHTS deals atoms out by their place alone. So while
// it exchanges atoms, points of a bond that has a home (Body::home) show a place in the brick of that rank. Their true places are
// shown again before anyone looks. All functions are collective.
#ifndef MPDEM_POINT_RANKS_H
#define MPDEM_POINT_RANKS_H

#include <string>
#include <vector>

#include "../cement/work_shares.h"
#include "atom_vec_mpdem.h"
#include "pointers.h"

namespace mpdem {

class PointRanks : protected LAMMPS_NS::Pointers {
 public:
  explicit PointRanks(LAMMPS_NS::LAMMPS* lmp);

  // Whether it is wanted; answers what speaks against it, empty if nothing does.
  std::string take(bool balance);
  // Before an exchange, with their true places shown: bonds of which these ranks are not beside their places any more have no home from here on. Then points that are to go to
  // another rank show a place there, or in a brick on the way: LIGGGHTS hands atoms to neighbours only. Are some not there after this exchange? For a
  // command between runs, write_restart for one, points go back to the ranks of their places, since nobody would show these again.
  bool show_homes(LAMMPS_NS::AtomVecMpdem& avec);
  bool any_homes(const LAMMPS_NS::AtomVecMpdem& avec) const;
  // Is the work of the ranks so uneven that bonds should move?
  bool is_uneven(const LAMMPS_NS::AtomVecMpdem& avec);
  // After that, with their true places shown: gives homes to bonds; true if there are new ones.
  bool find_homes(LAMMPS_NS::AtomVecMpdem& avec);

  void start_run() { last_ = worst_ = 1.0; }
  // At the end of a run: the largest work of a rank over the mean when it was last looked at, and the most in this run.
  void tell(const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec) const;

 private:
  struct Brick {
    BrickPlace place;
    double low[3], high[3];
  };
  void find_bricks();
  int brick_along(int d, double x) const;  // that has this coordinate
  double middle(int d, int brick) const;
  std::vector<MovableBond> movable_bonds(const LAMMPS_NS::AtomVecMpdem& avec) const;

  std::vector<BrickPlace> bricks_;  // of each rank
  std::vector<double> edges_[3];    // of bricks along each direction, ascending
  std::vector<double> work_;        // of each rank, in points that are awake
  bool balance_ = false;
  double last_ = 1.0, worst_ = 1.0;  // largest work over the mean
};

}  // namespace mpdem

#endif
