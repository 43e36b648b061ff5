// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Copies motion and loads of bonded grains between LIGGGHTS' atoms and the engine. Also checks that each grain moves as
// its velocity says: a formula that starts anew may displace a grain, which would strain its bonds without a physical
// cause.
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
  // who: name of the command, for error messages.
  BondedAtoms(LAMMPS_NS::LAMMPS* lmp, std::string who) : lmp_(lmp), who_(std::move(who)) {}

  // Finds the bonded grains of this rank and gives them a state. Call it after atoms were reordered or exchanged.
  void find(LAMMPS_NS::AtomVecMpdem& avec, BondedGrains& grains);
  // Copies velocities and loads from LIGGGHTS to the engine.
  void read(BondedGrains& grains) const;
  void write_forces(const BondedGrains& grains) const;
  // Call these after LIGGGHTS moved the grains. read_positions() copies their positions to the engine. write_motion() sets
  // positions and velocities of free grains to those of the engine.
  void read_positions(BondedGrains& grains) const;
  void write_motion(const BondedGrains& grains) const;
  void write_velocities(const BondedGrains& grains) const;
  void write_free_velocities(const BondedGrains& grains) const;  // writes velocities in free directions only
  // Adds gravity by fixes that act after `fix` to the loads of grains in their first step, since they feel it in that
  // step already.
  void expect_gravity(BondedGrains& grains, const LAMMPS_NS::Fix* fix) const;

  // Stops if follow() found a jump on any rank. Collective, so it is not called in every step.
  void report_trouble();
  // Records positions and displacements of grains, and checks that these agree with the velocities. dt: time since the
  // recorded positions, that of a sub-step. Call it in each step, before the engine forgets the velocities of the last one.
  void follow(BondedGrains& grains, double cell, double dt);

 private:
  LAMMPS_NS::LAMMPS* lmp_;
  std::string who_;
  std::vector<int> atoms_;  // indices of the atoms of the grains, ascending in tag
  std::string trouble_;     // what this rank found, for the next report_trouble()
};

}  // namespace mpdem

#endif
