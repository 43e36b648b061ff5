// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Atoms of grains and points that leave the scene: those that LIGGGHTS is about to drop, those that commands and fixes
// deleted, and points beyond a face of the box. LIGGGHTS must not drop points itself, so the atom of such a point stays
// on the face until the point is removed at the exchange after a check. cement/step/departures.h decides which points
// may leave.
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

// Whether a position is beyond a fixed face of the box.
bool left_the_box(const LAMMPS_NS::Domain& box, int direction, double x);

class LeavingAtoms : protected LAMMPS_NS::Pointers {
 public:
  // who: name of the command, for error messages.
  LeavingAtoms(LAMMPS_NS::LAMMPS* lmp, std::string who) : Pointers(lmp), who_(std::move(who)) {}

  // Collective. Writes positions and velocities of points to their atoms. A position beyond a face is moved onto it.
  void show_points(const LAMMPS_NS::AtomVecMpdem& avec, Report& report);
  // Collective. Was a point of any rank beyond a face?
  bool some_are_outside() const;
  // Collective. May failed cement be beyond a face? Checks the nodes, since points lie between them.
  bool may_be_outside(const LAMMPS_NS::AtomVecMpdem& avec) const;

  // Collective. Points beyond a face.
  Departing outside() const;
  // Collective. Call before an exchange. Returns the grains and points that are gone or leave at this exchange, if any;
  // with points_too also the points beyond a face. Stops if a grain has no finite position.
  std::optional<Departing> find(const LAMMPS_NS::AtomVecMpdem& avec, bool points_too);
  // Collective. Stops if a leaving grain or point is joined to a grain that stays, or is so fast that the motion must
  // be unstable. of_all: number of all points. dt: time step of the cement.
  void stop_if_wrong(const Leaving& leaving, LAMMPS_NS::bigint of_all, double cell, double dt) const;
  // Collective. Deletes the atoms of these points of this rank, unless a command did. dropped: how many of them are dropped
  // (Leaving::dropped_points).
  void remove(const std::vector<int>& tags, double dropped);

  // Advice on an atom outside of the box, depending on its speed.
  std::string flight(int i, double cell, double dt) const;

 private:
  struct Outside {
    int atom, row, slot, direction;
    double x;  // coordinate in this direction, which is beyond a face
  };
  void show(int i, int row, int slot, double* x);
  std::string place(int d, double x) const;

  std::string who_;
  std::vector<Outside> outside_;
  bool reported_flag_ = false, dropped_reported_ = false;
};

}  // namespace mpdem

#endif
