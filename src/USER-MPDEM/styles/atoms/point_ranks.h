// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `balance yes` of fix mpm: bonds on ranks beside that of their place (cement/bond/work_shares.h). LIGGGHTS deals atoms out
// by their place alone. So while it exchanges atoms, points of a bond that has a home (Body::home) show a place in the
// brick of that rank. fix mpm shows their true places again after the exchange of a step, before a restart file is
// written, and in its setup() at the start of a run. All functions are collective, except those of one line.
#ifndef MPDEM_STYLES_ATOMS_POINT_RANKS_H
#define MPDEM_STYLES_ATOMS_POINT_RANKS_H

#include <string>
#include <vector>

#include "../../cement/bond/work_shares.h"
#include "atom_vec_mpdem.h"
#include "fix.h"
#include "pointers.h"

namespace mpdem {

class PointRanks : protected LAMMPS_NS::Pointers {
 public:
  explicit PointRanks(LAMMPS_NS::LAMMPS* lmp);

  // Takes whether balance is wanted. Returns what speaks against it, or an empty text.
  std::string take(bool balance);
  // Call at the start of a run. fix acts after all others before an exchange, so that these see true places.
  void start_run(const LAMMPS_NS::Fix* fix);

  // Call before an exchange, with true places shown. for_run: the exchange is that of a run, whose layout follows. Then
  // bonds have no home from here on if their ranks are not beside their places any more. Points that are to go to
  // another rank show a place there, or in a brick on the way, since LIGGGHTS hands atoms to neighbours only. Returns
  // whether some will not be there after this exchange. Other exchanges, such as that of write_restart, leave points
  // where their nodes are.
  bool show_homes(LAMMPS_NS::AtomVecMpdem& avec, bool for_run);
  // Do some points show other places than their true ones? The same on all ranks.
  bool shows_homes() const { return shows_homes_; }
  void true_places_shown() { shows_homes_ = false; }

  // Is the work of the ranks so uneven that bonds should move?
  bool is_uneven(const LAMMPS_NS::AtomVecMpdem& avec);
  // Gives homes to bonds. Call after is_uneven(), with true places shown. Returns true if there are new homes.
  bool find_homes(LAMMPS_NS::AtomVecMpdem& avec);
  // Call at the end of a run. Tells the largest work of a rank over the mean, now and at most in this run.
  void tell(const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec);

 private:
  struct Brick {
    SubdomainIndex subdomain;
    double low[3], high[3];
  };
  bool any_homes(const LAMMPS_NS::AtomVecMpdem& avec) const;
  void find_bricks();
  int brick_along(int d, double x) const;  // the brick that has this coordinate
  double middle(int d, int brick) const;
  std::vector<MovableBond> movable_bonds(const LAMMPS_NS::AtomVecMpdem& avec) const;

  std::vector<SubdomainIndex> bricks_;  // brick of each rank
  std::vector<double> edges_[3];        // edges of bricks along each direction, ascending
  std::vector<double> work_;            // work of each rank, in points that are awake
  bool balance_ = false;
  bool shows_homes_ = false, on_the_way_ = false;  // on_the_way_: some points are not yet where they belong after an exchange
  double last_ = 1.0, worst_ = 1.0;                // largest work over the mean, now and at most in this run
};

}  // namespace mpdem

#endif
