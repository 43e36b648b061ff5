// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Cement and grains that leave the scene of fix mpm: over a face of the box, by commands, and by `fragments drop`.
#include <optional>

#include "../atoms/point_atoms.h"
#include "fix_mpm.h"
#include "update.h"

namespace LAMMPS_NS {

// Attached cement must not be beyond a face of the box. Fragments leave in the step after a check, so that results do
// not depend on where a run is divided.
void FixMpm::watch_outside() {
  if (!leaving_.some_are_outside()) return;
  if (update->ntimestep % cement_->options().check_every == 0) next_reneighbor = update->ntimestep + 1;
  guarded([this] {
    leaving_.stop_if_wrong(cement_->departures().choose(leaving_.outside()), mpdem::points_made(*avec_), cell(), cement_->dt());
  });
}

// Cement that is due is dropped in the step after a check, as fragments outside are.
void FixMpm::watch_loose() {
  if (update->ntimestep % cement_->options().check_every != 0) return;
  guarded([this] {
    if (cement_->departures().loose_cement().examine()) next_reneighbor = update->ntimestep + 1;
  });
}

// Call it before LIGGGHTS exchanges atoms, while true positions are shown.
void FixMpm::remove_leaving(bool points_too) {
  if (!cement_->built()) return;
  std::optional<mpdem::Departing> departing = leaving_.find(*avec_, points_too);
  if (!departing && !(points_too && cement_->options().fragments.drop)) return;
  guarded([&] {
    if (!departing) departing.emplace();
    if (points_too) departing->dropped = cement_->departures().loose_cement().due();
    remove(*departing);
  });
}

// LIGGGHTS then has to set up the next run, also with `pre no`.
void FixMpm::delete_bonds(const std::vector<int>& rows) {
  update->first_update = 0;
  guarded([&] {
    mpdem::Departing departing;
    departing.dropped.bonds = rows;
    remove(departing);
  });
}

// Removes what may leave, and stops if something must not.
void FixMpm::remove(const mpdem::Departing& departing) {
  const mpdem::Leaving leaving = cement_->departures().choose(departing);
  leaving_.stop_if_wrong(leaving, mpdem::points_made(*avec_), cell(), cement_->dt());
  if (leaving.rows.empty()) return;
  leaving_.remove(cement_->departures().carry_out(leaving), leaving.dropped_points);
  report_->forget();
}

}  // namespace LAMMPS_NS
