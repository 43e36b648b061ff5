// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Reports of the cement: sums over all bonds, a row for each bond, and the motion of points. Nothing here but note_peaks()
// runs in a step that prints nothing, and nothing here changes the state. Consistent units.
#ifndef MPDEM_CEMENT_ENGINE_REPORT_H
#define MPDEM_CEMENT_ENGINE_REPORT_H

#include <vector>

#include "bond_table.h"
#include "../condensed/condensed_bonds.h"
#include "../failure/cracks.h"
#include "../bond/scene.h"

namespace mpdem {

class Report {
 public:
  Report(const Scene& scene, const Cracks& cracks, const CondensedBonds& condensed)
      : scene_(scene), cracks_(cracks), condensed_(condensed) {}

  // Collective. Totals over all bonds. reach_of_box: the largest coordinate, by which positions are rounded.
  CementTotals totals(double reach_of_box) const;
  // Collective. Returns a row for each bond of the table.
  const std::vector<BondState>& bond_states();
  // Does the same, but columns that need points (needs_points()) are 0. Cheap enough for every step.
  const std::vector<BondState>& bond_loads();
  // Shares of the energy that was put into cement and free grains and not taken back, 1 at most; 0 if there is none.
  // kinetic: energy of motion of both. That of the grains counts as often as the inertia of the cement is scaled: cement with S times
  // its inertia is as late in what a grain does as cement in a motion that is sqrt(S) times as fast. dissipated: by damage, of what
  // was put into the cement.
  struct EnergyShares {
    double kinetic = 0.0, dissipated = 0.0;
  };
  // Collective. Only nodes are summed up, so it is cheap enough for checks.
  EnergyShares energy_shares() const;
  // Magnitudes of forces, their sum and number.
  struct Magnitudes {
    double sum = 0.0, number = 0.0;
  };
  // Collective. Root mean square of the resultants of grains over the mean magnitude of the forces of bonds and contacts. It is the
  // ratio of Yade (doc/bibliography.md) with that mean of the resultants. A resultant is the force that accelerates a grain with half
  // of the cement of each of its bonds, or with its own cement of one that is separated. Grains that are not free have none. The force
  // of a bond is half of the difference of its forces on both grains; bonds that are broken have none.
  // loads: bond_loads() or bond_states(). of_contacts: forces of contacts of grains that have bonds, each on one rank. Without any force the value is 0; it is 1e9 at most.
  double unbalanced_force(const std::vector<BondState>& loads, const Magnitudes& of_contacts) const;
  // Collective. Added mass at either side of each bond, over all ranks.
  std::vector<double> added_mass_of_sides() const;
  double cement_mass() const;                                    // mass on this rank, with the mass scale
  int resolved_bonds() const;                                    // number over all ranks
  int bonds_solved() const { return condensed_.solved_last(); }  // number at the last layout, of this rank
  const std::vector<int>& bonds_without_field() const { return condensed_.without_field_last(); }  // rows
  std::size_t memory_of_condensed() const { return condensed_.memory_usage(); }
  std::size_t memory_usage() const { return scene_.bonds().memory_usage() + condensed_.memory_usage(); }  // bytes, on this rank

  // Displacement and velocity of the points of a bond at the present time, in the axes of its body.
  struct PointMotionNow {
    vd u[3], v[3];
  };
  void motion_of_points(const Bond& bond, std::vector<PointMotionNow>& motion) const;
  void motion_of_film(const Bond& bond, std::vector<PointMotionNow>& motion) const;

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
  std::vector<BondState> states_;
  std::vector<double> peaks_;  // largest tension of each bond in the steps that this rank had its first grain
};

}  // namespace mpdem

#endif
