// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Goes between LIGGGHTS' atoms and the engine for bonded grains. It takes their motion and loads to the engine, and the
// engine's loads back. It checks whether grains go where their velocity takes them. A formula that starts anew may displace a grain,
// which would load its bond with a strain that nothing in the scene has caused.
#ifndef MPDEM_STYLES_ATOMS_BONDED_ATOMS_H
#define MPDEM_STYLES_ATOMS_BONDED_ATOMS_H

#include <string>
#include <vector>

#include "../../cement/bond/bonded_grains.h"
#include "atom_vec_mpdem.h"
#include "fix.h"

namespace mpdem {

class BondedAtoms {
 public:
  // who: name of the command, for complaints.
  BondedAtoms(LAMMPS_NS::LAMMPS* lmp, std::string who) : lmp_(lmp), who_(std::move(who)) {}

  // Finds the bonded grains of this rank, and gives them a state. Call after atoms changed place.
  void find(LAMMPS_NS::AtomVecMpdem& avec, BondedGrains& grains);
  // Takes velocities and loads from LIGGGHTS to the engine.
  void read(BondedGrains& grains) const;
  void write_forces(const BondedGrains& grains) const;
  // Call after the host moved its grains. read_places() takes their places to the engine. write_motion() sets places
  // and velocities of free grains to those of the engine.
  void read_places(BondedGrains& grains) const;
  void write_motion(const BondedGrains& grains) const;
  void write_velocities(const BondedGrains& grains) const;
  void write_pushes(const BondedGrains& grains) const;  // writes velocities where grains are free
  // Adds gravity by fixes that come later in the step than `fix` to the loads of grains that start, since they feel it
  // in the first step already.
  void expect_gravity(BondedGrains& grains, const LAMMPS_NS::Fix* fix) const;

  // Stops if a grain jumped. Collective, so not called in every step.
  void report_trouble();
  // Notes positions, and how far each grain moved. Checks that a grain goes where its velocity takes it. Call in each
  // step, before the engine forgets the velocities of the last one.
  void follow(BondedGrains& grains, double cell, double dt);

 private:
  LAMMPS_NS::LAMMPS* lmp_;
  std::string who_;
  std::vector<int> atoms_;  // places of the grains among the atoms, ascending in tag
  std::string trouble_;     // what this rank found, told at the next report
};

}  // namespace mpdem

#endif
