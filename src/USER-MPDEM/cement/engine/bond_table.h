// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The output table of bonds. A column is one line of the list in bond_table.cpp: its name, its description, and how its
// value is found. The CSV file of fix mpm/couple, its vector, its array, their sizes and the check of
// doc/fix_mpm_couple.md follow from that list. Scripts use the numbers of columns, so a new column must be the last.
// Values are in consistent units.
#ifndef MPDEM_CEMENT_ENGINE_BOND_TABLE_H
#define MPDEM_CEMENT_ENGINE_BOND_TABLE_H

#include <variant>
#include <vector>

#include "../bond/bond.h"
#include "../bond/energy_balance.h"
#include "../bond/point_sums.h"

namespace mpdem {

// Totals over all bonds.
struct CementTotals {
  double points, failed, largest_damage, mean_damage;
  double kinetic, elastic, coupling, dissipated, released, damped, frictional, external_work, imbalance;
  double momentum[3], angular_momentum[3];
  double separated, debonding, internal, mixed;  // numbers of bonds
  double broken;                                 // number of bonds that are separated or carry almost nothing
  double resolved;                               // number of resolved bonds
  EnergyBalance::Left left;                      // cement that left the scene
  double kinetic_share;                          // see Report::EnergyShares
  double unbalanced_force;                       // see Report::unbalanced_force(); 0 until the host asks for it
  double contact, contact_friction;              // energies of contact/piece_contact.h: stored, and dissipated
};

// The share of a bond on one rank.
struct BondShare {
  const Bond& bond;
  const BondRecord& record;
  const PointSums& points;
};

// Number of columns that are sums over the shares of a bond.
int summed_columns();

// State of one bond, over all ranks.
struct BondState {
  double force[2][3] = {}, torque[2][3] = {}, gap = 0.0, tension = 0.0;
  double contact[2][3] = {};  // the share of the force by contact between rigid pieces of the bond
  double normal[3] = {};      // unit vector from the centre of the first grain to that of the second; 0 if a grain is gone
  double peak = 0.0;          // largest tension of all steps so far
  double failed = 0.0, largest_damage = 0.0, mean_damage = 0.0;
  double separated = 0.0, share[2] = {0.0, 0.0};  // 1 once separated; shares of the fracture surface at each grain
  double broken = 0.0;                            // 1 once separated, or when it carries almost nothing
  std::vector<double> sums = std::vector<double>(static_cast<std::size_t>(summed_columns()), 0.0);  // in the order of their columns
};

struct BondColumn {
  const char* name;         // name in the header line of the CSV file
  const char* description;  // text in the table of doc/fix_mpm_couple.md
  // How the value is found: a field or a function of the state of the bond, a total over all bonds, or a sum over the
  // shares of the bond.
  std::variant<double BondState::*, double (*)(const BondState&), double CementTotals::*, double (*)(const BondShare&)> found;
  int sum = -1;  // index in BondState::sums, set by bond_columns(); -1: no sum

  // Does the value need a loop over the points or links of the bond?
  bool needs_points() const;
  // Is the value the same for all bonds? Totals need one loop over all points, and states of bonds another.
  bool of_all() const { return std::holds_alternative<double CementTotals::*>(found); }
  double value(const CementTotals& all) const { return all.*std::get<double CementTotals::*>(found); }
  // Does the value need the contact forces of the host?
  bool needs_contacts() const { return of_all() && std::get<double CementTotals::*>(found) == &CementTotals::unbalanced_force; }
  double value(const BondState& bond) const;
};

const std::vector<BondColumn>& bond_columns();

// Adds the share of this rank to BondState::sums.
void add_to_sums(const BondShare& share, double* sums);

}  // namespace mpdem

#endif
