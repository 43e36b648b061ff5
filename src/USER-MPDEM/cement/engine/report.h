// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Reports of the cement: sums over all bonds, a row for each bond, and the motion of points. Only note_peaks() runs in
// steps without output, and nothing here changes the state of the cement. Consistent units.
#ifndef MPDEM_CEMENT_ENGINE_REPORT_H
#define MPDEM_CEMENT_ENGINE_REPORT_H

#include <vector>

#include "bond_table.h"
#include "../../contact/piece_contact.h"
#include "../condensed/condensed_bonds.h"
#include "../failure/cracks.h"
#include "../bond/grain_virial.h"
#include "../bond/scene.h"

namespace mpdem {

class Report {
 public:
  Report(const Scene& scene, const Cracks& cracks, const CondensedBonds& condensed, const PieceContact& contact)
      : scene_(scene), cracks_(cracks), condensed_(condensed), contact_(contact) {}

  // Collective. Totals over all bonds. reach_of_box: largest coordinate, which sets the rounding error of positions.
  CementTotals totals(double reach_of_box) const;
  // Collective. Returns a row for each bond of the table.
  const std::vector<BondState>& bond_states();
  // The same, but columns that need points (BondColumn::needs_points()) are 0. Cheap enough for every step.
  const std::vector<BondState>& bond_loads();
  // Shares of the energy put in and not taken out again, 1 at most; 0 if there is none. kinetic: kinetic energy of cement
  // and free grains. That of the grains is multiplied by the mass scale S: cement with S times its inertia lags a motion
  // of a grain as unscaled cement lags a motion sqrt(S) times as fast. dissipated: energy dissipated by damage, over the
  // energy put into the cement, which is put_in.
  struct EnergyShares {
    double kinetic = 0.0, dissipated = 0.0, put_in = 0.0;
  };
  // Collective. Sums over nodes only, so it is cheap enough for checks.
  EnergyShares energy_shares() const;
  // Sum and number of magnitudes of forces.
  struct Magnitudes {
    double sum = 0.0, number = 0.0;
  };
  // Collective. Root mean square of the resultant forces of free grains over the mean magnitude of the forces of bonds
  // and contacts. It is the unbalanced force of Yade (doc/bibliography.md) with the root mean square of the resultants.
  // A resultant is the force that accelerates a grain with half of the cement of each of its bonds, or with the cement
  // attached to it if the bond is separated. The force of a bond is half of the difference of its forces on both
  // grains; broken bonds have none. loads: bond_loads() or bond_states(). of_contacts: contact forces of grains that
  // have bonds, each on one rank. The value is 0 without resultants, and 1e9 at most.
  double unbalanced_force(const std::vector<BondState>& loads, const Magnitudes& of_contacts) const;
  // Collective. Added mass at both ends of each bond (2 row + end), over all ranks.
  std::vector<double> added_mass_of_ends() const;
  double cement_mass() const;                                                                      // mass on this rank, with mass scaling
  int resolved_bonds() const;                                                                      // over all ranks
  int bonds_solved() const { return condensed_.solved_last(); }                                    // at the last layout, on this rank
  const std::vector<int>& bonds_without_field() const { return condensed_.without_field_last(); }  // rows
  std::size_t memory_of_condensed() const { return condensed_.memory_usage(); }
  std::size_t memory_usage() const {
    return scene_.bonds().memory_usage() + condensed_.memory_usage() + contact_.memory_usage();
  }  // bytes, on this rank

  // Displacement and velocity of a block of points at the present time, in bond coordinates.
  struct PointMotionNow {
    vd u[3], v[3];
  };
  void motion_of_points(const Bond& bond, std::vector<PointMotionNow>& motion) const;
  void motion_of_film(const Bond& bond, std::vector<PointMotionNow>& motion) const;

  // Adds the force of each bond on its two grains, at the middle of the gap on the line of centres, on the first rank. loads:
  // bond_loads(), the same on all ranks.
  void add_virials(const std::vector<BondState>& loads, GrainVirial& virial) const;

  // Call at the end of each step.
  void note_peaks();
  // Collective. Returns the largest tension of each bond in any step so far.
  std::vector<double> peaks() const;
  void restore(std::vector<double> peaks) { peaks_ = std::move(peaks); }

 private:
  void set_totals(const std::vector<double>& sum, double reach_of_box, CementTotals& t) const;

  const Scene& scene_;
  const Cracks& cracks_;
  const CondensedBonds& condensed_;
  const PieceContact& contact_;
  std::vector<BondState> states_;
  std::vector<double> peaks_;  // largest tension by row, in the steps in which this rank had the first grain
};

}  // namespace mpdem

#endif
