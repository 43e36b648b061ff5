// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Prints what fix mpm reports on screen and in the log, and caches totals and states of the bonds of a step.
#ifndef MPDEM_STYLES_FIXES_CEMENT_REPORT_H
#define MPDEM_STYLES_FIXES_CEMENT_REPORT_H

#include <memory>
#include <string>
#include <vector>

#include "../../cement/engine/cement.h"
#include "../atoms/atom_vec_mpdem.h"
#include "../atoms/contact_forces.h"
#include "lammps.h"

namespace mpdem {

class CementReport {
 public:
  using bigint = LAMMPS_NS::bigint;
  // who: name of the command.
  CementReport(LAMMPS_NS::LAMMPS* lmp, std::string who) : lmp_(lmp), who_(std::move(who)) {}

  // Collective. Return totals and states of bonds at the present step. They are computed once a step, unless forget()
  // was called since.
  const CementTotals& totals(Cement& c);
  // Totals with the unbalanced force, too. The force is computed within a run only (ContactForces). Between runs it is that
  // of the end of the last run.
  const CementTotals& totals_with_contacts(Cement& c);
  const std::vector<BondState>& bonds(Cement& c);
  const std::vector<BondState>& loads(Cement& c);  // columns that need points are 0
  void forget() { totals_at_ = bonds_at_ = loads_at_ = unbalanced_at_ = -1; }

  // All functions below are collective.
  void start_run(Cement& c);
  void enter_steps() { in_run_ = true; }  // not collective; for a run without a set-up
  void end_run(Cement& c);
  void start_timing(Cement& c);  // call it at the end of the set-up of a run
  // Prints what the parameters imply, once. Stops if the time step is not stable.
  void parameters(Cement& c, bigint points);
  // Stops if the time step is not positive or not stable.
  void check_step(Cement& c);
  // Prints the last lines of parameters(). The added mass depends on the eigenvalue, which parameters() computes.
  void added_mass(Cement& c, const LAMMPS_NS::AtomVecMpdem& avec);
  // Warns of cement whose initial velocity differs from that of its grains, which sends a stress wave through it.
  void start(Cement& c);
  // Warns of the first jump of a prescribed velocity on the lowest rank that saw one, once in a run.
  void jump(Cement& c);
  // Prints the time spent in each phase of the run, by the slowest rank for each phase.
  void times(Cement& c, bigint points);
  // Prints one line for each bond with failed points, debonded links or a separation, at the end of a run.
  void modes(Cement& c);

 private:
  void damping(Cement& c);
  void accelerations(Cement& c);  // warns once if they are imprecise
  void stop_if_not_positive(const Cement& c) const;
  void stop_if_too_long(Cement& c, double limit) const;
  static bool is_listed(const BondState& bond);
  void sum_of_modes(const Cement& c, int lines) const;
  double limit_of_jumps(const Cement& c) const;

  LAMMPS_NS::LAMMPS* lmp_;
  std::string who_;
  bool reported_ = false, jump_reported_ = false, split_reported_ = false, accelerations_reported_ = false;
  bigint steps_timed_ = 0;  // steps of all runs since the last set-up
  CementTotals totals_{};
  const std::vector<BondState>* bonds_ = nullptr;
  bigint totals_at_ = -1, bonds_at_ = -1, loads_at_ = -1, unbalanced_at_ = -1;  // steps of what is cached; -1: nothing
  std::unique_ptr<ContactForces> contacts_;                                     // made when first needed
  double unbalanced_ = 0.0;
  bool in_run_ = false;
};

}  // namespace mpdem

#endif
