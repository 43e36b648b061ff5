// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// `balance yes` of fix mpm: bonds on ranks next to the one of their position (cement/bond/work_shares.h). LIGGGHTS
// assigns atoms to ranks by position only. So while it exchanges atoms, the points of a bond with a home
// (BondRecord::home) show a position in the subdomain of that rank. fix mpm writes their true positions back after the
// exchange of a step, before a restart file is written, and in setup(). All functions are collective, except those of
// one line.
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

  // Sets whether balance is wanted. Returns the reason why it cannot be had, or an empty text.
  std::string set_balance(bool balance);
  // Call at the start of a run. fix acts after all others before an exchange, so that these read true positions.
  void start_run(const LAMMPS_NS::Fix* fix);

  // Call before an exchange, while true positions are shown. for_run: the exchange is that of a run, and a layout
  // follows. Then a bond loses its home if that rank is no longer next to the position of the bond. Points that change
  // rank show a position in the new subdomain, or in one on the path to it, since LIGGGHTS passes atoms to neighbours
  // only. Returns whether some points need another exchange. Other exchanges, such as that of write_restart, leave
  // points on the rank of their nodes.
  bool show_homes(LAMMPS_NS::AtomVecMpdem& avec, bool for_run);
  // Do some points show a position that is not their own? The same on all ranks.
  bool shows_homes() const { return shows_homes_; }
  void true_positions_shown() { shows_homes_ = false; }

  // Is the work of the ranks so uneven that bonds should move?
  bool is_uneven(const LAMMPS_NS::AtomVecMpdem& avec);
  // Assigns homes to bonds. Call it after is_uneven(), with true positions shown. Returns true if there are new homes.
  bool find_homes(LAMMPS_NS::AtomVecMpdem& avec);
  // Call at the end of a run. Prints the largest work of a rank over the mean, now and at most in this run.
  void tell(const std::string& who, const LAMMPS_NS::AtomVecMpdem& avec);

 private:
  struct Subdomain {
    SubdomainIndex subdomain;
    double low[3], high[3];
  };
  bool any_homes(const LAMMPS_NS::AtomVecMpdem& avec) const;
  void find_subdomains();
  int subdomain_along(int d, double x) const;  // index of the subdomain with this coordinate
  double middle(int d, int subdomain) const;
  std::vector<MovableBond> movable_bonds(const LAMMPS_NS::AtomVecMpdem& avec) const;

  std::vector<SubdomainIndex> subdomains_;  // subdomain of each rank
  std::vector<double> edges_[3];            // edges of subdomains along each direction, ascending
  std::vector<double> work_;                // work of each rank, in points of resolved bonds
  bool balance_ = false;
  bool shows_homes_ = false, in_transit_ = false;  // in_transit_: some points need another exchange
  double last_ = 1.0, worst_ = 1.0;                // largest work over the mean, now and at most in this run
};

}  // namespace mpdem

#endif
