// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Bonded grains between LIGGGHTS' atoms and the engine: their motion and loads to it, its loads back; and whether they are where
// their cement knows them to be, and as large. A grain that a command displaces, or a formula that starts anew, would
// load its bond with a strain that nothing in the scene has caused.
#ifndef MPDEM_BONDED_ATOMS_H
#define MPDEM_BONDED_ATOMS_H

#include <string>
#include <vector>

#include "../cement/bonded_grains.h"
#include "atom_vec_mpdem.h"
#include "fix.h"

namespace mpdem {

class BondedAtoms {
 public:
  // who: the command, for complaints.
  BondedAtoms(LAMMPS_NS::LAMMPS* lmp, std::string who) : lmp_(lmp), who_(std::move(who)) {}

  // After atoms changed place: the bonded grains of this rank. Gives them a state.
  void find(LAMMPS_NS::AtomVecMpdem& avec, BondedGrains& grains);
  // Velocity and load of LIGGGHTS to the engine.
  void read(BondedGrains& grains) const;
  void write_forces(const BondedGrains& grains) const;
  // After the host moved its grains: where they are; and where free ones are to be instead, with their velocities.
  void read_places(BondedGrains& grains) const;
  void write_motion(const BondedGrains& grains) const;
  void write_velocities(const BondedGrains& grains) const;
  void write_pushes(const BondedGrains& grains) const;  // the same where grains are free
  // Gravity by fixes that come later in the step than `fix`, for grains that start: they feel it in the first step already.
  void expect_gravity(BondedGrains& grains, const LAMMPS_NS::Fix* fix) const;

  // Collective, so not in every step: stops if a grain jumped, was lost, or changed its size.
  void report_trouble();
  // Of this rank, before LIGGGHTS drops a grain that leaves, which it does without a word.
  void watch_for_those_that_leave(double cell);
  // In each step, before the engine forgets the velocities of the last one: position, and how far each moved. A grain goes where its
  // velocity takes it.
  void follow(BondedGrains& grains, const LAMMPS_NS::AtomVecMpdem& avec, double cell, double dt);
  // At the start of a run, against the end of the last one, the restart file or create_cement. Collective.
  void check_stayed(LAMMPS_NS::AtomVecMpdem& avec, double cell) const;
  // What to do about an atom that is out of the box, by its speed.
  std::string flight(int i, double cell) const;

 private:
  std::string changed_radius(int i, double made_for) const;

  LAMMPS_NS::LAMMPS* lmp_;
  std::string who_;
  std::vector<int> atoms_;  // of the grains, ascending in tag
  std::string trouble_;     // found on this rank, told at the next report
};

// Why the box is not that of the cement, the same on every rank; empty if it is.
std::string changed_box(LAMMPS_NS::LAMMPS* lmp, const std::string& who, const std::vector<Body>& table);

}  // namespace mpdem

#endif
