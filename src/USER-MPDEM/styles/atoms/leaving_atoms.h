// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Atoms of grains and points that leave the scene: what LIGGGHTS is about to drop, what commands and fixes deleted, and points
// beyond a side of the box. LIGGGHTS must not drop points by itself, so a point that is beyond a side is shown on it, until it leaves at
// the exchange after a check. The engine says which points may leave (cement/step/departures.h).
#ifndef MPDEM_STYLES_ATOMS_LEAVING_ATOMS_H
#define MPDEM_STYLES_ATOMS_LEAVING_ATOMS_H

#include <optional>
#include <string>
#include <vector>

#include "../../cement/step/departures.h"
#include "../../cement/engine/report.h"
#include "atom_vec_mpdem.h"
#include "pointers.h"

namespace mpdem {

// Whether a place is beyond a side of the box that stays where it is.
bool left_the_box(const LAMMPS_NS::Domain& box, int direction, double x);

class LeavingAtoms : protected LAMMPS_NS::Pointers {
 public:
  // who: name of the command, for complaints.
  LeavingAtoms(LAMMPS_NS::LAMMPS* lmp, std::string who) : Pointers(lmp), who_(std::move(who)) {}

  // Collective. Brings positions and velocities of the atoms of points up to date. A place that is beyond a side is brought onto it.
  void show_points(const LAMMPS_NS::AtomVecMpdem& avec, Report& report);
  // Collective. Was a point of some rank beyond a side?
  bool some_are_outside() const;
  // Collective. May cement that failed have come beyond a side? Looks at nodes, between which points are.
  bool may_be_outside(const LAMMPS_NS::AtomVecMpdem& avec) const;

  // Collective. Points beyond a side.
  Departing outside() const;
  // Collective. Call before an exchange. Returns what is gone or goes with it, if there is anything. The points beyond a side are among it
  // if points_too. Stops if a grain has no finite place.
  std::optional<Departing> find(const LAMMPS_NS::AtomVecMpdem& avec, bool points_too);
  // Collective. Stops if something is attached to a grain that stays, or if what leaves is so fast that the motion must be unstable.
  // of_all: number of all points. dt: time step of the cement.
  void stop_if_wrong(const Leaving& leaving, LAMMPS_NS::bigint of_all, double cell, double dt) const;
  // Collective. Deletes the atoms of these points of this rank, where a command has not.
  void remove(const std::vector<int>& tags);

  // Text about what to do with an atom that is out of the box, by its speed.
  std::string flight(int i, double cell, double dt) const;

 private:
  struct Outside {
    int atom, row, slot, direction;
    double x;
  };
  void show(int i, int row, int slot, double* x);
  std::string place(int d, double x) const;

  std::string who_;
  std::vector<Outside> outside_;
  bool told_ = false;
};

}  // namespace mpdem

#endif
