// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Adds the styles of the package to LIGGGHTS' shared library without a patch. Fix, compute and command styles are in
// run-time maps. LIGGGHTS fills these again for every set of top-level classes (also after `clear`), right before
// LAMMPS::post_create(). Atom styles are a compile-time chain in Atom::new_avec(). LAMMPS::help() prints the list of
// `-h`. LAMMPS::init() begins every run. Output::setup() is called with 0 where a run has no set-up. LIGGGHTS calls
// these functions through the symbol table, so the definitions below take precedence if the executable exports its
// symbols (-rdynamic). They call the original functions.
#include <cstring>

#include "../styles/atoms/atom_vec_mpdem.h"
#include "../styles/commands/bond_stiffness.h"
#include "../styles/commands/cement_material.h"
#include "../styles/computes/compute_mpm_atom.h"
#include "../styles/computes/compute_mpm_fragment.h"
#include "../styles/computes/compute_mpm_stress.h"
#include "../styles/commands/create_cement.h"
#include "../styles/commands/delete_bond.h"
#include "../styles/fixes/fix_check_timestep_mpm.h"
#include "../styles/fixes/fix_mpm.h"
#include "../styles/fixes/fix_mpm_couple.h"
#include "../styles/guards/host_guards.h"
#include "../styles/atoms/private_access.h"
#include "../styles/commands/write_cement.h"
#include "../version.h"
#include "abort.h"
#include "atom.h"
#include "original.h"
#include "output.h"
#include "universe.h"

namespace {

using namespace LAMMPS_NS;
using mpdem::original;

template <class T>
Fix* make_fix(LAMMPS* lmp, int narg, char** arg) {
  return new T(lmp, narg, arg);
}
template <class T>
Compute* make_compute(LAMMPS* lmp, int iarg, int narg, char** arg) {
  return new T(lmp, iarg, narg, arg);
}
template <class T>
void run_command(LAMMPS* lmp, int narg, char** arg) {
  T command(lmp);
  command.command(narg, arg);
}

}  // namespace

namespace LAMMPS_NS {

void LAMMPS::post_create() {
  original<void (*)(LAMMPS*)>("_ZN9LAMMPS_NS6LAMMPS11post_createEv")(this);
  auto& fixes = mpdem::fix_styles(modify);
  fixes["mpm"] = &make_fix<FixMpm>;
  fixes["check/timestep/mpm"] = &make_fix<FixCheckTimestepMpm>;
  fixes["mpm/couple"] = &make_fix<FixMpmCouple>;
  mpdem::compute_styles(modify)["mpm/atom"] = &make_compute<ComputeMpmAtom>;
  mpdem::compute_styles(modify)["mpm/fragment"] = &make_compute<ComputeMpmFragment>;
  mpdem::compute_styles(modify)["mpm/stress"] = &make_compute<ComputeMpmStress>;
  mpdem::command_styles(input)["bond_stiffness"] = &run_command<BondStiffness>;
  mpdem::command_styles(input)["cement_material"] = &run_command<CementMaterial>;
  mpdem::command_styles(input)["create_cement"] = &run_command<CreateCement>;
  mpdem::command_styles(input)["delete_bond"] = &run_command<DeleteBond>;
  mpdem::command_styles(input)["write_cement"] = &run_command<WriteCement>;
  mpdem::learn_log_name(this);
}

void LAMMPS::init() {
  mpdem::learn_log_name(this);
  original<void (*)(LAMMPS*)>("_ZN9LAMMPS_NS6LAMMPS4initEv")(this);
}

// A run without a set-up calls no fix, so settings that the fixes would refuse are checked here.
void Output::setup(int memory_is_reported) {
  const AtomVecMpdem* cement = AtomVecMpdem::of(lmp);
  if (memory_is_reported == 0 && cement && !cement->bonds.table.empty())
    mpdem::check_host(mpdem::kNoFix, {lmp, "run ... pre no: ", cement});
  original<void (*)(Output*, int)>("_ZN9LAMMPS_NS6Output5setupEi")(this, memory_is_reported);
}

AtomVec* Atom::new_avec(const char* style, char* suffix, int& sflag) {
  if (std::strcmp(style, "mpdem") == 0) {
    sflag = 0;
    return new AtomVecMpdem(lmp);
  }
  return original<AtomVec* (*)(Atom*, const char*, char*, int&)>("_ZN9LAMMPS_NS4Atom8new_avecEPKcPcRi")(this, style, suffix, sflag);
}

void LAMMPS::help() {
  original<void (*)(LAMMPS*)>("_ZN9LAMMPS_NS6LAMMPS4helpEv")(this);
  std::fprintf(
      screen,
      "\n\n* USER-MPDEM %s styles\n\n"
      "atom_style mpdem, fix mpm, fix mpm/couple, fix check/timestep/mpm, compute mpm/atom, compute mpm/fragment, compute mpm/stress,\n"
      "commands create_cement, cement_material, write_cement, delete_bond, bond_stiffness\n",
      mpdem::kVersion);
}

}  // namespace LAMMPS_NS
